// `betamesh coherence` as a user runs it.

#include "base/icosphere.h"
#include "io/mesh_file.h"
#include "io/particle_file.h"
#include "support/program.h"
#include "support/sanitized.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

namespace betamesh {
namespace {

using Json = nlohmann::json;

Mesh sphere(const Vec3& centre) {
    const Icosphere ball = icosphere(16);
    Mesh mesh{ball.position, {}, ball.triangles, {}};
    for (Vec3& p : mesh.position) p += centre;
    return mesh;
}

// Five spheres, the third of which jumps aside; particles move up by 0.125 per frame.
void writeSequence(const TemporaryFolder& folder) {
    for (int frame = 1; frame <= 5; ++frame) {
        const std::string number = "000" + std::to_string(frame);
        const double z = 0.125 * frame;
        writeMesh(folder / ("m." + number + ".ply"), sphere(Vec3(frame == 3 ? 0.5 : 0, 0, z)));
        Particles particles;
        particles.position = {Vec3f(0, 0, static_cast<float>(z)), Vec3f(1, 0, 0)};
        writeParticles(folder / ("p." + number + ".bgeo"), particles);
    }
}

TEST(Coherence, MeasuresEachPairOfAPattern) {
    const TemporaryFolder folder;
    writeSequence(folder);
    const Outcome outcome =
        runProgram({"coherence", "--json", "m.####.ply", "--particles", "p.####.bgeo"}, folder.path());
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    const std::vector<Json> pairs = jsonLines(outcome.out);
    ASSERT_EQ(pairs.size(), 4u);
    EXPECT_EQ(pairs[0]["from"], "m.0001.ply");
    EXPECT_EQ(pairs[0]["to"], "m.0002.ply");
    EXPECT_NEAR(pairs[0]["max"].get<double>(), 0.125, 0.002);
    EXPECT_NEAR(pairs[0]["particles"]["max"].get<double>(), 0.125, 1e-6);
    EXPECT_EQ(pairs[0]["particles"]["matched"], 2);
    EXPECT_NEAR(pairs[0]["ratio"].get<double>(), 1, 0.02);
    EXPECT_NEAR(pairs[1]["max"].get<double>(), std::hypot(0.5, 0.125), 0.01);
    EXPECT_GT(pairs[1]["worst"][0].get<double>(), -1.1);
    EXPECT_LT(pairs[0]["rms"].get<double>(), pairs[0]["quantile_999"].get<double>());
    EXPECT_LE(pairs[0]["quantile_999"].get<double>(), pairs[0]["max"].get<double>());
}

TEST(Coherence, MeasuresSurfacesAlone) {
    const TemporaryFolder folder;
    writeSequence(folder);
    Mesh vertices = sphere(Vec3(0));
    vertices.triangles.clear();
    writeMesh(folder / "vertices.bgeo", vertices);
    write(folder / "curve.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2 3 1\n");
    for (const auto& [file, contents] : {std::pair("p.0001.bgeo", "particles"), {"curve.obj", "curves"}}) {
        for (const char* other : {file, "m.0001.ply"}) {
            const Outcome outcome = runProgram({"coherence", other, file}, folder.path());
            EXPECT_EQ(outcome.exit_code, 1) << outcome.out;
            EXPECT_NE(outcome.err.find(std::string(file) + ": contains " + contents + ", but no triangles"),
                      std::string::npos)
                << outcome.err;
        }
    }
    EXPECT_EQ(runProgram({"coherence", "m.0001.ply", "vertices.bgeo"}, folder.path()).exit_code, 1);

    writeMesh(folder / "empty.ply", {});
    const Outcome nothing = runProgram({"coherence", "empty.ply", "empty.ply"}, folder.path());
    EXPECT_EQ(nothing.exit_code, 0);
    EXPECT_NE(nothing.out.find("nothing was measured: no surface has triangles"), std::string::npos) << nothing.out;
    EXPECT_NE(runProgram({"coherence", "vertices.bgeo", "m.0001.ply"}, folder.path())
                  .out.find("nothing was measured: no two surfaces in a row could be compared"),
              std::string::npos);
    EXPECT_EQ(runProgram({"coherence", "empty.ply", "m.0001.ply"}, folder.path()).exit_code, 0);
}

TEST(Coherence, PrintsWhereAndExitsWithOneBeyondTheLimit) {
    const TemporaryFolder folder;
    writeSequence(folder);
    const Outcome outcome = runProgram({"coherence", "m.####.ply", "--max-jump", "0.2"}, folder.path());
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_NE(outcome.out.find("largest: 0.51"), std::string::npos) << outcome.out;
    EXPECT_NE(outcome.out.find("from m.0002.ply to m.0003.ply"), std::string::npos) << outcome.out;
    EXPECT_EQ(runProgram({"coherence", "m.####.ply", "--max-jump", "0.6"}, folder.path()).exit_code, 0);
    EXPECT_EQ(runProgram({"coherence", "m.0001.ply", "m.0001.ply", "--max-jump", "0"}, folder.path()).exit_code, 0);
}

TEST(Coherence, EmptyAndUnreadableMeshesDoNotEndTheSequence) {
    const TemporaryFolder folder;
    writeSequence(folder);
    writeMesh(folder / "m.0002.ply", {});
    write(folder / "m.0004.ply", "no");
    const Outcome outcome = runProgram({"coherence", "--json", "m.####.ply"}, folder.path());
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_NE(outcome.err.find("m.0004.ply"), std::string::npos) << outcome.err;
    const std::vector<Json> pairs = jsonLines(outcome.out);
    ASSERT_EQ(pairs.size(), 4u);
    EXPECT_EQ(pairs[0]["max"], nullptr);
    EXPECT_EQ(pairs[1]["max"], nullptr);
    EXPECT_FALSE(pairs[2]["error"].empty());
    EXPECT_FALSE(pairs[3]["error"].empty());
    EXPECT_EQ(runProgram({"coherence", "m.0001.ply", "m.0002.ply"}, folder.path()).exit_code, 0);
    EXPECT_EQ(runProgram({"coherence", "m.0001.ply", "m.0002.ply", "--max-jump", "9"}, folder.path()).exit_code, 1);
    EXPECT_EQ(runProgram({"coherence", "m.0001.ply", "m.0003.ply", "--particles", "absent.####.vdb"}, folder.path())
                  .exit_code,
              2);
}

// The third sphere jumps aside and back: each time liquid is lost on one side and gained on the other, at one place.
TEST(Coherence, ListsPlacesWhereTheSurfaceMovesFartherThanTheParticles) {
    const TemporaryFolder folder;
    writeSequence(folder);
    const std::vector<std::string> words{"coherence", "m.####.ply", "--particles", "p.####.bgeo"};
    const auto outcomeWith = [&](std::vector<std::string> more) {
        more.insert(more.begin(), words.begin(), words.end());
        return runProgram(more, folder.path());
    };
    const std::vector<Json> pairs = jsonLines(outcomeWith({"--json"}).out);
    ASSERT_EQ(pairs.size(), 4u);
    EXPECT_TRUE(pairs[0]["places"].empty());
    ASSERT_FALSE(pairs[1]["places"].empty());
    const Json& place = pairs[1]["places"][0];
    EXPECT_EQ(place["position"], pairs[1]["worst"]);
    EXPECT_EQ(place["jump"], pairs[1]["max"]);
    EXPECT_EQ(place["ratio"], pairs[1]["ratio"]);
    EXPECT_EQ(place["liquid"], "both");
    EXPECT_TRUE(place["events"].empty());
    EXPECT_GT(place["points"].get<int>(), 100);
    EXPECT_NEAR(place["vanished_area"].get<double>(), place["appeared_area"].get<double>(), 0.1);
    EXPECT_GT(jsonLines(outcomeWith({"--json", "--places-above", "0.5"}).out)[0]["places"].size(), 0u);
    EXPECT_TRUE(jsonLines(outcomeWith({"--json", "--places-above", "9"}).out)[1]["places"].empty());
    EXPECT_EQ(place["expected"], pairs[1]["particles"]["max"]);
    EXPECT_EQ(outcomeWith({"--max-ratio", "5"}).exit_code, 0);
    EXPECT_EQ(outcomeWith({"--max-ratio", "4"}).exit_code, 1);
    EXPECT_EQ(jsonLines(outcomeWith({"--json", "--ignore-thinner", "1.5"}).out)[1]["max"], pairs[1]["max"]);
    EXPECT_EQ(jsonLines(outcomeWith({"--json", "--ignore-thinner", "2.6"}).out)[1]["max"], 0);

    const std::string table = outcomeWith({}).out;
    EXPECT_NE(table.find("no change of topology"), std::string::npos) << table;
    const std::string short_table = outcomeWith({"--places-above", "0.5", "--places", "0"}).out;
    EXPECT_NE(short_table.find("and 1 more place\n"), std::string::npos) << short_table;
    EXPECT_EQ(short_table.find("no change of topology"), std::string::npos);
}

// A lone particle comes to touch another.
TEST(Coherence, NamesTheEventsAtAPlace) {
    const TemporaryFolder folder;
    for (int frame = 1; frame <= 2; ++frame) {
        Particles particles;
        particles.position = {{0, 0, 0}, {frame == 1 ? 2.01f : 1.97f, 0, 0}};
        writeParticles(folder / ("p.000" + std::to_string(frame) + ".bgeo"), particles);
    }
    ASSERT_EQ(runProgram({"mesh", "p.####.bgeo", "m.####.ply", "--radius", "1"}, folder.path()).exit_code, 0);
    const Outcome outcome = runProgram({"coherence", "m.####.ply", "--particles", "p.####.bgeo"}, folder.path());
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_NE(outcome.out.find("pieces joined"), std::string::npos) << outcome.out;

    // Two particles give no spacing, so the largest jump replaces the radius. Surfaces that meet are expected to move
    // by the square root of displacement times radius.
    const Json pair =
        jsonLines(runProgram({"coherence", "m.####.ply", "--particles", "p.####.bgeo", "--json"}, folder.path()).out)
            .at(0);
    const double displacement = pair["particles"]["max"], jump = pair["max"], expected = pair["places"][0]["expected"];
    EXPECT_NEAR(expected, std::sqrt(displacement * jump), 1e-12);
}

// One vertex of a sphere moves out and back, then in and back.
TEST(Coherence, DistinguishesDentsFromTips) {
    const TemporaryFolder folder;
    const std::vector<double> length = {1, 1.3, 1, 0.7, 1};
    for (std::size_t frame = 0; frame < length.size(); ++frame) {
        Mesh mesh = sphere(Vec3(0, 0, 0));
        mesh.position[0] *= length[frame];
        Particles particles;
        particles.position = {Vec3f(0, 0, 0.1f * static_cast<float>(frame))};
        writeMesh(folder / ("m.000" + std::to_string(frame) + ".ply"), mesh);
        writeParticles(folder / ("p.000" + std::to_string(frame) + ".bgeo"), particles);
    }
    const std::string table = runProgram({"coherence", "m.####.ply", "--particles", "p.####.bgeo"}, folder.path()).out;
    std::size_t at = 0;
    for (const char* words : {": tip rose", ": tip sank", ": dent opened", ": dent filled"}) {
        at = table.find(words, at);
        EXPECT_NE(at, std::string::npos) << words << '\n' << table;
    }
}

TEST(Coherence, PlotsOverTime) {
    const TemporaryFolder folder;
    writeSequence(folder);
    const Outcome outcome =
        runProgram({"coherence", "m.####.ply", "--particles", "p.####.bgeo", "--plot", "distance.svg"}, folder.path());
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    const std::string svg = contentsOf(folder / "distance.svg");
    EXPECT_TRUE(svg.starts_with("<svg ")) << svg;
    EXPECT_TRUE(svg.ends_with("</svg>\n"));
    for (const char* part : {">max<", ">99.9 %<", ">RMS<", ">particles<", ">frame<", ">0.1<", ">1<", ">2<", ">5<"})
        EXPECT_NE(svg.find(part), std::string::npos) << part;
    EXPECT_EQ(svg.find("nan"), std::string::npos);
    EXPECT_EQ(svg.find("inf"), std::string::npos);
    // If nothing moves, the plot has axes but no lines.
    EXPECT_EQ(runProgram({"coherence", "m.0001.ply", "m.0001.ply", "--plot", "still.svg"}, folder.path()).exit_code, 0);
    EXPECT_EQ(contentsOf(folder / "still.svg").find("nan"), std::string::npos);
    const Outcome absent = runProgram({"coherence", "m.####.ply", "--plot", "absent/way.svg"}, folder.path());
    EXPECT_EQ(absent.exit_code, 2);
    EXPECT_EQ(absent.out, "");  // before anything is measured
    EXPECT_NE(absent.err.find("there is no folder 'absent'"), std::string::npos) << absent.err;
}

TEST(Coherence, PlotsAgainstAnotherRun) {
    const TemporaryFolder folder;
    writeSequence(folder);
    const Outcome first = runProgram({"coherence", "m.####.ply", "--json"}, folder.path());
    std::ofstream(folder / "other.json") << first.out;
    const std::vector<std::string> words{"coherence", "m.####.ply", "--plot", "p.svg", "--against", "other.json"};
    ASSERT_EQ(runProgram(words, folder.path()).exit_code, 0);
    EXPECT_NE(contentsOf(folder / "p.svg").find("max, other"), std::string::npos);
    std::filesystem::remove(folder / "p.svg");
    std::ofstream(folder / "other.json") << first.out.substr(0, first.out.find('\n') + 1);
    const Outcome shorter = runProgram(words, folder.path());
    EXPECT_EQ(shorter.exit_code, 2);
    EXPECT_NE(shorter.err.find("has 1 lines, but 4 pairs are measured"), std::string::npos) << shorter.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "p.svg"));
}

