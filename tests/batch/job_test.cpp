// Batch jobs as a farm sees them: the files they write, and their exit codes.

#include "batch/config/presets.h"
#include "io/file_info.h"
#include "io/mesh_file.h"
#include "support/clouds.h"
#include "support/file_samples.h"
#include "support/job_folder.h"

#include <algorithm>
#include <csignal>
#include <set>
#include <sstream>

#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace betamesh {
namespace {

using Job = JobFolder;

TEST_F(Job, WritesEveryFrameOnDiskWithItsReport) {
    writeFrames(1, 3);
    const Outcome outcome = mesh();
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    for (int frame = 1; frame <= 3; ++frame) {
        EXPECT_TRUE(written(frame));
        EXPECT_EQ(report(frame)["status"], "ok");
        const Mesh read = readMesh(folder_ / numbered("out/a", frame, ".ply"));
        EXPECT_EQ(read.triangles.size(), report(frame)["triangles"].get<std::size_t>());
        EXPECT_EQ(read.velocity.size(), read.position.size());
    }
    EXPECT_EQ(hiddenFiles("out"), 0U);
}

TEST_F(Job, JsonPrintsOneObjectPerFrameAndNothingElseOnStdout) {
    writeFrames(1, 4);
    writeFrameWithNaN(5);
    for (const char* progress : {"auto", "bar", "none", "openjd", "tractor"}) {
        SCOPED_TRACE(progress);
        const Outcome outcome = mesh({"--json", "-v", "--overwrite", "--frames", "1-6", "--progress", progress});
        EXPECT_EQ(outcome.exit_code, 1);
        std::set<int> frames;
        for (const Json& line : jsonLines(outcome.out)) {
            ASSERT_TRUE(line.is_object()) << outcome.out;
            frames.insert(line["frame"].get<int>());
            for (const char* key : {"input",
                                    "output",
                                    "status",
                                    "particles",
                                    "radius",
                                    "spacing",
                                    "skin",
                                    "predicates",
                                    "perturbation_retries",
                                    "alpha_triangles",
                                    "double_sided_triangles",
                                    "degenerate_edges",
                                    "isolated_particles",
                                    "vertices",
                                    "triangles",
                                    "components",
                                    "euler",
                                    "volume",
                                    "area",
                                    "peak_bytes",
                                    "warnings"}) {
                EXPECT_TRUE(line.contains(key)) << key;
            }
            for (const char* key : {"read", "structure", "tessellate", "smooth", "velocity", "write", "total"}) {
                EXPECT_TRUE(line["seconds"].contains(key)) << key;
            }
            EXPECT_EQ(line["status"] == "failed", line["frame"] >= 5);
            EXPECT_EQ(line.contains("error"), line["frame"] >= 5);
            EXPECT_GT(line["peak_bytes"].get<std::uint64_t>(), 1'000'000U);
        }
        EXPECT_EQ(frames, (std::set<int>{1, 2, 3, 4, 5, 6}));
    }
}

TEST_F(Job, AMissingFrameIsAnErrorASkipOrAnEmptyMesh) {
    writeFrames(1, 1);
    writeFrames(3, 3);
    const Outcome error = mesh({"--frames", "1-3"});
    EXPECT_EQ(error.exit_code, 1);
    EXPECT_NE(error.err.find("in/a.0002.ply"), std::string::npos) << error.err;
    EXPECT_TRUE(written(1) && absent(2) && written(3));

    EXPECT_EQ(mesh({"--frames", "1-3", "--overwrite", "--on-missing", "skip"}).exit_code, 0);
    EXPECT_TRUE(written(1) && absent(2) && written(3));

    EXPECT_EQ(mesh({"--frames", "1-3", "--overwrite", "--on-missing", "empty"}).exit_code, 0);
    EXPECT_TRUE(written(1) && written(2) && written(3));
    EXPECT_EQ(report(2)["status"], "empty");
    EXPECT_FALSE(report(2)["warnings"].empty());
    EXPECT_TRUE(readMesh(folder_ / "out/a.0002.ply").position.empty());
}

TEST_F(Job, AnEmptyFrameIsAnEmptyMeshThatDeclaresTheSameAttributes) {
    writeFrames(1, 1);
    Particles none;
    writeFrame(2, none);
    EXPECT_EQ(mesh().exit_code, 0);
    EXPECT_EQ(report(2)["status"], "empty");
    const auto header = [&](int frame) {
        const std::string text = contentsOf(folder_ / numbered("out/a", frame, ".ply"));
        std::istringstream in(text.substr(0, text.find("end_header")));
        std::string properties;
        for (std::string line; std::getline(in, line);) {
            if (line.starts_with("property")) properties += line + '\n';
        }
        return properties;
    };
    EXPECT_EQ(header(1), header(2));
    EXPECT_NE(header(1).find("vx"), std::string::npos);
}

TEST_F(Job, ABrokenFrameDoesNotStopTheOthers) {
    writeFrameWithNaN(1);
    writeFrames(2, 3);
    write(folder_ / "in/a.0004.ply", "ply\nformat nonsense\n");
    writeFrames(5, 5);
    const Outcome outcome = mesh();
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_TRUE(absent(1) && written(2) && written(3) && absent(4) && written(5));
    EXPECT_NE(outcome.err.find("frame 1: in/a.0001.ply: particle 17"), std::string::npos) << outcome.err;
    EXPECT_EQ(hiddenFiles("out"), 0U);
}

TEST_F(Job, ExistingOutputsAreRefusedBeforeAnythingIsWritten) {
    writeFrames(1, 3);
    write(folder_ / "out/a.0002.ply", "mine");
    const Outcome refused = mesh();
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_NE(refused.err.find("out/a.0002.ply"), std::string::npos) << refused.err;
    EXPECT_TRUE(absent(1) && absent(3));
    EXPECT_EQ(contentsOf(folder_ / "out/a.0002.ply"), "mine");
    EXPECT_EQ(mesh({"--overwrite", "--skip-existing"}).exit_code, 2);

    EXPECT_EQ(mesh({"--overwrite"}).exit_code, 0);
    EXPECT_NE(contentsOf(folder_ / "out/a.0002.ply"), "mine");
}

TEST_F(Job, SkipExistingKeepsFinishedFramesAndMeshesTheOthers) {
    writeFrames(1, 4);
    ASSERT_EQ(mesh({"--frames", "1-3"}).exit_code, 0);
    const auto before = meshesIn("out");
    const auto time = fs::last_write_time(folder_ / "out/a.0001.ply");
    fs::remove(folder_ / "out/a.0002.ply.json");  // as if it had been interrupted before the report
    write(folder_ / "out/a.0002.ply", "half");
    fs::remove(folder_ / "out/a.0003.ply");
    const Outcome outcome = mesh({"--skip-existing", "--json"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    for (const Json& line : jsonLines(outcome.out)) EXPECT_EQ(line["status"], line["frame"] == 1 ? "skipped" : "ok");
    EXPECT_EQ(fs::last_write_time(folder_ / "out/a.0001.ply"), time);
    auto after = meshesIn("out");
    EXPECT_EQ(after.erase("a.0004.ply"), 1U);
    EXPECT_EQ(after, before);
}

TEST_F(Job, OutputsThatCannotBeWrittenFailAsEarlyAsPossible) {
    writeFrames(1, 3);
    write(folder_ / "file", "");
    EXPECT_EQ(mesh({}, "file/a.####.ply").exit_code, 2);

    fs::create_directories(folder_ / "out/a.0002.ply/inside");
    const Outcome outcome = mesh({"--overwrite", "--io-retries", "0"});
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_NE(outcome.err.find("out/a.0002.ply"), std::string::npos) << outcome.err;
    EXPECT_TRUE(written(1) && written(3));
    EXPECT_FALSE(exists("out/a.0002.ply.json"));
    EXPECT_EQ(hiddenFiles("out"), 0U);
}

TEST_F(Job, WrongUsageWritesNothing) {
    writeFrames(1, 2);
    for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{{"--radus", "1"},
                                                                                       {"--radius", "big"},
                                                                                       {"--set", "surface.radus=1"},
                                                                                       {"--frames", "1-2:2"},
                                                                                       {"--frames", "1,x"},
                                                                                       {"--chunk", "3/2"},
                                                                                       {"--progress", "dots"},
                                                                                       {"--memory-limit", "16"},
                                                                                       {"--set", "input.velocity"},
                                                                                       {"extra"}}) {
        const Outcome outcome = mesh(words);
        EXPECT_EQ(outcome.exit_code, 2) << words.front() << '\n' << outcome.err;
        EXPECT_FALSE(outcome.err.empty());
        EXPECT_FALSE(exists("out"));
    }
    EXPECT_EQ(mesh({}, "out/all.ply").exit_code, 2);
    EXPECT_EQ(mesh({}, "out/a.####.xyz").exit_code, 2);
    EXPECT_EQ(mesh({}, "in/a.####.ply").exit_code, 2);
    EXPECT_EQ(runProgram({"mesh", "in/b.####.ply", "out/b.####.ply"}, folder_.path()).exit_code, 2);
    EXPECT_EQ(runProgram({}, folder_.path()).exit_code, 2);
    EXPECT_EQ(runProgram({"mash"}, folder_.path()).exit_code, 2);
    EXPECT_FALSE(exists("out"));
}

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
    EXPECT_EQ(report(1)["components"], 3);
    EXPECT_EQ(report(1)["bubbles_filled"], 1);
    run({"--bubbles", "mesh"});
    EXPECT_EQ(report(1)["components"], 4);  // the body with its thread, the bubble, the pair, the one
    EXPECT_EQ(report(1)["droplets"], 0);
    EXPECT_FALSE(exists("out/a.0001.spheres.ply"));
    EXPECT_FALSE(readMesh(folder_ / "out/a.0001.ply").component);

    run({"--droplets", "points", "--tendrils", "points", "--bubbles", "fill", "--bubble-volume", "30", "--components"});
    EXPECT_EQ(report(1)["components"], 1);
    EXPECT_EQ(report(1)["droplets"], 2);
    EXPECT_EQ(report(1)["droplet_particles"], 3);
    EXPECT_EQ(report(1)["bubbles_filled"], 1);
    EXPECT_EQ(report(1)["spheres"], 3 + report(1)["tendril_particles"].get<int>());
    EXPECT_GE(report(1)["tendril_particles"], 4);
    EXPECT_EQ(report(1)["distinct_particles"], particles.size() - 1);
    const Particles spheres = readParticles(folder_ / "out/a.0001.spheres.ply");
    ASSERT_EQ(spheres.size(), report(1)["spheres"].get<std::size_t>());
    ASSERT_EQ(spheres.id.size(), spheres.size());
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        ASSERT_GE(spheres.id[i], 1000 + body);
        EXPECT_EQ(spheres.position[i], particles.position[spheres.id[i] - 1000]);
        EXPECT_EQ(spheres.velocity[i], particles.velocity[spheres.id[i] - 1000]);
        EXPECT_NEAR(spheres.attributes.at(0).real[i], 1.5, 1e-5);
    }
    EXPECT_EQ(readMesh(folder_ / "out/a.0001.ply").component,
              std::vector<std::int32_t>(report(1)["triangles"].get<std::size_t>(), 0));

