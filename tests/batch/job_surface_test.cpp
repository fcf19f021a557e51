// What the meshes of a job contain: features, skin, spheres, components and attributes.

#include "io/file_info.h"
#include "io/mesh_file.h"
#include "support/file_samples.h"
#include "support/job_folder.h"

#include <algorithm>

namespace betamesh {
namespace {

using Job = JobFolder;

TEST_F(Job, DropletsAndTendrilsLeaveTheMeshAndBubblesAreFilled) {
    Particles particles;  // spacing 1: a hollow block, a thread that hangs on it, a pair, and one alone, twice
    const auto add = [&](float x, float y, float z) {
        particles.position.emplace_back(x, y, z);
        particles.velocity.emplace_back(x, -y, 0.5F * z);
        particles.id.push_back(1000 + particles.id.size());
    };
    for (int z = 0; z < 9; ++z)
        for (int y = 0; y < 9; ++y)
            for (int x = 0; x < 9; ++x)
                if ((Vec3(x, y, z) - Vec3(4, 4, 4)).length() > 2.3)
                    add(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
    const std::uint64_t body = particles.id.size();
    for (int i = 1; i <= 5; ++i) add(8 + 2.5F * static_cast<float>(i), 4, 4);
    add(30, 0, 0), add(31, 0, 0), add(40, 0, 0), add(40, 0, 0);
    writeFrame(1, particles);
    const std::vector<std::string> with{"--radius", "1.5", "--overwrite", "--smoothing", "none"};
    const auto run = [&](std::vector<std::string> further, const std::string& output = "out/a.####.ply") {
        further.insert(further.begin(), with.begin(), with.end());
        const Outcome outcome = mesh(further, output);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return outcome;
    };

    run({});
    EXPECT_EQ(manifest(1)["components"], 3);
    EXPECT_EQ(manifest(1)["bubbles_filled"], 1);
    run({"--bubbles", "mesh"});
    EXPECT_EQ(manifest(1)["components"], 4);  // the body with its thread, the bubble, the pair, the one
    EXPECT_EQ(manifest(1)["droplets"], 0);
    EXPECT_FALSE(exists("out/a.0001.spheres.ply"));
    EXPECT_FALSE(readMesh(folder_ / "out/a.0001.ply").component);

    run({"--droplets", "points", "--tendrils", "points", "--bubbles", "fill", "--bubble-volume", "30", "--components"});
    EXPECT_EQ(manifest(1)["components"], 1);
    EXPECT_EQ(manifest(1)["droplets"], 2);
    EXPECT_EQ(manifest(1)["droplet_particles"], 3);
    EXPECT_EQ(manifest(1)["bubbles_filled"], 1);
    EXPECT_EQ(manifest(1)["spheres"], 3 + manifest(1)["tendril_particles"].get<int>());
    EXPECT_GE(manifest(1)["tendril_particles"], 4);
    EXPECT_EQ(manifest(1)["distinct_particles"], particles.size() - 1);
    const Particles spheres = readParticles(folder_ / "out/a.0001.spheres.ply");
    ASSERT_EQ(spheres.size(), manifest(1)["spheres"].get<std::size_t>());
    ASSERT_EQ(spheres.id.size(), spheres.size());
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        ASSERT_GE(spheres.id[i], 1000 + body);
        EXPECT_EQ(spheres.position[i], particles.position[spheres.id[i] - 1000]);
        EXPECT_EQ(spheres.velocity[i], particles.velocity[spheres.id[i] - 1000]);
        EXPECT_NEAR(spheres.attributes.at(0).real[i], 1.5, 1e-5);
    }
    EXPECT_EQ(readMesh(folder_ / "out/a.0001.ply").component,
              std::vector<std::int32_t>(manifest(1)["triangles"].get<std::size_t>(), 0));

    run({"--droplets", "drop", "--droplet-particles", "2", "--bubbles", "mesh"});
    EXPECT_EQ(manifest(1)["components"], 3);
    EXPECT_EQ(manifest(1)["droplets"], 1);
    EXPECT_EQ(manifest(1)["spheres"], 0);
    EXPECT_FALSE(exists("out/a.0001.spheres.ply"));  // nor one left by the run before

    run({"--droplets", "points"}, "out/a.####.obj");
    EXPECT_TRUE(exists("out/a.0001.spheres.ply"));
    run({"--bubbles", "fill", "--bubble-volume", "0.001"});
    EXPECT_EQ(manifest(1)["bubbles_filled"], 0);
    run({"--bubble-gap", "0.5dx"});
    EXPECT_EQ(manifest(1)["bubbles_filled"], 0);
    run({"--bubble-gap", "8"});
    EXPECT_EQ(manifest(1)["bubbles_filled"], 1);
    for (const std::vector<std::string>& other : std::vector<std::vector<std::string>>{
             {"--surface", "alpha"}, {"--surface", "union"}, {"--tessellation", "paper"}}) {
        EXPECT_EQ(run(other).err.find("features.bubbles"), std::string::npos);
        std::vector<std::string> asked = other;
        asked.insert(asked.end(), {"--bubbles", "fill"});
        EXPECT_NE(run(asked).err.find("features.bubbles"), std::string::npos);
    }
}

TEST_F(Job, TheSkinIsReportedInWorldUnits) {
    writeFrames(1, 1);
    const auto skinOf = [&](std::vector<std::string> words) {
        words.insert(words.begin(), {"--overwrite", "--radius", "0.3"});
        const Outcome outcome = mesh(words);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return manifest(1)["skin"].get<double>();
    };
    EXPECT_NEAR(skinOf({}), 0.55 * 0.2, 1e-12);
    EXPECT_NEAR(skinOf({"--skin", "auto"}), 0.55 * 0.2, 1e-12);
    EXPECT_NEAR(skinOf({"--spacing", "10"}), 0.8 * 0.3, 1e-12);
    EXPECT_NEAR(skinOf({"--skin", "0.5dx"}), 0.1, 1e-12);
    EXPECT_NEAR(skinOf({"--skin", "0.25"}), 0.25, 1e-12);
    EXPECT_EQ(skinOf({"--skin", "none"}), 0);
    const Outcome unknown_spacing = mesh({"--overwrite", "--skin", "none"});
    EXPECT_EQ(unknown_spacing.exit_code, 0) << unknown_spacing.err;
    EXPECT_EQ(manifest(1)["skin"].get<double>(), 0);
    for (const std::vector<std::string>& other : std::vector<std::vector<std::string>>{
             {"--tessellation", "paper"}, {"--surface", "alpha"}, {"--surface", "union"}}) {
        EXPECT_EQ(skinOf(other), 0);
        for (const char* allowed : {"auto", "none"}) {
            std::vector<std::string> words = other;
            words.insert(words.end(), {"--skin", allowed});
            EXPECT_EQ(skinOf(words), 0);
        }
    }
}

TEST_F(Job, AnImpossibleSkinIsRefusedBeforeAnythingIsWritten) {
    writeFrames(1, 1);
    const auto refused = [&](std::vector<std::string> words, const std::string& why) {
        for (const bool dry : {false, true}) {
            const Outcome outcome = mesh(words);
            EXPECT_EQ(outcome.exit_code, 2) << outcome.out;
            EXPECT_NE(outcome.err.find(why), std::string::npos) << outcome.err;
            EXPECT_FALSE(exists("out"));
            if (!dry) words.push_back("--dry-run");
        }
    };
    refused({"--skin", "1.5dx"}, "surface.skin is 1.5dx, but must be less than surface.radius, which is 1.5dx");
    refused({"--radius", "0.1", "--skin", "0.2"}, "less than surface.radius, which is 0.1");
    refused({"--radius", "0.3", "--skin", "3dx"}, "0.6 and 0.3");
    refused({"--radius", "1.5dx", "--spacing", "0.1", "--skin", "1"}, "1 and 0.15");
    refused({"--skin", "0.5dx", "--tessellation", "paper"}, "complete tessellation");
    refused({"--skin", "0.5dx", "--smoothing", "paper"}, "complete tessellation");
    refused({"--skin", "0.01", "--surface", "alpha"}, "complete tessellation");
    refused({"--skin", "0.5dx", "--surface", "union"}, "complete tessellation");
    refused({"--inset", "0.5dx", "--surface", "union"}, "surface.inset");
    refused({"--inset", "1.5dx"}, "surface.inset");
    refused({"--inset", "0.5dx", "--skin", "0.5dx"}, "both set");
    refused({"--inset", "0", "--skin", "none"}, "both set");
    refused({"--skin", "-0.5dx"}, "auto, none");
    EXPECT_EQ(mesh({"--skin", "100"}).exit_code, 2);  // against a radius that has to be measured
    EXPECT_FALSE(exists("out"));
}

TEST_F(Job, AnInsetIsTheRadiusMinusTheSkinAndGivesOneWarning) {
    writeFrames(1, 3);
    const std::vector<std::string> with{"--radius", "0.3", "--overwrite"};
    const auto run = [&](const std::string& output, std::vector<std::string> words) {
        words.insert(words.begin(), with.begin(), with.end());
        const Outcome outcome = mesh(words, output);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return count(outcome.err, "deprecated");
    };
    EXPECT_EQ(run("skin/a.####.ply", {"--skin", "0.2"}), 0);
    EXPECT_EQ(run("out/a.####.ply", {"--inset", "0.1"}), 1);
    EXPECT_NEAR(manifest(1)["skin"].get<double>(), 0.2, 1e-12);
    const double inset = manifest(1)["volume"];
    EXPECT_EQ(run("none/a.####.ply", {"--skin", "none"}), 0);
    EXPECT_EQ(run("out/a.####.ply", {"--inset", "0"}), 1);
    EXPECT_EQ(manifest(1)["skin"], 0);
    EXPECT_TRUE(meshesIn("out") == meshesIn("none"));
    EXPECT_LT(inset, manifest(1)["volume"].get<double>());
    const auto json = [&](const std::string& name) { return Json::parse(contentsOf(folder_ / name)); };
    EXPECT_NEAR(json("skin/a.0001.ply.json")["volume"].get<double>(), inset, 1e-6 * inset);
}

TEST_F(Job, SpheresAreWrittenBesideTheMeshAndRemovedIfThereAreNone) {
    Sample sample({"jitter", 400, 1, 24});
    Particles particles = sample.frame(1);
    particles.velocity.clear();
    particles.id.clear();
    writeFrame(1, particles);
    particles.position.push_back(Vec3f(100, 100, 100));
    writeFrame(2, particles);
    ASSERT_EQ(mesh({"--tessellation", "paper"}).exit_code, 0);
    EXPECT_FALSE(exists("out/a.0001.spheres.ply"));
    EXPECT_TRUE(exists("out/a.0002.spheres.ply"));
    EXPECT_EQ(manifest(2)["isolated_particles"], 1);
    ASSERT_EQ(mesh({"--tessellation", "paper", "--overwrite"}, "out/a.####.obj").exit_code, 0);
    EXPECT_TRUE(exists("out/a.0002.spheres.ply"));
    ASSERT_EQ(mesh({"--tessellation", "paper"}, "out/a.####.bgeo.gz").exit_code, 0);
    EXPECT_TRUE(exists("out/a.0002.spheres.bgeo.gz"));

    particles.position.pop_back();
    writeFrame(2, particles);
    ASSERT_EQ(mesh({"--tessellation", "paper", "--overwrite"}).exit_code, 0);
    EXPECT_FALSE(exists("out/a.0002.spheres.ply"));
}

TEST_F(Job, ComponentsAreDeclaredInEveryFrameOfEveryFormat) {
    writeFrames(1, 1, 2000);
    writeFrame(2, {});
    for (const char* output : {"out/a.####.ply", "out/a.####.bgeo", "out/a.####.bgeo.gz"}) {
        SCOPED_TRACE(output);
        const std::string extension = std::string(output).substr(10);
        EXPECT_EQ(
            mesh({"--frames", "1-3", "--on-missing", "empty", "--set", "output.components=true"}, output).exit_code, 0);
        for (int frame = 1; frame <= 3; ++frame) {
            const Mesh read = readMesh(folder_ / numbered("out/a", frame, extension));
            ASSERT_TRUE(read.component) << frame;
            EXPECT_EQ(read.component->size(), read.triangles.size());
            EXPECT_EQ(read.triangles.empty(), frame > 1);
        }
    }
}

TEST_F(Job, SurfaceAttributesAreColumnsOfEveryFrame) {
    writeFrames(1, 1, 2000);
    writeFrame(2, {});
    for (const char* output : {"out/a.####.ply", "out/a.####.bgeo", "out/a.####.bgeo.gz"}) {
        SCOPED_TRACE(output);
        const std::string extension = std::string(output).substr(10);
        EXPECT_EQ(mesh({"--frames", "1-3", "--on-missing", "empty", "--output-normals", "--surface-attributes",
                        "thickness,shape"},
                       output)
                      .exit_code,
                  0);
        for (int frame = 1; frame <= 3; ++frame) {
            const Mesh read = readMesh(folder_ / numbered("out/a", frame, extension));
            EXPECT_EQ(read.triangles.empty(), frame > 1);
            for (const char* name : {"N", "thickness", "drop", "thread", "sheet", "bulk"}) {
                const auto found = std::find_if(read.attributes.begin(), read.attributes.end(),
                                                [&](const Attribute& a) { return a.name == name; });
                ASSERT_NE(found, read.attributes.end()) << name << " of frame " << frame;
                EXPECT_EQ(found->real.size(), read.position.size() * found->components);
                EXPECT_EQ(found->components, found->name == "N" ? 3U : 1U);
            }
        }
    }
    const Outcome stl = mesh({"--frames", "1", "--output-normals"}, "out/b.####.stl");
    EXPECT_NE(stl.err.find("written without"), std::string::npos) << stl.err;
    EXPECT_NE(stl.err.find("attributes"), std::string::npos) << stl.err;
    const Outcome obj = mesh({"--frames", "1", "--output-normals"}, "out/b.####.obj");
    EXPECT_EQ(obj.err.find("attributes"), std::string::npos) << obj.err;
}

TEST_F(Job, EmptyFramesHaveTheAttributesOfTheOthers) {
    Particles particles = sampleParticles(200, true, true, true);
    particles.attributes.push_back({"accel", 3, std::vector<float>(600, 1.0F), {}});
    writeFrame(1, {});
    writeFrame(2, particles);
    for (const std::string extension : {".ply", ".bgeo", ".bhclassic", ".vtp", ".usda", ".abc"}) {
        SCOPED_TRACE(extension);
        const Outcome outcome = mesh({"--frames", "1-3", "--on-missing", "empty", "--attributes", "state,Cd",
                                      "--radius", "0.5", "--spacing", "0.3"},
                                     "out/a.####" + extension);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        std::vector<std::vector<std::string>> attributes;
        for (const int frame : {2, 1, 3}) {
            auto& of_frame = attributes.emplace_back();
            for (const AttributeInfo& a : inspectFile(folder_ / numbered("out/a", frame, extension)).attributes)
                of_frame.push_back(a.name + " " + a.type + " " + std::to_string(a.components));
        }
        EXPECT_GE(attributes[0].size(), 4U);
        EXPECT_EQ(attributes[1], attributes[0]);
        EXPECT_EQ(attributes[2], attributes[0]);
    }
}

TEST_F(Job, WallsWithTheLiquidOnTheOtherSideAreWarnedOf) {
    writeFrames(1, 2);  // the liquid is around the origin
    for (const std::string around : {"x>-100", "x<100", "x<100,y>-100,0.6x+0.8y<90"}) {
        const Outcome outcome = mesh({"--walls", around, "--overwrite"});
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        EXPECT_EQ(count(outcome.err, "beyond the wall"), 0U) << outcome.err;
    }
    for (const std::string beyond : {"x>100", "y<-100", "0.6x+0.8y>90"}) {
        const Outcome outcome = mesh({"--walls", "z<100," + beyond, "--overwrite"});
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        EXPECT_EQ(count(outcome.err, "beyond the wall"), 1U) << outcome.err;
        const std::string all = manifest(2)["particles"].dump();
        EXPECT_NE(manifest(2)["warnings"].dump().find(all + " of " + all + " particles are beyond the wall " + beyond),
                  std::string::npos)
            << manifest(2)["warnings"];
    }
}

TEST_F(Job, AnEmptyLevelSetIsWarnedOf) {
    Particles particles = Sample({"jitter", 100, 1, 24}).frame(1);
    for (Vec3f& p : particles.position) p += Vec3f(300, 300, 300);
    writeFrame(1, particles);
    const Outcome outcome = mesh({"--voxel", "1000"}, "out/a.####.vdb");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("the level set is empty: no voxel of 1e+03 is inside the mesh"), std::string::npos)
        << outcome.err;
    const Json report = Json::parse(contentsOf(folder_ / "out/a.0001.vdb.json"));
    EXPECT_NE(report["warnings"].dump().find("Choose smaller voxels"), std::string::npos) << report;
    for (const char* voxel : {"nan", "inf", "0", "-1"}) {
        const Outcome wrong = mesh({"--voxel", voxel}, "out/b.####.vdb");
        EXPECT_EQ(wrong.exit_code, 2);
        EXPECT_NE(
            wrong.err.find(std::string("--voxel (output.voxel): '") + voxel + "' is not valid. Use a number above 0"),
            std::string::npos)
            << wrong.err;
    }
}

}  // namespace
}  // namespace betamesh
