// `betamesh check` as a user runs it.

#include "base/icosphere.h"
#include "io/mesh_file.h"
#include "io/particle_file.h"
#include "support/program.h"

#include <gtest/gtest.h>

namespace betamesh {
namespace {

using Json = nlohmann::json;

Mesh sphere(double radius, const Vec3& centre) {
    const Icosphere ball = icosphere(4);
    Mesh mesh{ball.position, {}, ball.triangles, {}};
    for (Vec3& p : mesh.position) p = p * radius + centre;
    return mesh;
}

TEST(Check, ClosedMeshesPassAndOpenOnesFail) {
    const TemporaryFolder folder;
    Mesh mesh = sphere(1, Vec3(0));
    writeMesh(folder / "good.ply", mesh);
    mesh.triangles.pop_back();
    writeMesh(folder / "open.obj", mesh);
    const Outcome good = runProgram({"check", "good.ply"}, folder.path());
    EXPECT_EQ(good.exit_code, 0) << good.err;
    EXPECT_TRUE(good.out.starts_with("good.ply: good\n")) << good.out;
    EXPECT_NE(good.out.find("1: 1 of genus 0"), std::string::npos) << good.out;
    const Outcome open = runProgram({"check", "open.obj"}, folder.path());
    EXPECT_EQ(open.exit_code, 1);
    EXPECT_TRUE(open.out.starts_with("open.obj: open_edges\n")) << open.out;

    const Outcome both = runProgram({"check", "--json", "open.obj", "good.ply"}, folder.path());
    EXPECT_EQ(both.exit_code, 1);
    const std::vector<Json> reports = jsonLines(both.out);
    ASSERT_EQ(reports.size(), 2u);
    EXPECT_EQ(reports[0]["faults"], Json({"open_edges"}));
    EXPECT_EQ(reports[0]["open_edges"]["count"], 3);
    EXPECT_EQ(reports[0]["closed"], false);
    EXPECT_EQ(reports[0]["component"][0]["genus"], nullptr);
    EXPECT_EQ(reports[1]["good"], true);
    EXPECT_EQ(reports[1]["euler"], 2);
    EXPECT_EQ(reports[1]["components"], 1);
    EXPECT_EQ(reports[1]["component"][0]["genus"], 0);
}

TEST(Check, ParticlesAreNoMesh) {
    const TemporaryFolder folder;
    Particles particles;
    particles.position = {{0, 0, 0}, {1, 0, 0}};
    particles.id = {0, 1};
    for (const char* name : {"a.ply", "a.bgeo", "a.vtp", "a.usda", "a.abc"}) {
        writeParticles(folder / name, particles);
        const Outcome outcome = runProgram({"check", name}, folder.path());
        EXPECT_EQ(outcome.exit_code, 1) << name << '\n' << outcome.out;
        EXPECT_NE(outcome.err.find(std::string(name) + ": contains particles"), std::string::npos) << outcome.err;
        writeMesh(folder / name, {});
        EXPECT_EQ(runProgram({"check", name}, folder.path()).exit_code, 0) << name;
    }
}

TEST(Check, VerticesThatAreNotFiniteAreOneFaultOfSeveral) {
    const TemporaryFolder folder;
    write(folder / "a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\n");
    for (const char* more : {"--json", "--weld"}) {
        const Outcome outcome = runProgram({"check", "a.obj", more}, folder.path());
        EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
        EXPECT_EQ(outcome.err, "");
        EXPECT_NE(outcome.out.find("not_finite"), std::string::npos) << outcome.out;
        EXPECT_NE(outcome.out.find("open_edges"), std::string::npos) << outcome.out;
    }
    write(folder / "p.csv", "x,y,z\n0.1,0.1,0.1\n");
    EXPECT_EQ(runProgram({"check", "a.obj", "--particles", "p.csv"}, folder.path()).exit_code, 1);
    write(folder / "c.obj", "v 0 0 0\nv 1 0 0\nv nan 1 0\nl 1 2 3 1\n");
    const Outcome curves = runProgram({"check", "c.obj"}, folder.path());
    EXPECT_EQ(curves.exit_code, 1);
    EXPECT_TRUE(curves.out.starts_with("c.obj: not_finite")) << curves.out << curves.err;
}

TEST(Check, TheDeprecatedScratchFolderIsWarnedOf) {
    const TemporaryFolder folder;
    writeMesh(folder / "a.ply", sphere(1, Vec3(0)));
    const Outcome without = runProgram({"check", "--json", "a.ply"}, folder.path());
    const Outcome outcome = runProgram({"check", "--json", "a.ply", "--scratch", "absent"}, folder.path());
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(outcome.out, without.out);
    EXPECT_NE(outcome.err.find("--scratch has no effect any more"), std::string::npos) << outcome.err;
}

TEST(Check, CrossingsAreListedAndShallowOnesAreTolerated) {
    const TemporaryFolder folder;
    Mesh mesh;
    mesh.position = {{-9, -9, 0},  {9, -9, 0},  {0, 9, 0},      {0, 0, 9},
                     {0, 0, 0.25}, {1, 0, -20}, {-1, 0.5, -20}, {0, -1, -20}};
    mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}, {4, 5, 6}, {4, 6, 7}, {4, 7, 5}, {5, 7, 6}};
    writeMesh(folder / "a.ply", mesh);
    const Outcome outcome = runProgram({"check", "--json", "a.ply", "--examples", "2"}, folder.path());
    EXPECT_EQ(outcome.exit_code, 1);
    const Json report = jsonLines(outcome.out).at(0);
    EXPECT_EQ(report["faults"], Json({"crossings"}));
    EXPECT_EQ(report["crossings"]["count"], 3);
    EXPECT_NEAR(report["crossings"]["deepest"].get<double>(), 0.25, 1e-9);
    ASSERT_EQ(report["crossings"]["listed"].size(), 2u);
    EXPECT_EQ(report["crossings"]["listed"][0]["triangles"], Json({0, 4}));
    EXPECT_NEAR(report["crossings"]["listed"][0]["position"][2].get<double>(), 0, 1e-9);
    EXPECT_NE(runProgram({"check", "a.ply"}, folder.path()).out.find("triangles 0 and 4 at"), std::string::npos);
    EXPECT_EQ(runProgram({"check", "a.ply", "--tolerance", "0.3"}, folder.path()).exit_code, 0);
    EXPECT_EQ(runProgram({"check", "a.ply", "--tolerance", "0.2"}, folder.path()).exit_code, 1);
}

