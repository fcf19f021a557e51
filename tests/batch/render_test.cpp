// `betamesh render`, `compare` and previews of pipelines, as a user runs them.

#include "render/exr_file.h"
#include "render/png_file.h"
#include "support/program.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace betamesh {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kSmall{"--width", "160", "--height", "90", "--samples", "2"};

std::vector<std::string> small(std::vector<std::string> words) {
    words.insert(words.end(), kSmall.begin(), kSmall.end());
    return words;
}

class Previews : public ::testing::Test {
protected:
    void SetUp() override {
        ASSERT_EQ(runProgram({"sample", "drop", "sim.####.vdb", "--particles", "400", "--frames", "1-3"}, folder.path())
                      .exit_code,
                  0);
        ASSERT_EQ(runProgram({"mesh", "sim.####.vdb", "mesh.####.ply"}, folder.path()).exit_code, 0);
    }
    Outcome run(const std::vector<std::string>& words) const { return runProgram(words, folder.path()); }
    std::string bytes(const std::string& name) const { return contentsOf(folder / name); }
    Image image(const std::string& name) const { return decodePng(bytes(name), name); }
    Picture exr(const std::string& name) const { return decodeExr(bytes(name), name); }

    TemporaryFolder folder;
};

double coverage(const Picture& picture) {
    double sum = 0;
    for (const float a : picture.alpha) sum += static_cast<double>(a);
    return sum / static_cast<double>(picture.size());
}

std::string outputOf(const std::string& command) {
    std::string text;
    FILE* pipe = ::popen(command.c_str(), "r");
    for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) text += static_cast<char>(c);
    return ::pclose(pipe) == 0 ? text : "failed: " + text;
}

TEST_F(Previews, OfASequenceShareACameraThatFramesAllFrames) {
    const Outcome outcome = run(small({"render", "mesh.####.ply", "look/a.####.exr", "look/a.####.png"}));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    for (int frame = 1; frame <= 3; ++frame) {
        const Picture picture = exr("look/a.000" + std::to_string(frame) + ".exr");
        const double covered = coverage(picture);
        EXPECT_GT(covered, 0.1) << frame;
        EXPECT_LT(covered, 0.6) << frame;
        const auto width = static_cast<std::size_t>(picture.width);
        for (std::size_t i = 0; i < picture.size(); ++i)
            if (i < width || i + width >= picture.size() || i % width == 0 || (i + 1) % width == 0) {
                EXPECT_EQ(picture.alpha[i], 0) << "the surface reaches the edge of the picture";
            }
    }
    // Frame 2 alone, with the camera of the whole sequence.
    const std::size_t begin = outcome.err.find("--camera-position");
    ASSERT_NE(begin, std::string::npos) << outcome.err;
    std::istringstream words(outcome.err.substr(begin, outcome.err.find('\n', begin) - begin));
    std::vector<std::string> again = small({"render", "mesh.0002.ply", "b.exr"});
    for (std::string word; words >> word;) again.push_back(word);
    ASSERT_EQ(run(again).exit_code, 0);
    EXPECT_NEAR(coverage(exr("b.exr")), coverage(exr("look/a.0002.exr")), 0.001);
    ASSERT_EQ(run(small({"render", "mesh.####.ply", "look/c.####.png", "--frames", "2", "-j", "1"})).exit_code, 0);
    EXPECT_EQ(bytes("look/c.0002.png"), bytes("look/a.0002.png"));
}

TEST_F(Previews, AreReadByOiiotool) {
    if (std::system("command -v oiiotool >/dev/null") != 0) GTEST_SKIP() << "oiiotool is not installed here";
    ASSERT_EQ(run(small({"render", "mesh.0001.ply", "a.exr", "a.png"})).exit_code, 0);
    const std::string exr_info = outputOf("oiiotool --info -v " + folder / "a.exr");
    for (const char* words : {"160 x   90, 15 channel", "A (half)", "Z (float)", "N.X (half)", "P.Z (float)",
                              "forward.u (float)", "id (uint)"})
        EXPECT_NE(exr_info.find(words), std::string::npos) << words << " in " << exr_info;
    const std::string png_info = outputOf("oiiotool --info -v " + folder / "a.png");
    EXPECT_NE(png_info.find("160 x   90, 3 channel, uint8 png"), std::string::npos) << png_info;
}

