// Jobs in two dimensions as a user runs them.

#include "betamesh/check.h"
#include "io/curve_file.h"
#include "io/particle_file.h"
#include "support/planar_clouds.h"
#include "support/program.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace betamesh {
namespace {

using Json = nlohmann::json;

class PlaneJob : public ::testing::Test {
protected:
    PlaneJob() {
        Particles particles = randomPlanarCloud(1).particles;
        writeParticles(folder_ / "flat.bgeo", particles);
        particles.position[0].z += 1;
        writeParticles(folder_ / "bent.bgeo", particles);
    }
    Outcome run(const std::string& in, const std::string& out, const std::vector<std::string>& further) {
        std::vector<std::string> words{"mesh", in, out, "--radius", "1", "--overwrite"};
        words.insert(words.end(), further.begin(), further.end());
        return runProgram(words, folder_.path());
    }

    TemporaryFolder folder_;
};

TEST_F(PlaneJob, EveryFormatContainsTheSameClosedCurves) {
    std::vector<Curves> found;
    for (const std::string name : {"c.ply", "c.bgeo", "c.obj"}) {
        const Outcome outcome = run("flat.bgeo", name, {"--dimension", "2", "--progress", "json"});
        ASSERT_EQ(outcome.exit_code, 0);
        found.push_back(readCurves(folder_ / name));
        const CurveMeasure measure = measureCurves(found.back());
        const Json report = Json::parse(contentsOf(folder_ / (name + ".json")));
        EXPECT_EQ(measure.unpaired_ends, 0U);
        EXPECT_EQ(report["dimension"], 2);
        EXPECT_EQ(report["status"], "ok");
        EXPECT_EQ(Json::parse(outcome.out)["particles"], report["particles"]);
        EXPECT_EQ(report["euler"], measure.turning);
        EXPECT_EQ(report["edges"], found.back().edges.size());
        EXPECT_NEAR(report["area"], measure.area, 1e-5);
        EXPECT_EQ(found.back().position, found.front().position);
        EXPECT_EQ(found.back().edges, found.front().edges);
    }
}

TEST_F(PlaneJob, DrawingsShowTheChosenLayersAndBounds) {
    ASSERT_EQ(run("flat.bgeo", "p.svg", {"--dimension", "2"}).exit_code, 0);
    const std::string usual = contentsOf(folder_ / "p.svg");
    ASSERT_EQ(run("flat.bgeo", "p.svg", {"--dimension", "2", "--layers", "beta", "--bounds", "0,0,4,4"}).exit_code, 0);
    const std::string curve = contentsOf(folder_ / "p.svg");
    EXPECT_NE(usual.find("<circle"), std::string::npos);
    EXPECT_EQ(curve.find("<circle"), std::string::npos);
    EXPECT_NE(curve.find("height='1000.00'"), std::string::npos);
}

TEST_F(PlaneJob, TheSkinIsReportedAndAnInsetIsTheRadiusMinusTheSkin) {
    const auto skinOf = [&](const std::string& name, std::vector<std::string> words) {
        words.insert(words.end(), {"--dimension", "2"});
        EXPECT_EQ(run("flat.bgeo", name, words).exit_code, 0);
        return Json::parse(contentsOf(folder_ / (name + ".json")))["skin"].get<double>();
    };
    EXPECT_NEAR(skinOf("auto.ply", {}), 0.5 / 1.5, 1e-6);
    EXPECT_EQ(skinOf("none.ply", {"--skin", "none"}), 0);
    EXPECT_EQ(skinOf("rough.ply", {"--smoothing", "none"}), 0);
    EXPECT_NEAR(skinOf("skin.ply", {"--skin", "0.25"}), 0.25, 1e-6);
    EXPECT_NEAR(skinOf("inset.ply", {"--inset", "0.75"}), 0.25, 1e-6);
    EXPECT_EQ(contentsOf(folder_ / "skin.ply"), contentsOf(folder_ / "inset.ply"));
    EXPECT_NE(contentsOf(folder_ / "skin.ply"), contentsOf(folder_ / "auto.ply"));
}

TEST_F(PlaneJob, ContradictingOptionsAreRefusedBeforeAnythingIsWritten) {
    const auto refused = [&](const std::string& out, const std::vector<std::string>& words, const std::string& why) {
        const Outcome outcome = run("flat.bgeo", out, words);
        EXPECT_EQ(outcome.exit_code, 2);
        EXPECT_NE(outcome.err.find(why), std::string::npos) << outcome.err;
        EXPECT_FALSE(std::filesystem::exists(folder_ / out));
    };
    refused("c.svg", {}, "Use another extension, or --dimension 2");
    refused("c.ply", {"--dimension", "4"}, "2 to 3");
    refused("c.ply", {"--dimension", "2", "--layers", "beta"}, "are for .svg output");
    refused("c.ply", {"--bounds", "0,0,1,1"}, "are for .svg output");
    refused("c.ply", {"--dimension", "2", "--tendrils", "points"}, "three dimensions");
    refused("c.ply", {"--dimension", "2", "--walls", "x>0"}, "surface.walls (--walls) is for meshes");
    refused("c.ply", {"--dimension", "2", "--surface-box", "0,0,0,1,1,1"}, "surface.box (--surface-box) is for meshes");
    refused("c.ply", {"--dimension", "2", "--simplify", "0.1"}, "output.simplify (--simplify) is for meshes");
    refused("c.ply", {"--dimension", "2", "--skin", "1"}, "less than surface.radius");
    refused("c.ply", {"--dimension", "2", "--skin", "0.1", "--tessellation", "paper"}, "complete tessellation");
    refused("c.ply", {"--dimension", "2", "--predicates", "float"}, "three dimensions");
    refused("c.svg", {"--dimension", "2", "--layers", "gamma"}, "layers");
    refused("c.svg", {"--dimension", "2", "--bounds", "1,1,0,0"}, "lowest");
}

TEST_F(PlaneJob, ParticlesOutsideThePlaneFailTheirFrameAndFlatInputGivesAHint) {
    const Outcome bent = run("bent.bgeo", "c.ply", {"--dimension", "2"});
    EXPECT_EQ(bent.exit_code, 1);
    EXPECT_NE(bent.err.find("plane of one z"), std::string::npos) << bent.err;
    EXPECT_NE(run("flat.bgeo", "m.ply", {}).err.find("--dimension 2"), std::string::npos);
    EXPECT_EQ(run("bent.bgeo", "m.ply", {}).err.find("--dimension 2"), std::string::npos);
}

}  // namespace
}  // namespace betamesh