    run({"--droplets", "drop", "--droplet-particles", "2", "--bubbles", "mesh"});
    EXPECT_EQ(report(1)["components"], 3);
    EXPECT_EQ(report(1)["droplets"], 1);
    EXPECT_EQ(report(1)["spheres"], 0);
    EXPECT_FALSE(exists("out/a.0001.spheres.ply"));  // nor one left by the run before

    run({"--droplets", "points"}, "out/a.####.obj");
    EXPECT_TRUE(exists("out/a.0001.spheres.ply"));
    run({"--bubbles", "fill", "--bubble-volume", "0.001"});
    EXPECT_EQ(report(1)["bubbles_filled"], 0);
    run({"--bubble-gap", "0.5dx"});
    EXPECT_EQ(report(1)["bubbles_filled"], 0);
    run({"--bubble-gap", "8"});
    EXPECT_EQ(report(1)["bubbles_filled"], 1);
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
        return report(1)["skin"].get<double>();
    };
    EXPECT_NEAR(skinOf({}), 0.55 * 0.2, 1e-12);
    EXPECT_NEAR(skinOf({"--skin", "auto"}), 0.55 * 0.2, 1e-12);
    EXPECT_NEAR(skinOf({"--spacing", "10"}), 0.8 * 0.3, 1e-12);
    EXPECT_NEAR(skinOf({"--skin", "0.5dx"}), 0.1, 1e-12);
    EXPECT_NEAR(skinOf({"--skin", "0.25"}), 0.25, 1e-12);
    EXPECT_EQ(skinOf({"--skin", "none"}), 0);
    const Outcome unknown_spacing = mesh({"--overwrite", "--skin", "none"});
    EXPECT_EQ(unknown_spacing.exit_code, 0) << unknown_spacing.err;
    EXPECT_EQ(report(1)["skin"].get<double>(), 0);
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
    EXPECT_NEAR(report(1)["skin"].get<double>(), 0.2, 1e-12);
    const double inset = report(1)["volume"];
    EXPECT_EQ(run("none/a.####.ply", {"--skin", "none"}), 0);
    EXPECT_EQ(run("out/a.####.ply", {"--inset", "0"}), 1);
    EXPECT_EQ(report(1)["skin"], 0);
    EXPECT_TRUE(meshesIn("out") == meshesIn("none"));
    EXPECT_LT(inset, report(1)["volume"].get<double>());
    const auto json = [&](const std::string& name) { return Json::parse(contentsOf(folder_ / name)); };
    EXPECT_NEAR(json("skin/a.0001.ply.json")["volume"].get<double>(), inset, 1e-6 * inset);
}