TEST_F(Previews, ParticlesAreBallsAndTheirUnionIsLarger) {
    ASSERT_EQ(run(small({"render", "sim.0002.vdb", "p.exr", "--show", "particles"})).exit_code, 0);
    ASSERT_EQ(run(small({"render", "sim.0002.vdb", "u.exr", "--show", "union"})).exit_code, 0);
    const Picture picture = exr("p.exr");
    EXPECT_TRUE(std::all_of(picture.id.begin(), picture.id.end(),
                            [](std::uint32_t id) { return id == Picture::kNothing || id == Picture::kSphere; }));
    EXPECT_GT(coverage(picture), 0.02);
    EXPECT_GT(coverage(exr("u.exr")), coverage(picture));
}

TEST_F(Previews, DifferForEverySetting) {
    std::vector<std::string> seen;
    const std::vector<std::vector<std::string>> looks{{},
                                                      {"--shading", "zebra"},
                                                      {"--normals", "flat"},
                                                      {"--wireframe", "1"},
                                                      {"--colour", "velocity"},
                                                      {"--colour", "kind", "--ground", "none"},
                                                      {"--colour", "component", "--ground", "none"},
                                                      {"--colour", "curvature"},
                                                      {"--shutter", "1", "--fps", "10"},
                                                      {"--azimuth", "-90"},
                                                      {"--up", "z"}};
    for (const auto& look : looks) {
        std::vector<std::string> words = small({"render", "mesh.0002.ply", "a.png", "--overwrite"});
        words.insert(words.end(), look.begin(), look.end());
        ASSERT_EQ(run(words).exit_code, 0) << ::testing::PrintToString(look);
        const std::string picture = bytes("a.png");
        EXPECT_EQ(std::count(seen.begin(), seen.end(), picture), 0) << ::testing::PrintToString(look);
        seen.push_back(picture);
    }
}

TEST_F(Previews, AreRenderedBesideTheMeshesOfAPipeline) {
    std::ofstream(folder / "job.yaml")
        << "version: 1\n"
           "input: {path: sim.####.vdb}\n"
           "output: {path: out/a.####.ply}\n"
           "preview: {path: look/a.####.exr, width: 160, height: 90, samples: 2, camera_position: auto}\n";
    ASSERT_EQ(run({"run", "job.yaml", "--frames", "2"}).exit_code, 0);
    EXPECT_FALSE(fs::exists(folder / "look/a.0001.exr"));
    const std::string alone = bytes("look/a.0002.exr");
    EXPECT_EQ(run({"run", "job.yaml", "--frames", "2"}).exit_code, 2);
    fs::remove(folder / "out/a.0002.ply");
    EXPECT_EQ(run({"run", "job.yaml", "--frames", "2"}).exit_code, 2) << "the picture already exists";
    fs::remove(folder / "look/a.0002.exr");
    ASSERT_EQ(run({"run", "job.yaml", "--frames", "1-2"}).exit_code, 0);
    fs::remove(folder / "look/a.0002.exr");
    ASSERT_EQ(run({"run", "job.yaml", "--frames", "1-2", "--skip-existing"}).exit_code, 0);
    EXPECT_EQ(bytes("look/a.0002.exr"), alone) << "a frame without its picture is not finished";
    ASSERT_EQ(run({"run", "job.yaml", "--frames", "2", "--skip-existing", "--set", "preview.up=z"}).exit_code, 0);
    EXPECT_NE(bytes("look/a.0002.exr"), alone) << "nor is one whose picture has other settings";
    ASSERT_EQ(run({"run", "job.yaml", "--overwrite", "--frames-in-flight", "2"}).exit_code, 0);
    EXPECT_TRUE(fs::exists(folder / "look/a.0003.exr"));
    EXPECT_EQ(bytes("look/a.0002.exr"), alone);
    EXPECT_GT(coverage(exr("look/a.0002.exr")), 0.1);
    EXPECT_EQ(run({"run", "job.yaml", "--overwrite", "--set", "preview.show=union"}).exit_code, 0);
    EXPECT_NE(bytes("look/a.0002.exr"), alone);
}

