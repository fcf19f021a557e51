// Which particles a job meshes, what their attributes mean, and what it says of the rest of the input.

#include "base/random.h"
#include "io/curve_file.h"
#include "io/mesh_file.h"
#include "support/job_folder.h"

#include <cmath>

namespace betamesh {
namespace {

Attribute realAttribute(const std::string& name, std::size_t n, float value) {
    return {name, 1, std::vector<float>(n, value), {}};
}

/// Particles of a jittered block, spacing 0.1, that move downwards.
Particles block(std::size_t nx, std::size_t ny, std::size_t nz, const Vec3& corner = {0, 0, 0}) {
    Particles particles;
    Random random(5);
    for (std::size_t x = 0; x < nx; ++x)
        for (std::size_t y = 0; y < ny; ++y)
            for (std::size_t z = 0; z < nz; ++z) {
                const Vec3 lattice(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z));
                particles.position.emplace_back(corner + 0.1 * lattice + 0.02 * random.cube());
                particles.velocity.emplace_back(0, -1, 0);
            }
    return particles;
}

void append(const Particles& more, Particles& particles) {
    particles.position.insert(particles.position.end(), more.position.begin(), more.position.end());
    particles.velocity.insert(particles.velocity.end(), more.velocity.begin(), more.velocity.end());
}

/// A binary .ply of positions in double precision.
std::string doublesPly(const std::vector<Vec3>& positions) {
    std::string text = "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(positions.size()) +
                       "\nproperty double x\nproperty double y\nproperty double z\nend_header\n";
    for (const Vec3& p : positions)
        for (const double number : {p.x, p.y, p.z}) text.append(reinterpret_cast<const char*>(&number), sizeof number);
    return text;
}

class InputJob : public JobFolder {
protected:
    std::string meshBytes(int frame) { return contentsOf(folder_ / numbered("out/a", frame, ".ply")); }
};

// Frame 1: a tank with walls of type 0, whose spacing is half that of the liquid; frame 2: its liquid alone.
TEST_F(InputJob, ChosenParticlesGiveTheMeshOfAFileOfThemAlone) {
    const Particles liquid = block(8, 5, 8);
    Particles tank;
    for (std::size_t i = 0; i < 20; ++i)
        for (std::size_t k = 0; k < 20; ++k) {
            tank.position.emplace_back(-0.1F + 0.05F * static_cast<float>(i), -0.15F,
                                       -0.1F + 0.05F * static_cast<float>(k));
            tank.velocity.emplace_back(0, 0, 0);
        }
    const std::size_t wall = tank.size();
    append(liquid, tank);
    Attribute type{"type", 1, {}, std::vector<std::int32_t>(tank.size(), 1)};
    std::fill_n(type.integer.begin(), wall, 0);
    tank.attributes.push_back(type);
    fs::create_directories(folder_ / "in");
    writeParticles(folder_ / "in/a.0001.ply", tank);
    writeParticles(folder_ / "liquid.ply", liquid);
    ASSERT_EQ(runProgram({"mesh", "liquid.ply", "expected.ply"}, folder_.path()).exit_code, 0);
    const std::string expected = contentsOf(folder_ / "expected.ply");

    for (const std::vector<std::string>& choice : {std::vector<std::string>{"--where", "type == 1"},
                                                   {"--box=-1,-0.1,-1,2,2,2"},
                                                   {"--set", "input.where=type > 0 && P.y > -1"}}) {
        SCOPED_TRACE(choice.back());
        std::vector<std::string> further = choice;
        further.emplace_back("--overwrite");
        const Outcome outcome = mesh(further);
        ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
        EXPECT_EQ(meshBytes(1), expected);
        EXPECT_EQ(manifest(1)["particles"], liquid.size());
        EXPECT_EQ(manifest(1)["particles_read"], tank.size());
    }
    const auto checked = [&](const std::vector<std::string>& further) {
        std::vector<std::string> words{"check", "out/a.0001.ply", "--particles", "in/a.####.ply"};
        words.insert(words.end(), further.begin(), further.end());
        return runProgram(words, folder_.path()).exit_code;
    };
    EXPECT_EQ(checked({"--where", "type == 1"}), 0);
    EXPECT_EQ(checked({}), 1);  // the walls are outside

    const Outcome unknown = mesh({"--overwrite", "--where", "typ == 1"});
    EXPECT_EQ(unknown.exit_code, 1);
    EXPECT_NE(unknown.err.find("Did you mean 'type'?"), std::string::npos) << unknown.err;
    const Outcome none = mesh({"--overwrite", "--where", "type == 7", "--spacing", "0.1"});
    EXPECT_EQ(none.exit_code, 0) << none.err;
    EXPECT_NE(none.err.find("none of the"), std::string::npos) << none.err;
    EXPECT_EQ(mesh({"--overwrite", "--where", "type = 1"}).exit_code, 2);
    EXPECT_EQ(mesh({"--overwrite", "--box", "1,1,1,0,0,0"}).exit_code, 2);
}

TEST_F(InputJob, BadParticlesAreDroppedOnRequest) {
    Particles particles = block(6, 6, 6);
    particles.velocity.clear();
    for (int frame = 1; frame <= 3; ++frame) writeFrame(frame, particles);
    std::string bad = contentsOf(folder_ / "in/a.0002.ply");
    const float nan = std::numeric_limits<float>::quiet_NaN();
    bad.replace(bad.find("end_header\n") + 11 + 77 * 12, sizeof nan, reinterpret_cast<const char*>(&nan), sizeof nan);
    write(folder_ / "in/a.0002.ply", bad);
    const Outcome error = mesh();
    EXPECT_EQ(error.exit_code, 1);
    EXPECT_NE(error.err.find("particle 77: position"), std::string::npos) << error.err;
    EXPECT_TRUE(written(1) && absent(2) && written(3));

    const Outcome dropped = mesh({"--overwrite", "--on-bad-particle", "drop"});
    EXPECT_EQ(dropped.exit_code, 0) << dropped.err;
    EXPECT_NE(dropped.err.find("1 particle is left out"), std::string::npos) << dropped.err;
    EXPECT_EQ(manifest(2)["particles"], particles.size() - 1);
    EXPECT_EQ(manifest(2)["particles_dropped"], 1);
    EXPECT_EQ(manifest(1)["particles_dropped"], 0);
}

TEST_F(InputJob, MessagesNameTheRowsOfTheFile) {
    constexpr std::size_t kBad = 1000;
    const auto bad = [&](const std::string& key, const std::string& value) {
        std::string table = "x,y,z,key,size,heat\n";
        const Particles particles = block(12, 12, 12);
        for (std::size_t i = 0; i < particles.size(); ++i) {
            const Vec3f& p = particles.position[i];
            const bool is_bad = i == kBad, is_dropped = i % 100 == 7;
            table += (is_dropped             ? "nan"
                      : is_bad && key == "x" ? value
                                             : std::to_string(p.x)) +
                     ',' + std::to_string(p.y) + ',' + std::to_string(p.z) + ',' + std::to_string(i % 3) + ',' +
                     (is_bad && key == "size" ? value : "0.1") + ',' + (is_bad && key == "heat" ? value : "1") + '\n';
        }
        write(folder_ / "a.csv", table);
    };
    const auto said = [&](std::vector<std::string> words, const std::vector<std::string>& further) {
        words.insert(words.end(), {"--on-bad-particle", "drop"});
        words.insert(words.end(), further.begin(), further.end());
        const Outcome outcome = runProgram(words, folder_.path());
        return outcome.out + outcome.err;
    };
    const std::vector<std::string> mesh{"mesh", "a.csv", "o.ply", "--overwrite", "--spacing", "0.1"};
    std::vector<std::string> sizes = mesh, plan = mesh, streamed = mesh, values = mesh;
    for (auto* words : {&sizes, &plan, &streamed}) words->insert(words->end(), {"--radius-attribute", "size"});
    plan.emplace_back("--dry-run");
    streamed.insert(streamed.end(), {"--memory-limit", "1MiB", "-j", "1"});
    values.insert(values.end(), {"--attributes", "heat"});
    const std::string row = "particle " + std::to_string(kBad);
    for (const std::vector<std::string>& choice :
         {std::vector<std::string>{}, {"--where", "key == 1"}, {"--box", "-1,-1,-1,9,9,0.55"}}) {
        bad("size", "-1");
        for (const auto& words :
             {sizes,
              plan,
              streamed,
              {"render", "a.csv", "o.png", "--radius-attribute", "size", "--overwrite", "--spacing", "0.1"}})
            EXPECT_NE(said(words, choice).find(row + " has size = -1"), std::string::npos)
                << words[0] << said(words, choice);
        bad("size", "0.00001");
        EXPECT_NE(said(sizes, choice).find(row + " has a ball of radius"), std::string::npos);
        bad("heat", "nan");
        EXPECT_NE(said(values, choice).find("that of the particle at 0.594994, 1.0827, 0.41"), std::string::npos)
            << said(values, choice);
    }
    bad("x", "50");
    ASSERT_EQ(runProgram({"sample", "jitter", "s.ply", "--particles", "500"}, folder_.path()).exit_code, 0);
    ASSERT_EQ(runProgram({"mesh", "s.ply", "m.ply"}, folder_.path()).exit_code, 0);
    const std::string checked = said({"check", "m.ply", "--particles", "a.csv"}, {"--where", "key == 1"});
    EXPECT_NE(checked.find(", " + row + " (50, "), std::string::npos) << checked;
}

// Attributes, as uses in the manifest and as remarks in the log: one of each kind for the whole job.
TEST_F(InputJob, WhatIsNotUsedIsNamedOnce) {
    Particles particles = block(6, 6, 6);
    const std::size_t n = particles.size();
    Attribute pscale = realAttribute("pscale", n, 0.1F), temperature = realAttribute("temperature", n, 300);
    pscale.real[3] = 0.02F;
    temperature.real[9] = std::numeric_limits<float>::quiet_NaN();
    temperature.real[11] = std::numeric_limits<float>::infinity();
    particles.attributes = {pscale, temperature, realAttribute("density", n, 1000)};
    for (int frame = 1; frame <= 3; ++frame) writeFrame(frame, particles);
    const Outcome outcome = mesh({"--attributes", "temperature"});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(count(outcome.err, "'pscale' gives each particle a radius"), 1U) << outcome.err;
    EXPECT_EQ(
        count(outcome.err, "'temperature' has 2 numbers that are NaN or infinite, the first of them for particle 9"),
        1U)
        << outcome.err;
    EXPECT_EQ(count(outcome.err, "not used: attributes 'pscale', 'density'"), 1U) << outcome.err;
    for (int frame = 1; frame <= 3; ++frame) {
        std::map<std::string, Json> uses;
        const Json contents = manifest(frame)["input_contents"];
        for (const Json& part : contents["attributes"]) uses[part["name"]] = part["use"];
        const std::map<std::string, Json> expected{
            {"x", "position"},  {"y", "position"},   {"z", "position"},    {"vx", "velocity"},       {"vy", "velocity"},
            {"vz", "velocity"}, {"pscale", nullptr}, {"density", nullptr}, {"temperature", "output"}};
        EXPECT_EQ(uses, expected);
        EXPECT_EQ(manifest(frame)["warnings"].size(), 2U);
    }
}

TEST_F(InputJob, FramesWithoutVelocityAreNamedInTheEnd) {
    Particles particles = block(5, 5, 5), still = particles;
    particles.velocity.assign(particles.size(), Vec3f(0, 1, 0));
    still.velocity.clear();
    for (int frame = 1; frame <= 6; ++frame) writeFrame(frame, frame % 3 == 0 || frame == 4 ? still : particles);
    const Outcome outcome = mesh();
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(
        count(outcome.err, "3 of 6 frames written have no velocity, and zero velocities are written for them: 3-4,6"),
        1U)
        << outcome.err;
    particles.attributes.push_back({"heat", 1, std::vector<float>(particles.size(), 1), {}});
    for (int frame = 1; frame <= 6; ++frame) writeFrame(frame, frame == 1 ? still : particles);
    const Outcome failed = mesh({"--overwrite", "--attributes", "heat"});
    EXPECT_EQ(failed.exit_code, 1);
    EXPECT_EQ(count(failed.err, "written have no velocity"), 0U) << failed.err;  // the one without failed
    for (int frame = 1; frame <= 6; ++frame) writeFrame(frame, still);
    EXPECT_EQ(count(mesh({"--overwrite"}).err, "written have no velocity"), 0U);  // the first warning speaks of all
    fs::create_directories(folder_ / "in");
    std::string text = "x,y,z,vx,vy\n";
    for (const Vec3f& p : particles.position)
        text += std::to_string(p.x) + ',' + std::to_string(p.y) + ',' + std::to_string(p.z) + ",1,2\n";
    write(folder_ / "in/flat.csv", text);
    EXPECT_EQ(count(runProgram({"mesh", "in/flat.csv", "flat.ply"}, folder_.path()).err,
                    "Of the velocity 'v' has x and y, but z is missing"),
              1U);
}

TEST_F(InputJob, AStarDoesNotStandForFrames) {
    writeFrame(1, block(5, 5, 5));
    const Outcome outcome = runProgram({"mesh", "in/a.*.ply", "o.ply"}, folder_.path());
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_NE(outcome.err.find("are written with #, as in name.####.ply"), std::string::npos) << outcome.err;
}

TEST_F(InputJob, RequestedAttributesThatAreReadOtherwiseAreExplained) {
    Particles particles = block(5, 5, 5);
    for (std::size_t i = 0; i < particles.size(); ++i) particles.id.push_back(i);
    writeFrame(1, particles);
    for (const auto& [name, reason] : {std::pair("P", "is the position, which is written anyway"),
                                       {"v", "is the velocity, which is written anyway"},
                                       {"id", "is the id of particles, which vertices do not have"}})
        EXPECT_NE(mesh({"--attributes", name}).err.find("'" + std::string(name) + "' " + reason), std::string::npos)
            << name;
    // Columns of a table.
    const auto refuses = [&](const std::string& columns, std::vector<std::string> options, const std::string& reason) {
        std::string table = columns + '\n';
        for (const Vec3f& p : particles.position)
            table += std::to_string(p.x) + ',' + std::to_string(p.y) + ',' + std::to_string(p.z) + ",0.5,1,2,3,4\n";
        write(folder_ / "a.csv", table);
        for (const char* option : {"--dry-run", "--overwrite"}) {
            std::vector<std::string> words{"mesh", "a.csv", "a.ply", option};
            words.insert(words.end(), options.begin(), options.end());
            const Outcome outcome = runProgram(words, folder_.path());
            EXPECT_EQ(outcome.exit_code, 1);
            EXPECT_NE((outcome.out + outcome.err).find(reason), std::string::npos) << outcome.out << outcome.err;
        }
        if (reason.find("the velocity") == std::string::npos) return;
        write(folder_ / "a.csv", columns + '\n');  // nor in frames without particles
        std::vector<std::string> words{"mesh", "a.csv", "a.ply", "--overwrite"};
        words.insert(words.end(), options.begin(), options.end());
        EXPECT_NE(runProgram(words, folder_.path()).err.find(reason), std::string::npos) << columns;
    };
    refuses("x,y,z,velocity_x,velocity_y,velocity_z,key,heat", {"--attributes", "velocity_x"},
            "'velocity_x' is a component of the velocity, which is written anyway");
    refuses("x,y,z,vx,vy,vz,key,heat", {"--attributes", "v_w"}, "the particles have no attribute 'v_w'");
    refuses("x,y,z,u,v,w,key,heat", {"--attributes", "heat,u"}, "'u' is a component of the velocity");
    refuses("x,y,z,a,b,c,key,heat", {"--attributes", "b", "--velocity", "a,b,c"}, "'b' is a component of the velocity");
    refuses("x,y,z,flow_x,flow_y,flow_z,key,heat", {"--attributes", "flow", "--velocity", "flow"},
            "'flow' is the velocity");
    refuses("x,y,z,a,b,c,key,heat", {"--attributes", "key", "--id", "key"}, "'key' is read as the id of particles");
    refuses("x,y,z,a,b,c,id,heat", {"--attributes", "id", "--id", "id"}, "'id' is the id of particles");
    refuses("x,y,z,a,b,c,flow_x,flow_y", {"--attributes", "flow_y"},
            "'flow_y' is a component of the attribute 'flow'. Use --attributes flow");
    refuses("x,y,z,a,b,c,flow_x,flow_y", {"--attributes", "flow_q"}, "the particles have no attribute 'flow_q'");
}

TEST_F(InputJob, AColumnBesideTheVelocityIsNotTakenForAComponent) {
    std::string table = "x,y,z,vx,vy,vz,v_x\n";
    for (const Vec3f& p : block(5, 5, 5).position)
        table += std::to_string(p.x) + ',' + std::to_string(p.y) + ',' + std::to_string(p.z) + ",0.5,1,2,3\n";
    write(folder_ / "a.csv", table);
    const Outcome outcome = runProgram({"mesh", "a.csv", "a.ply"}, folder_.path());
    EXPECT_NE(outcome.err.find("not used: attribute 'v_x'"), std::string::npos) << outcome.err;
}

TEST_F(InputJob, WholeNumbersThatBecomeOtherFloatsAreNamedOnce) {
    for (int frame = 1; frame <= 3; ++frame) {
        std::string table = "x,y,z,velocity_group\n";
        for (const Vec3f& p : block(5, 5, 5).position)
            table += std::to_string(p.x) + ',' + std::to_string(p.y) + ',' + std::to_string(p.z) + ",9" +
                     std::string(static_cast<std::size_t>(60 + frame), '8') + '\n';
        write(folder_ / ("h." + std::to_string(frame) + ".csv"), table);
    }
    const Outcome outcome = runProgram({"mesh", "h.#.csv", "o.#.ply"}, folder_.path());
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    const std::size_t at = outcome.err.find("in column 'velocity_group' needs more than 24 bits");
    EXPECT_NE(at, std::string::npos) << outcome.err;
    EXPECT_EQ(outcome.err.find("24 bits", at + 60), std::string::npos) << outcome.err;
    EXPECT_EQ(outcome.err.find(std::string(60, '8')), std::string::npos) << outcome.err;
}

TEST_F(InputJob, ColumnsHaveTheSameTypesInAllFrames) {
    for (const int frame : {1, 2}) {
        std::string table = "x,y,z,id,temp,heat,\"phase\"\n";
        std::size_t row = 0;
        for (const Vec3f& p : block(5, 5, 5).position)
            table += std::to_string(p.x) + ',' + std::to_string(p.y) + ',' + std::to_string(p.z) + ',' +
                     std::to_string(++row) + (frame == 1 ? ",300,-1,2\n" : ",300.5,1e-3,2.0\n");
        write(folder_ / ("t." + std::to_string(frame) + ".csv"), table);
        const std::string name = "o." + std::to_string(frame) + ".ply";
        const Outcome outcome = runProgram(
            {"mesh", "t.#.csv", "o.#.ply", "--attributes", "temp,heat,phase", "--frames", std::to_string(frame)},
            folder_.path());
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        const std::string mesh = contentsOf(folder_ / name);
        for (const char* property : {"property float temp\n", "property float heat\n", "property int phase\n"})
            EXPECT_NE(mesh.find(property), std::string::npos) << property << mesh.substr(0, mesh.find("end_header"));
    }
}

TEST_F(InputJob, TypesOfAttributesAreKeptAndLostNumbersAreNamed) {
    const Particles particles = block(5, 5, 5);
    std::string text = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(particles.size()) +
                       "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar phase\n"
                       "property short level\nproperty double mass\nproperty double heat\nproperty int64 key\n"
                       "end_header\n";
    for (std::size_t i = 0; i < particles.size(); ++i) {
        const Vec3f& p = particles.position[i];
        text += std::to_string(p.x) + ' ' + std::to_string(p.y) + ' ' + std::to_string(p.z) + ' ' +
                std::to_string(i % 200) + ' ' + std::to_string(static_cast<int>(i) - 60) + (i == 7 ? " 1e300" : " 2") +
                " 1e300 99999999999\n";
    }
    fs::create_directories(folder_ / "in");
    write(folder_ / "in/a.0001.ply", text);
    const Outcome outcome = mesh({"--attributes", "phase,level,mass,key"});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    for (const char* property : {"property uchar phase\n", "property short level\n", "property float mass\n"})
        EXPECT_NE(meshBytes(1).find(property), std::string::npos) << property;
    for (const char* part :
         {"'mass'", "particle 7 has 1e+300", "'mass' has double precision", "'key' has whole numbers of more"})
        EXPECT_NE(outcome.err.find(part), std::string::npos) << outcome.err;
    EXPECT_EQ(outcome.err.find("'heat' has"), std::string::npos) << outcome.err;  // is not used
    const Mesh read = readMesh(folder_ / "out/a.0001.ply");
    ASSERT_EQ(read.attributes.size(), 5U);  // and N
    for (std::size_t v = 0; v < read.position.size(); ++v)
        EXPECT_EQ(read.attributes[0].integer[v] - 60, read.attributes[1].integer[v]);
    EXPECT_NE(mesh({"--attributes", "phase"}, "out/a.####.obj").err.find("cannot store attributes"), std::string::npos);
}

TEST_F(InputJob, SpheresCarryTheRequestedAttributes) {
    Particles particles = block(5, 5, 5);
    const std::size_t bulk = particles.size();
    for (int i = 0; i < 5; ++i) {
        particles.position.emplace_back(3 + i, 2, 1);
        particles.velocity.emplace_back(0, 0, 0);
    }
    Attribute temperature{"temperature", 1, {}, {}}, kind{"kind", 1, {}, {}};
    for (std::size_t i = 0; i < particles.size(); ++i) {
        temperature.real.push_back(static_cast<float>(i));
        kind.integer.push_back(-static_cast<std::int32_t>(i));
    }
    particles.attributes = {temperature, kind};
    writeFrame(1, particles);
    for (const std::vector<std::string>& further :
         {std::vector<std::string>{"--droplets", "points"}, {"--tessellation", "paper"}}) {
        SCOPED_TRACE(further[1]);
        std::vector<std::string> all{"--attributes", "temperature,kind", "--overwrite", "--spacing", "0.1"};
        all.insert(all.end(), further.begin(), further.end());
        ASSERT_EQ(mesh(all).exit_code, 0);
        const Particles spheres = readParticles(folder_ / "out/a.0001.spheres.ply");
        ASSERT_EQ(spheres.size(), 5U);
        ASSERT_EQ(spheres.attributes.size(), 3U);  // with the radius
        EXPECT_EQ(spheres.attributes[1].name, "temperature");
        EXPECT_EQ(spheres.attributes[2].name, "kind");
        for (std::size_t i = 0; i < 5; ++i) {
            const auto row = static_cast<std::size_t>(spheres.attributes[1].real[i]);
            EXPECT_GE(row, bulk);
            EXPECT_EQ(spheres.position[i], particles.position[row]);
            EXPECT_EQ(spheres.attributes[2].integer[i], -static_cast<std::int32_t>(row));
        }
    }
}

TEST_F(InputJob, AMissingVelocityNamesItsCandidates) {
    Particles particles = block(6, 6, 6);
    const std::size_t n = particles.size();
    particles.velocity.clear();
    particles.attributes.push_back({"momentum", 3, std::vector<float>(3 * n, 1), {}});
    writeFrame(1, particles);
    const Outcome outcome = mesh();
    EXPECT_NE(outcome.err.find("'momentum'"), std::string::npos) << outcome.err;
    ASSERT_EQ(mesh({"--overwrite", "--velocity", "momentum"}).exit_code, 0);
    for (const Vec3& v : readMesh(folder_ / "out/a.0001.ply").velocity) EXPECT_NEAR(v.x, 1, 1e-3);

    particles.attributes[0].name = "Vel";
    writeFrame(1, particles);
    const Outcome found = mesh({"--overwrite"});
    EXPECT_NE(found.err.find("the velocity is read from 'Vel'"), std::string::npos) << found.err;
}

TEST_F(InputJob, ASingleParticleHasNoLocalOrigin) {
    fs::create_directories(folder_ / "in");
    write(folder_ / "in/a.0001.ply", doublesPly({Vec3(0.5, 0.5, 0.5)}));
    const Outcome outcome = mesh({"--spacing", "0.1"});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(outcome.err.find("local origin"), std::string::npos) << outcome.err;
}

// The mesh of a cube far away is that of the same cube near the origin, for any choice of frames.
TEST_F(InputJob, DoublesFarFromTheOriginAreMeshedRelativeToALocalOrigin) {
    const Vec3 far(500123.4, 4500987.6, 312);
    std::vector<Vec3> near, away;
    for (const Vec3f& p : block(8, 8, 8).position) {
        away.push_back(Vec3(p) + far);
        near.emplace_back(away.back() - Vec3(500124, 4500988, 312));
    }
    fs::create_directories(folder_ / "in");
    write(folder_ / "in/a.0001.ply", doublesPly(away));
    for (Vec3& p : away) p.x += 100;
    write(folder_ / "in/a.0002.ply", doublesPly(away));
    const Outcome outcome = mesh();
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("local origin 500124,4500988,312"), std::string::npos) << outcome.err;
    EXPECT_EQ(manifest(1)["local_origin"], Json({500124.0, 4500988.0, 312.0}));
    const std::string first = meshBytes(1), second = meshBytes(2);