TEST_F(Job, PresetsAreListedAndOverriddenByEverythingElse) {
    writeFrames(1, 1);
    const Outcome listed = runProgram({"config", "presets"}, folder_.path());
    EXPECT_EQ(listed.exit_code, 0);
    std::size_t lines = 0;
    for (const Preset& preset : presets()) {
        ++lines;
        EXPECT_NE(listed.out.find(std::string(preset.name) + ' '), std::string::npos) << listed.out;
        EXPECT_NE(listed.out.find(std::string(descriptionOf(preset)) + '\n'), std::string::npos) << listed.out;
        const Outcome printed = runProgram({"config", "print", "--preset", std::string(preset.name)}, folder_.path());
        EXPECT_NE(printed.out.find("\npreset: " + std::string(preset.name) + '\n'), std::string::npos);
    }
    EXPECT_EQ(std::count(listed.out.begin(), listed.out.end(), '\n'), static_cast<std::ptrdiff_t>(lines));

    write(folder_ / "job.yaml",
          "version: 1\npreset: flip\ninput: {path: in/a.####.ply}\noutput: {path: out/a.####.ply}\n");
    write(folder_ / "own.yaml", "version: 1\ninclude: job.yaml\nsurface: {radius: 1.4dx}\n");
    const auto radiusOf = [&](std::vector<std::string> words) {  // in spacings
        words.insert(words.end(), {"--overwrite", "--spacing", "0.2"});
        const Outcome outcome =
            words.front() == "mesh" ? mesh({words.begin() + 1, words.end()}) : runProgram(words, folder_.path());
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return report(1)["radius"].get<double>() / 0.2;
    };
    EXPECT_NEAR(radiusOf({"mesh", "--preset", "splash"}), 1.2, 1e-12);
    EXPECT_NEAR(radiusOf({"mesh", "--set", "preset=splash"}), 1.2, 1e-12);
    EXPECT_NEAR(radiusOf({"mesh", "--preset", "splash", "--set", "surface.radius=1.3dx"}), 1.3, 1e-12);
    EXPECT_NEAR(radiusOf({"mesh", "--preset", "splash,viscous"}), 1.75, 1e-12);
    EXPECT_NEAR(radiusOf({"mesh", "--radius", "1.1dx", "--preset", "splash"}), 1.1, 1e-12);
    EXPECT_NEAR(radiusOf({"run", "job.yaml"}), 2, 1e-12);
    EXPECT_NEAR(radiusOf({"run", "job.yaml", "--preset", "splash"}), 1.2, 1e-12);
    EXPECT_NEAR(radiusOf({"run", "own.yaml", "--preset", "splash"}), 1.4, 1e-12);
    EXPECT_NEAR(radiusOf({"mesh", "--preset", "paper", "--radius", "1.5dx"}), 1.5, 1e-12);
    EXPECT_EQ(report(1)["predicates"], "float");
    EXPECT_EQ(report(1)["skin"], 0);
}