TEST_F(Previews, CompareShowsFourSurfacesOfAFrame) {
    ASSERT_EQ(run(small({"compare", "sim.0002.vdb", "a.png"})).exit_code, 0);
    const Image sheet = image("a.png");
    EXPECT_GT(sheet.width, 2 * 160);
    EXPECT_LT(sheet.width, 2 * 160 + 40);
    EXPECT_GT(sheet.height, 2 * 90);
    // The first panel shows the same balls as `render --show union`, with the same camera.
    const auto panel = [&](int left, int top) {
        Image part(160, 90, {});
        paste(sheet, -left, -top, part);
        return part.pixel;
    };
    const int gap = (sheet.width - 2 * 160) / 3, cell = (sheet.height - gap) / 2;
    std::vector<std::vector<Colour>> panels;
    for (const int top : {gap, gap + cell})
        for (const int left : {gap, 2 * gap + 160}) {
            panels.push_back(panel(left, top));
            for (std::size_t i = 0; i + 1 < panels.size(); ++i) EXPECT_NE(panels[i], panels.back());
        }
    ASSERT_EQ(run(small({"render", "sim.0002.vdb", "u.png", "--show", "union"})).exit_code, 0);
    EXPECT_EQ(image("u.png").pixel, panels[0]);
    std::ofstream(folder / "look.yaml") << "version: 1\npreview: {width: 160, height: 90, samples: 2}\n";
    ASSERT_EQ(run({"compare", "sim.0002.vdb", "row.png", "--pipeline", "look.yaml", "--columns", "4"}).exit_code, 0);
    EXPECT_EQ(image("row.png").width, 4 * 160 + 5 * gap);
    EXPECT_EQ(run({"compare", "sim.0002.vdb", "a.exr"}).exit_code, 2);
    EXPECT_EQ(run({"compare", "sim.0002.vdb", "a.png"}).exit_code, 2);
}

TEST_F(Previews, CompareLeavesOutThePaperIfParticlesHaveSizes) {
    std::ofstream(folder / "sizes.csv") << "x,y,z,pscale\n0,0,0,0.1\n0.1,0,0,0.1\n0,0.1,0,0.1\n0.2,0.2,0.2,0.2\n";
    const std::vector<std::string> words =
        small({"compare", "sizes.csv", "a.png", "--radius-attribute", "pscale", "--spacing", "0.1"});
    const Outcome outcome = run(words);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("'beta mesh (paper)' is left out"), std::string::npos) << outcome.err;
    EXPECT_GT(image("a.png").width, 2 * 160);
}

TEST_F(Previews, ParticlesHaveTheSizeThatIsAskedForInAllFormats) {
    std::ofstream(folder / "a.csv") << "x,y,z,pscale\n0,0,0,0.1\n1,0,0,0.2\n0,1,0,0.1\n1,1,0,0.4\n";
    const auto shown = [&](const std::string& file, std::vector<std::string> further) {
        std::vector<std::string> words = small({"render", file, "a.exr", "--overwrite", "--spacing", "0.2",
                                                "--camera-position", "0.5,0.5,4", "--look-at", "0.5,0.5,0"});
        words.insert(words.end(), further.begin(), further.end());
        const Outcome outcome = run(words);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return coverage(exr("a.exr"));
    };
    std::vector<double> expected;
    for (const char* file : {"a.csv", "a.vdb", "a.bgeo", "a.ply", "a.vtp", "a.usda", "a.abc"}) {
        SCOPED_TRACE(file);
        if (std::string(file) != "a.csv") {
            ASSERT_EQ(run({"convert", "a.csv", file}).exit_code, 0);
        }
        const std::vector<double> areas{shown(file, {}), shown(file, {"--show", "union"}),
                                        shown(file, {"--radius-attribute", "pscale"}),
                                        shown(file, {"--show", "union", "--radius-attribute", "pscale"}),
                                        shown(file, {"--radius-attribute", "pscale", "--radius-scale", "0.5"})};
        if (expected.empty()) expected = areas;
        for (std::size_t i = 0; i < areas.size(); ++i) EXPECT_NEAR(areas[i], expected[i], 1e-6) << i;
    }
    // Four discs of radius 1, or of 0.5, 1, 0.5 and 2.
    EXPECT_NEAR(expected[2] / expected[0], (0.25 + 1 + 0.25 + 4) / 4, 0.1);
    EXPECT_NEAR(expected[3] / expected[1], (0.25 + 1 + 0.25 + 4) / 4, 0.15);
    EXPECT_NEAR(expected[4] / expected[2], 0.25, 0.05);
    const Outcome absent = run(small({"render", "a.ply", "b.png", "--spacing", "0.2", "--radius-attribute", "size"}));
    EXPECT_EQ(absent.exit_code, 1);
    EXPECT_NE(absent.err.find("a.ply: "), std::string::npos) << absent.err;
    EXPECT_NE(absent.err.find("no attribute 'size'"), std::string::npos) << absent.err;
    const Outcome unused = run(small({"render", "a.ply", "b.png", "--spacing", "0.2"}));
    EXPECT_NE(unused.err.find("'pscale' is not used: all balls have the same radius"), std::string::npos) << unused.err;
    // A file of spheres beside a mesh shows these spheres.
    fs::copy_file(folder / "a.ply", folder / "m.spheres.ply");
    EXPECT_NEAR(shown("m.spheres.ply", {}) / expected[1], (1 + 4 + 1 + 16) / 4.0 / 9, 0.1);
}

