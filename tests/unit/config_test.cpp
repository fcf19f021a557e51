#include "batch/config.h"

#include "core/error.h"
#include "support/temporary_folder.h"

#include <gtest/gtest.h>

#include <set>

namespace betamesh {
namespace {

std::vector<std::string> valuesOf(const Config& config) {
    std::vector<std::string> values;
    for (const ConfigKey& key : configKeys()) values.push_back(key.path + "=" + key.get(config));
    return values;
}

class ConfigFile : public ::testing::Test {
protected:
    std::string file(const std::string& name, const std::string& text) {
        write(folder_ / name, text);
        return folder_ / name;
    }

    /// What readConfig() says of a pipeline file with these lines after the version.
    std::string messageOf(const std::string& lines) {
        try {
            readConfig(file("job.yaml", "version: 1\n" + lines));
        } catch (const Error& error) {
            return error.what();
        }
        return "no error";
    }

    void expectError(const std::string& lines, const std::vector<std::string>& parts) {
        SCOPED_TRACE(lines);
        const std::string message = messageOf(lines);
        for (const std::string& part : parts) EXPECT_NE(message.find(part), std::string::npos) << message;
    }

    TemporaryFolder folder_;
};

TEST_F(ConfigFile, DefaultYamlIsWhatConfigPrintWrites) {
    const std::string path = BETAMESH_SOURCE "/configs/default.yaml";
    EXPECT_EQ(valuesOf(readConfig(path)), valuesOf(Config{}));
    const std::string text = contentsOf(path);
    EXPECT_NE(text.find(printConfig(Config{})), std::string::npos)
        << "configs/default.yaml is its heading, then the output of `betamesh config print`:\n"
        << printConfig(Config{});
}

TEST_F(ConfigFile, WhatIsPrintedIsReadBack) {
    Config config;
    for (const char* assignment : {"input.path=sim/a.####.vdb",
                                   "input.velocity=vel: \"x\" #",
                                   "input.id=",
                                   "frames=-5--1,3",
                                   "surface.radius=0.125",
                                   "surface.spacing=0.1",
                                   "surface.kind=union",
                                   "surface.predicates=float",
                                   "surface.resolve_intersections=true",
                                   "perturbation.retries=7",
                                   "perturbation.tolerance=0.001",
                                   "smoothing.method=none",
                                   "smoothing.passes=0",
                                   "output.path=%04d.ply",
                                   "run.frames_in_flight=3",
                                   "run.threads=2",
                                   "run.retries=0",
                                   "preview.camera_position=1,-2,3.5",
                                   "preview.colour=Cd",
                                   "preview.colour_range=-1,0.5",
                                   "preview.azimuth=-45",
                                   "preview.cut=y>-0.5",
                                   "preview.show=union",
                                   "run.on_missing=empty",
                                   "run.memory_limit=1.5GiB"}) {
        setConfigKey(config, assignment);
    }
    const Config again = readConfig(file("printed.yaml", printConfig(config)));
    EXPECT_EQ(valuesOf(again), valuesOf(config));
    EXPECT_EQ(again.run.memory_limit, 1536ULL << 20);
}

TEST_F(ConfigFile, EveryKeyReadsItsOwnDefaultBackAndExplainsItself) {
    std::set<std::string> paths;
    for (const ConfigKey& key : configKeys()) {
        SCOPED_TRACE(key.path);
        Config config;
        EXPECT_NO_THROW(key.set(config, key.get(config)));
        EXPECT_EQ(valuesOf(config), valuesOf(Config{}));
        EXPECT_FALSE(key.reason.empty());
        EXPECT_FALSE(key.expects.empty());
        EXPECT_TRUE(paths.insert(key.path).second);
    }
}

TEST_F(ConfigFile, ErrorsNameFileLineColumnAndTheNearestKey) {
    expectError("surface: {radus: 1.5dx}\n", {"job.yaml:2:11", "surface.radus", "'surface.radius'"});
    expectError("surfce:\n  radius: 1\n", {"job.yaml:2:1", "surfce", "'surface'"});
    expectError("\nradius: 1\n", {"job.yaml:3:1", "'surface.radius'"});
    expectError("run:\n  frame_in_flight: 2\n", {"job.yaml:3:3", "'run.frames_in_flight'"});
    expectError("frame: 1\n", {"job.yaml:2:1", "'frames'"});
}

TEST_F(ConfigFile, RefusesWrongTypesAndImpossibleValues) {
    expectError("surface:\n  radius: -1\n", {"job.yaml:3:11", "'-1'", "above 0"});
    for (const char* radius :
         {"0", "dx", "1.5d", "1.5 dx", "nan", "inf", "1e999", "infdx", "0x10", "[1]", "~", "{a: 1}"}) {
        expectError(std::string("surface:\n  radius: ") + radius + "\n", {"job.yaml:3:", "surface.radius", "expected"});
    }
    expectError("smoothing: {passes: 1.5}\n", {"job.yaml:2:21", "a whole number, 0 to 100"});
    expectError("smoothing: {passes: \"1\"}\n", {"text in quotes", "a whole number"});
    expectError("smoothing: {passes: 101}\n", {"0 to 100"});
    expectError("smoothing: {passes: 99999999999999}\n", {"0 to 100"});
    expectError("smoothing: {method: laplace}\n", {"'laplace'", "one of coherent paper none"});
    expectError("smoothing: {width: 3}\nsurface: {radius: auto}\n", {"'auto'", "a number above 0"});
    expectError("surface: {resolve_intersections: yes}\n", {"true or false"});
    expectError("surface: {kind: [beta]}\n", {"a list", "one of beta alpha union"});
    expectError("perturbation: {tolerance: 0.2}\n", {"at most 0.1"});
    expectError("run: {memory_limit: 16}\n", {"with its unit"});
    expectError("run: {on_missing: ignore}\n", {"one of error skip empty"});
    expectError("frames: 1-10:2\n", {"job.yaml:2:9", "OpenJD"});
    expectError("surface: 1\n", {"job.yaml:2:10", "expected a map"});
    expectError("surface:\n", {"job.yaml:2:1", "nothing", "expected a map"});
    expectError("input: {path: a.####.xyz}\n", {"job.yaml:2:15", "input.path", "xyz"});
    expectError("output: {path: a.####.vdb}\n", {"job.yaml:2:16", "output.path"});
    expectError("output: {path: a.##.##.ply}\n", {"job.yaml:2:16", "2 places"});
}

TEST_F(ConfigFile, RefusesWhatIsNotOnePipelineFile) {
    expectError("frames: 1\nframes: 2\n", {"job.yaml:3:1", "second time"});
    expectError("run: {threads: 1, threads: 2}\n", {"job.yaml:2:19", "second time"});
    expectError("surface: {radius: 1\n", {"job.yaml:", "not YAML"});
    expectError("---\nversion: 1\n", {"second document"});
    EXPECT_THROW(readConfig(folder_ / "absent.yaml"), Error);
    EXPECT_THROW(readConfig(folder_.path()), Error);
    EXPECT_THROW(readConfig(file("empty.yaml", "")), Error);
    EXPECT_THROW(readConfig(file("list.yaml", "- 1\n")), Error);
    EXPECT_THROW(readConfig(file("none.yaml", "frames: 1\n")), Error);
    EXPECT_THROW(readConfig(file("two.yaml", "version: 2\n")), Error);
}

TEST_F(ConfigFile, LaterKeysWinOverIncludes) {
    file("base/a.yaml", "version: 1\nsmoothing: {passes: 2}\nsurface: {radius: 2dx, kind: alpha}\n");
    file("base/b.yaml", "version: 1\ninclude: a.yaml\nsurface: {kind: union}\n");
    file("c.yaml", "version: 1\nsmoothing: {passes: 5}\n");
    const Config config =
        readConfig(file("job.yaml", "version: 1\nsurface: {radius: 3dx}\ninclude: [base/b.yaml, c.yaml]\n"));
    EXPECT_EQ(config.smoothing.passes, 5);
    EXPECT_EQ(config.surface.kind, SurfaceKind::union_);
    EXPECT_EQ(config.surface.radius, (LengthText{3, true}));
}

TEST_F(ConfigFile, AFileMayBeIncludedTwiceButNotByItself) {
    file("a.yaml", "version: 1\nsmoothing: {passes: 2}\n");
    EXPECT_EQ(readConfig(file("job.yaml", "version: 1\ninclude: [a.yaml, a.yaml]\n")).smoothing.passes, 2);
    file("b.yaml", "version: 1\ninclude: ./c.yaml\n");
    file("c.yaml", "version: 1\ninclude: b.yaml\n");
    try {
        readConfig(folder_ / "b.yaml");
        FAIL();
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("b.yaml -> c.yaml -> b.yaml"), std::string::npos) << error.what();
    }
}

TEST_F(ConfigFile, ErrorsInAnIncludeNameTheIncludedFile) {
    file("preset.yaml", "version: 1\nsurface:\n  kind: gamma\n");
    expectError("include: preset.yaml\n", {"preset.yaml:3:9", "'gamma'"});
    expectError("include: nowhere.yaml\n", {"job.yaml:2:10", "nowhere.yaml"});
    expectError("include: {a: b}\n", {"job.yaml:2:10", "expected a path"});
}

TEST_F(ConfigFile, EveryPresetAndPipelineOfTheProjectIsRight) {
    for (const char* folder : {"/configs", "/pipelines"}) {
        for (const auto& entry : std::filesystem::recursive_directory_iterator(std::string(BETAMESH_SOURCE) + folder)) {
            if (entry.path().extension() != ".yaml") continue;
            SCOPED_TRACE(entry.path().string());
            EXPECT_NO_THROW(readConfig(entry.path()));
        }
    }
}

TEST(SetConfigKey, NamesWhatWasWrittenOnTheCommandLine) {
    Config config;
    for (const char* wrong :
         {"surface.radus=1", "surface.radius", "=1", "surface.radius=big", "surface=1", "version=1"}) {
        try {
            setConfigKey(config, wrong);
            FAIL() << wrong;
        } catch (const Error& error) {
            EXPECT_NE(std::string(error.what()).find("--set " + std::string(wrong)), std::string::npos) << error.what();
        }
    }
    setConfigKey(config, "input.velocity=a=b");
    EXPECT_EQ(config.input.velocity, "a=b");
}

}  // namespace
}  // namespace betamesh
