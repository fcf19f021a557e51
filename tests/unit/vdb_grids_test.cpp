// Files of OpenVDB with several point grids: attributes that only some grids have are told of.

#include "io/particle_file.h"
#include "support/file_checks.h"

#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>
#include <openvdb/points/PointDataGrid.h>

namespace betamesh {
namespace {

using Texts = std::vector<std::string>;

/// One file with the grids of others, named a, b, c in their order.
void joinGrids(const Texts& files, const std::string& to) {
    openvdb::GridPtrVec grids;
    for (const std::string& name : files) {
        openvdb::io::File file(name);
        file.open();
        const openvdb::GridPtrVecPtr read = file.getGrids();
        for (const auto& grid : *read) {
            grid->setName(std::string(1, static_cast<char>('a' + grids.size())));
            grids.push_back(grid);
        }
    }
    openvdb::io::File(to).write(grids);
}

class VdbGrids : public ::testing::Test {
protected:
    /// A file with one grid of n particles, with velocities or not, and with attributes.
    std::string grid(std::size_t n, bool velocities, const std::vector<Attribute>& attributes) {
        Particles particles = sampleParticles(n, velocities, false, false);
        particles.attributes = attributes;
        files_.push_back(folder_ / ("part" + std::to_string(files_.size()) + ".vdb"));
        writeParticles(files_.back(), particles);
        return files_.back();
    }

    SummarisedParticles read(const Texts& files) {
        const std::string all = folder_ / "all.vdb";
        joinGrids(files, all);
        return readSummarised(all, {});
    }

    static Attribute temperature(std::size_t n) { return {"temperature", 1, std::vector<float>(n, 300.0F), {}}; }
    static Attribute integers(std::size_t n) { return {"temperature", 1, {}, std::vector<std::int32_t>(n, 300)}; }

    const TemporaryFolder folder_;
    Texts files_;
};

Texts notRead(const SummarisedParticles& read) {
    Texts names;
    for (const InputPart& part : read.summary.parts)
        if (part.name.find("grid '") != std::string::npos) names.push_back(part.name);
    return names;
}

TEST_F(VdbGrids, AttributesOfAllGridsAreRead) {
    const std::string one = grid(40, true, {temperature(40)}), other = grid(70, true, {temperature(70)});
    const SummarisedParticles all = read({one, other});
    EXPECT_EQ(all.particles.size(), 110U);
    EXPECT_EQ(all.particles.velocity.size(), 110U);
    ASSERT_EQ(all.particles.attributes.size(), 1U);
    EXPECT_EQ(all.particles.attributes[0].real, std::vector<float>(110, 300.0F));
    EXPECT_EQ(all.summary.warnings, Texts{});
    EXPECT_EQ(notRead(all), Texts{});
}

TEST_F(VdbGrids, VelocitiesThatSomeGridsLackGiveAWarning) {
    const std::string with = grid(40, true, {}), without = grid(70, false, {});
    const SummarisedParticles first = read({with, without}), second = read({without, with});
    EXPECT_TRUE(first.particles.velocity.empty());
    EXPECT_TRUE(second.particles.velocity.empty());
    EXPECT_EQ(first.summary.warnings,
              Texts{"attribute 'v' is left out: grid 'a' has it, but in grid 'b' it is missing"});
    EXPECT_EQ(second.summary.warnings,
              Texts{"attribute 'v' is left out: grid 'b' has it, but in grid 'a' it is missing"});
}

TEST_F(VdbGrids, OtherAttributesThatSomeGridsLackAreListed) {
    const std::string with = grid(40, true, {temperature(40)}), without = grid(70, true, {}),
                      other_type = grid(20, true, {integers(20)});
    const SummarisedParticles lacking = read({with, without, with});
    EXPECT_TRUE(lacking.particles.attributes.empty());
    EXPECT_EQ(lacking.particles.velocity.size(), 150U);
    EXPECT_EQ(notRead(lacking), Texts{"attribute 'temperature': grid 'a' has it, but in grid 'b' it is missing"});
    EXPECT_EQ(notRead(read({with, other_type})),
              Texts{"attribute 'temperature': grid 'a' has it, but in grid 'b' it has another type"});
}

TEST_F(VdbGrids, GridsWithoutPointsTakeNothingAway) {
    const std::string with = grid(40, true, {temperature(40)}), empty = grid(0, false, {});
    for (const SummarisedParticles& all : {read({with, empty}), read({empty, with})}) {
        EXPECT_EQ(all.particles.velocity.size(), 40U);
        EXPECT_EQ(all.particles.attributes.size(), 1U);
        EXPECT_EQ(all.summary.warnings, Texts{});
    }
}

}  // namespace
}  // namespace betamesh