TEST_F(Previews, OfParticlesWithSizesShowEachInItsOwn) {
    std::ofstream(folder / "a.csv") << "x,y,z,pscale\n0,0,0,0.1\n1,0,0,0.2\n0,1,0,0.1\n1,1,0,0.4\n";
    for (const char* show : {"particles", "union"}) {
        SCOPED_TRACE(show);
        std::ofstream(folder / "job.yaml")
            << "version: 1\ninput: {path: a.csv}\noutput: {path: m.ply}\n"
               "surface: {radius_attribute: pscale, spacing: 0.2}\n"
            << "preview: {path: job.exr, show: " << show << ", width: 160, height: 90, samples: 2}\n";
        const Outcome outcome = run({"run", "job.yaml", "--overwrite"});
        ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
        const Picture job = exr("job.exr");
        EXPECT_GT(coverage(job), 0.01);
        double most = 0;  // z of the front of the largest ball
        for (std::size_t i = 0; i < job.size(); ++i)
            if (job.id[i] == Picture::kSphere) most = std::max(most, static_cast<double>(job.position[2][i]));
        const double unit = std::string(show) == "union" ? 1.5 : 0.5;
        EXPECT_NEAR(most, 0.4 * unit, 0.08 * unit);
        ASSERT_EQ(run(small({"render", "a.csv", "same.exr", "--show", show, "--radius-attribute", "pscale", "--spacing",
                             "0.2", "--overwrite"}))
                      .exit_code,
                  0);
        if (std::string(show) == "union") {
            EXPECT_NEAR(coverage(job), coverage(exr("same.exr")), 1e-6);
        }
    }
    const std::vector<std::string> words = small({"compare", "a.csv", "b.png", "--radius-attribute", "pscale",
                                                  "--spacing", "0.2", "--panel", "u: preview.show=union"});
    ASSERT_EQ(run(words).exit_code, 0);
    ASSERT_EQ(
        run(small({"render", "a.csv", "u.png", "--show", "union", "--radius-attribute", "pscale", "--spacing", "0.2"}))
            .exit_code,
        0);
    const Image sheet = image("b.png");
    Image panel(160, 90, {});
    const int gap = (sheet.width - 160) / 2;
    paste(sheet, -gap, -gap, panel);
    EXPECT_EQ(panel.pixel, image("u.png").pixel);
}

TEST_F(Previews, PanelsDifferOnlyInTheKeysTheySet) {
    const auto compared = [&](const std::vector<std::string>& panels) {
        std::vector<std::string> words = small({"compare", "sim.0002.vdb", "a.png", "--columns", "2", "--overwrite"});
        for (const std::string& panel : panels) words.insert(words.end(), {"--panel", panel});
        return run(words);
    };
    const auto halves = [&] {
        const Image sheet = image("a.png");
        const int gap = (sheet.width - 2 * 160) / 3;
        Image left(160, 90, {}), right = left;
        paste(sheet, -gap, -gap, left);
        paste(sheet, -2 * gap - 160, -gap, right);
        return std::pair(left.pixel, right.pixel);
    };
    ASSERT_EQ(compared({"one:", "the same: preview.show=surface"}).exit_code, 0);
    EXPECT_EQ(halves().first, halves().second);
    const auto whole = halves().first;
    ASSERT_EQ(compared({"whole:", "cut open: preview.cut=z<0"}).exit_code, 0);
    EXPECT_EQ(halves().first, whole);
    EXPECT_NE(halves().second, whole);
    for (const char* wrong : {"no colon", "unknown: surface.colour=red", "a word: flat", "plane: surface.dimension=2",
                              "cut: preview.cut=w<1"}) {
        const Outcome outcome = compared({"one:", wrong});
        EXPECT_EQ(outcome.exit_code, 2) << wrong;
        EXPECT_EQ(outcome.err.find("--set"), std::string::npos) << outcome.err;
        if (std::string(wrong).find("plane") != 0) {
            EXPECT_NE(outcome.err.find("--panel '"), std::string::npos) << outcome.err;
        }
    }
}

