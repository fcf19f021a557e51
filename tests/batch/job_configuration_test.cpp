// Which of presets, pipeline files, --set and options wins.

#include "batch/config/presets.h"
#include "support/job_folder.h"

#include <algorithm>

namespace betamesh {
namespace {

using Job = JobFolder;

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
        return manifest(1)["radius"].get<double>() / 0.2;
    };
    EXPECT_NEAR(radiusOf({"mesh", "--preset", "splash"}), 1.2, 1e-12);
    EXPECT_NEAR(radiusOf({"mesh", "--set", "preset=splash"}), 1.2, 1e-12);
    EXPECT_NEAR(radiusOf({"mesh", "--preset", "splash", "--set", "surface.radius=1.3dx"}), 1.3, 1e-12);
    EXPECT_NEAR(radiusOf({"mesh", "--preset", "splash,viscous"}), 1.75, 1e-12);
    EXPECT_NEAR(radiusOf({"mesh", "--radius", "1.1dx", "--preset", "splash"}), 1.1, 1e-12);
    EXPECT_NEAR(radiusOf({"run", "job.yaml"}), 2.2, 1e-12);
    EXPECT_NEAR(radiusOf({"run", "job.yaml", "--preset", "splash"}), 1.2, 1e-12);
    EXPECT_NEAR(radiusOf({"run", "own.yaml", "--preset", "splash"}), 1.4, 1e-12);
    EXPECT_NEAR(radiusOf({"mesh", "--preset", "paper", "--radius", "1.5dx"}), 1.5, 1e-12);
    EXPECT_EQ(manifest(1)["predicates"], "float");
    EXPECT_EQ(manifest(1)["skin"], 0);
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
        return manifest(1)["radius"].get<double>();
    };
    EXPECT_EQ(radiusOf({}), 0.4);
    EXPECT_EQ(manifest(1)["predicates"], "float");
    EXPECT_TRUE(written(2) && absent(3));
    EXPECT_EQ(radiusOf({"--set", "surface.radius=0.3", "--set", "surface.predicates=exact"}), 0.3);
    EXPECT_EQ(manifest(1)["predicates"], "exact");
    EXPECT_EQ(radiusOf({"--radius", "0.2", "--set", "surface.radius=0.3"}), 0.2);
}

TEST_F(Job, PathsOfAPipelineMayBeginInTheHomeFolder) {
    writeFrames(1, 2);
    write(folder_ / "base.yaml", "version: 1\npreview: {width: 64, height: 36, samples: 1}\n");
    fs::create_directory(folder_ / "elsewhere");
    write(folder_ / "elsewhere/job.yaml",
          "version: 1\ninclude: ~/base.yaml\ninput: {path: ~/in/a.####.ply}\noutput: {path: ~/out/a.####.ply}\n"
          "preview: {path: ~/look/a.####.png}\n");
    const std::vector<std::string> home{"HOME=" + folder_.path().string()};
    const Outcome outcome = runProgram({"run", "job.yaml"}, folder_ / "elsewhere", home);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_TRUE(written(1) && written(2) && exists("look/a.0002.png"));
    EXPECT_FALSE(exists("elsewhere/~"));
    const Outcome planned = runProgram({"submit", "job.yaml", "--to", "tractor"}, folder_ / "elsewhere", home);
    EXPECT_NE(planned.out.find("{-o} {" + (folder_ / "out/job.html")), std::string::npos) << planned.out;
    write(folder_ / "job.yaml", "version: 1\ninput: {path: ~other/a.ply}\noutput: {path: a.ply}\n");
    EXPECT_EQ(runProgram({"run", "job.yaml"}, folder_.path()).exit_code, 2);
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

TEST_F(Job, APipelineFileMayBeJson) {
    write(folder_ / "job.yaml",
          R"({"version": 1, "input": {"path": "in/a.####.ply"}, "output": {"path": "out/a.####.ply"}})");
    EXPECT_EQ(runProgram({"config", "check", "job.yaml"}, folder_.path()).err, "");
    write(folder_ / "job.yaml", R"({"version": 1, "input": {"path": "in/a.####.ply")");
    const Outcome outcome = runProgram({"config", "check", "job.yaml"}, folder_.path());
    EXPECT_NE(outcome.err.find("this is not valid YAML"), std::string::npos) << outcome.err;
}

TEST_F(Job, APathThatIsACommentIsExplained) {
    write(folder_ / "job.yaml", "version: 1\ninput:\n  path: ####.ply\noutput: {path: out/a.####.ply}\n");
    const Outcome outcome = runProgram({"config", "check", "job.yaml"}, folder_.path());
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_NE(outcome.err.find("job.yaml:3:3: input.path: the value is nothing."), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("A path that begins with # needs quotes"), std::string::npos) << outcome.err;
}

TEST_F(Job, ConfigCheckRefusesWhatRunRefusesWithoutReadingTheInput) {
    const std::string paths = "input: {path: in/a.####.ply}\noutput: {path: out/a.####.ply}\n";
    const std::string input = "input: {path: in/a.####.ply}\n";
    const auto check = [&](const std::string& text, const std::string& command) {
        write(folder_ / "job.yaml", "version: 1\n" + text);
        std::vector<std::string> words{"config", "check", "job.yaml"};
        if (command == "run") words = {"run", "job.yaml"};
        return runProgram(words, folder_.path());
    };
    const std::vector<std::string> refused{
        paths + "surface: {radius: 1.5dx, skin: 2dx}\n",
        paths + "surface: {radius: 1, skin: 2}\n",
        paths + "surface: {kind: alpha, walls: \"x>0\"}\n",
        paths + "surface: {kind: alpha, box: \"0,0,0,1,1,1\"}\n",
        paths + "surface: {radius_attribute: pscale, predicates: float}\n",
        paths + "surface: {tessellation: paper, skin: 0.5dx}\n",
        paths + "surface: {dimension: 2, walls: \"x>0\"}\n",
        paths + "surface: {dimension: 2}\npreview: {path: look/a.####.png}\n",
        paths + "preview: {path: look.png}\nframes: 1-2\n",
        input + "outputs: []\n",
        input + "output: {path: in/a.####.ply}\n",
        input + "output: {path: out/a.####.unknown}\n",
        input + "output: {path: out/a.ply}\nframes: 1-2\n",
        input + "outputs: [{path: out/a.####.ply}, {path: ./out/a.####.ply}]\n",
    };
    writeFrames(1, 2);
    for (const std::string& text : refused) {
        const Outcome checked = check(text, "check"), run = check(text, "run");
        EXPECT_EQ(checked.exit_code, 2) << text;
        EXPECT_EQ(run.exit_code, 2) << text;
        const auto message = [](const Outcome& outcome) { return outcome.err.substr(outcome.err.find("error:")); };
        EXPECT_EQ(message(checked), message(run)) << text;
    }
    // What is missing may come from options.
    fs::remove_all(folder_ / "in");
    for (const std::string& text :
         {paths, input, std::string("surface: {radius: 0.5}\n"),
          input + "outputs: [{path: out/a.####.ply}, {path: out/b.####.ply, smoothing: {passes: 2}}]\n"})
        EXPECT_EQ(check(text, "check").exit_code, 0) << text;
}

}  // namespace
}  // namespace betamesh