TEST(Coherence, MeasuresAPipelineInFineSteps) {
    const TemporaryFolder folder;
    const int particles = kSanitized ? 50 : 500;  // many take a quarter of an hour there
    ASSERT_EQ(runProgram({"sample", "drop", "p.####.vdb", "--particles", std::to_string(particles), "--frames", "1-2"},
                         folder.path())
                  .exit_code,
              0);
    write(folder / "drop.yaml", "version: 1\ninput: {path: p.####.vdb}\noutput: {path: m.####.ply}\n");
    const std::vector<std::string> words{"coherence", "--json", "--pipeline", "drop.yaml", "--frame",
                                         "2",         "--step", "1e-5",       "--steps",   "3"};
    const Outcome outcome = runProgram(words, folder.path());
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    const std::vector<Json> pairs = jsonLines(outcome.out);
    ASSERT_EQ(pairs.size(), 3u);
    for (const Json& pair : pairs) {
        EXPECT_GT(pair["particles"]["max"].get<double>(), 0);
        EXPECT_GT(pair["max"].get<double>(), 0);
        EXPECT_GT(pair["particles"]["matched"].get<int>(), particles / 2);
    }
    EXPECT_EQ(pairs[2]["to"], "3e-05 s");
    EXPECT_FALSE(std::filesystem::exists(folder / "m.0002.ply"));
    EXPECT_EQ(runProgram(words, folder.path()).out, outcome.out);

    std::vector<std::string> raw = words;
    raw.insert(raw.end(), {"--set", "smoothing.method=none"});
    EXPECT_NE(runProgram(raw, folder.path()).out, outcome.out);
}