TEST_F(Previews, AContactSheetContainsTheChosenFrames) {
    const std::vector<std::string> words = small({"render", "mesh.####.ply", "a.####.png", "--contact-sheet", "s.png"});
    ASSERT_EQ(run(words).exit_code, 0);
    const Image all = image("s.png");
    EXPECT_EQ(run(words).exit_code, 2);
    std::vector<std::string> again = words;
    again.push_back("--skip-existing");  // made from the existing pictures
    ASSERT_EQ(run(again).exit_code, 0);
    EXPECT_EQ(image("s.png").pixel, all.pixel);
    again.insert(again.end(), {"--sheet-pictures", "2"});
    ASSERT_EQ(run(again).exit_code, 0);
    EXPECT_EQ(image("s.png").width, all.width);
    EXPECT_LT(image("s.png").height, all.height);
}

TEST_F(Previews, AMovieNeedsFfmpeg) {
    const std::vector<std::string> words = small({"render", "mesh.####.ply", "a.####.png", "--movie", "movies/m.mp4"});
    const Outcome without = runProgram(words, folder.path(), {"PATH=/nowhere"});
    EXPECT_EQ(without.exit_code, 2);
    EXPECT_NE(without.err.find("ffmpeg"), std::string::npos) << without.err;
    EXPECT_FALSE(fs::exists(folder / "a.0001.png"));
    if (std::system("command -v ffmpeg >/dev/null") != 0) GTEST_SKIP() << "ffmpeg is not installed here";
    const Outcome with = run(words);
    ASSERT_EQ(with.exit_code, 0) << with.err;
    EXPECT_EQ(bytes("movies/m.mp4").substr(4, 4), "ftyp");
    if (std::system("command -v ffprobe >/dev/null") != 0) return;
    EXPECT_EQ(outputOf("ffprobe -v error -count_frames -show_entries stream=width,height,nb_read_frames -of csv=p=0 " +
                       (folder / "movies/m.mp4")),
              "160,90,3\n");
}

TEST_F(Previews, OptionsWithoutEffectAreWarnedOf) {
    struct Given {
        std::vector<std::string> words;
        bool of_mesh, of_particles;  ///< whether there is a warning
    };
    for (const Given& given :
         {Given{{"--wireframe", "2"}, false, true}, Given{{"--normals", "flat"}, false, true},
          Given{{"--colour", "curvature"}, false, true}, Given{{"--colour", "velocity"}, false, false},
          Given{{"--show", "union"}, true, false}, Given{{"--particle-radius", "0.1"}, true, false},
          Given{{"--where", "id > 3"}, true, false}, Given{{"--spacing", "0.1"}, true, false},
          Given{{"--set", "smoothing.passes=3"}, true, true}, Given{{"--colour-range", "0,1"}, true, true},
          Given{{"--sheet-columns", "3"}, true, true}, Given{{"--azimuth", "10"}, false, false}})
        for (const bool is_mesh : {false, true}) {
            std::vector<std::string> words =
                small({"render", is_mesh ? "mesh.0002.ply" : "sim.0002.vdb", "a.png", "--overwrite"});
            words.insert(words.end(), given.words.begin(), given.words.end());
            const Outcome outcome = run(words);
            EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
            EXPECT_EQ(outcome.err.find(" no effect") != std::string::npos, is_mesh ? given.of_mesh : given.of_particles)
                << given.words[0] << is_mesh << outcome.err;
        }
    std::ofstream(folder / "t.csv") << "x,y,z,T\n0,0,0,1\n1,0,0,2\n0,1,0,3\n0,0,1,4\n";
    const auto coloured = [&](const std::string& colour) {
        return run(small({"render", "t.csv", "t.png", "--spacing", "1", "--colour", colour, "--overwrite"}));
    };
    ASSERT_EQ(coloured("plain").exit_code, 0);
    const std::string plain = bytes("t.png");
    ASSERT_EQ(coloured("T").exit_code, 0);
    EXPECT_NE(bytes("t.png"), plain);
    const Outcome absent = coloured("U");
    EXPECT_EQ(absent.exit_code, 1);
    EXPECT_NE(absent.err.find("the particles have T."), std::string::npos) << absent.err;
}

