// Sequences of .usda files and the layers that play them.

#include "batch/job/usd_sequence.h"

#include "io/mesh_file.h"
#include "io/up_axis.h"
#include "io/usd_clips.h"
#include "support/file_checks.h"
#include "support/job_folder.h"

namespace betamesh {
namespace {

const std::vector<std::string> kRadius{"--radius", "0.2", "--spacing", "0.1", "-q"};

class UsdJob : public JobFolder {
protected:
    Outcome meshUsd(std::vector<std::string> further, const std::string& output = "out/a.####.usda") {
        further.insert(further.end(), kRadius.begin(), kRadius.end());
        return mesh(further, output);
    }
    std::string layer() { return contentsOf(folder_ / "out/a.usda"); }
};

TEST(UsdSequence, TheLayerIsNamedLikeTheFilesWithoutFrame) {
    for (const auto& [files, layer] :
         {std::pair("shot.####.usda", "shot.usda"), std::pair("a/shot_%04d.usda", "a/shot.usda"),
          std::pair("shot-$F4.v2.usda", "shot.v2.usda"), std::pair("a/####.usda", "a/sequence.usda"),
          std::pair("a/####/shot.usda", "a/shot.usda"), std::pair("/x/s####/b/shot.####.USDA", "/x/shot.USDA"),
          std::pair("shot.usda", ""), std::pair("shot.####.ply", "")})
        EXPECT_EQ(sequenceLayer(framePattern(files)), layer) << files;
}

TEST_F(UsdJob, UnitsThatTheOutputContradictsAreTold) {
    writeParticles(folder_ / "cm.usda", Sample({"jitter", 100, 1, 24}).frame(1),
                   {.frames_per_second = 30, .meters_per_unit = 0.01});
    const auto warnings = [&](std::vector<std::string> further, const std::string& output) {
        std::vector<std::string> words{"mesh", "cm.usda", output, "--overwrite"};
        words.insert(words.end(), further.begin(), further.end());
        const Outcome outcome = runProgram(words, folder_.path());
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return outcome.err;
    };
    const auto tells = [](const std::string& text, const char* words) { return text.find(words) != std::string::npos; };
    const char *metres = "0.01 metres per unit of length, but the output will say 1",
               *rate = "30 frames per second, but the output will say 24";
    const std::string plain = warnings({}, "out.usda");
    EXPECT_TRUE(tells(plain, metres)) << plain;
    EXPECT_TRUE(tells(plain, rate)) << plain;
    for (const std::vector<std::string>& same :
         {std::vector<std::string>{"--meters-per-unit", "0.01", "--output-fps", "30"},
          {"--scale", "0.01", "--output-fps", "30"}}) {
        const std::string text = warnings(same, "out.usda");
        EXPECT_FALSE(tells(text, "but the output will say")) << text;
    }
    EXPECT_FALSE(tells(warnings({}, "out.ply"), "but the output will say"));  // which has no units
}

/// A .usda with the particles of the sample `jitter` at these times, and the same as files with one frame each.
void writeSamples(const fs::path& folder, const std::string& name, const std::vector<int>& frames) {
    Sample sample({"jitter", 150, 1, 24});
    std::string samples, whole;
    for (const int frame : frames) {
        const std::string file = (folder / numbered("one", frame, ".usda")).string();
        writeParticles(file, sample.frame(frame), {.frame = frame});
        whole = contentsOf(file);
        const std::string begin = "point3f[] points.timeSamples = {\n";
        const std::size_t at = whole.find(begin) + begin.size();
        samples += whole.substr(at, whole.find("]", at) + 1 - at) + ",\n";
    }
    write(folder / name, "#usda 1.0\ndef Points \"p\" {\npoint3f[] points.timeSamples = {\n" + samples + "}\n}\n");
}

TEST_F(UsdJob, EveryFrameOfAFileWithTimeSamplesIsMeshed) {
    writeSamples(folder_.path(), "anim_v003.usda", {2, 3, 5});
    const auto run = [&](const std::string& output, std::vector<std::string> further) {
        std::vector<std::string> words{"mesh", "anim_v003.usda", output, "--overwrite"};
        words.insert(words.end(), further.begin(), further.end());
        return runProgram(words, folder_.path());
    };
    const auto sameAs = [&](const std::string& file, int frame) {
        const Mesh mesh = readMesh(folder_ / file);
        const std::string one = numbered("one", frame, ".usda");
        EXPECT_EQ(runProgram({"mesh", one, "m.ply", "--overwrite", "-q", "--radius", "0.2", "--spacing", "0.1"},
                             folder_.path())
                      .exit_code,
                  0);
        EXPECT_EQ(mesh.position, readMesh(folder_ / "m.ply").position) << file;
        EXPECT_EQ(mesh.triangles, readMesh(folder_ / "m.ply").triangles) << file;
    };
    const Outcome all = run("a.%04d.ply", {"--radius", "0.2", "--spacing", "0.1"});
    ASSERT_EQ(all.exit_code, 0) << all.err;
    for (const int frame : {2, 3, 5}) sameAs(numbered("a", frame, ".ply"), frame);
    EXPECT_FALSE(exists("a.0000.ply") || exists("a.0004.ply"));
    EXPECT_NE(all.err.find("gaps (2-3,5)"), std::string::npos) << all.err;
    EXPECT_EQ(all.err.find("time samples"), std::string::npos) << all.err;

    ASSERT_EQ(run("b.%04d.ply", {"--frames", "3-5x2", "--radius", "0.2", "--spacing", "0.1"}).exit_code, 0);
    EXPECT_FALSE(exists("b.0002.ply"));
    sameAs("b.0005.ply", 5);
    const Outcome missing = run("c.%04d.ply", {"--frames", "3-4"});
    EXPECT_EQ(missing.exit_code, 1);
    EXPECT_NE(missing.err.find("anim_v003.usda: has no time sample at frame 4"), std::string::npos) << missing.err;
    EXPECT_TRUE(exists("c.0003.ply") && !exists("c.0004.ply"));

    // One output: the first frame, or the one that is asked for, also if the output is there for another frame.
    const Outcome one = run("d.ply", {"--radius", "0.2", "--spacing", "0.1"});
    EXPECT_NE(one.err.find("'anim_v003.usda': only frame 2 of 2-3,5 is read"), std::string::npos) << one.err;
    sameAs("d.ply", 2);
    ASSERT_EQ(runProgram({"mesh", "anim_v003.usda", "d.ply", "--skip-existing", "--frames", "5", "--radius", "0.2",
                          "--spacing", "0.1"},
                         folder_.path())
                  .exit_code,
              0);
    sameAs("d.ply", 5);
    EXPECT_EQ(run("e.ply", {"--frames", "2-3"}).exit_code, 2);

    ASSERT_EQ(runProgram({"convert", "anim_v003.usda", "f.####.csv"}, folder_.path()).exit_code, 0);
    for (const int frame : {2, 3, 5})
        EXPECT_EQ(readParticles(folder_ / numbered("f", frame, ".csv")).position,
                  readParticles(folder_ / numbered("one", frame, ".usda")).position);
    EXPECT_NE(runProgram({"convert", "anim_v003.usda", "g.####.csv", "--frames", "4"}, folder_.path()).exit_code, 0);
}

/// A tetrahedron that moves by 1 per frame and is inside out in frame 2, and particles in its corner.
void writeMeshSamples(const fs::path& folder) {
    const auto sampled = [&](const std::string& name, const std::string& prim, const std::string& of_2,
                             const std::string& of_others) {
        std::string samples;
        for (const int frame : {1, 2, 4}) {
            std::string points = frame == 2 ? of_2 : of_others;
            for (std::size_t at = 0; (at = points.find('x', at)) != std::string::npos;)
                points.replace(at, 1, std::to_string(frame));
            samples += std::to_string(frame) + ": [" + points + "],\n";
        }
        write(folder / name, "#usda 1.0\ndef " + prim + "\npoint3f[] points.timeSamples = {\n" + samples + "}\n}\n");
    };
    sampled("m.usda",
            "Mesh \"m\" {\nint[] faceVertexCounts = [3, 3, 3, 3]\n"
            "int[] faceVertexIndices = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]",
            "(x, 0, 0), (x, 1, 0), (x.5, 0, 0), (x, 0, 1)", "(x, 0, 0), (x.5, 0, 0), (x, 1, 0), (x, 0, 1)");
    sampled("p.usda", "Points \"p\" {", "(x.1, 0.1, 0.1), (x.2, 0.1, 0.1)", "(x.1, 0.1, 0.1), (x.2, 0.1, 0.1)");
}

class UsdTimeSamples : public UsdJob {
protected:
    void SetUp() override { writeMeshSamples(folder_.path()); }
    Outcome run(const std::vector<std::string>& words, int exit_code = 0) {
        Outcome outcome = runProgram(words, folder_.path());
        EXPECT_EQ(outcome.exit_code, exit_code) << words[0] << ": " << outcome.err;
        return outcome;
    }
    static bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }
};

TEST_F(UsdTimeSamples, InfoTellsHowManyThereAre) {
    const std::string one = run({"info", "m.usda"}).out;
    EXPECT_TRUE(has(one, "samples     3 at frames 1-2,4, of which frame 1 is shown")) << one;
    EXPECT_TRUE(has(one, "bounds      1 0 0  to  1.5 1 1")) << one;
    const Json json = Json::parse(run({"info", "p.usda", "--frames", "4", "--json"}).out);
    EXPECT_EQ(json.at("frame"), 4);
    EXPECT_EQ(json.at("times"), Json({1, 2, 4}));
    EXPECT_FLOAT_EQ(json.at("lower")[0].get<float>(), 4.1F);
    EXPECT_FALSE(Json::parse(run({"info", "m.usda", "--json"}).out).at("not_read").size() > 0);
    const std::string missing = run({"info", "m.usda", "--frames", "2-3"}, 2).err;
    EXPECT_TRUE(has(missing, "there is no frame 3 (--frames): the files have 1-2,4")) << missing;
}

TEST_F(UsdTimeSamples, CheckReadsAllOfThem) {
    const std::string all = run({"check", "m.usda", "--particles", "p.usda"}, 1).out;
    for (const char* line : {"m.usda, frame 1: good", "m.usda, frame 2: ", "m.usda, frame 4: good"})
        EXPECT_TRUE(has(all, line)) << all;
    EXPECT_TRUE(has(all, "inside out")) << all;
    const Json last = Json::parse(run({"check", "m.usda", "--json", "--frames", "4", "--particles", "p.usda"}).out);
    EXPECT_EQ(last.at("frame"), 4);
    EXPECT_EQ(last.at("particles").at("outside"), 0);
    // Meshes in files with particles in samples: those of the same frame.
    run({"convert", "m.usda", "m.####.ply"});
    EXPECT_EQ(run({"check", "m.####.ply", "--frames", "1,4", "--particles", "p.usda"}).err, "");
    write(folder_ / "m.0003.ply", contentsOf(folder_ / "m.0001.ply"));
    const std::string missing = run({"check", "m.0003.ply", "--particles", "p.usda"}, 1).err;
    EXPECT_TRUE(has(missing, "p.usda: has no time sample at frame 3. There are 1-2,4")) << missing;
    // The frame in the name is the one that is meant.
    write(folder_ / "m.0004.usda", contentsOf(folder_ / "m.usda"));
    const Outcome named = run({"check", "m.0004.usda"});
    EXPECT_TRUE(has(named.out, "m.0004.usda, frame 4: good")) << named.out;
    EXPECT_TRUE(has(named.err, "only frame 4 of 1-2,4 is read. Choose others with --frames\n")) << named.err;
    // Errors name the frame.
    std::string damaged = contentsOf(folder_ / "m.usda");
    damaged.replace(damaged.find("(4, 0, 0), "), 11, "");
    write(folder_ / "d.usda", damaged);
    const std::string error = run({"check", "d.usda", "--frames", "1,4"}, 1).err;
    EXPECT_TRUE(has(error, "frame 4: d.usda: ")) << error;
}

TEST_F(UsdTimeSamples, CoherenceMeasuresFromOneToTheNext) {
    std::istringstream lines(run({"coherence", "m.usda", "--particles", "p.usda", "--json"}).out);
    std::vector<Json> pairs;
    for (std::string line; std::getline(lines, line);) pairs.push_back(Json::parse(line));
    ASSERT_EQ(pairs.size(), 2U);
    EXPECT_EQ(pairs[1].at("to"), "m.usda");
    EXPECT_EQ(pairs[1].at("from_frame"), 2);
    EXPECT_EQ(pairs[1].at("to_frame"), 4);
    EXPECT_NEAR(pairs[1].at("particles").at("max").get<double>(), 2, 1e-5);
    EXPECT_TRUE(has(run({"coherence", "m.usda", "--frames", "1-2"}).out, "m.usda, frame 2")) << "table";
    run({"coherence", "m.usda", "--frames", "1"}, 2);
}

TEST_F(UsdTimeSamples, PicturesShowTheirFrames) {
    const std::vector<std::string> small{"--width", "40", "--height", "30", "--samples", "1"};
    const auto picture = [&](std::vector<std::string> words, int exit_code = 0) {
        words.insert(words.end(), small.begin(), small.end());
        return run(words, exit_code).err;
    };
    picture({"render", "m.usda", "r.####.png"});
    EXPECT_TRUE(exists("r.0001.png") && exists("r.0002.png") && exists("r.0004.png") && !exists("r.0003.png"));
    EXPECT_NE(contentsOf(folder_ / "r.0001.png"), contentsOf(folder_ / "r.0004.png"));
    picture({"render", "p.usda", "p.####.png", "--frames", "1,4", "--spacing", "0.1"});
    EXPECT_NE(contentsOf(folder_ / "p.0001.png"), contentsOf(folder_ / "p.0004.png"));
    const std::string one = picture({"render", "m.usda", "one.png"});
    EXPECT_TRUE(has(one, "'m.usda': only frame 1 of 1-2,4 is read")) << one;
    const std::string missing = picture({"render", "m.usda", "s.####.png", "--frames", "3-4"}, 1);
    EXPECT_TRUE(has(missing, "frame 3: m.usda: has no time sample at frame 3. There are 1-2,4")) << missing;
    EXPECT_TRUE(exists("s.0004.png") && !exists("s.0003.png"));
    picture({"compare", "p.usda", "c.####.png", "--frames", "4", "--spacing", "0.1"});
    EXPECT_TRUE(exists("c.0004.png"));
    picture({"compare", "p.usda", "c.####.png", "--frames", "3", "--spacing", "0.1"}, 1);
}

TEST_F(UsdJob, TheSpacingIsMeasuredInTheFramesOfTheFile) {
    writeSamples(folder_.path(), "anim.usda", {1, 2, 3});
    const auto spacingOf = [&](const std::string& input, const std::string& output) {
        const Outcome outcome = runProgram({"mesh", input, output}, folder_.path());
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return Json::parse(contentsOf(folder_ / (numbered(output.substr(0, 1), 2, ".ply.json")))).at("spacing");
    };
    EXPECT_EQ(spacingOf("anim.usda", "a.####.ply"), spacingOf("one.####.usda", "b.####.ply"));
}

TEST_F(UsdJob, ALayerPlaysTheFramesOfAllChunks) {
    writeFrames(1, 5, 100);
    ASSERT_EQ(meshUsd({"--output-fps", "25"}).exit_code, 0);
    const std::string whole = layer();
    EXPECT_NE(whole.find("active = [(1, 0), (2, 1), (3, 2), (4, 3), (5, 4)]"), std::string::npos) << whole;
    EXPECT_NE(whole.find("framesPerSecond = 25"), std::string::npos);
    fs::remove_all(folder_ / "out");
    for (const char* chunk : {"2/3", "3/3", "1/3"}) {
        ASSERT_EQ(meshUsd({"--output-fps", "25", "--chunk", chunk}).exit_code, 0);
        EXPECT_TRUE(isUsdClipsLayer(folder_ / "out/a.usda"));
    }
    EXPECT_EQ(layer(), whole);
    // Resuming finds every frame up to date, and restores the layer.
    fs::remove(folder_ / "out/a.usda");
    ASSERT_EQ(meshUsd({"--output-fps", "25", "--skip-existing"}).exit_code, 0);
    EXPECT_EQ(layer(), whole);
    EXPECT_EQ(hiddenFiles("out"), 0U);
}

TEST_F(UsdJob, FramesThatAreMissingAreNotInTheLayer) {
    writeFrames(1, 3, 100);
    fs::remove(folder_ / "in/a.0002.ply");
    writeFrameWithNaN(3);
    writeFrame(4, {});
    EXPECT_EQ(meshUsd({"--frames", "1-4", "--on-missing", "skip"}).exit_code, 1);
    EXPECT_NE(layer().find("active = [(1, 0), (4, 1)]"), std::string::npos) << layer();
    EXPECT_NE(layer().find("times = [(1, 1), (4, 1), (4, 4)]"), std::string::npos);
}

TEST_F(UsdJob, OneFileHasNoLayer) {
    writeFrames(7, 7, 100);
    ASSERT_EQ(runProgram({"mesh", "in/a.0007.ply", "a.0007.usda", "--radius", "0.2", "-q"}, folder_.path()).exit_code,
              0);
    EXPECT_FALSE(exists("a.usda"));
    EXPECT_NE(contentsOf(folder_ / "a.0007.usda").find("            7: ["), std::string::npos);
}

TEST_F(UsdJob, TheLayerOfAnotherSequenceIsNotReplaced) {
    writeFrames(1, 3);
    ASSERT_EQ(mesh({"--frames", "1-2"}, "out/a.####.usda").exit_code, 0);
    const std::string layer = contentsOf(folder_ / "out/a.usda");
    const Outcome other = mesh({"--frames", "3"}, "out/a_####.usda");
    EXPECT_EQ(other.exit_code, 2);
    EXPECT_NE(other.err.find("out/a.usda already exists"), std::string::npos) << other.err;
    EXPECT_EQ(contentsOf(folder_ / "out/a.usda"), layer);
    // Its own frames may be deleted and made again.
    fs::remove(folder_ / "out/a.0001.usda");
    EXPECT_EQ(mesh({"--frames", "1-3", "--overwrite"}, "out/a.####.usda").exit_code, 0);
}

TEST_F(UsdJob, ALayerThatSomebodyHasEditedStays) {
    writeFrames(1, 3);
    ASSERT_EQ(meshUsd({"--frames", "1-2"}).exit_code, 0);
    const std::string edited = layer() + "# kept\n";
    write(folder_ / "out/a.usda", edited);
    const Outcome outcome = mesh({"--frames", "3", "--radius", "0.2", "--spacing", "0.1"}, "out/a.####.usda");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("out/a.usda: was edited after this program wrote it, and stays as it is. Delete it"),
              std::string::npos)
        << outcome.err;
    EXPECT_EQ(layer(), edited);
    fs::remove(folder_ / "out/a.usda");
    ASSERT_EQ(meshUsd({"--skip-existing"}).exit_code, 0);
    EXPECT_NE(layer().find("active = [(1, 0), (2, 1), (3, 2)]"), std::string::npos);
}