TEST(Check, SplitVerticesGiveAHintAndAreWelded) {
    const TemporaryFolder folder;
    // Two quads and two triangles around a wedge; every face has its own vertices.
    write(folder / "wedge.obj",
          "v 0 0 0\nv 0 1 0\nv 1 1 0\nv 1 0 0\n"
          "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\n"
          "v 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 0\n"
          "v 0 0 0\nv 0 0 1\nv 0 1 0\nv 1 0 0\nv 1 1 0\nv 1 0 1\n"
          "f 1 2 3 4\nf 5 6 7 8\nf 9 10 11 12\nf 13 14 15\nf 16 17 18\n");
    const Outcome split = runProgram({"check", "wedge.obj"}, folder.path());
    EXPECT_EQ(split.exit_code, 1);
    EXPECT_NE(split.out.find("--weld"), std::string::npos) << split.out;
    const Outcome welded = runProgram({"check", "--weld", "--strict", "--json", "wedge.obj"}, folder.path());
    EXPECT_EQ(welded.exit_code, 0) << welded.out;
    EXPECT_EQ(jsonLines(welded.out).at(0)["vertices"], 6);
    EXPECT_NEAR(jsonLines(welded.out).at(0)["volume"].get<double>(), 0.5, 1e-12);
}

TEST(Check, ParticlesMustBeInsideTheMeshOrTheSpheresBesideIt) {
    const TemporaryFolder folder;
    writeMesh(folder / "m.0007.ply", sphere(1, Vec3(0)));
    Particles particles;
    particles.position = {Vec3f(0), Vec3f(0.5f, 0.2f, 0), Vec3f(0, 0, 3)};
    writeParticles(folder / "p.0007.bgeo", particles);
    const std::vector<std::string> words{"check",       "--json",   "m.0007.ply", "--particles",
                                         "p.####.bgeo", "--radius", "0.5"};
    const Outcome outside = runProgram(words, folder.path());
    EXPECT_EQ(outside.exit_code, 1);
    const Json report = jsonLines(outside.out).at(0);
    EXPECT_EQ(report["faults"], Json({"particles_outside"}));
    EXPECT_EQ(report["particles"]["count"], 3);
    EXPECT_EQ(report["particles"]["outside"], 1);
    EXPECT_EQ(report["particles"]["farthest_particle"], 2);
    EXPECT_NEAR(report["particles"]["farthest"].get<double>(), 2, 0.05);
    EXPECT_NEAR(report["particles"]["farthest_radii"].get<double>(), 4, 0.1);
    EXPECT_EQ(runProgram({"check", "m.0007.ply", "--particles", "p.0007.bgeo", "--tolerance", "2.1"}, folder.path())
                  .exit_code,
              0);

    Spheres spheres;
    spheres.position = {Vec3(0, 0, 3)};
    spheres.radius = {0.5f};
    writeSpheres(folder / "m.0007.spheres.ply", spheres);
    const Outcome beside = runProgram(words, folder.path());
    EXPECT_EQ(beside.exit_code, 0) << beside.out;
    EXPECT_EQ(jsonLines(beside.out).at(0)["particles"]["spheres"], 1);
}