    write(folder_ / "near.ply", doublesPly(near));
    ASSERT_EQ(runProgram({"mesh", "near.ply", "near.mesh.ply"}, folder_.path()).exit_code, 0);
    EXPECT_EQ(first, contentsOf(folder_ / "near.mesh.ply"));

    ASSERT_EQ(mesh({"--overwrite", "--frames", "2"}).exit_code, 0);
    EXPECT_EQ(meshBytes(2), second);
    const Outcome resumed = mesh({"--skip-existing"});
    EXPECT_NE(resumed.err.find("2 skipped"), std::string::npos) << resumed.err;
    EXPECT_EQ(runProgram({"check", "out/a.0002.ply", "--particles", "in/a.####.ply"}, folder_.path()).exit_code, 0);

    // Another origin, or none, on request.
    ASSERT_EQ(mesh({"--overwrite", "--frames", "1", "--origin", "500000,4500000,0", "--spacing", "0.1"}).exit_code, 0);
    EXPECT_EQ(manifest(1)["local_origin"], Json({500000.0, 4500000.0, 0.0}));
    ASSERT_EQ(
        mesh({"--overwrite", "--frames", "1", "--origin", "none", "--spacing", "0.1", "--surface", "alpha"}).exit_code,
        0);
    EXPECT_EQ(manifest(1)["local_origin"], Json({0.0, 0.0, 0.0}));

