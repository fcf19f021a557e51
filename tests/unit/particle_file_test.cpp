// Reading particles in blocks, in all formats.

#include "io/particle_file.h"

#include "io/extension.h"
#include "io/output_file.h"
#include "support/file_checks.h"

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <limits>
#include <numeric>
#include <sstream>

namespace betamesh {
namespace {

/// The extensions of all formats that hold particles and can be written.
std::vector<std::string> particleFormats() {
    std::istringstream in(extensionsFor(FileKind::particles, Access::write));
    return {std::istream_iterator<std::string>(in), {}};
}

// The file has more particles than a block of any reader.
TEST(ParticleFile, SelectedRowsEqualThoseOfTheWholeFile) {
    const TemporaryFolder folder;
    Particles particles = sampleParticles(50000, true, true, true);
    for (Attribute& a : particles.attributes)
        if (a.name == "state") a.integer.back() = std::numeric_limits<std::int32_t>::min();
    for (const std::string& format : particleFormats()) {
        SCOPED_TRACE(format);
        const auto file = folder / ("a" + format);
        writeParticles(file, particles);
        const Particles all = readParticles(file);
        ASSERT_EQ(all.size(), particles.size());
        std::vector<Vec3f> positions;
        visitPositions(
            file, [&](std::span<const Vec3f> some) { positions.insert(positions.end(), some.begin(), some.end()); });
        EXPECT_EQ(positions, all.position);
        std::vector<std::uint32_t> every, few, late{49998, 49999};
        for (std::uint32_t row = 0; row < 50000; ++row) {
            every.push_back(row);
            if (row % 1001 == 7) few.push_back(row);
        }
        for (const auto& rows : {every, few, late}) expectSame(readParticles(file, {}, rows), rowsOf(all, rows));
    }
}

TEST(ParticleFile, ChosenRowsAreFoundInTheFile) {
    const TemporaryFolder folder;
    constexpr std::uint32_t kParticles = 30000;
    Particles particles = sampleParticles(kParticles, false, false, false);
    particles.attributes.push_back({"row", 1, {}, {}});
    for (std::uint32_t row = 0; row < kParticles; ++row)
        particles.attributes.back().integer.push_back(static_cast<std::int32_t>(row));
    for (const std::string& format : particleFormats()) {
        SCOPED_TRACE(format);
        const auto file = folder / ("a" + format);
        writeParticles(file, particles);
        const auto rowsIn = [&](const ParticleInput& input) {
            for (const Attribute& a : readParticles(file, input).attributes)
                if (a.name == "row") return a.integer;
            return std::vector<std::int32_t>{};
        };
        const std::vector<std::int32_t> all = rowsIn({});  // OpenVDB does not keep their order
        for (const char* where : {"", "row > 500 && row < 20000", "row < 100 || row >= 29990", "row >= 12345"}) {
            ParticleInput input;
            input.where = where;
            const std::vector<std::int32_t> chosen = rowsIn(input);
            ASSERT_FALSE(chosen.empty());
            for (std::size_t i = 0; i < chosen.size(); i += std::max<std::size_t>(1, chosen.size() / 20))
                EXPECT_EQ(all[rowInFile(file, input, i)], chosen[i]) << where;
        }
    }
}

/// Rows by id and attributes by name: OpenVDB keeps neither order.
Particles sorted(const Particles& particles) {
    std::vector<std::uint32_t> rows(particles.size());
    std::iota(rows.begin(), rows.end(), 0U);
    std::sort(rows.begin(), rows.end(), [&](auto a, auto b) { return particles.id[a] < particles.id[b]; });
    Particles result = rowsOf(particles, rows);
    std::sort(result.attributes.begin(), result.attributes.end(),
              [](const Attribute& a, const Attribute& b) { return a.name < b.name; });
    return result;
}

TEST(ParticleFile, WritingWithZUpUndoesReadingWithZUp) {
    const TemporaryFolder folder;
    Particles particles = sampleParticles(100, true, true, false);
    for (const char* name : {"N", "accel", "Cd"}) {
        particles.attributes.push_back({name, 3, {}, {}});
        for (const Vec3f& p : particles.position)
            particles.attributes.back().real.insert(particles.attributes.back().real.end(), {p.z, p.x, 3 * p.y});
    }
    ParticleInput z_up;
    z_up.up_axis = UpAxis::z;
    for (const std::string& format : particleFormats()) {
        SCOPED_TRACE(format);
        writeParticles(folder / ("a" + format), particles, {.up_axis = UpAxis::z});
        expectSame(sorted(readParticles(folder / ("a" + format), z_up)), sorted(particles));
        const Particles rotated = sorted(readParticles(folder / ("a" + format)));
        const Particles original = sorted(particles);
        const Vec3f &p = original.position[7], &v = original.velocity[7];
        EXPECT_EQ(rotated.position[7], Vec3f(p.x, -p.z, p.y));
        EXPECT_EQ(rotated.velocity[7], Vec3f(v.x, -v.z, v.y));
        ASSERT_EQ(rotated.attributes[0].name, "Cd");
        EXPECT_EQ(rotated.attributes[0].real, original.attributes[0].real);  // a colour has no direction
    }
}

TEST(ParticleFile, AsciiNumbersMayCrossReadBuffers) {
    const TemporaryFolder folder;
    const Particles particles = sampleParticles(40000, false, false, false);
    std::string text =
        "ply\nformat ascii 1.0\nelement vertex 40000\nproperty float x\nproperty list uchar int some\n"
        "property float y\nproperty float z\nend_header\n";
    for (std::size_t i = 0; i < particles.size(); ++i) {
        const Vec3f& p = particles.position[i];
        const std::string space(i % 5000 == 0 ? 10000 : 1, ' ');
        char row[200];
        std::snprintf(row, sizeof row, "%.9g 2 7 %zu %.9g %.9g\n", double{p.x}, i, double{p.y}, double{p.z});
        text += space + row;
    }
    writeFile(folder / "a.ply", text);
    EXPECT_EQ(readParticles(folder / "a.ply").position, particles.position);
    writeFile(folder / "b.ply", text.substr(0, text.size() - 20));
    expectError([&] { readParticles(folder / "b.ply"); }, {"b.ply: byte", "ends"});
}

TEST(ParticleFile, NonFiniteValuesAreFoundInRowsThatAreNotSelected) {
    const TemporaryFolder folder;
    Particles particles = sampleParticles(40000, true, true, false);
    writeParticles(folder / "a.ply", particles);
    const Bytes good = readWholeFile(folder / "a.ply");
    constexpr std::size_t kRow = 28, kBad = 20001;  // x y z vx vy vz id
    const std::size_t first = good.size() - particles.size() * kRow;
    for (const std::size_t number : {1, 4}) {
        Bytes bad = good;
        const float nan = std::numeric_limits<float>::quiet_NaN();
        std::memcpy(&bad[first + kBad * kRow + number * sizeof nan], &nan, sizeof nan);
        writeFile(folder / "b.ply", {reinterpret_cast<const char*>(bad.data()), bad.size()});
        const std::string what = number == 1 ? "position" : "velocity";
        expectError([&] { readParticles(folder / "b.ply"); }, {"b.ply: particle 20001: " + what});
        expectError([&] { readParticles(folder / "b.ply", {}, {1, 2}); }, {"b.ply: particle 20001: " + what});
        if (number == 1)
            expectError([&] { visitPositions(folder / "b.ply", [](std::span<const Vec3f>) {}); },
                        {"b.ply: particle 20001: position"});
    }
}

TEST(ParticleFile, ExceptionsOfTheReceiverArePropagated) {
    const TemporaryFolder folder;
    for (const std::string& format : particleFormats()) {
        SCOPED_TRACE(format);
        const auto file = folder / ("a" + format);
        writeParticles(file, sampleParticles(10, true, true, false));
        EXPECT_THROW(visitPositions(file, [](std::span<const Vec3f>) { throw std::bad_alloc(); }), std::bad_alloc);
        EXPECT_THROW(visitPositions(file, [](std::span<const Vec3f>) { throw 7; }), int);
    }
}

}  // namespace
}  // namespace betamesh