TEST_F(Job, AnUnknownPresetIsAnErrorThatListsAllPresets) {
    writeFrames(1, 1);
    const Outcome outcome = mesh({"--preset", "flipp"});
    EXPECT_EQ(outcome.exit_code, 2);
    for (const Preset& preset : presets())
        EXPECT_NE(outcome.err.find(std::string(preset.name)), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("Did you mean 'flip'?"), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("--preset"), std::string::npos) << outcome.err;
    EXPECT_FALSE(exists("out"));
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

TEST_F(Job, TheSameBytesForAnyThreadsFramesInFlightAndChunks) {
    Sample sample({"dambreak", 2000, 1, 24});
    for (int frame = 1; frame <= 6; ++frame) writeFrame(frame, sample.frame(frame));
    ASSERT_EQ(mesh({"-j", "1", "--frames-in-flight", "1"}, "one/a.####.ply").exit_code, 0);
    ASSERT_EQ(mesh({"-j", "2", "--frames-in-flight", "1"}, "two/a.####.ply").exit_code, 0);
    ASSERT_EQ(mesh({"-j", "1", "--frames-in-flight", "4"}, "three/a.####.ply").exit_code, 0);
    ASSERT_EQ(mesh({"-j", "4", "--frames-in-flight", "4"}, "four/a.####.ply").exit_code, 0);
    ASSERT_EQ(mesh({"--chunk", "1/2"}, "five/a.####.ply").exit_code, 0);
    ASSERT_EQ(mesh({"--chunk", "2/2"}, "five/a.####.ply").exit_code, 0);
    const auto expected = meshesIn("one");
    ASSERT_GE(expected.size(), 6U);
    for (const char* other : {"two", "three", "four", "five"}) EXPECT_TRUE(meshesIn(other) == expected) << other;
}

TEST_F(Job, TheRadiusDoesNotDependOnWhichFramesAreMeshed) {
    Particles few;
    few.position = {Vec3f(0, 0, 0), Vec3f(1, 0, 0)};
    writeFrame(1, few);
    writeFrames(2, 2);
    writeFrames(3, 3, 2000);
    ASSERT_EQ(mesh({"--frames", "3"}).exit_code, 0);
    const double radius = report(3)["radius"].get<double>();
    ASSERT_EQ(mesh({"--chunk", "3/3", "--overwrite"}).exit_code, 0);
    EXPECT_EQ(report(3)["radius"].get<double>(), radius);
    ASSERT_EQ(mesh({"--overwrite"}).exit_code, 0);
    for (int frame = 1; frame <= 3; ++frame) EXPECT_EQ(report(frame)["radius"].get<double>(), radius);
    EXPECT_NEAR(radius, 1.5 * report(3)["spacing"].get<double>(), 1e-12);

    ASSERT_EQ(mesh({"--overwrite", "--radius", "0.3"}).exit_code, 0);
    EXPECT_EQ(report(1)["radius"].get<double>(), 0.3);
    EXPECT_NEAR(report(1)["spacing"].get<double>(), 0.2, 1e-12);
    ASSERT_EQ(mesh({"--overwrite", "--radius", "2dx", "--spacing", "0.25"}).exit_code, 0);
    EXPECT_EQ(report(1)["radius"].get<double>(), 0.5);
}

TEST_F(Job, TooFewParticlesNeedASpacingOrARadiusInWorldUnits) {
    Particles few;
    few.position.assign(6, Vec3f(0, 0, 0));
    for (std::size_t i = 0; i < 6; ++i) few.position[i].x = static_cast<float>(i);
    writeFrame(1, few);
    const Outcome outcome = mesh();
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_NE(outcome.err.find("--spacing"), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("--radius"), std::string::npos) << outcome.err;
    EXPECT_FALSE(exists("out"));
    EXPECT_EQ(mesh({"--radius", "0.4"}).exit_code, 0);
    EXPECT_EQ(mesh({"--spacing", "1", "--overwrite"}).exit_code, 0);
}

TEST_F(Job, MissingVelocityGivesOneWarningAndZeros) {
    Sample sample({"jitter", 400, 1, 24});
    for (int frame = 1; frame <= 3; ++frame) {
        Particles particles = sample.frame(frame);
        particles.velocity.clear();
        writeFrame(frame, particles);
    }
    const Outcome outcome = mesh();
    EXPECT_EQ(outcome.exit_code, 0);
    EXPECT_EQ(count(outcome.err, "zero velocities"), 1U) << outcome.err;
    for (int frame = 1; frame <= 3; ++frame) {
        ASSERT_EQ(report(frame)["warnings"].size(), 1U);
        const Mesh read = readMesh(folder_ / numbered("out/a", frame, ".ply"));
        EXPECT_EQ(read.velocity, std::vector<Vec3>(read.position.size(), Vec3(0, 0, 0)));
    }
    EXPECT_EQ(mesh({"--overwrite", "--velocity", "speed"}).exit_code, 1);
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
    EXPECT_EQ(report(2)["isolated_particles"], 1);
    ASSERT_EQ(mesh({"--tessellation", "paper"}, "out/a.####.obj").exit_code, 0);
    EXPECT_TRUE(exists("out/a.0002.spheres.ply"));
    ASSERT_EQ(mesh({"--tessellation", "paper"}, "out/a.####.bgeo.gz").exit_code, 0);
    EXPECT_TRUE(exists("out/a.0002.spheres.bgeo.gz"));

    particles.position.pop_back();
    writeFrame(2, particles);
    ASSERT_EQ(mesh({"--tessellation", "paper", "--overwrite"}).exit_code, 0);
    EXPECT_FALSE(exists("out/a.0002.spheres.ply"));
}

TEST_F(Job, DryRunShowsThePlanAndWritesNothing) {
    writeFrames(1, 2);
    Outcome outcome = mesh({"--dry-run", "--frames", "1-3", "--on-missing", "skip"});
    EXPECT_EQ(outcome.exit_code, 0);
    EXPECT_NE(outcome.out.find("frame 2: in/a.0002.ply -> out/a.0002.ply: mesh"), std::string::npos) << outcome.out;
    EXPECT_NE(outcome.out.find("frame 3: in/a.0003.ply -> out/a.0003.ply: skip (input missing)"), std::string::npos);
    EXPECT_FALSE(exists("out"));
    write(folder_ / "out/a.0002.ply", "mine");
    outcome = mesh({"--dry-run", "--json"});
    EXPECT_EQ(outcome.exit_code, 2);
    ASSERT_EQ(jsonLines(outcome.out).size(), 2U);
    EXPECT_EQ(jsonLines(outcome.out)[1]["action"], "refuse (output exists)");
}

TEST_F(Job, ASingleFileNeedsNoFrameNumber) {
    writeFrames(7, 7);
    ASSERT_EQ(runProgram({"mesh", "in/a.0007.ply", "drop.ply"}, folder_.path()).exit_code, 0);
    EXPECT_EQ(Json::parse(contentsOf(folder_ / "drop.ply.json"))["frame"], 7);
    ASSERT_EQ(runProgram({"mesh", "in/a.0007.ply", "out/b.$F4.ply"}, folder_.path()).exit_code, 0);
    EXPECT_TRUE(exists("out/b.0007.ply"));
    EXPECT_EQ(runProgram({"mesh", "in/a.0008.ply", "none.ply"}, folder_.path()).exit_code, 1);
    EXPECT_EQ(runProgram({"mesh", "in/a.0007.ply", "out/c.####.ply", "--frames", "1-2"}, folder_.path()).exit_code, 2);
}

TEST_F(Job, SignalsEndAJobWithTheirExitCodeAndNoPartialFiles) {
    Sample sample({"jitter", 8000, 1, 24});
    fs::create_directories(folder_ / "in");
    writeFrame(1, sample.frame(1));
    const int last = 2000;
    for (int frame = 2; frame <= last; ++frame) {
        fs::create_hard_link(folder_ / "in/a.0001.ply", folder_ / numbered("in/a", frame, ".ply"));
    }
    for (const int signal : {SIGTERM, SIGINT}) {
        SCOPED_TRACE(signal);
        fs::remove_all(folder_ / "out");
        RunningProgram program({"mesh", "in/a.####.ply", "out/a.####.ply", "--frames-in-flight", "3"}, folder_.path());
        ASSERT_TRUE(within(kSecondsToStart, [&] { return written(3); }));
        program.send(signal);
        const Outcome outcome = program.wait();
        EXPECT_EQ(outcome.exit_code, 128 + signal) << outcome.err;
        EXPECT_EQ(hiddenFiles("out"), 0U);
        int finished = 0;
        for (int frame = 1; frame <= last; ++frame) {
            EXPECT_TRUE(written(frame) || absent(frame)) << frame;
            if (!written(frame)) continue;
            ++finished;
            EXPECT_EQ(report(frame)["status"], "ok");
            EXPECT_FALSE(readMesh(folder_ / numbered("out/a", frame, ".ply")).triangles.empty());
        }
        EXPECT_GE(finished, 1);  // frame 3 at least; those before it may have been under way
        EXPECT_LT(finished, last);
    }
}

TEST_F(Job, ASignalInterruptsALongStage) {
    // Every ball reaches every other, and all are exposed: many minutes of work.
    writeFrame(1, spiralOnSphere(100000, 1));
    RunningProgram program({"mesh", "in/a.####.ply", "out/a.####.ply", "--radius", "1", "--spacing", "1"},
                           folder_.path());
    ASSERT_TRUE(within(kSecondsToStart, [&] { return exists("out"); }));  // made when the job begins
    std::this_thread::sleep_for(std::chrono::seconds(1));
    program.send(SIGTERM);
    const auto begin = std::chrono::steady_clock::now();
    const Outcome outcome = program.wait();
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(25));  // farms kill after 30 and more
    EXPECT_EQ(outcome.exit_code, 128 + SIGTERM) << outcome.err;
    EXPECT_TRUE(absent(1));
    EXPECT_EQ(hiddenFiles("out"), 0U);
}

