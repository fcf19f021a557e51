// Jobs with several outputs.

#include "support/job_folder.h"

#include <chrono>
#include <thread>

namespace betamesh {
namespace {

class Outputs : public JobFolder {
protected:
    /// Runs a pipeline of these outputs, a YAML list, on the frames in in/.
    Outcome run(const std::string& outputs, const std::vector<std::string>& further = {}) {
        write(folder_ / "job.yaml",
              "version: 1\ninput: {path: in/a.####.ply}\npreview: {width: 64, height: 36, samples: 1}\noutputs:\n" +
                  outputs);
        std::vector<std::string> words{"run", "job.yaml"};
        words.insert(words.end(), further.begin(), further.end());
        return runProgram(words, folder_.path());
    }
};

constexpr const char* kThree =
    "  - {path: hero/a.####.ply, components: true}\n"
    "  - {path: hero/a.####.bgeo, components: true}\n"
    "  - {path: proxy/a.####.ply, preset: preview, input: {where: P.y > 0.2}}\n";

TEST_F(Outputs, EachIsThatOfAJobOfItsOwn) {
    writeFrames(1, 3);
    const Outcome outcome = run(kThree, {"--json"});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("3 of 3 frames written"), std::string::npos) << outcome.err;
    std::map<std::string, int> reported;
    for (const Json& frame : jsonLines(outcome.out)) ++reported[frame["output"].get<std::string>()];
    EXPECT_EQ(reported.size(), 9U);
    const auto same = [&](const std::string& folder, const std::string& extension,
                          const std::vector<std::string>& further) {
        ASSERT_EQ(mesh(further, "alone/a.####" + extension).exit_code, 0);
        for (int frame = 1; frame <= 3; ++frame)
            EXPECT_EQ(contentsOf(folder_ / numbered(folder + "/a", frame, extension)),
                      contentsOf(folder_ / numbered("alone/a", frame, extension)))
                << folder << extension << frame;
        fs::remove_all(folder_ / "alone");
    };
    same("hero", ".ply", {"--components"});
    same("hero", ".bgeo", {"--components"});
    same("proxy", ".ply", {"--preset", "preview", "--where", "P.y > 0.2"});
}

TEST_F(Outputs, OnlyWhatIsMissingIsMadeAgain) {
    writeFrames(1, 2);
    const std::string outputs =
        "  - {path: out/a.####.ply, preview: {path: look/a.####.png}}\n"
        "  - {path: small/a.####.ply, preset: preview}\n";
    ASSERT_EQ(run(outputs).exit_code, 0);
    const auto meshes = meshesIn("out"), pictures = meshesIn("look"), small = meshesIn("small");
    const Json before = manifest(2);
    fs::remove(folder_ / "look/a.0002.png");
    fs::remove(folder_ / "small/a.0001.ply");
    const auto made = fs::last_write_time(folder_ / "out/a.0002.ply");

    const Outcome planned = run(outputs, {"--skip-existing", "--dry-run"});
    EXPECT_NE(planned.out.find("out/a.0002.ply: draw"), std::string::npos) << planned.out;
    EXPECT_NE(planned.out.find("small/a.0001.ply: mesh"), std::string::npos) << planned.out;
    EXPECT_EQ(count(planned.out, "skip (output exists)"), 2U) << planned.out;

    ASSERT_EQ(run(outputs, {"--skip-existing"}).exit_code, 0);
    EXPECT_EQ(meshesIn("look"), pictures);
    EXPECT_EQ(meshesIn("small"), small);
    EXPECT_EQ(meshesIn("out"), meshes);
    EXPECT_EQ(manifest(2), before);
    EXPECT_EQ(fs::last_write_time(folder_ / "out/a.0002.ply"), made);
    EXPECT_NE(run(outputs, {"--skip-existing"}).err.find("0 of 2 frames written, 2 skipped"), std::string::npos);
}

/// A preview may fail while it is rendered or while it is written.
TEST_F(Outputs, AMeshOutlivesItsPreview) {
    writeFrames(1, 2);
    const std::string output = "  - {path: out/a.####.ply, preview: {path: look/a.####.png}}\n";
    ASSERT_EQ(run(output).exit_code, 0);
    const auto meshes = meshesIn("out"), pictures = meshesIn("look");
    const auto forget = [&] {
        fs::remove_all(folder_ / "out");
        fs::remove_all(folder_ / "look");
    };
    const auto expectMeshAlone = [&](const Outcome& outcome, const std::string& why) {
        EXPECT_EQ(outcome.exit_code, 1);
        EXPECT_NE(outcome.err.find("frame 2: look/a.0002.png: " + why), std::string::npos) << outcome.err;
        EXPECT_NE(outcome.err.find("The mesh out/a.0002.ply is complete"), std::string::npos) << outcome.err;
        EXPECT_EQ(outcome.err.find("in/a.0002.ply"), std::string::npos) << outcome.err;
        EXPECT_TRUE(meshesIn("out") == meshes);
        EXPECT_EQ(manifest(2)["status"], "ok");
        const auto made = fs::last_write_time(folder_ / "out/a.0002.ply");
        fs::remove_all(folder_ / "look/a.0002.png");
        ASSERT_EQ(run(output, {"--skip-existing"}).exit_code, 0);
        EXPECT_EQ(fs::last_write_time(folder_ / "out/a.0002.ply"), made);
        EXPECT_TRUE(meshesIn("look") == pictures);
        EXPECT_NE(run(output, {"--skip-existing"}).err.find("2 skipped"), std::string::npos);
    };
    forget();
    expectMeshAlone(run("  - {path: out/a.####.ply, preview: {path: look/a.####.png, colour: Cd}}\n", {"--overwrite"}),
                    "the mesh has no attribute 'Cd'");
    forget();
    fs::create_directories(folder_ / "look/a.0002.png/inside");
    const Outcome outcome = run(output, {"--overwrite", "--io-retries", "0", "--json"});
    const std::vector<Json> frames = jsonLines(outcome.out);
    ASSERT_EQ(frames.size(), 2U);
    for (const Json& frame : frames) EXPECT_EQ(frame["status"], frame["frame"] == 2 ? "failed" : "ok");
    expectMeshAlone(outcome, "cannot be written");
}

TEST_F(Outputs, MeshesDoNotDependOnPreviews) {
    writeFrames(1, 2);
    const auto outputWith = [](const std::string& preview) {
        return "  - {path: out/a.####.ply, preview: {" + preview + "}}\n";
    };
    ASSERT_EQ(run(outputWith("shading: studio")).exit_code, 0);
    const auto meshes = meshesIn("out");
    const auto made = fs::last_write_time(folder_ / "out/a.0002.ply");
    const std::vector<std::string> previews{
        "path: look/a.####.png",                  // where there was none
        "path: look/a.####.png, shading: zebra",  // other settings
        "path: look/a.####.png, show: particles",
        "path: look/a.####.png, show: union",
        "path: other/a.####.png, show: union",                  // elsewhere
        "path: look/a.####.exr",                                // another format
        "path: '" + folder_.path().string() + "/b.####.png'"};  // whose way to the mesh is not known
    for (const std::string& preview : previews) {
        SCOPED_TRACE(preview);
        const Outcome planned = run(outputWith(preview), {"--skip-existing", "--dry-run"});
        EXPECT_EQ(count(planned.out, ": draw"), 2U) << planned.out;
        ASSERT_EQ(run(outputWith(preview), {"--skip-existing"}).exit_code, 0);
        EXPECT_TRUE(meshesIn("out") == meshes);
        EXPECT_EQ(fs::last_write_time(folder_ / "out/a.0002.ply"), made);
        EXPECT_NE(run(outputWith(preview), {"--skip-existing"}).err.find("2 skipped"), std::string::npos);
    }
    // The pictures are those of a job that makes all files.
    ASSERT_EQ(run(outputWith("path: look/a.####.png, show: union"), {"--skip-existing"}).exit_code, 0);
    const std::string drawn = contentsOf(folder_ / "look/a.0002.png");
    ASSERT_EQ(run(outputWith("path: look/a.####.png, show: union"), {"--overwrite"}).exit_code, 0);
    EXPECT_TRUE(contentsOf(folder_ / "look/a.0002.png") == drawn);
    fs::remove_all(folder_ / "look");  // no preview is wanted any more
    EXPECT_NE(run(outputWith("shading: zebra"), {"--skip-existing"}).err.find("2 skipped"), std::string::npos);
}

TEST_F(Outputs, TheSameMeshMayHaveSeveralFormats) {
    writeFrames(1, 1);
    EXPECT_EQ(run("  - {path: out/a.####.ply}\n  - {path: out/a.####.obj}\n").exit_code, 0);
    const Outcome spheres =
        run("  - {path: b/a.####.ply, features: {droplets: points}}\n"
            "  - {path: b/a.####.obj, features: {droplets: points}}\n");
    EXPECT_EQ(spheres.exit_code, 2);
    EXPECT_NE(spheres.err.find("both the file of spheres"), std::string::npos) << spheres.err;
}

// One surface, of which the outputs have different shares of the triangles.
TEST_F(Outputs, AreSimplifiedEachByItsLength) {
    writeFrames(1, 1);
    const Outcome outcome =
        run("  - {path: full/a.####.ply}\n"
            "  - {path: fine/a.####.ply, simplify: 0.01dx}\n"
            "  - {path: coarse/a.####.ply, simplify: 0.1dx}\n",
            {"--json"});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    std::vector<Json> results = jsonLines(outcome.out);
    ASSERT_EQ(results.size(), 3U);
    EXPECT_LT(results[1]["triangles"], results[0]["triangles"]);
    EXPECT_LT(results[2]["triangles"], results[1]["triangles"]);
    for (const Json& result : results) {
        const std::string file = result["output"];
        const Json check = Json::parse(runProgram({"check", "--json", file}, folder_.path()).out);
        EXPECT_EQ(check["triangles"], result["triangles"]);
        EXPECT_NEAR(check["area"], result["area"], 1e-5 * result["area"].get<double>());
        EXPECT_TRUE(check["faults"].empty()) << file;
    }
    ASSERT_EQ(mesh({"--simplify", "0.1dx"}).exit_code, 0);
    EXPECT_EQ(contentsOf(folder_ / "out/a.0001.ply"), contentsOf(folder_ / "coarse/a.0001.ply"));
}

TEST_F(Outputs, OneThatFailsHarmsNoOther) {
    writeFrames(1, 2);
    const Outcome outcome =
        run("  - {path: out/a.####.ply}\n"
            "  - {path: bad/a.####.ply, attributes: [temperature]}\n"
            "  - {path: good/a.####.bgeo}\n");
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_NE(outcome.err.find("bad/a.0001.ply: "), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("temperature"), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("2 failed"), std::string::npos) << outcome.err;
    for (const int frame : {1, 2}) {
        EXPECT_TRUE(written(frame));
        EXPECT_TRUE(exists(numbered("good/a", frame, ".bgeo.json")));
        EXPECT_FALSE(exists(numbered("bad/a", frame, ".ply")));
    }
}

TEST_F(Outputs, SurviveTheLossOfAWorker) {
    const int last = 40;
    writeFrames(1, last, 2000);
    ASSERT_EQ(run(kThree, {"-q"}).exit_code, 0);
    const auto hero = meshesIn("hero"), proxy = meshesIn("proxy");
    fs::remove_all(folder_ / "hero");
    fs::remove_all(folder_ / "proxy");
    RunningProgram program({"run", "job.yaml"}, folder_.path());
    ASSERT_TRUE(within(kSecondsToStart, [&] { return exists("proxy/a.0002.ply.json"); }));
    if (const pid_t worker = program.worker(); worker > 0) kill(worker, SIGKILL);
    const Outcome outcome = program.wait();
    if (outcome.exit_code != 0) {  // only one frame was in progress: then that is given up
        EXPECT_EQ(outcome.exit_code, 33) << outcome.err;
        EXPECT_NE(outcome.err.find("39 of 40 frames written, 0 skipped, 1 failed"), std::string::npos) << outcome.err;
        const Outcome again = runProgram({"run", "job.yaml", "--skip-existing"}, folder_.path());
        ASSERT_EQ(again.exit_code, 0) << again.err;
    }
    EXPECT_TRUE(meshesIn("hero") == hero);  // printing a difference of so many bytes takes gigabytes
    EXPECT_TRUE(meshesIn("proxy") == proxy);
}

TEST_F(Outputs, WrongListsAreRefusedBeforeAnythingIsWritten) {
    writeFrames(1, 1);
    struct Wrong {
        const char* outputs;
        const char* error;
    };
    for (const Wrong& wrong :
         {Wrong{"  - {path: out/a.####.ply}\n  - {path: out/a.####.ply}\n",
                "both the mesh of frame 1 in output 1 and the mesh of frame 1 in output 2"},
          Wrong{"  - {path: out/a.####.ply}\n  - {preset: preview}\n", "output 2 of the list of outputs has no path"},
          Wrong{"  - {path: out/a.####.ply, frames: 1-2}\n", "job.yaml:5:28: frames is the same for all outputs"},
          Wrong{"  - {path: out/a.####.ply, run: {threads: 2}}\n", "run.threads is the same for all outputs"},
          Wrong{"  - {path: out/a.####.ply, output: {path: b.####.ply}}\n", "output.path is set a second time"},
          Wrong{"  - {path: out/a.####.ply, radius: 2dx}\n", "Did you mean 'surface.radius'?"},
          Wrong{"  - out/a.####.ply\n", "job.yaml:5:5: outputs: an output is a value"},
          Wrong{"  {path: out/a.####.ply}\n", "job.yaml:5:3: outputs: the value is a map"},
          Wrong{"  - {path: out/a.####.ply}\noutput: {path: out/b.####.ply}\n", "beside a list of outputs"}}) {
        SCOPED_TRACE(wrong.outputs);
        const Outcome outcome = run(wrong.outputs);
        EXPECT_EQ(outcome.exit_code, 2);
        EXPECT_NE(outcome.err.find(wrong.error), std::string::npos) << outcome.err;
        EXPECT_FALSE(exists("out"));
    }
}

TEST_F(Outputs, PrintedConfigurationsReadBack) {
    writeFrames(1, 1);
    run(kThree, {"--dry-run"});
    const Outcome printed = runProgram({"config", "print", "job.yaml"}, folder_.path());
    write(folder_ / "printed.yaml", printed.out);
    const auto plan = [&](const std::string& file) {
        return runProgram({"run", file, "--dry-run", "--json"}, folder_.path()).out;
    };
    EXPECT_EQ(plan("printed.yaml"), plan("job.yaml"));
    EXPECT_EQ(count(plan("job.yaml"), "\"mesh\""), 3U);
    EXPECT_EQ(runProgram({"config", "print", "printed.yaml"}, folder_.path()).out, printed.out);
}

}  // namespace
}  // namespace betamesh