TEST_F(UsdJob, CheckAndCoherenceLeaveOutTheLayerAmongItsFrames) {
    writeFrames(1, 2, 100);
    ASSERT_EQ(meshUsd({}).exit_code, 0);
    const std::vector<std::string> files{"out/a.0001.usda", "out/a.0002.usda", "out/a.usda"};
    for (const char* command : {"check", "coherence", "info"}) {
        std::vector<std::string> words{command};
        words.insert(words.end(), files.begin(), files.end());
        const Outcome outcome = runProgram(words, folder_.path());
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        EXPECT_NE(outcome.err.find("out/a.usda: left out. It is the layer that plays a sequence"), std::string::npos)
            << outcome.err;
    }
    EXPECT_EQ(runProgram({"check", "out/a.usda"}, folder_.path()).exit_code, 1);
}

TEST_F(UsdJob, AFileOfTheUserIsNotReplacedByTheLayer) {
    writeFrames(1, 2, 100);
    fs::create_directories(folder_ / "out");
    write(folder_ / "out/a.usda", "#usda 1.0\n");
    const Outcome outcome = meshUsd({"--overwrite"});
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_NE(outcome.err.find("a.usda already exists"), std::string::npos) << outcome.err;
    EXPECT_FALSE(exists("out/a.0001.usda"));
    EXPECT_EQ(layer(), "#usda 1.0\n");
    EXPECT_EQ(runProgram({"convert", "in/a.####.ply", "out/a.####.usda"}, folder_.path()).exit_code, 2);
    EXPECT_EQ(runProgram({"sample", "drop", "out/a.####.usda", "--frames", "1-2"}, folder_.path()).exit_code, 2);
    EXPECT_FALSE(exists("out/a.0001.usda"));
}