TEST_F(Previews, OfParticlesThatAreNotFiniteAreRefusedWithAdvice) {
    std::ofstream(folder / "nan.ply") << "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\n"
                                         "property float y\nproperty float z\nend_header\n0 0 0\nnan 0 0\n";
    const Outcome outcome = run(small({"render", "nan.ply", "nan.png", "--spacing", "1e-10"}));
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_NE(outcome.err.find("nan.ply: particle 1: position is (nan, "), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("Use --on-bad-particle drop"), std::string::npos) << outcome.err;
    const Outcome dropped =
        run(small({"render", "nan.ply", "nan.png", "--spacing", "1e-10", "--on-bad-particle", "drop"}));
    EXPECT_EQ(dropped.exit_code, 0) << dropped.err;
    EXPECT_NE(dropped.err.find("particle spacing 1e-10"), std::string::npos) << dropped.err;
}

TEST_F(Previews, WrongUsageIsRefusedBeforeAnythingIsWritten) {
    for (const std::vector<std::string>& wrong :
         std::vector<std::vector<std::string>>{{"--contact-sheet", "k.jpg"}, {"--movie", "k.avi"}}) {
        const Outcome outcome = run(small({"render", "mesh.####.ply", "c.####.png", wrong[0], wrong[1]}));
        EXPECT_EQ(outcome.exit_code, 2);
        EXPECT_NE(outcome.err.find(wrong[1] + ": "), std::string::npos) << outcome.err;
        EXPECT_FALSE(fs::exists(folder / "c.0001.png"));
    }
    std::ofstream(folder / "file") << "no folder";
    for (const char* sheet : {"file/s.png", "s.png"})
        EXPECT_EQ(run(small({"render", "mesh.####.ply", sheet[0] == 's' ? "file/c.####.png" : "c.####.png",
                             "--contact-sheet", sheet}))
                      .exit_code,
                  2);
    EXPECT_FALSE(fs::exists(folder / "c.0001.png"));

    EXPECT_EQ(run({"render", "mesh.####.ply", "a.####.jpg"}).exit_code, 2);
    EXPECT_EQ(run({"render", "mesh.####.ply", "a.png"}).exit_code, 2);
    EXPECT_EQ(run({"render", "nothing.####.ply", "a.####.png"}).exit_code, 2);
    EXPECT_EQ(run({"render", "mesh.0001.ply", "a.png", "--camera-position", "1,2"}).exit_code, 2);
    const Outcome colour = run({"render", "mesh.0001.ply", "a.png", "--colour", "Cd"});
    EXPECT_EQ(colour.exit_code, 1);
    EXPECT_NE(colour.err.find("frame 1: mesh.0001.ply: the mesh has no attribute 'Cd'"), std::string::npos)
        << colour.err;
    EXPECT_FALSE(fs::exists(folder / "a.png"));
    ASSERT_EQ(run(small({"render", "mesh.0001.ply", "a.png"})).exit_code, 0);
    const std::string before = bytes("a.png");
    EXPECT_EQ(run(small({"render", "mesh.0002.ply", "a.png"})).exit_code, 2);
    EXPECT_EQ(run(small({"render", "mesh.0002.ply", "a.png", "--skip-existing"})).exit_code, 0);
    EXPECT_EQ(bytes("a.png"), before);
    EXPECT_EQ(run(small({"render", "mesh.####.ply", "b.####.png", "--frames", "0,2-4"})).exit_code, 1);
    EXPECT_TRUE(fs::exists(folder / "b.0003.png"));
}

}  // namespace
}  // namespace betamesh