    // Near the origin nothing is moved.
    write(folder_ / "in/a.0001.ply", doublesPly(near));
    ASSERT_EQ(mesh({"--overwrite", "--frames", "1"}).exit_code, 0);
    EXPECT_EQ(manifest(1)["local_origin"], Json({0.0, 0.0, 0.0}));
}

TEST_F(InputJob, FramesThatAreMeshedOneByOneAgreeInTheOriginThatTheLogNames) {
    fs::create_directories(folder_ / "in");
    for (const int frame : {1, 2}) {
        std::vector<Vec3> positions;
        for (const Vec3f& p : block(8, 8, 8).position)
            positions.push_back(Vec3(p) + Vec3(500123.4 + 700 * frame, 4500987.6, 312));
        write(folder_ / numbered("in/a", frame, ".ply"), doublesPly(positions));
    }
    const std::vector<std::string> units{"--scale", "2", "--up-axis", "z", "--spacing", "0.2"};
    ASSERT_EQ(mesh(units).exit_code, 0);
    const std::string together = meshBytes(2);
    const auto alone = [&](int frame, std::vector<std::string> further) {
        std::vector<std::string> words{"mesh", numbered("in/a", frame, ".ply"), numbered("out/a", frame, ".ply"),
                                       "--overwrite"};
        words.insert(words.end(), units.begin(), units.end());
        words.insert(words.end(), further.begin(), further.end());
        const Outcome outcome = runProgram(words, folder_.path());
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return outcome.err;
    };
    const std::string log = alone(1, {}), words = "use --origin ";
    const std::size_t at = log.find(words);
    ASSERT_NE(at, std::string::npos) << log;
    const std::string origin = log.substr(at + words.size(), log.find('\n', at) - at - words.size());
    alone(2, {});
    EXPECT_NE(meshBytes(2), together);
    EXPECT_EQ(alone(2, {"--origin", origin}).find(words), std::string::npos);
    EXPECT_EQ(meshBytes(2), together);
    EXPECT_EQ(manifest(2)["local_origin"], manifest(1)["local_origin"]);
}

