// Batch jobs as a farm sees them: which files they write, and their exit codes.

#include "batch/job/frames.h"
#include "io/mesh_file.h"
#include "support/job_folder.h"

#include <sstream>

namespace betamesh {
namespace {

using Job = JobFolder;

TEST_F(Job, WritesEveryFrameOnDiskWithItsManifest) {
    writeFrames(1, 3);
    const Outcome outcome = mesh();
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    for (int frame = 1; frame <= 3; ++frame) {
        EXPECT_TRUE(written(frame));
        EXPECT_EQ(manifest(frame)["status"], "ok");
        const Mesh read = readMesh(folder_ / numbered("out/a", frame, ".ply"));
        EXPECT_EQ(read.triangles.size(), manifest(frame)["triangles"].get<std::size_t>());
        EXPECT_EQ(read.velocity.size(), read.position.size());
    }
    EXPECT_EQ(hiddenFiles("out"), 0U);
}

TEST_F(Job, AMissingFrameIsAnErrorASkipOrAnEmptyMesh) {
    writeFrames(1, 1);
    writeFrames(3, 3);
    const Outcome error = mesh({"--frames", "1-3"});
    EXPECT_EQ(error.exit_code, 1);
    EXPECT_NE(error.err.find("in/a.0002.ply"), std::string::npos) << error.err;
    EXPECT_TRUE(written(1) && absent(2) && written(3));

    const Outcome skipped = mesh({"--frames", "1-3", "--overwrite", "--on-missing", "skip"});
    EXPECT_EQ(skipped.exit_code, 0);
    EXPECT_NE(skipped.err.find("frame 2: skipped, as there is no input (in/a.0002.ply)"), std::string::npos)
        << skipped.err;
    EXPECT_TRUE(written(1) && absent(2) && written(3));

    EXPECT_EQ(mesh({"--frames", "1-3", "--overwrite", "--on-missing", "empty"}).exit_code, 0);
    EXPECT_TRUE(written(1) && written(2) && written(3));
    EXPECT_EQ(manifest(2)["status"], "empty");
    EXPECT_FALSE(manifest(2)["warnings"].empty());
    EXPECT_TRUE(readMesh(folder_ / "out/a.0002.ply").position.empty());
}

TEST_F(Job, AnEmptyFrameIsAnEmptyMeshThatDeclaresTheSameAttributes) {
    writeFrames(1, 1);
    Particles none;
    writeFrame(2, none);
    EXPECT_EQ(mesh().exit_code, 0);
    EXPECT_EQ(manifest(2)["status"], "empty");
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

TEST_F(Job, ErrorsNameTheInputWhateverTheOutputIsCalled) {
    writeFrames(1, 1);
    for (const char* output : {"out/a.svg", "out/plane.svg"}) {
        const Outcome outcome = runProgram({"mesh", "in/a.0001.ply", output, "--dimension", "2"}, folder_.path());
        EXPECT_EQ(outcome.exit_code, 1);
        EXPECT_NE(outcome.err.find("in/a.0001.ply: the particles do not lie in a plane"), std::string::npos)
            << outcome.err;
    }
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
    fs::remove(folder_ / "out/a.0002.ply.json");  // as if it had been interrupted before the manifest
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
    const double radius = manifest(3)["radius"].get<double>();
    ASSERT_EQ(mesh({"--chunk", "3/3", "--overwrite"}).exit_code, 0);
    EXPECT_EQ(manifest(3)["radius"].get<double>(), radius);
    ASSERT_EQ(mesh({"--overwrite"}).exit_code, 0);
    for (int frame = 1; frame <= 3; ++frame) EXPECT_EQ(manifest(frame)["radius"].get<double>(), radius);
    EXPECT_NEAR(radius, 1.5 * manifest(3)["spacing"].get<double>(), 1e-12);

    ASSERT_EQ(mesh({"--overwrite", "--radius", "0.3"}).exit_code, 0);
    EXPECT_EQ(manifest(1)["radius"].get<double>(), 0.3);
    EXPECT_NEAR(manifest(1)["spacing"].get<double>(), 0.2, 1e-12);
    ASSERT_EQ(mesh({"--overwrite", "--radius", "2dx", "--spacing", "0.25"}).exit_code, 0);
    EXPECT_EQ(manifest(1)["radius"].get<double>(), 0.5);
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
        ASSERT_EQ(manifest(frame)["warnings"].size(), 1U);
        const Mesh read = readMesh(folder_ / numbered("out/a", frame, ".ply"));
        EXPECT_EQ(read.velocity, std::vector<Vec3>(read.position.size(), Vec3(0, 0, 0)));
    }
    EXPECT_EQ(mesh({"--overwrite", "--velocity", "speed"}).exit_code, 1);
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

TEST_F(Job, WhatIsLeftOutOfASequenceGivesAWarning) {
    for (const int frame : {1, 2, 4}) writeFrames(frame, frame);
    ASSERT_EQ(mesh().exit_code, 0);
    const auto expectWarning = [&](const std::vector<std::string>& words, const std::string& warning) {
        const Outcome outcome = runProgram(words, folder_.path());
        EXPECT_EQ(outcome.exit_code, 0) << words[0] << outcome.err;
        EXPECT_EQ(count(outcome.err, warning), 1U) << words[0] << outcome.err;
    };
    for (const std::string& folder : {std::string("in"), std::string("out")})
        fs::copy_file(folder_ / (folder + "/a.0002.ply"), folder_ / (folder + "/a.03.ply"));
    std::vector<std::vector<std::string>> commands{
        {"convert", "in/a.####.ply", "new/a.####.ply", "--overwrite"},
        {"render", "out/a.####.ply", "new/a.####.png", "--width", "64", "--height", "48", "--overwrite"},
        {"info", "in/a.####.ply"},
        {"check", "out/a.####.ply"},
        {"coherence", "out/a.####.ply"}};
    for (const auto& words : commands) {
        expectWarning(words, "gaps (1-2,4)");
        expectWarning(words,
                      "left out because their numbers are padded otherwise: " + folderOf(words[1]) + "/a.03.ply");
    }
    expectWarning({"mesh", "in/a.####.ply", "new/m.####.ply"}, "gaps (1-2,4), which are left out. Give");
    expectWarning({"mesh", "in/a.####.ply", "new/m.####.ply", "--overwrite"}, "padded otherwise: in/a.03.ply");
    // Sub-frames have other time steps: only mesh refuses them.
    for (const std::string& folder : {std::string("in"), std::string("out")})
        fs::copy_file(folder_ / (folder + "/a.0002.ply"), folder_ / (folder + "/a.0002.25.ply"));
    for (const auto& words : commands) expectWarning(words, "left out because they are sub-frames: ");
    EXPECT_EQ(mesh({"--overwrite"}).exit_code, 2);
    commands[0].insert(commands[0].end(), {"--frames", "1-2"});
    EXPECT_EQ(runProgram(commands[0], folder_.path()).err.find("left out"), std::string::npos);
}

}  // namespace
}  // namespace betamesh
