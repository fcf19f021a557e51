// Which particles of a file are read, and what its attributes mean.

#include "io/particle_file.h"

#include "base/random.h"
#include "io/extension.h"
#include "io/output_file.h"
#include "support/file_checks.h"

#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <set>
#include <sstream>

namespace betamesh {
namespace {

constexpr const char* kFormats[] = {".ply", ".bgeo", ".bgeo.gz", ".bgeo.sc", ".bhclassic", ".vdb"};
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

/// A property of the element vertex with its numbers.
struct Property {
    std::string type, name;
    std::vector<double> numbers;
};

/// An ascii .ply whose points lie on a line, from (0, 0, 0) to (n - 1, 0, 0), unless a property is called x; with more
/// properties.
std::string plyText(std::size_t n, const std::vector<Property>& more, const std::string& before_vertex = "") {
    std::vector<Property> all = more;
    const bool has_position =
        std::any_of(more.begin(), more.end(), [](const Property& p) { return p.name == "x" || p.name == "px"; });
    if (!has_position) {
        all.push_back({"float", "x", {}});
        for (std::size_t i = 0; i < n; ++i) all.back().numbers.push_back(static_cast<double>(i));
        for (const char* name : {"y", "z"}) all.push_back({"float", name, std::vector<double>(n)});
    }
    std::string text = "ply\nformat ascii 1.0\n" + before_vertex + "element vertex " + std::to_string(n) + "\n";
    for (const Property& p : all) text += "property " + p.type + " " + p.name + "\n";
    text += "end_header\n";
    if (!before_vertex.empty()) text += "3 0 1 2\n";
    for (std::size_t i = 0; i < n; ++i) {
        for (const Property& p : all) {
            char number[40];
            std::snprintf(number, sizeof number, p.type.find("int") != std::string::npos ? "%.0f " : "%.17g ",
                          p.numbers.at(i));
            text += number;
        }
        text += '\n';
    }
    return text;
}

Particles particlesWhere(const Particles& particles, const std::function<bool(std::size_t)>& isKept) {
    std::vector<std::uint32_t> rows;
    for (std::uint32_t row = 0; row < particles.size(); ++row)
        if (isKept(row)) rows.push_back(row);
    return rowsOf(particles, rows);
}

const Attribute& attributeOf(const Particles& particles, const std::string& name) {
    for (const Attribute& a : particles.attributes)
        if (a.name == name) return a;
    throw Error("no attribute " + name);
}

// The file has more particles than a block of any reader. Reading all, some rows and the positions agree.
TEST(ParticleInput, ChosenParticlesAreThoseOfTheWholeFileThatFit) {
    const TemporaryFolder folder;
    constexpr std::size_t kParticles = 30000;
    const Particles particles = sampleParticles(kParticles, true, true, true);
    for (const char* format : kFormats) {
        SCOPED_TRACE(format);
        const auto file = folder / ("a" + std::string(format));
        writeParticles(file, particles);
        const Particles all = readParticles(file);
        const std::vector<std::int32_t>& state = attributeOf(all, "state").integer;
        const float middle = all.position[kParticles / 2].y;
        ParticleInput odd, box, both;
        odd.where = "state > 0 && id > 9";
        box.box = {-1e30, static_cast<double>(middle), -1e30, 1e30, 1e30, 1e30};
        both.where = odd.where;
        both.box = box.box;
        const auto isOdd = [&](std::size_t row) { return state[row] > 0 && all.id[row] > 9; };
        const auto isInside = [&](std::size_t row) { return all.position[row].y >= middle; };
        const std::vector<std::pair<ParticleInput, std::function<bool(std::size_t)>>> choices{
            {odd, isOdd}, {box, isInside}, {both, [&](std::size_t row) { return isOdd(row) && isInside(row); }}};
        for (const auto& [input, isKept] : choices) {
            const Particles expected = particlesWhere(all, isKept);
            ASSERT_GT(expected.size(), 0U);
            ASSERT_LT(expected.size(), all.size());
            const SummarisedParticles read = readSummarised(file, input);
            expectSame(read.particles, expected);
            EXPECT_EQ(read.summary.particles_read, kParticles);
            std::vector<Vec3f> positions;
            visitPositions(file, input, [&](std::span<const Vec3f> some) {
                positions.insert(positions.end(), some.begin(), some.end());
            });
            EXPECT_EQ(positions, expected.position);
            positions.clear();
            std::vector<std::int32_t> states;
            visitAttributes(file, input, [&](const Particles& some) {
                positions.insert(positions.end(), some.position.begin(), some.position.end());
                const std::vector<std::int32_t>& more = attributeOf(some, "state").integer;
                states.insert(states.end(), more.begin(), more.end());
            });
            EXPECT_EQ(positions, expected.position);
            EXPECT_EQ(states, attributeOf(expected, "state").integer);
            const std::vector<std::uint32_t> rows{0, 7, static_cast<std::uint32_t>(expected.size()) - 1};
            expectSame(readParticles(file, input, rows), particlesWhere(expected, [&](std::size_t row) {
                           return std::find(rows.begin(), rows.end(), row) != rows.end();
                       }));
        }
    }
}

TEST(ParticleInput, BadParticlesAreAnErrorOrAreDroppedAndCounted) {
    const TemporaryFolder folder;
    const std::string file = folder / "a.ply";
    std::vector<double> x(20000, 1), vx(20000, 0), type(20000, 1);
    x[12345] = std::numeric_limits<double>::infinity();
    vx[17] = std::numeric_limits<double>::quiet_NaN();
    type[12345] = 0;
    const std::vector<double> zero(20000, 0);
    writeFile(file, plyText(20000, {{"float", "x", x},
                                    {"float", "y", zero},
                                    {"float", "z", zero},
                                    {"float", "vx", vx},
                                    {"float", "vy", zero},
                                    {"float", "vz", zero},
                                    {"int", "type", type}}));
    expectError([&] { readParticles(file); }, {"a.ply: particle 12345: position", "--on-bad-particle drop"});
    ParticleInput input;
    input.where = "type == 1";  // without the particle at infinity
    expectError([&] { readParticles(file, input); }, {"a.ply: particle 17: velocity", "--on-bad-particle drop"});
    input.where = "type == 0";
    expectError([&] { readParticles(file, input); }, {"a.ply: particle 12345: position"});
    expectError([&] { visitPositions(file, input, [](std::span<const Vec3f>) {}); },
                {"a.ply: particle 12345: position"});
    input.where = "type == 1 && P.x < 0";
    EXPECT_EQ(readParticles(file, input).size(), 0U);

    input.where = "";
    input.on_bad_particle = OnBadParticle::drop;
    const SummarisedParticles read = readSummarised(file, input);
    EXPECT_EQ(read.particles.size(), 19998U);
    EXPECT_EQ(read.summary.particles_read, 20000U);
    EXPECT_EQ(read.summary.dropped, 2U);
    EXPECT_EQ(read.summary.first_dropped.find("particle 17: velocity is (nan"), 0U) << read.summary.first_dropped;
    std::size_t visited = 0;
    visitPositions(file, input, [&](std::span<const Vec3f> some) { visited += some.size(); });
    EXPECT_EQ(visited, 19998U);  // the same particles as are read
    visited = 0;
    visitAttributes(file, input, [&](const Particles& some) { visited += some.size(); });
    EXPECT_EQ(visited, 19998U);
}

TEST(ParticleInput, GroupsAndGridsThatAreNotThereAreNamed) {
    const TemporaryFolder folder;
    Particles particles = sampleParticles(100, true, true, false);
    Attribute group{"group:spray", 1, {}, {}};
    for (std::size_t i = 0; i < particles.size(); ++i) group.integer.push_back(i % 3 == 0);
    particles.attributes.push_back(group);
    writeParticles(folder / "a.bgeo", particles);
    particles.attributes.clear();
    writeParticles(folder / "a.ply", particles);
    ParticleInput input;
    input.group = {"spray"};
    EXPECT_EQ(readParticles(folder / "a.bgeo", input).position,
              particlesWhere(particles, [](std::size_t row) { return row % 3 == 0; }).position);
    expectError([&] { readParticles(folder / "a.ply", input); },
                {"a.ply: has no point group 'spray'", "no point groups"});
    input.group = {"foam"};
    expectError([&] { readParticles(folder / "a.bgeo", input); }, {"no point group 'foam'", "'spray'"});
    input = {};
    input.grid = {"fluid"};
    expectError([&] { readParticles(folder / "a.ply", input); }, {"a.ply: has no grids", "fluid"});
}

TEST(ParticleInput, TheMissingComponentOfAVelocityIsNamed) {
    const auto scalar = [](const char* name) { return Attribute{name, 1, {1.0F}, {}}; };
    EXPECT_EQ(incompleteVelocity({scalar("vx"), scalar("mass"), scalar("vy")}, 1),
              "there are 'vx' and 'vy', but 'vz' is missing");
    EXPECT_EQ(incompleteVelocity({scalar("Vel.z [m/s]"), scalar("Vel.x [m/s]")}, 1),
              "there are 'Vel.x [m/s]' and 'Vel.z [m/s]', but 'vel.y' is missing");
    // Counted from 0 or from 1.
    EXPECT_EQ(incompleteVelocity({scalar("v_1"), scalar("v_2")}, 1),
              "there are 'v_1' and 'v_2', but either 'v_0' or 'v_3' is missing");
    EXPECT_EQ(incompleteVelocity({scalar("v_1"), scalar("v_0")}, 1), "there are 'v_0' and 'v_1', but 'v_2' is missing");
    EXPECT_EQ(incompleteVelocity({scalar("v_2"), scalar("v_3"), scalar("vel.x"), scalar("vel.y")}, 1),
              "there are 'v_2' and 'v_3', but 'v_1' is missing");
    EXPECT_EQ(incompleteVelocity({{"vel", 2, {1, 2}, {}}}, 1), "'vel' has x and y, but z is missing");
    for (const std::vector<Attribute>& none : {std::vector<Attribute>{}, {scalar("u"), scalar("v")}, {scalar("vx")}})
        EXPECT_EQ(incompleteVelocity(none, 1), "");
}

TEST(ParticleInput, EveryUsualNameOfTheVelocityIsFound) {
    const TemporaryFolder folder;
    const std::string file = folder / "a.ply";
    const auto velocityFrom = [&](const std::vector<std::string>& names) {
        std::vector<Property> properties;
        for (std::size_t k = 0; k < names.size(); ++k)
            properties.push_back({"float", names[k], std::vector<double>(5, static_cast<double>(k % 3 + 1))});
        writeFile(file, plyText(5, properties));
        return readSummarised(file, {});
    };
    const std::vector<std::vector<std::string>> spellings{{"vx", "vy", "vz"},
                                                          {"velx", "vely", "velz"},
                                                          {"u", "v", "w"},
                                                          {"Velocity_x", "Velocity_y", "Velocity_z"},
                                                          {"velocity_x", "velocity_y", "velocity_z"},
                                                          {"v_1", "v_2", "v_3"},
                                                          {"v_0", "v_1", "v_2"},
                                                          {"VX", "VY", "VZ"},
                                                          {"vel.X", "vel.Y", "vel.Z"},
                                                          {"Velocities:0", "Velocities:1", "Velocities:2"},
                                                          {"velu", "velv", "velw"},
                                                          {"vel[0]", "vel[1]", "vel[2]"},
                                                          {"v1", "v2", "v3"}};
    for (const auto& names : spellings) {
        SCOPED_TRACE(names[0]);
        const SummarisedParticles read = velocityFrom(names);
        EXPECT_EQ(read.particles.velocity, std::vector<Vec3f>(5, Vec3f(1, 2, 3)));
        EXPECT_TRUE(read.particles.attributes.empty());
        EXPECT_FALSE(read.summary.velocity.empty());
        for (const InputPart& part : read.summary.parts) EXPECT_NE(part.use, "") << part.name;
    }
    // In the order of preference: the format's own, then vectors, then components.
    const SummarisedParticles several = velocityFrom({"u", "v", "w", "vx", "vy", "vz", "velx", "vely", "velz"});
    EXPECT_EQ(several.summary.velocity, "v");
    EXPECT_EQ(several.particles.attributes.size(), 6U);
    EXPECT_EQ(velocityFrom({"u", "v", "w", "velx", "vely", "velz"}).summary.velocity, "velx, vely, velz");

    // Not the velocity, but named as candidates.
    const SummarisedParticles none = velocityFrom({"mom_x", "mom_y", "mom_z", "a.1", "a.2", "a.3", "vx", "vy"});
    EXPECT_TRUE(none.particles.velocity.empty());
    EXPECT_EQ(none.summary.velocity_candidates, (std::vector<std::string>{"mom", "a.1,a.2,a.3"}));
    ParticleInput input;
    input.velocity = "mom";
    EXPECT_EQ(readParticles(file, input).velocity, std::vector<Vec3f>(5, Vec3f(1, 2, 3)));
    input.velocity = "a.3, a.2,a.1";
    EXPECT_EQ(readParticles(file, input).velocity, std::vector<Vec3f>(5, Vec3f(3, 2, 1)));
    input.velocity = "mom_z,mom_y,mom_x";  // components of a vector
    EXPECT_EQ(readParticles(file, input).velocity, std::vector<Vec3f>(5, Vec3f(3, 2, 1)));
    for (const char* absent : {"v", "mom_x,mom_y,mom_w", "vx,vy,vz"}) {
        input.velocity = absent;
        expectError([&] { readParticles(file, input); }, {"a.ply: has no velocity attribute", "mom_x"});
    }
}

TEST(ParticleInput, PropertiesThatNobodyAskedForDoNotMatter) {
    const TemporaryFolder folder;
    const std::string file = folder / "a.ply";
    writeFile(file, plyText(4, {{"int64", "id", {0x1p40, 0x1p41, 3, 4}}, {"uint64", "hash", {1, 2, 3, 0x1p63}}}));
    Particles read = readParticles(file);
    EXPECT_EQ(read.id, (std::vector<std::uint64_t>{1ULL << 40, 1ULL << 41, 3, 4}));
    EXPECT_EQ(read.size(), 4U);

    writeFile(file, plyText(4, {}, "element face 1\nproperty list uchar int vertex_indices\n"));
    EXPECT_EQ(readParticles(file).position.back(), Vec3f(3, 0, 0));

    writeFile(file, plyText(2, {{"float", "px", {1, 2}}, {"float", "py", {3, 4}}, {"float", "pz", {5, 6}}}));
    EXPECT_EQ(readParticles(file).position, (std::vector<Vec3f>{{1, 3, 5}, {2, 4, 6}}));
    writeFile(file, plyText(2, {{"float", "px", {1, 2}}, {"float", "py", {3, 4}}}));
    expectError([&] { readParticles(file); }, {"a.ply", "'x'"});
}

/// Attributes of random names, types and numbers of components.
std::vector<Attribute> randomAttributes(std::size_t n, Random& random) {
    const std::vector<std::string> names{"Cd", "temp",   "density", "type", "age",  "w1",   "K",
                                         "m",  "stress", "flags",   "Cs",   "rest", "Temp", "normal_2"};
    std::vector<Attribute> attributes;
    for (const std::string& name : names) {
        if (random.unit() < 0.4) continue;
        Attribute attribute{name, random.unit() < 0.5 ? 1U : 3U, {}, {}};
        for (std::size_t i = 0; i < n * attribute.components; ++i) {
            const auto number = static_cast<float>(std::floor(1000 * random.unit()));
            attribute.real.push_back(number / 8);
        }
        if (attribute.components == 1 && random.unit() < 0.5) {
            for (const float number : attribute.real)
                attribute.integer.push_back(static_cast<std::int32_t>(8 * number));
            attribute.real.clear();
        }
        attributes.push_back(attribute);
    }
    return attributes;
}

// Whatever the format and the attributes: every particle and every attribute of a file is read, and is a part of its
// summary, either with a use or without one; the job names those without.
TEST(ParticleInput, EveryPartOfAFileIsReadAndNamed) {
    const TemporaryFolder folder;
    std::istringstream extensions(extensionsFor(FileKind::particles, Access::write));
    std::uint64_t seed = 0;
    for (std::string extension; extensions >> extension;) {
        for (int round = 0; round < 8; ++round) {
            SCOPED_TRACE(extension + ' ' + std::to_string(seed));
            Random random(++seed);
            Particles written = sampleParticles(1 + static_cast<std::size_t>(300 * random.unit()), random.unit() < 0.7,
                                                random.unit() < 0.7, false);
            written.attributes = randomAttributes(written.size(), random);
            const std::string file = folder / ("a" + extension);
            writeParticles(file, written);
            const auto [read, summary] = readSummarised(file, {});
            EXPECT_EQ(summary.particles_read, written.size());
            EXPECT_EQ(read.size() + summary.dropped, written.size());
            std::map<std::string, std::set<std::string>> uses;  // by attribute
            for (const InputPart& part : summary.parts) {
                if (part.kind != InputPart::Kind::attribute) continue;
                const auto component = componentName(part.name);
                uses[part.name].insert(part.use);
                if (component) uses[component->vector].insert(part.use);
            }
            for (const Attribute& attribute : written.attributes) {
                EXPECT_TRUE(uses.contains(attribute.name)) << attribute.name;
                EXPECT_EQ(uses[attribute.name], std::set<std::string>{""}) << attribute.name;
                const auto has = [&](const Attribute& a) {
                    const auto component = componentName(a.name);
                    return a.name == attribute.name || (component && component->vector == attribute.name);
                };
                EXPECT_TRUE(std::any_of(read.attributes.begin(), read.attributes.end(), has)) << attribute.name;
            }
            const auto used = [&](const std::string& use) {
                return std::any_of(summary.parts.begin(), summary.parts.end(),
                                   [&](const InputPart& part) { return part.use == use; });
            };
            EXPECT_TRUE(used("position"));
            EXPECT_EQ(used("velocity"), !summary.velocity.empty());
            EXPECT_GE(used("velocity"), !written.velocity.empty());
            EXPECT_EQ(used("id"), !written.id.empty());
        }
    }
}

TEST(ParticleInput, ScalesAndTheUpAxisApplyToVectors) {
    const TemporaryFolder folder;
    Particles particles = sampleParticles(1000, true, true, false);
    Attribute accel{"accel", 3, {}, {}}, normal{"N", 3, {}, {}}, colour{"Cd", 3, {}, {}};
    for (std::size_t i = 0; i < 3 * particles.size(); ++i)
        for (Attribute* a : {&accel, &normal, &colour}) a->real.push_back(static_cast<float>(i % 7));
    particles.attributes = {accel, normal, colour};
    const auto scaled = [](const Vec3f& v, double scale) {
        return Vec3f(static_cast<float>(v.x * scale), static_cast<float>(v.z * scale),
                     -static_cast<float>(v.y * scale));
    };
    for (const char* format : {".ply", ".bgeo"}) {
        const auto file = folder / ("a" + std::string(format));
        writeParticles(file, particles);
        ParticleInput input;
        input.scale = 0.01;
        input.velocity_scale = 30;
        input.time_scale = 24.0 / 64;
        input.up_axis = UpAxis::z;
        const Particles read = readParticles(file, input);
        std::vector<Vec3f> positions;
        visitPositions(file, input, [&](std::span<const Vec3f> some) {
            positions.insert(positions.end(), some.begin(), some.end());
        });
        EXPECT_EQ(positions, read.position);
        const auto vectorAt = [](const Attribute& a, std::size_t i) {
            return Vec3f(a.real[3 * i], a.real[3 * i + 1], a.real[3 * i + 2]);
        };
        for (std::size_t i = 0; i < particles.size(); ++i) {
            EXPECT_EQ(read.position[i], scaled(particles.position[i], 0.01));
            EXPECT_EQ(read.velocity[i], scaled(particles.velocity[i], 0.01 * 30 * (24.0 / 64)));
            EXPECT_EQ(vectorAt(attributeOf(read, "accel"), i),
                      scaled(vectorAt(accel, i), 0.01 * (24.0 / 64) * (24.0 / 64)));
            EXPECT_EQ(vectorAt(attributeOf(read, "N"), i), scaled(vectorAt(normal, i), 1));
        }
        EXPECT_EQ(attributeOf(read, "Cd").real, colour.real);
        input.where = "P.y > 0";  // of the file, not of the world
        EXPECT_EQ(readParticles(file, input).size(),
                  static_cast<std::size_t>(std::count_if(particles.position.begin(), particles.position.end(),
                                                         [](const Vec3f& p) { return p.y > 0; })));
    }
}

// Doubles survive if the origin is subtracted before they are rounded; conditions see the numbers of the file.
TEST(ParticleInput, AnOriginIsSubtractedInDoublePrecision) {
    const TemporaryFolder folder;
    Random random(3);
    std::vector<double> x, y, z;
    for (int i = 0; i < 20000; ++i) {
        x.push_back(500123.4 + random.unit());
        y.push_back(4500987.6 + random.unit());
        z.push_back(312 + random.unit());
    }
    ParticleInput input;
    input.origin = {500120, 4500990, 310};
    const auto expect = [&](const std::string& file, double tolerance) {
        SCOPED_TRACE(file);
        const Particles read = readParticles(file, input);
        ASSERT_EQ(read.size(), x.size());
        for (std::size_t i = 0; i < x.size(); ++i) {
            EXPECT_NEAR(read.position[i].x, x[i] - 500120, tolerance);
            EXPECT_NEAR(read.position[i].y, y[i] - 4500990, tolerance);
            EXPECT_NEAR(read.position[i].z, z[i] - 310, tolerance);
        }
        ParticleInput above = input;
        above.where = "P.x > 500123.9";
        const auto count = std::count_if(x.begin(), x.end(), [](double coordinate) { return coordinate > 500123.9; });
        EXPECT_NEAR(static_cast<double>(readParticles(file, above).size()), static_cast<double>(count),
                    tolerance < 1e-3 ? 1 : 2000);
        above.where = "";
        above.box = {500123.9, 0, 0, 1e9, 1e9, 1e9};
        EXPECT_NEAR(static_cast<double>(readParticles(file, above).size()), static_cast<double>(count),
                    tolerance < 1e-3 ? 1 : 2000);
    };
    writeFile(folder / "ascii.ply", plyText(x.size(), {{"double", "x", x}, {"double", "y", y}, {"double", "z", z}}));
    EXPECT_TRUE(hasDoublePositions(folder / "ascii.ply"));
    expect(folder / "ascii.ply", 1e-6);

    std::string binary =
        "ply\nformat binary_little_endian 1.0\nelement vertex 20000\nproperty double x\nproperty double y\n"
        "property double z\nend_header\n";
    for (std::size_t i = 0; i < x.size(); ++i)
        for (const double number : {x[i], y[i], z[i]}) binary.append(reinterpret_cast<const char*>(&number), 8);
    writeFile(folder / "binary.ply", binary);
    EXPECT_TRUE(hasDoublePositions(folder / "binary.ply"));
    expect(folder / "binary.ply", 1e-6);

    Particles rounded;
    for (std::size_t i = 0; i < x.size(); ++i) rounded.position.emplace_back(Vec3(x[i], y[i], z[i]));
    writeParticles(folder / "float.bgeo", rounded);
    writeParticles(folder / "float.bhclassic", rounded);
    EXPECT_FALSE(hasDoublePositions(folder / "float.bgeo"));
    expect(folder / "float.bgeo", 0.5);  // what the file has lost is lost
    expect(folder / "float.bhclassic", 0.5);
}

}  // namespace
}  // namespace betamesh