TEST_F(UsdJob, ParticlesHaveALayerToo) {
    ASSERT_EQ(
        runProgram({"sample", "drop", "p.####.usda", "--frames", "-1-1", "--particles", "50", "-q"}, folder_.path())
            .exit_code,
        0);
    const std::string sampled = contentsOf(folder_ / "p.usda");
    EXPECT_NE(sampled.find("active = [(-1, 0), (0, 1), (1, 2)]"), std::string::npos) << sampled;
    EXPECT_NE(sampled.find("def Points \"points\""), std::string::npos);
    ASSERT_EQ(runProgram({"convert", "p.####.usda", "c/p.####.usda", "-q"}, folder_.path()).exit_code, 0);
    EXPECT_EQ(contentsOf(folder_ / "c/p.usda"), sampled);
    EXPECT_EQ(contentsOf(folder_ / "c/p.-001.usda"), contentsOf(folder_ / "p.-001.usda"));
    // As an input, the folder has one sequence: the layer is none.
    const Outcome meshed = runProgram({"mesh", "c", "m.####.ply", "--radius", "0.2", "-q"}, folder_.path());
    EXPECT_EQ(meshed.exit_code, 0) << meshed.err;
    EXPECT_TRUE(exists("m.-001.ply"));
}

TEST_F(UsdJob, SpheresAreWrittenBesideTheMesh) {
    Particles particles;
    for (int i = 0; i < 3; ++i) particles.position.emplace_back(static_cast<float>(3 * i), 0.0F, 0.0F);
    particles.velocity.assign(3, Vec3f(0, -1, 0));
    writeFrame(1, particles);
    ASSERT_EQ(meshUsd({"--droplets", "points"}).exit_code, 0);
    const Particles spheres = readParticles(folder_ / "out/a.0001.spheres.usda");
    EXPECT_EQ(spheres.size(), 3U);
    ASSERT_EQ(spheres.attributes.size(), 1U);
    EXPECT_EQ(spheres.attributes[0].name, "pscale");
    EXPECT_EQ(spheres.velocity, particles.velocity);
}

