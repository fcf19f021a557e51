#include "io/vdb.h"

#include "io/file_info.h"
#include "io/gzip.h"
#include "io/particle_file.h"
#include "support/file_checks.h"
#include "support/file_samples.h"
#include "support/program.h"
#include "support/temporary_folder.h"
#include "support/vdb_of_groups.h"
#include "support/vdb_of_many_codecs.h"

#include <algorithm>
#include <map>
#include <numeric>

namespace betamesh {

namespace {

/// The particles sorted by id, because a .vdb file stores points voxel by voxel.
Particles sortedById(const Particles& p) {
    std::vector<std::size_t> order(p.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return p.id[a] < p.id[b]; });
    Particles sorted;
    sorted.attributes = p.attributes;
    for (Attribute& a : sorted.attributes) {
        a.real.clear();
        a.integer.clear();
    }
    for (const std::size_t i : order) {
        sorted.position.push_back(p.position[i]);
        if (!p.velocity.empty()) sorted.velocity.push_back(p.velocity[i]);
        sorted.id.push_back(p.id[i]);
        for (std::size_t k = 0; k < p.attributes.size(); ++k)
            for (std::size_t c = i * p.attributes[k].components; c < (i + 1) * p.attributes[k].components; ++c) {
                if (!p.attributes[k].real.empty()) sorted.attributes[k].real.push_back(p.attributes[k].real[c]);
                if (!p.attributes[k].integer.empty())
                    sorted.attributes[k].integer.push_back(p.attributes[k].integer[c]);
            }
    }
    return sorted;
}

void writeFixture(std::string_view hex, const std::string& file) {
    Bytes packed;
    for (; !hex.empty(); hex.remove_prefix(2))
        packed.push_back(static_cast<std::byte>(std::stoi(std::string(hex.substr(0, 2)), nullptr, 16)));
    const Bytes bytes = gunzip(packed, "fixture");
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

void writeVdbOfManyCodecs(const std::string& file) { writeFixture(kVdbOfManyCodecs, file); }

}  // namespace

TEST(VdbFile, ParticlesSurviveARoundTripExactly) {
    const TemporaryFolder folder;
    for (const std::size_t n : {1U, 2U, 5000U})
        for (int mask = 0; mask < 4; ++mask) {
            SCOPED_TRACE(std::to_string(n) + " particles, mask " + std::to_string(mask));
            const Particles particles = sampleParticles(n, mask & 1, true, mask & 2);
            writeParticles(folder / "a.vdb", particles);
            expectSame(sortedById(readParticles(folder / "a.vdb")), sortedById(particles));
        }
}

TEST(VdbFile, AwkwardPositionsSurviveARoundTripExactly) {
    const TemporaryFolder folder;
    const std::map<std::string, std::vector<Vec3f>> clouds{
        {"coincident", std::vector<Vec3f>(100, Vec3f(0.1F, 0.2F, 0.3F))},
        {"origin", {{0, 0, 0}}},
        {"far apart", {{1e-30F, 0, 0}, {3e30F, -1e30F, 7.7F}}},
        {"far from the origin", {{1e6F, 1e6F, 1e6F}, {1e6F + 1, 1e6F, 1e6F}, {1e6F, 1e6F + 0.5F, 1e6F}}},
        {"flat", {{0.1F, 0.7F, 0}, {0.3F, 0.11F, 0}, {-0.77F, 0.13F, 0}}},
        {"tiny", {{1e-20F, 2e-20F, 3e-20F}, {4e-20F, 5e-20F, -6e-20F}}}};
    for (const auto& [name, positions] : clouds) {
        SCOPED_TRACE(name);
        Particles particles;
        particles.position = positions;
        for (std::size_t i = 0; i < positions.size(); ++i) particles.id.push_back(i);
        writeParticles(folder / "a.vdb", particles);
        const Particles read = sortedById(readParticles(folder / "a.vdb"));
        if (name == "far apart") {  // both in one voxel, whose float offsets are accurate to 1e-7 of its size
            ASSERT_EQ(read.size(), 2U);
            EXPECT_NEAR(read.position[0].x, 0, 1e24);
            EXPECT_NEAR(read.position[1].x, 3e30, 1e24);
        } else {
            EXPECT_EQ(read.position, positions);
        }
    }
}

TEST(VdbFile, BytesAreReproducible) {
    const Particles a = sampleParticles(3000, true, true, true);
    const std::string bytes = encodeVdb(a, "a.vdb");
    EXPECT_EQ(bytes, encodeVdb(a, "a.vdb"));
    Particles b = a;
    b.velocity[17].x += 1;
    EXPECT_NE(bytes.substr(21, 36), encodeVdb(b, "b.vdb").substr(21, 36));  // the UUID
    EXPECT_EQ(bytes[21 + 8], '-');
    EXPECT_EQ(bytes[21 + 14], '4');
}

TEST(VdbFile, FilesWithoutParticlesAreValid) {
    const TemporaryFolder folder;
    writeParticles(folder / "a.vdb", {});
    EXPECT_EQ(readParticles(folder / "a.vdb").size(), 0U);
    EXPECT_EQ(inspectFile(folder / "a.vdb").points, 0U);
}

TEST(VdbFile, IdsHave64Bits) {
    const TemporaryFolder folder;
    Particles p = sampleParticles(2, false, true, false);
    p.id = {1ULL << 40, ~0ULL};
    writeParticles(folder / "a.vdb", p);
    expectSame(sortedById(readParticles(folder / "a.vdb")), p);
}

TEST(VdbFile, ReadsQuantisedPointsOfSeveralGrids) {
    const TemporaryFolder folder;
    writeVdbOfManyCodecs(folder / "a.vdb");
    const Particles p = sortedById(readParticles(folder / "a.vdb"));
    const std::vector<Vec3f> expected{{10, 0, 0},  {10.25F, 0.5F, -0.125F}, {14, 5, 6}, {-3, 2, 1}, {1, 1, 1},
                                      {-1, -2, -3}};
    ASSERT_EQ(p.size(), expected.size());
    EXPECT_EQ(p.id, (std::vector<std::uint64_t>{0, 1, 2, 3, 100, 101}));
    ASSERT_EQ(p.attributes.size(), 4U);
    EXPECT_EQ(p.attributes[0].name, "pscale");
    EXPECT_EQ(p.attributes[0].real, (std::vector<float>{0.5F, 0.75F, 1, 1.25F, 0.5F, 0.75F}));
    EXPECT_EQ(p.attributes[1].name, "age");
    EXPECT_EQ(p.attributes[1].real, (std::vector<float>{0, 0.125F, 0.25F, 0.375F, 0, 0.125F}));
    for (std::size_t i = 0; i < p.size(); ++i) {
        const float voxel = i < 4 ? 0.5F / 65535 : 0.25F / 255;
        EXPECT_LE((p.position[i] - expected[i]).length(), voxel) << i;
        EXPECT_EQ(p.velocity[i], expected[i] * 2.0F) << i;
        for (std::size_t axis = 0; axis < 3; ++axis)
            EXPECT_EQ(p.attributes[2].real[3 * i + axis], expected[i][static_cast<int>(axis)] / 2) << i;
        EXPECT_NEAR(p.attributes[3].real[3 * i + 2], 1, 1e-3);
    }

    const FileInfo info = inspectFile(folder / "a.vdb");
    EXPECT_NE(info.format.find("zip"), std::string::npos) << info.format;
    EXPECT_NE(info.format.find("2 grids"), std::string::npos) << info.format;
    EXPECT_EQ(info.attributes[0].codec, "fxpt16");
    EXPECT_EQ(info.attributes[7].type, "group");
}

TEST(VdbFile, GridsAndGroupsAreChosenByName) {
    const TemporaryFolder folder;
    const std::string file = folder / "a.vdb";
    writeFixture(kVdbOfGroups, file);
    const auto positionsOf = [&](const ParticleInput& input) {
        std::vector<Vec3f> visited, read = readParticles(file, input).position;
        visitPositions(file, input,
                       [&](std::span<const Vec3f> some) { visited.insert(visited.end(), some.begin(), some.end()); });
        EXPECT_EQ(visited, read);
        std::sort(read.begin(), read.end(),
                  [](const Vec3f& a, const Vec3f& b) { return std::pair(a.y, a.x) < std::pair(b.y, b.x); });
        return read;
    };
    const std::vector<Vec3f> wall{{0, -1, 0}, {0.25F, -1, 0}, {0.5F, -1, 0}};
    ParticleInput input;
    EXPECT_EQ(positionsOf(input).size(), 8U);
    input.grid = {"wall"};
    EXPECT_EQ(positionsOf(input), wall);
    EXPECT_EQ(readSummarised(file, input).summary.particles_read, 3U);
    input.grid = {"wall", "fluid"};
    EXPECT_EQ(positionsOf(input).size(), 8U);
    for (const char* absent : {"foam", "density"}) {
        input.grid = {absent};
        expectError([&] { readParticles(file, input); },
                    {std::string("no point grid '") + absent + "'", "'fluid', 'wall'"});
    }
    input.grid.clear();
    input.group = {"spray"};
    EXPECT_EQ(positionsOf(input), (std::vector<Vec3f>{{0.75F, 0, 0}, {1, 0, 0}}));
    input.group = {"odd", "spray"};  // those of both
    EXPECT_EQ(positionsOf(input), (std::vector<Vec3f>{{0.25F, 0, 0}, {0.75F, 0, 0}, {1, 0, 0}}));
    input.where = "v.z < 4";
    EXPECT_EQ(positionsOf(input), (std::vector<Vec3f>{{0.25F, 0, 0}, {0.75F, 0, 0}}));
    input.where.clear();
    input.group = {"foam"};
    expectError([&] { readParticles(file, input); }, {"no point group 'foam'", "'odd', 'spray'"});

    // Or all groups are read: ones for members, also in grids that lack the group.
    ReadOptions with_groups;
    with_groups.all_groups = true;
    const FileContents contents = readVdb(file, with_groups);
    EXPECT_TRUE(contents.passed_over.empty());
    for (const Attribute& a : contents.attributes)
        if (a.name == "group:spray") {
            EXPECT_EQ(std::accumulate(a.integer.begin(), a.integer.end(), 0), 2);
            EXPECT_EQ(a.integer.size(), 8U);
        }
    EXPECT_EQ(std::count_if(contents.attributes.begin(), contents.attributes.end(), isPointGroup), 2);

    // Everything in the file is listed, with what it is used for.
    std::map<std::string, std::string> uses;
    for (const InputPart& part : readSummarised(file, {}).summary.parts) uses[part.name] = part.use;
    const std::map<std::string, std::string> expected{{"fluid", "position"}, {"wall", "position"}, {"density", ""},
                                                      {"spray", ""},         {"odd", ""},          {"P", "position"},
                                                      {"v", "velocity"}};
    EXPECT_EQ(uses, expected);
}

TEST(VdbFile, GroupsAreWrittenAsPointGroups) {
    const TemporaryFolder folder;
    Particles particles = sampleParticles(2000, true, true, false);  // several leaves
    std::iota(particles.id.begin(), particles.id.end(), std::uint64_t{0});
    for (const int step : {3, 5000, 1}) {  // some, one and all
        Attribute group{"group:every" + std::to_string(step), 1, {}, {}};
        for (std::size_t i = 0; i < particles.size(); ++i)
            group.integer.push_back(i % static_cast<std::size_t>(step) == 0);
        particles.attributes.push_back(group);
    }
    particles.attributes.push_back({"group:weight", 1, std::vector<float>(particles.size(), 0.5F), {}});  // is none
    const std::string file = folder / "a.vdb";
    writeParticles(file, particles);
    const FileInfo info = inspectFile(file);
    EXPECT_EQ(info.groups, (std::vector<std::string>{"every1", "every3", "every5000"}));
    ParticleInput input;
    input.group = {"every3"};
    std::vector<Vec3f> third;
    for (std::size_t i = 0; i < particles.size(); i += 3) third.push_back(particles.position[i]);
    EXPECT_EQ(sortedById(readParticles(file, input)).position, third);
    input.group = {"every5000"};
    EXPECT_EQ(readParticles(file, input).position, std::vector<Vec3f>{particles.position[0]});
    input.group = {"every1"};
    EXPECT_EQ(readParticles(file, input).size(), particles.size());
    const Particles all = readParticles(file);
    ASSERT_EQ(all.attributes.size(), 1U);
    EXPECT_EQ(all.attributes[0].name, "group:weight");
    EXPECT_EQ(encodeVdb(particles, "a.vdb"), contentsOf(file));
}

TEST(VdbFile, FileInfoReportsTypesAndCodecs) {
    const TemporaryFolder folder;
    writeParticles(folder / "a.vdb", sampleParticles(10, true, true, true));
    const FileInfo info = inspectFile(folder / "a.vdb");
    EXPECT_EQ(info.kind, FileKind::particles);
    EXPECT_EQ(info.points, 10U);
    EXPECT_NE(info.format.find("vdb points"), std::string::npos);
    ASSERT_EQ(info.attributes.size(), 8U);
    EXPECT_EQ(info.attributes[0].name, "P");
    EXPECT_EQ(info.attributes[1].type, "vec3s");
    EXPECT_EQ(info.attributes[2].type, "int64");
    EXPECT_EQ(info.attributes[5].name, "frame");
    EXPECT_EQ(info.attributes[5].components, 6U);
}

TEST(VdbFile, DamagedFilesAreErrorsThatNameTheFile) {
    const TemporaryFolder folder;
    std::ofstream(folder / "a.vdb") << "no vdb at all";
    expectError([&] { readParticles(folder / "a.vdb"); }, {"a.vdb"});
    std::ofstream(folder / "b.vdb") << "";
    expectError([&] { readParticles(folder / "b.vdb"); }, {"b.vdb"});
    expectError([&] { readParticles(folder / "none.vdb"); }, {"none.vdb"});
    const std::string bytes = encodeVdb(sampleParticles(2000, true, true, true), "c");
    for (const std::size_t tenths : {1U, 5U, 9U}) {
        std::ofstream(folder / "c.vdb", std::ios::binary) << bytes.substr(0, bytes.size() * tenths / 10);
        expectError([&] { readParticles(folder / "c.vdb"); }, {"c.vdb"});
    }
}

TEST(VdbFile, ReadingInPiecesGivesTheSameParticles) {
    const TemporaryFolder folder;
    const std::vector<std::string> files{folder / "few.vdb", folder / "many.vdb", folder / "none.vdb",
                                         folder / "codecs.vdb"};
    writeParticles(files[0], sampleParticles(3, true, true, true));
    writeParticles(files[1], sampleParticles(100000, true, true, true));
    writeParticles(files[2], {});
    writeVdbOfManyCodecs(files[3]);
    for (const std::string& file : files)
        for (const bool attributes : {true, false}) {
            SCOPED_TRACE(file);
            ReadOptions options;
            options.attributes = attributes;
            const FileContents whole = readVdb(file, options);
            FileContents pieces;
            std::size_t count = 0;
            options.points = [&](FileContents&& points, std::uint64_t all) {
                ++count;
                append(std::move(points), all, pieces);
            };
            const FileContents rest = readVdb(file, options);
            EXPECT_TRUE(rest.position.empty());
            EXPECT_EQ(rest.declared.size(), whole.declared.size());
            EXPECT_EQ(count > 1, file == files[1] || file == files[3]);
            EXPECT_EQ(pieces.position, whole.position);
            EXPECT_EQ(pieces.id, whole.id);
            expectSame(pieces.attributes, whole.attributes);
        }
}

}  // namespace betamesh