TEST(Coherence, RefusesWrongUsage) {
    const TemporaryFolder folder;
    writeSequence(folder);
    write(folder / "p.yaml",
          "version: 1\ninput: {path: p.####.bgeo}\noutput: {path: x.####.ply}\nsurface: {radius: 0.5}\n");
    for (const std::vector<std::string>& words :
         {std::vector<std::string>{"coherence"},
          {"coherence", "m.0001.ply"},
          {"coherence", "absent.####.ply"},
          {"coherence", "m.####.xyz"},
          {"coherence", "m.####.ply", "--max-jump", "-1"},
          {"coherence", "m.####.ply", "--places-above", "1"},
          {"coherence", "m.####.ply", "--max-ratio", "1"},
          {"coherence", "m.####.ply", "--ignore-thinner", "-1"},
          {"coherence", "m.####.ply", "--particles", "p.####.bgeo", "--places-above", "-1"},
          {"coherence", "m.####.ply", "--particles", "p.0001.bgeo"},
          {"coherence", "m.####.ply", "--frame", "1"},
          {"coherence", "--pipeline", "p.yaml"},
          {"coherence", "m.####.ply", "--pipeline", "p.yaml", "--frame", "1", "--step", "1"},
          {"coherence", "--pipeline", "p.yaml", "--frame", "77", "--step", "1"},
          {"coherence", "--pipeline", "p.yaml", "--frame", "1", "--step", "0"}})
        EXPECT_EQ(runProgram(words, folder.path()).exit_code, 2) << words.back();
    const Outcome still =
        runProgram({"coherence", "--pipeline", "p.yaml", "--frame", "1", "--step", "1"}, folder.path());
    EXPECT_EQ(still.exit_code, 2);
    EXPECT_NE(still.err.find("no velocity"), std::string::npos) << still.err;
}

}  // namespace
}  // namespace betamesh