TEST_F(InputJob, CurvesLieInAnyPlaneAcrossAnAxis) {
    Particles flat;
    Random random(8);
    for (int x = 0; x < 20; ++x)
        for (int y = 0; y < 10; ++y) {
            flat.position.emplace_back(0.02 * (Vec3(x, y, 0) + 0.25 * random.cube()));
            flat.position.back().z = 0.5F;
            flat.velocity.emplace_back(1, 2, 0);
        }
    const auto curvesOf = [&](const std::function<Vec3f(const Vec3f&)>& turned) {
        Particles particles = flat;
        for (Vec3f& p : particles.position) p = turned(p);
        for (Vec3f& v : particles.velocity) v = turned(v);
        writeFrame(1, particles);
        const Outcome outcome = mesh({"--dimension", "2", "--overwrite"});
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        EXPECT_EQ(runProgram({"check", "--strict", "out/a.0001.ply", "--particles", "in/a.0001.ply"}, folder_.path())
                      .exit_code,
                  0);
        return readCurves(folder_ / "out/a.0001.ply");
    };
    const Curves across_z = curvesOf([](const Vec3f& p) { return p; });
    const auto expectTurned = [&](const std::function<Vec3f(const Vec3f&)>& turned) {
        const Curves curves = curvesOf(turned);
        ASSERT_EQ(curves.position.size(), across_z.position.size());
        for (std::size_t i = 0; i < curves.position.size(); ++i) {
            EXPECT_EQ(Vec3f(curves.position[i]), turned(Vec3f(across_z.position[i])));
            EXPECT_EQ(Vec3f(curves.velocity[i]), turned(Vec3f(across_z.velocity[i])));
        }
        EXPECT_EQ(curves.edges, across_z.edges);
    };
    expectTurned([](const Vec3f& p) { return Vec3f(p.x, -p.z, p.y); });  // across y
    expectTurned([](const Vec3f& p) { return Vec3f(p.z, p.x, p.y); });   // across x

    // Noise far below the spacing is flat; a hundredth of it is not.
    Particles noisy = flat;
    for (Vec3f& p : noisy.position) p.z = 0.5F + static_cast<float>(1e-6 * random.between(-1, 1));
    writeFrame(1, noisy);
    EXPECT_EQ(mesh({"--dimension", "2", "--overwrite"}).exit_code, 0);
    for (Vec3f& p : noisy.position) p.z = 0.5F + static_cast<float>(1e-3 * random.between(-1, 1));
    writeFrame(1, noisy);
    EXPECT_EQ(mesh({"--dimension", "2", "--overwrite"}).exit_code, 1);
}