TEST(Check, ParticlesAreComparedInTheAxesOfTheMesh) {
    const TemporaryFolder folder;
    Particles block;
    for (int i = 0; i < 60; ++i)
        block.position.emplace_back(static_cast<float>(i % 3), static_cast<float>(i / 3 % 10),
                                    static_cast<float>(i / 30));
    writeParticles(folder / "p.0001.ply", block);
    for (const std::string up : {"y", "z"}) {
        ASSERT_EQ(runProgram({"mesh", "p.####.ply", "m.####.ply", "--spacing", "1", "--output-up-axis", up,
                              "--overwrite", "--origin", "1,2,3"},
                             folder.path())
                      .exit_code,
                  0);
        const Outcome by_manifest = runProgram({"check", "m.0001.ply", "--particles", "p.####.ply"}, folder.path());
        EXPECT_EQ(by_manifest.exit_code, 0) << by_manifest.out << by_manifest.err;
    }
    std::filesystem::remove(folder / "m.0001.ply.json");
    const std::vector<std::string> words{"check", "m.0001.ply", "--particles", "p.####.ply", "--origin", "1,2,3"};
    EXPECT_EQ(runProgram(words, folder.path()).exit_code, 1);
    std::vector<std::string> with_axis = words;
    with_axis.insert(with_axis.end(), {"--output-up-axis", "z"});
    EXPECT_EQ(runProgram(with_axis, folder.path()).exit_code, 0);
    with_axis.back() = "x";
    EXPECT_EQ(runProgram(with_axis, folder.path()).exit_code, 2);
}

TEST(Check, WrongUsageAndUnreadableFilesHaveDifferentExitCodes) {
    const TemporaryFolder folder;
    writeMesh(folder / "good.ply", sphere(1, Vec3(0)));
    write(folder / "broken.ply", "no");
    for (const std::vector<std::string>& words : {std::vector<std::string>{"check"},
                                                  {"check", "good.xyz"},
                                                  {"check", "good.ply", "--radius", "1"},
                                                  {"check", "good.ply", "--tolerance", "-1"},
                                                  {"check", "good.ply", "--particles", "p.fbx"},
                                                  {"check", "good.ply", "--particles", "absent.####.vdb"}})
        EXPECT_EQ(runProgram(words, folder.path()).exit_code, 2);
    EXPECT_EQ(runProgram({"check", "good.ply", "--particles", "absent.vdb"}, folder.path()).exit_code, 1);
    const Outcome broken = runProgram({"check", "--json", "broken.ply", "good.ply"}, folder.path());
    EXPECT_EQ(broken.exit_code, 1);
    EXPECT_NE(broken.err.find("broken.ply"), std::string::npos);
    const std::vector<Json> reports = jsonLines(broken.out);
    ASSERT_EQ(reports.size(), 2u);
    EXPECT_EQ(reports[0]["good"], false);
    EXPECT_FALSE(reports[0]["error"].empty());
    EXPECT_EQ(reports[1]["good"], true);
}