TEST_F(UsdJob, ParticlesWithZUpGiveAWarningUnlessTheyAreTurned) {
    const Particles particles = sampleParticles(20, true, true, false);
    for (const auto& [axis, name] : {std::pair(UpAxis::y, "y.usda"), {UpAxis::z, "z.usda"}})
        writeParticles(folder_ / name, axis == UpAxis::z ? withYUp(particles) : particles, {.up_axis = axis});
    const auto warnsOf = [&](const std::string& input, std::vector<std::string> options, const std::string& output) {
        options.insert(options.begin(), {"mesh", input, output, "--radius", "0.2", "--overwrite"});
        const Outcome outcome = runProgram(options, folder_.path());
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        EXPECT_EQ(outcome.err.find("group"), std::string::npos) << outcome.err;
        return outcome.err.find("z is up in this file, but the output will say y") != std::string::npos;
    };
    const auto upAxis = [&](const std::string& file) {
        const std::string text = contentsOf(folder_ / file);
        return text.substr(text.find("upAxis = ") + 10, 1);
    };
    EXPECT_FALSE(warnsOf("y.usda", {}, "plain.usda"));
    EXPECT_TRUE(warnsOf("z.usda", {}, "left.usda"));
    EXPECT_FALSE(warnsOf("z.usda", {"--up-axis", "z"}, "turned.usda"));
    EXPECT_FALSE(warnsOf("z.usda", {"--up-axis", "z", "--output-up-axis", "z"}, "kept.usda"));
    EXPECT_FALSE(warnsOf("z.usda", {}, "left.ply"));  // says no axis
    EXPECT_EQ(upAxis("left.usda") + upAxis("turned.usda") + upAxis("kept.usda"), "YYZ");
    EXPECT_EQ(readMesh(folder_ / "left.usda").position, readMesh(folder_ / "plain.usda").position);
}

TEST_F(UsdJob, AttributesThatAreRenamedAreNamedOnce) {
    Particles particles = sampleParticles(20, true, true, false);
    particles.attributes.push_back({"heat.max", 1, std::vector<float>(20, 1.0F), {}});
    writeFrame(1, particles);
    writeFrame(2, particles);
    const Outcome outcome =
        mesh({"--attributes", "heat.max", "--radius", "0.2", "--spacing", "0.1"}, "out/a.####.usda");
    EXPECT_EQ(outcome.exit_code, 0);
    EXPECT_EQ(count(outcome.err, "'heat.max' is written as 'heat_max'"), 1U) << outcome.err;
    EXPECT_EQ(count(runProgram({"convert", "in/a.####.ply", "c/a.####.usda"}, folder_.path()).err,
                    "'heat.max' is written as 'heat_max'"),
              1U);
}

}  // namespace
}  // namespace betamesh