TEST_F(InputJob, UnitsAndTheUpAxisReachTheMesh) {
    Particles particles = block(5, 6, 7), expected = particles;
    for (Vec3f& p : particles.position) p = Vec3f(p.x, -p.z, p.y) * 100.0F;
    for (Vec3f& v : particles.velocity) v = Vec3f(v.x, -v.z, v.y) * 100.0F;
    writeFrame(1, particles);
    ASSERT_EQ(mesh({"--scale", "0.01", "--up-axis", "z", "--time-scale", "0.5", "--velocity-scale", "-1"}).exit_code,
              0);
    const Mesh read = readMesh(folder_ / "out/a.0001.ply");
    Box box;
    for (const Vec3& p : read.position) box.extendBy(p);
    EXPECT_NEAR(box.size().x, 0.5, 0.1);
    EXPECT_NEAR(box.size().y, 0.6, 0.1);
    EXPECT_NEAR(box.size().z, 0.7, 0.1);
    for (const Vec3& v : read.velocity) EXPECT_NEAR((v - Vec3(0, 0.5, 0)).length(), 0, 1e-3);
}

TEST_F(InputJob, TheUpAxisOfTheOutputUndoesThatOfTheInput) {
    Particles particles = block(5, 6, 7);
    for (std::size_t i = 0; i < particles.size(); ++i) particles.velocity[i] = Vec3f(1, static_cast<float>(i % 3), 2);
    writeFrame(1, particles);
    ASSERT_EQ(mesh({"--origin", "0.25,0.5,1"}).exit_code, 0);
    const Mesh y_up = readMesh(folder_ / "out/a.0001.ply");
    ASSERT_EQ(mesh({"--origin", "0.25,0.5,1", "--output-up-axis", "z", "--skip-existing"}).exit_code, 0);
    const Mesh z_up = readMesh(folder_ / "out/a.0001.ply");  // made again, because the configuration is another one
    EXPECT_EQ(manifest(1)["local_origin"], Json({0.25, -1.0, 0.5}));
    EXPECT_EQ(z_up.triangles, y_up.triangles);
    ASSERT_EQ(z_up.position.size(), y_up.position.size());
    for (std::size_t i = 0; i < y_up.position.size(); ++i) {
        const Vec3 &p = y_up.position[i], &v = y_up.velocity[i];
        ASSERT_EQ(z_up.position[i], Vec3(p.x, -p.z, p.y));
        ASSERT_EQ(z_up.velocity[i], Vec3(v.x, -v.z, v.y));
    }
}

}  // namespace
}  // namespace betamesh