TEST(Check, ManifestsAreLeftOutAmongTheirMeshes) {
    const TemporaryFolder folder;
    ASSERT_EQ(
        runProgram({"sample", "drop", "p.####.ply", "--particles", "500", "--frames", "1-2"}, folder.path()).exit_code,
        0);
    ASSERT_EQ(runProgram({"mesh", "p.####.ply", "m.####.ply", "-q"}, folder.path()).exit_code, 0);
    std::filesystem::copy_file(folder / "m.0002.ply", folder / "n.0003.ply");
    write(folder / "n.0003.ply.json", "{}");
    using Names = std::vector<std::string>;
    for (const char* command : {"check", "info", "coherence"}) {
        SCOPED_TRACE(command);
        const auto run = [&](Names files) {
            files.insert(files.begin(), command);
            return runProgram(files, folder.path());
        };
        // As a shell orders m.*
        const Outcome outcome = run({"m.0001.ply", "m.0001.ply.json", "m.0002.ply", "m.0002.ply.json"});
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        EXPECT_NE(outcome.err.find("left out because they are manifests: m.0001.ply.json and m.0002.ply.json"),
                  std::string::npos)
            << outcome.err;
        EXPECT_EQ(outcome.out, run({"m.0001.ply", "m.0002.ply"}).out);
        for (const Names& files :  // without their mesh, or no manifest
             {Names{"m.0001.ply.json"}, Names{"m.0001.ply", "m.0002.ply.json"},
              Names{"m.0001.ply", "n.0003.ply", "n.0003.ply.json"}})
            EXPECT_NE(run(files).exit_code, 0);
    }
    // What is no mesh but its manifest says so.
    for (const char* command : {"check", "info", "mesh", "convert", "render"}) {
        std::vector<std::string> words{command, "m.0001.ply.json",
                                       std::string(command) == "render" ? "x.png" : "x.ply"};
        if (words[0] == "check" || words[0] == "info") words.pop_back();
        const Outcome outcome = runProgram(words, folder.path());
        EXPECT_TRUE(outcome.exit_code == 1 || outcome.exit_code == 2) << command << outcome.exit_code;
        EXPECT_NE(outcome.err.find("manifest, the report"), std::string::npos) << command << outcome.err;
        EXPECT_NE(outcome.err.find("ive the mesh"), std::string::npos) << command << outcome.err;
    }
    EXPECT_NE(runProgram({"info", "m.0001.ply.json"}, folder.path()).err.find("Give the mesh, m.0001.ply."),
              std::string::npos);
}

TEST(Check, StarsInNamesThatNoFileHasAreExplained) {
    const TemporaryFolder folder;
    writeMesh(folder / "m*.ply", sphere(1, Vec3(0)));
    for (const std::vector<std::string>& words : {std::vector<std::string>{"check", "a.*.ply"},
                                                  {"check", "--json", "a.????.ply"},
                                                  {"info", "a.*.ply"},
                                                  {"convert", "a.*.ply", "b.ply"},
                                                  {"render", "a.*.ply", "b.png"},
                                                  {"compare", "a.*.ply", "b.png"},
                                                  {"mesh", "a.*.ply", "b.ply"},
                                                  {"mesh", "a.<F4>.ply", "b.ply"},
                                                  {"mesh", "a.%4d.ply", "b.ply"},
                                                  {"render", "a.{frame}.ply", "b.png"},
                                                  {"info", "a.[1-9].ply"}}) {
        const Outcome outcome = runProgram(words, folder.path());
        EXPECT_EQ(outcome.exit_code, 1) << words[0];
        EXPECT_NE(outcome.err.find("o such file"), std::string::npos) << words[0] << outcome.err;
        EXPECT_NE(outcome.err.find(". The frame numbers of a sequence are written with #, as in name.####.ply"),
                  std::string::npos)
            << words[0] << outcome.err;
    }
    EXPECT_EQ(runProgram({"check", "m*.ply"}, folder.path()).exit_code, 0);  // the name of a file
    EXPECT_EQ(runProgram({"check", "absent.ply"}, folder.path()).err.find("####"), std::string::npos);
}

TEST(Check, ChecksMeshesOfThisProgram) {
    const TemporaryFolder folder;
    ASSERT_EQ(
        runProgram({"sample", "drop", "p.####.vdb", "--particles", "2000", "--frames", "1-2"}, folder.path()).exit_code,
        0);
    ASSERT_EQ(runProgram({"mesh", "p.####.vdb", "m.####.ply"}, folder.path()).exit_code, 0);
    const Outcome outcome =
        runProgram({"check", "--json", "m.0001.ply", "m.0002.ply", "--particles", "p.####.vdb"}, folder.path());
    const std::vector<Json> reports = jsonLines(outcome.out);
    ASSERT_EQ(reports.size(), 2u);
    for (const Json& report : reports) {
        EXPECT_EQ(report["closed"], true);
        EXPECT_EQ(report["oriented"], true);
        EXPECT_GT(report["particles"]["count"], 0);
    }
}

}  // namespace
}  // namespace betamesh