/// Whether memory limits work here: some emulators and sandboxes accept a limit and ignore it.
bool memoryLimitsWork() {
    if (kSanitized) return false;
    const pid_t child = fork();
    if (child == 0) {
        const rlimit limit{1 << 20, 1 << 20};
        if (setrlimit(RLIMIT_DATA, &limit) != 0) _exit(1);
        _exit(mmap(nullptr, 1 << 28, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) == MAP_FAILED ? 0 : 1);
    }
    int status = 0;
    waitpid(child, &status, 0);
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

TEST_F(Job, AMemoryLimitThatIsTooSmallEndsWith33) {
    if (!memoryLimitsWork()) GTEST_SKIP() << "memory cannot be limited here";
    writeFrames(1, 2, 200000);                      // 6 MB each on disk, as much again in memory
    for (const char* radius : {"1.5dx", "0.02"}) {  // the first is out of memory when it measures dx
        SCOPED_TRACE(radius);
        const Outcome outcome = mesh({"--memory-limit", "1MiB", "-j", "1", "--radius", radius});
        EXPECT_EQ(outcome.exit_code, 33) << outcome.err;
        EXPECT_NE(outcome.err.find("out of memory"), std::string::npos) << outcome.err;
        EXPECT_TRUE(absent(1) && absent(2));
    }
    // Wherever it strikes, frames are whole or absent.
    for (const int frame : {1, 2}) {
        writeParticles(folder_ / numbered("in/a", frame, ".vdb"),
                       readParticles(folder_ / numbered("in/a", frame, ".ply")));
    }
    for (const char* input : {"in/a.####.ply", "in/a.####.vdb"}) {
        for (const char* limit : {"4MiB", "16MiB", "24MiB", "32MiB", "48MiB"}) {
            SCOPED_TRACE(std::string(input) + ' ' + limit);
            fs::remove_all(folder_ / "out");
            const Outcome outcome =
                runProgram({"mesh", input, "out/a.####.ply", "--memory-limit", limit, "-j", "2"}, folder_.path());
            EXPECT_TRUE(outcome.exit_code == 0 || outcome.exit_code == 33) << outcome.exit_code << '\n' << outcome.err;
            for (const int frame : {1, 2})
                EXPECT_TRUE(written(frame) || (outcome.exit_code == 33 && absent(frame))) << frame;
        }
    }
}

TEST_F(Job, AFrameLargerThanTheMemoryGivesTheSameBytes) {
    if (!memoryLimitsWork()) GTEST_SKIP() << "memory cannot be limited here";
    writeFrames(1, 1, 1000000);
    const Particles particles = readParticles(folder_ / "in/a.0001.ply");
    const auto run = [&](const std::string& input, std::vector<std::string> further) {
        std::vector<std::string> words{"mesh",     input,       "out/a.0001.ply", "-v", "--overwrite", "--spacing",
                                       "0.015625", "--surface", "alpha",          "-j", "2",           "--droplets",
                                       "drop"};
        words.insert(words.end(), further.begin(), further.end());
        const Outcome outcome = runProgram(words, folder_.path());
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return outcome.err.find(" particles are near the surface") != std::string::npos;
    };
    EXPECT_FALSE(run("in/a.0001.ply", {}));
    const auto meshes = meshesIn("out");
    const Json whole = report(1);
    for (const char* format : {".ply", ".bgeo", ".bgeo.gz", ".vdb"}) {
        SCOPED_TRACE(format);
        const std::string input = "in/a.0001" + std::string(format);
        if (input != "in/a.0001.ply") writeParticles(folder_ / input, particles);
        EXPECT_TRUE(run(input, {"--memory-limit", "300MiB"}));  // thought to take more than a GiB
        EXPECT_EQ(meshesIn("out"), meshes);
        for (const char* key : {"particles", "distinct_particles", "alpha_triangles", "triangles", "volume"})
            EXPECT_EQ(report(1)[key], whole[key]) << key;
    }
    EXPECT_TRUE(run("in/a.0001.ply", {"--memory-limit", "300MiB"}));
    EXPECT_LT(report(1)["peak_bytes"], whole["peak_bytes"]);
}

TEST_F(Job, TheDeprecatedScratchFolderIsWarnedOfOnce) {
    writeFrames(1, 3);
    const Outcome outcome = mesh({"--scratch", "absent"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(count(outcome.err, "run.scratch has no effect any more"), 1U) << outcome.err;
    EXPECT_FALSE(exists("absent"));
}

TEST_F(Job, AMemoryLimitThrottlesRatherThanFails) {
    if (!memoryLimitsWork()) GTEST_SKIP() << "memory cannot be limited here";
    writeFrames(1, 1, 60000);  // takes about 50 MB, six of them more than the limit
    for (int frame = 2; frame <= 6; ++frame)
        fs::create_hard_link(folder_ / "in/a.0001.ply", folder_ / numbered("in/a", frame, ".ply"));
    const Outcome outcome = mesh({"--memory-limit", "120MiB", "-j", "6", "--frames-in-flight", "6"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    const auto meshes = meshesIn("out");
    ASSERT_EQ(meshes.size(), 6U);
    for (const auto& entry : meshes) EXPECT_TRUE(entry.second == meshes.begin()->second) << entry.first;
}

TEST_F(Job, LevelSetsAreCountedInTheMemoryOfFrames) {
    writeFrames(1, 1, 2000);
    const auto megabytes = [&](const std::vector<std::string>& further, const std::string& output) {
        std::vector<std::string> words{"--dry-run", "--json"};
        words.insert(words.end(), further.begin(), further.end());
        const Outcome outcome = mesh(words, output);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return jsonLines(outcome.out).at(0)["memory_bytes"].get<double>() / 1e6;
    };
    const double alone = megabytes({}, "out/a.####.ply");
    EXPECT_NEAR(megabytes({"--voxel", "0.5dx"}, "out/a.####.vdb"), alone + 1.06, 0.1);
    const double fine = megabytes({"--voxel", "0.05dx"}, "out/a.####.vdb");
    EXPECT_NEAR(fine, alone + 106, 10);
    EXPECT_NEAR(megabytes({"--voxel", "0.05", "--spacing", "1"}, "out/a.####.vdb"), fine, 10);
    EXPECT_NEAR(megabytes({"--voxel", "0.05dx", "--velocity-grid"}, "out/a.####.vdb"), alone + 211, 20);
    EXPECT_LT(megabytes({"--voxel", "1e-30"}, "out/a.####.vdb"), 1e19);
    // Farms are asked for as much, whichever output needs it.
    const auto submitted = [&](const std::string& outputs) {
        write(folder_ / "j.yaml", "version: 1\ninput: {path: in/a.####.ply}\noutputs: [" + outputs + "]\n");
        const Outcome outcome = runProgram({"submit", "j.yaml", "--to", "slurm", "--print"}, folder_.path());
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        const std::size_t at = outcome.out.find("mem=");
        return at == std::string::npos ? 0 : std::stoi(outcome.out.substr(at + 4));
    };
    const int meshes = submitted("{path: out/a.####.ply}");
    EXPECT_GT(submitted("{path: out/a.####.ply}, {path: out/a.####.vdb, voxel: 0.05dx}"), meshes + 140);
}

TEST_F(Job, LevelSetsThatDoNotFitTogetherAreMadeOneAfterTheOther) {
    if (!memoryLimitsWork()) GTEST_SKIP() << "memory cannot be limited here";
    writeFrames(1, 1, 4000);
    for (int frame = 2; frame <= 6; ++frame)
        fs::create_hard_link(folder_ / "in/a.0001.ply", folder_ / numbered("in/a", frame, ".ply"));
    const std::vector<std::string> options{"--voxel", "0.1dx", "-j", "6", "--frames-in-flight", "6", "--memory-limit"};
    std::vector<std::string> enough = options, little = options;
    enough.emplace_back("160MiB");
    const Outcome outcome = mesh(enough, "out/a.####.vdb");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    const auto meshes = meshesIn("out");
    ASSERT_EQ(meshes.size(), 6U);
    for (const auto& entry : meshes) EXPECT_TRUE(entry.second == meshes.begin()->second) << entry.first;
    little.emplace_back("40MiB");
    little.emplace_back("--overwrite");
    const Outcome too_little = mesh(little, "out/a.####.vdb");
    EXPECT_EQ(too_little.exit_code, 33) << too_little.err;
    for (const char* words : {"frame 3: out of memory", "voxels of", "Choose larger voxels with --voxel"})
        EXPECT_NE(too_little.err.find(words), std::string::npos) << too_little.err;
    EXPECT_EQ(hiddenFiles("out"), 0U);
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
            wrong.err.find(std::string("--voxel: output.voxel: '") + voxel + "' is not valid. Use a number above 0"),
            std::string::npos)
            << wrong.err;
    }
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

TEST_F(Job, AFrameTooLargeForTheMemoryDoesNotLoseTheOthers) {
    if (!memoryLimitsWork()) GTEST_SKIP() << "memory cannot be limited here";
    writeFrames(1, 5, 1000);
    writeFrames(3, 3, 300000);
    const Outcome outcome = mesh({"--memory-limit", "60MiB", "-j", "2", "--radius", "0.02"});
    EXPECT_EQ(outcome.exit_code, 33) << outcome.err;
    for (const char* words : {"frame 3: out of memory", "particles are near the surface", "MiB"})
        EXPECT_NE(outcome.err.find(words), std::string::npos) << outcome.err;
    for (int frame = 1; frame <= 5; ++frame) EXPECT_TRUE(frame == 3 ? absent(frame) : written(frame)) << frame;
}

/// The resources of a process.
struct Holdings {
    std::uint64_t kibibytes = 0;
    std::size_t descriptors = 0;
};

Holdings holdingsOf(pid_t process) {
    const fs::path folder = "/proc/" + std::to_string(process);
    Holdings holdings;
    std::ifstream status(folder / "status");
    for (std::string line; std::getline(status, line);)
        if (line.starts_with("VmRSS:")) holdings.kibibytes = std::stoull(line.substr(6));
    for (const auto& entry : fs::directory_iterator(folder / "fd")) holdings.descriptors += entry.exists() ? 1 : 0;
    return holdings;
}

TEST_F(Job, MemoryAndDescriptorsDoNotGrowWithTheNumberOfFrames) {
    if (kSanitized) GTEST_SKIP() << "sanitizers hold memory of their own";
    const int last = 5000;
    writeFrames(1, 1, 8);
    for (int frame = 2; frame <= last; ++frame)
        fs::create_hard_link(folder_ / "in/a.0001.ply", folder_ / numbered("in/a", frame, ".ply"));
    RunningProgram program(
        {"mesh", "in/a.####.ply", "out/a.####.ply", "--radius", "0.1", "-q", "--frames-in-flight", "8"},
        folder_.path());
    ASSERT_TRUE(within(kSecondsToStart, [&] { return written(500); }));
    const Holdings early = holdingsOf(program.worker());
    ASSERT_TRUE(within(kSecondsToStart, [&] { return written(4900); }));
    const Holdings late = holdingsOf(program.worker());
    EXPECT_EQ(program.wait().exit_code, 0);
    EXPECT_GT(early.kibibytes, 1000U);
    EXPECT_LT(late.kibibytes, early.kibibytes + early.kibibytes / 4);
    EXPECT_LE(late.descriptors, early.descriptors + 16);  // eight frames open three each at most, at any moment
    for (int frame = 1; frame <= last; ++frame) ASSERT_TRUE(written(frame)) << frame;
}

TEST_F(Job, ALogFileContainsAllMessagesAndDetails) {
    writeFrames(1, 3);
    EXPECT_EQ(mesh({"--log-file", "logs/job.log", "-q"}).exit_code, 0);
    const std::string once = contentsOf(folder_ / "logs/job.log");
    EXPECT_EQ(count(once, "debug: frame "), 3U) << once;
    EXPECT_EQ(count(once, "info: 3 of 3 frames written"), 1U);
    EXPECT_EQ(mesh({"--log-file", "logs/job.log", "--frames", "1-4", "--overwrite"}).exit_code, 1);
    const std::string twice = contentsOf(folder_ / "logs/job.log");
    EXPECT_TRUE(twice.starts_with(once));
    EXPECT_EQ(count(twice, "error: frame 4: in/a.0004.ply"), 1U) << twice;
    write(folder_ / "file", "");
    EXPECT_EQ(mesh({"--log-file", "file/job.log"}).exit_code, 2);

    // A full log file is renamed.
    fs::resize_file(folder_ / "logs/job.log", 9'999'900);
    EXPECT_EQ(mesh({"--log-file", "logs/job.log", "--overwrite"}).exit_code, 0);
    EXPECT_TRUE(exists("logs/job.1.log"));
    EXPECT_LT(fs::file_size(folder_ / "logs/job.log"), 100'000U);
}

TEST_F(Job, ProgressForMachinesCountsToTheEnd) {
    writeFrames(1, 4);
    for (const bool json : {false, true}) {
        std::vector<std::string> words{"--progress", "json", "--frames", "1-5", "--overwrite", "-q"};
        if (json) words.push_back("--json");
        const Outcome outcome = mesh(words);
        EXPECT_EQ(outcome.exit_code, 1);
        std::size_t ended = 0;
        for (const Json& line : jsonLines(json ? outcome.err : outcome.out)) {
            if (!line.is_object()) continue;  // errors among them
            EXPECT_EQ(line["ended"], ++ended);
            EXPECT_EQ(line["frames"], 5);
            EXPECT_GE(line["seconds_left"].get<double>(), 0);
            EXPECT_EQ(line["seconds_left"] == 0, ended == 5);
            if (ended < 5) continue;
            EXPECT_EQ(line["failed"], 1);
            EXPECT_GT(line["particles"].get<int>(), 4 * 300);
        }
        EXPECT_EQ(ended, 5U);
    }
}

TEST_F(Job, ProgressIsPrintedAsEachFarmEngineExpects) {
    writeFrames(1, 4);
    const Outcome openjd = mesh({"--progress", "openjd", "--frames", "1-5"});
    EXPECT_EQ(openjd.exit_code, 1);
    EXPECT_NE(openjd.out.find("openjd_progress: 20\nopenjd_status: "), std::string::npos) << openjd.out;
    EXPECT_NE(openjd.out.find("openjd_progress: 100\n"), std::string::npos);
    EXPECT_EQ(count(openjd.out, "openjd_fail: "), 1U);
    const Outcome tractor = mesh({"--progress", "tractor", "--overwrite"});
    EXPECT_EQ(tractor.out, "TR_PROGRESS 025%\nTR_PROGRESS 050%\nTR_PROGRESS 075%\nTR_PROGRESS 100%\n");
    const Outcome quiet = mesh({"-q", "--overwrite"});
    EXPECT_EQ(quiet.out + quiet.err, "");
}

TEST_F(Job, GapsInTheFramesOnDiskGiveAWarning) {
    for (const int frame : {1, 2, 4}) writeFrames(frame, frame);
    const Outcome outcome = mesh();
    EXPECT_EQ(outcome.exit_code, 0);
    EXPECT_NE(outcome.err.find("gaps (1-2,4)"), std::string::npos) << outcome.err;
}

TEST_F(Job, SetOverridesThePipelineFileAndOptionsOverrideSet) {
    writeFrames(1, 3);
    write(folder_ / "presets/base.yaml", "version: 1\nsurface: {radius: 0.5, predicates: float}\n");
    write(folder_ / "job.yaml",
          "version: 1\ninclude: presets/base.yaml\ninput: {path: in/a.@@@@.ply}\noutput: {path: out/a.%04d.ply}\n"
          "frames: 1-2\nsurface: {radius: 0.4}\n");
    const auto radiusOf = [&](const std::vector<std::string>& further) {
        std::vector<std::string> words{"run", "job.yaml", "--overwrite"};
        words.insert(words.end(), further.begin(), further.end());
        const Outcome outcome = runProgram(words, folder_.path());
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return report(1)["radius"].get<double>();
    };
    EXPECT_EQ(radiusOf({}), 0.4);
    EXPECT_EQ(report(1)["predicates"], "float");
    EXPECT_TRUE(written(2) && absent(3));
    EXPECT_EQ(radiusOf({"--set", "surface.radius=0.3", "--set", "surface.predicates=exact"}), 0.3);
    EXPECT_EQ(report(1)["predicates"], "exact");
    EXPECT_EQ(radiusOf({"--radius", "0.2", "--set", "surface.radius=0.3"}), 0.2);
}

TEST_F(Job, AnInvalidPipelineFileRunsNothing) {
    writeFrames(1, 1);
    write(folder_ / "job.yaml",
          "version: 1\ninput: {path: in/a.####.ply}\noutput: {path: out/a.####.ply}\nsurface:\n  radus: 1\n");
    for (const std::vector<std::string>& words : {std::vector<std::string>{"run", "job.yaml"},
                                                  {"config", "check", "job.yaml"},
                                                  {"config", "print", "job.yaml"}}) {
        const Outcome outcome = runProgram(words, folder_.path());
        EXPECT_EQ(outcome.exit_code, 2);
        EXPECT_NE(outcome.err.find("job.yaml:5:3: unknown key 'surface.radus'"), std::string::npos) << outcome.err;
        EXPECT_NE(outcome.err.find("'surface.radius'"), std::string::npos) << outcome.err;
        EXPECT_EQ(outcome.out, "");
    }
    EXPECT_FALSE(exists("out"));
}

}  // namespace
}  // namespace betamesh
