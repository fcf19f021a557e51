#include "batch/config/config.h"
#include "batch/config/presets.h"
#include "batch/config/surface_params.h"

#include "betamesh/error.h"
#include "support/file_checks.h"
#include "support/temporary_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
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

    /// The error of readConfig() for a pipeline file with these lines after the version.
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

TEST_F(ConfigFile, DefaultYamlIsTheOutputOfConfigPrint) {
    const std::string path = BETAMESH_SOURCE "/configs/default.yaml";
    EXPECT_EQ(valuesOf(readConfig(path)), valuesOf(Config{}));
    const std::string text = contentsOf(path);
    EXPECT_NE(text.find(printConfig(Config{})), std::string::npos)
        << "configs/default.yaml must be its heading and the output of `betamesh config print`:\n"
        << printConfig(Config{});
}

TEST_F(ConfigFile, APrintedConfigurationIsReadBack) {
    Config config;
    for (const char* assignment : {"input.path=sim/a.####.vdb",
                                   "input.velocity=vel: \"x\" #",
                                   "input.id=",
                                   "frames=-5--1,3",
                                   "surface.radius=0.125",
                                   "surface.spacing=0.1",
                                   "surface.kind=union",
                                   "surface.predicates=float",
                                   "surface.skin=0.5dx",
                                   "surface.walls=x>0,0.6x-0.8z<2e-3",
                                   "surface.box=-1,0,2,4,5,6.5",
                                   "surface.resolve_intersections=true",
                                   "perturbation.retries=7",
                                   "perturbation.tolerance=0.001",
                                   "smoothing.method=none",
                                   "smoothing.passes=0",
                                   "features.bubbles=mesh",
                                   "features.bubble_gap=3dx",
                                   "output.path=%04d.ply",
                                   "output.normals=true",
                                   "output.surface_attributes=shape,thickness",
                                   "output.up_axis=z",
                                   "output.fps=23.976",
                                   "output.meters_per_unit=0.01",
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

TEST_F(ConfigFile, DeprecatedKeysArePrintedOnlyIfTheyAreSet) {
    for (const ConfigKey& key : configKeys()) {
        if (key.replaced_by.empty()) continue;
        SCOPED_TRACE(key.path);
        EXPECT_TRUE(std::any_of(configKeys().begin(), configKeys().end(),
                                [&](const ConfigKey& other) { return other.path == key.replaced_by; }));
        Config config;
        const std::string line = '\n' + ("  " + key.path.substr(key.path.find('.') + 1)) + ": ";
        EXPECT_EQ(printConfig(config).find(line), std::string::npos);
        key.set(config, "0.25");
        EXPECT_NE(printConfig(config).find(line), std::string::npos);
        EXPECT_EQ(valuesOf(readConfig(file("printed.yaml", printConfig(config)))), valuesOf(config));
    }
}

TEST_F(ConfigFile, TheSkinIsAutoNoneOrALength) {
    const auto skinOf = [&](const std::string& text) {
        return readConfig(file("job.yaml", "version: 1\nsurface: {skin: " + text + "}\n")).surface.skin;
    };
    EXPECT_EQ(Config{}.surface.skin, std::nullopt);
    EXPECT_EQ(skinOf("auto"), std::nullopt);
    EXPECT_EQ(skinOf("none"), (Length{0, false}));
    EXPECT_EQ(skinOf("0"), (Length{0, false}));
    EXPECT_EQ(skinOf("0dx"), (Length{0, false}));
    EXPECT_EQ(skinOf("0.5dx"), (Length{0.5, true}));
    EXPECT_EQ(skinOf("0.02"), (Length{0.02, false}));
    for (const char* wrong : {"-1", "-0.5dx", "dx", "nan", "inf", "0.5 dx", "automatic", "true", "\"\"", "[0.5dx]"})
        expectError(std::string("surface: {skin: ") + wrong + "}\n", {"job.yaml:2:17", "surface.skin", "auto, none"});
}

TEST_F(ConfigFile, WallsAreTheSideOfAPlaneOnWhichTheLiquidLies) {
    const auto expectWall = [](const char* text, const Vec3& normal, double offset) {
        SCOPED_TRACE(text);
        const auto wall = wallOf(text);
        ASSERT_TRUE(wall);
        EXPECT_NEAR((wall->normal - normal).length(), 0, 1e-12);
        EXPECT_NEAR(wall->offset, offset, 1e-12);
    };
    expectWall("x<2", {1, 0, 0}, 2);
    expectWall("y>-0.5", {0, -1, 0}, 0.5);
    expectWall("3x+4y<10", {0.6, 0.8, 0}, 2);
    expectWall("-0.6*x + 8e-1z > 1", {0.6, 0, -0.8}, -1);
    for (const char* wrong : {"", "x", "x<", "<1", "x=1", "x<y", "w<1", "x+<1", "xy<1", "x--y<1", "0x<1", "x-x<1",
                              "nanx<1", "infx<1", "x<nan", "x<inf", "x<1<2", "1<x", "x<0.1dx"})
        EXPECT_FALSE(wallOf(wrong)) << wrong;
    expectError("surface: {walls: [x>0, x]}\n", {"job.yaml:2:18", "surface.walls", "'x'", "0.6x+0.8y<2"});
    EXPECT_EQ(readConfig(file("job.yaml", "version: 1\nsurface: {walls: [x>0, y>0]}\n")).surface.walls,
              (std::vector<std::string>{"x>0", "y>0"}));
}

TEST_F(ConfigFile, WallsAreInWorldUnitsWhateverTheLocalOrigin) {
    Config config;
    config.surface.walls = {"x<2", "y>-5"};
    config.input.origin = {100, 10, 0};
    config.input.scale = 0.01;
    const SkinParams params = withLengths(skinParams(config), config, {0.15, 0.1, "", {}, {}});
    ASSERT_EQ(params.walls.size(), 2U);
    EXPECT_NEAR(params.walls[0].offset, 1, 1e-12);
    EXPECT_NEAR(params.walls[1].offset, 5.1, 1e-12);
    config.surface.kind = SurfaceKind::alpha;
    EXPECT_THROW(withLengths(skinParams(config), config, {0.15, 0.1, "", {}, {}}), Error);
}

TEST_F(ConfigFile, TheBoxOfTheSurfaceIsSixNumbersInWorldUnits) {
    Config config;
    setConfigKey(config, "surface.box=-1,0,2,4,5,6.5");
    config.input.origin = {100, 0, 0};
    config.input.scale = 0.01;
    const SkinParams params = withLengths(skinParams(config), config, {0.15, 0.1, "", {}, {}});
    ASSERT_TRUE(params.box);
    EXPECT_EQ(*params.box, Box(Vec3(-2, 0, 2), Vec3(3, 5, 6.5)));
    for (const char* wrong : {"1,2,3,4,5", "0,0,0,1,0,1", "x", "\"\""})
        expectError(std::string("surface: {box: ") + wrong + "}\n", {"surface.box", "six numbers"});
    setConfigKey(config, "surface.box=none");
    EXPECT_FALSE(config.surface.box);
}

TEST_F(ConfigFile, NormalsAreFittedWhereTheFormatStoresThem) {
    const auto areFitted = [](const std::vector<std::string>& settings) {
        Config config;
        std::vector<std::string> warnings;
        for (const std::string& setting : settings) setConfigKey(config, setting);
        reconcileSurface(config, warnings);
        return skinParams(config).surface_attributes.normals;
    };
    for (const char* path : {"a.ply", "a.bgeo.sc", "a.usda", "a.obj", ""})
        EXPECT_TRUE(areFitted({"output.path=" + std::string(path)})) << path;
    for (const char* path : {"a.stl", "a.vdb"}) EXPECT_FALSE(areFitted({"output.path=" + std::string(path)})) << path;
    for (const char* setting : {"surface.kind=alpha", "surface.tessellation=paper", "smoothing.method=paper",
                                "surface.dimension=2", "output.normals=false", "output.attributes=Cd,N"})
        EXPECT_FALSE(areFitted({"output.path=a.ply", setting})) << setting;
    EXPECT_TRUE(areFitted({"output.path=a.stl", "output.normals=true"}));
}

TEST_F(ConfigFile, SurfaceAttributesAreKnownAndDifferFromThoseOfParticles) {
    Config config;
    setConfigKey(config, "output.surface_attributes=curvature,shape");
    setConfigKey(config, "output.normals=true");
    EXPECT_EQ(skinParams(config).surface_attributes, (SurfaceAttributes{true, false, true, true}));
    expectError("output: {surface_attributes: thikness}\n",
                {"job.yaml:2:30", "'thikness'", "Did you mean 'thickness'"});
    std::vector<std::string> warnings;
    setConfigKey(config, "output.attributes=Cd,drop");
    EXPECT_THROW(checkSkin(config, warnings), Error);
}

TEST_F(ConfigFile, TheLaterOfTheTwoBubbleKeysWins) {
    EXPECT_EQ(readConfig(file("job.yaml", "version: 1\n")).features.bubble_volume, 0);
    const Config by_volume = readConfig(file("job.yaml", "version: 1\nfeatures: {bubble_volume: 30}\n"));
    EXPECT_EQ(by_volume.features.bubble_volume, 30);
    Config config = by_volume;
    setConfigKey(config, "features.bubble_gap=3dx");
    EXPECT_EQ(config.features.bubble_gap, (Length{3, true}));
    EXPECT_EQ(config.features.bubble_volume, 0);
}

TEST_F(ConfigFile, EveryKeyReadsItsDefaultBackAndHasHelp) {
    std::set<std::string> paths;
    for (const ConfigKey& key : configKeys()) {
        SCOPED_TRACE(key.path);
        Config config;
        EXPECT_NO_THROW(key.set(config, key.get(config)));
        EXPECT_EQ(valuesOf(config), valuesOf(Config{}));
        EXPECT_FALSE(key.help.empty());
        EXPECT_FALSE(key.accepts.empty());
        EXPECT_TRUE(paths.insert(key.path).second);
    }
}

TEST_F(ConfigFile, ErrorsNameFileLineColumnAndTheNearestKey) {
    expectError("surface: {radus: 1.5dx}\n", {"job.yaml:2:11", "surface.radus", "'surface.radius'"});
    expectError("surfce:\n  radius: 1\n", {"job.yaml:2:1", "surfce", "'surface'"});
    expectError("\nradius: 1\n", {"job.yaml:3:1", "'surface.radius'"});
    expectError("run:\n  frame_in_flight: 2\n", {"job.yaml:3:3", "'run.frames_in_flight'"});
    expectError("frame: 1\n", {"job.yaml:2:1", "'frames'"});
    for (const std::string section : {"input", "output", "preview"})
        expectError(section + ": a/p.####.ply\n",
                    {"job.yaml:2:", section + ": 'a/p.####.ply' is no map. Use a map of keys, as in " + section +
                                        ": {path: a/p.####.ply}."});
    expectError("surface: 1.5dx\n", {"job.yaml:2:10", "as in surface: {radius: 1.5dx}."});
    expectError("input:\n", {"job.yaml:2:1", "the value is nothing", "as in input: {path: "});
}

TEST_F(ConfigFile, RefusesWrongTypesAndInvalidValues) {
    expectError("surface:\n  radius: -1\n", {"job.yaml:3:11", "'-1'", "above 0"});
    for (const char* radius :
         {"0", "dx", "1.5d", "1.5 dx", "nan", "inf", "1e999", "infdx", "0x10", "[1]", "~", "{a: 1}"}) {
        expectError(std::string("surface:\n  radius: ") + radius + "\n",
                    {"job.yaml:3:", "surface.radius", "Use a number above 0"});
    }
    expectError("smoothing: {passes: 1.5}\n", {"job.yaml:2:21", "a whole number from 0 to 100"});
    expectError("smoothing: {passes: \"1\"}\n", {"text in quotes", "a whole number"});
    expectError("smoothing: {passes: 101}\n", {"0 to 100"});
    expectError("smoothing: {passes: 99999999999999}\n", {"0 to 100"});
    expectError("smoothing: {method: laplace}\n", {"'laplace'", "one of coherent, paper, none"});
    expectError("smoothing: {width: 3}\nsurface: {radius: auto}\n", {"'auto'", "a number above 0"});
    expectError("surface: {resolve_intersections: yes}\n", {"true or false"});
    expectError("surface: {kind: [beta]}\n", {"a list", "one of beta, alpha, union"});
    expectError("perturbation: {tolerance: 0.2}\n", {"at most 0.1"});
    expectError("run: {memory_limit: 16}\n", {"with its unit"});
    expectError("run: {on_missing: ignore}\n", {"one of error, skip, empty"});
    expectError("frames: 1-10:2\n", {"job.yaml:2:9", "OpenJD"});
    expectError("surface: 1\n", {"job.yaml:2:10", "Use a map"});
    expectError("surface:\n", {"job.yaml:2:1", "nothing", "Use a map"});
    expectError("input: {path: a.####.fbx}\n", {"job.yaml:2:15", "input.path", "xyz"});
    expectError("output: {path: a.####.prt}\n", {"job.yaml:2:16", "output.path"});
    expectError("output: {voxel: 0}\n", {"output.voxel", "Use a number above 0"});
    expectError("output: {band: 0.5}\n", {"output.band", "a number from 1 to 100"});
    expectError("output: {path: a.##.####.ply}\n", {"job.yaml:2:16", "both stand for the frame number"});
}

TEST_F(ConfigFile, RefusesFilesThatAreNotOnePipelineFile) {
    expectError("frames: 1\nframes: 2\n", {"job.yaml:3:1", "second time"});
    expectError("run: {threads: 1, threads: 2}\n", {"job.yaml:2:19", "second time"});
    expectError("surface: {radius: 1\n", {"job.yaml:", "not valid YAML"});
    expectError("---\nversion: 1\n", {"second YAML document"});
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
    EXPECT_EQ(config.surface.radius, (Length{3, true}));
}

TEST_F(ConfigFile, AFileMayBeIncludedTwiceButNotInACircle) {
    file("a.yaml", "version: 1\nsmoothing: {passes: 2}\n");
    EXPECT_EQ(readConfig(file("job.yaml", "version: 1\ninclude: [a.yaml, a.yaml]\n")).smoothing.passes, 2);
    file("b.yaml", "version: 1\ninclude: ./c.yaml\n");
    file("c.yaml", "version: 1\ninclude: b.yaml\n");
    const std::string error = errorOf([&] { readConfig(folder_ / "b.yaml"); });
    EXPECT_NE(error.find("b.yaml -> c.yaml -> b.yaml"), std::string::npos) << error;
}

TEST_F(ConfigFile, IncludesThatAreTooDeepAreNotCalledACircle) {
    constexpr int kFiles = 40;
    for (int i = 0; i < kFiles; ++i) {
        const std::string next = i + 1 < kFiles ? "include: " + std::to_string(i + 1) + ".yaml\n" : "";
        file(std::to_string(i) + ".yaml", "version: 1\n" + next);
    }
    const std::string error = errorOf([&] { readConfig(folder_ / "0.yaml"); });
    EXPECT_NE(error.find("32.yaml: include: these files include each other in more than 32 levels: 0.yaml -> 1.yaml"),
              std::string::npos)
        << error;
}

TEST_F(ConfigFile, ErrorsInAnIncludeNameTheIncludedFile) {
    file("preset.yaml", "version: 1\nsurface:\n  kind: gamma\n");
    expectError("include: preset.yaml\n", {"preset.yaml:3:9", "'gamma'"});
    expectError("include: nowhere.yaml\n", {"job.yaml:2:10", "nowhere.yaml"});
    expectError("include: {a: b}\n", {"job.yaml:2:10", "Use a path"});
}

TEST_F(ConfigFile, LaterValuesWinInTheOrderPresetsIncludesFileCommandLine) {
    file("base.yaml", "version: 1\nsmoothing: {passes: 3}\n");
    const std::string job = file("job.yaml", "version: 1\npreset: [viscous, flip]\ninclude: base.yaml\n");
    const Config config = readConfig(job);
    EXPECT_EQ(config.preset, (std::vector<std::string>{"viscous", "flip"}));
    EXPECT_EQ(config.surface.radius, (Length{2.2, true}));  // the later preset wins
    EXPECT_EQ(config.smoothing.passes, 3);                  // the included file wins

    const std::string own = file("own.yaml", "version: 1\nsurface: {radius: 3dx}\npreset: viscous\n");
    EXPECT_EQ(readConfig(own).surface.radius, (Length{3, true}));  // wherever `preset` is in the file
    EXPECT_EQ(readConfig(own).smoothing.passes, 2);
    const std::vector<KeyValue> splash{{"preset", "splash", "--preset"}};
    EXPECT_EQ(readConfig(own, splash).surface.radius, (Length{3, true}));
    EXPECT_EQ(readConfig(own, splash).smoothing.passes, 1);  // instead of the file's preset
    EXPECT_EQ(readConfig(own, splash).preset, std::vector<std::string>{"splash"});
    EXPECT_EQ(readConfig(own, {{"preset", "", "--preset"}}).smoothing.passes, 1);
    const std::vector<KeyValue> both{{"surface.radius", "4dx", "--radius"}, {"preset", "splash", "--preset"}};
    EXPECT_EQ(readConfig(own, both).surface.radius, (Length{4, true}));
    EXPECT_EQ(readConfig("", both).surface.radius, (Length{4, true}));
    EXPECT_EQ(readConfig("", splash).surface.radius, (Length{1.2, true}));
    Config base;
    base.surface.radius = {5, true}, base.smoothing.passes = 7;
    EXPECT_EQ(readConfig("", splash, base).surface.radius, (Length{1.2, true}));
    EXPECT_EQ(readConfig("", splash, base).smoothing.passes, 7);

    file("included.yaml", "version: 1\npreset: flip\n");
    EXPECT_EQ(readConfig(file("job.yaml", "version: 1\ninclude: included.yaml\n")).surface.radius, (Length{2.2, true}));
    EXPECT_EQ(readConfig(file("job.yaml", "version: 1\ninclude: included.yaml\npreset: splash\n")).surface.radius,
              (Length{1.2, true}));
}

TEST_F(ConfigFile, AConfigurationWithPresetsIsReadBack) {
    const Config config = readConfig("", {{"preset", "viscous,preview", ""}, {"surface.radius", "1dx", ""}});
    EXPECT_EQ(valuesOf(readConfig(file("printed.yaml", printConfig(config)))), valuesOf(config));
}

TEST_F(ConfigFile, AnUnknownPresetIsAnErrorThatListsAllPresets) {
    for (const Preset& preset : presets())
        expectError("preset: slash\n", {"job.yaml:2:9", "'slash'", "'splash'", std::string(preset.name)});
    expectError("preset: {flip: 1}\n", {"job.yaml:2:9", "a map"});
    expectError("preset: flip,flip\n", {"job.yaml:2:9", "each at most once"});
    expectError("presets: flip\n", {"job.yaml:2:1", "'preset'"});
}

TEST_F(ConfigFile, PresetsAreTheFilesInConfigs) {
    std::set<std::string> on_disk, known;
    for (const auto& entry : std::filesystem::directory_iterator(BETAMESH_SOURCE "/configs"))
        on_disk.insert(entry.path().stem().string());
    on_disk.erase("default");
    for (const Preset& preset : presets()) {
        SCOPED_TRACE(preset.name);
        known.insert(std::string(preset.name));
        const std::string path = BETAMESH_SOURCE "/configs/" + std::string(preset.name) + ".yaml";
        EXPECT_EQ(preset.text, contentsOf(path));
        Config applied;
        applyPreset(applied, preset.name);
        EXPECT_EQ(valuesOf(applied), valuesOf(readConfig(path)));
        EXPECT_EQ(preset.text.find("\npreset"), std::string::npos);
        EXPECT_EQ(preset.text.find("\ninclude"), std::string::npos);
        EXPECT_TRUE(preset.text.starts_with("# "));
        EXPECT_TRUE(descriptionOf(preset).ends_with(".")) << descriptionOf(preset);
        EXPECT_EQ(descriptionOf(preset).find('#'), std::string::npos);
    }
    EXPECT_EQ(known, on_disk);
    EXPECT_TRUE(std::is_sorted(presets().begin(), presets().end(),
                               [](const Preset& a, const Preset& b) { return a.name < b.name; }));
}

TEST_F(ConfigFile, EveryPresetAndPipelineOfTheProjectIsValid) {
    for (const char* folder : {"/configs", "/pipelines"}) {
        for (const auto& entry : std::filesystem::recursive_directory_iterator(std::string(BETAMESH_SOURCE) + folder)) {
            if (entry.path().extension() != ".yaml") continue;
            SCOPED_TRACE(entry.path().string());
            EXPECT_NO_THROW(readConfig(entry.path()));
        }
    }
}

TEST(SetConfigKey, ErrorsQuoteTheCommandLine) {
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
