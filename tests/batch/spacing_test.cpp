// The particle spacing that a job uses, and what it says about it.

#include "base/random.h"
#include "support/job_folder.h"

namespace betamesh {
namespace {

constexpr double kSpacing = 0.1;

Particles box(int x, int y, int z, double spacing = kSpacing) {
    Particles particles;
    for (int k = 0; k < z; ++k)
        for (int j = 0; j < y; ++j)
            for (int i = 0; i < x; ++i) particles.position.emplace_back(Vec3(i, j, k) * spacing);
    particles.velocity.assign(particles.size(), Vec3f(0, 0, 0));
    return particles;
}

class JobSpacing : public JobFolder {};

TEST_F(JobSpacing, OfAnEmitterIsThatOfItsLiquid) {
    for (const Particles& first : {box(8, 1, 1), box(12, 12, 1), box(20, 1, 1, 3)}) {
        writeFrame(1, first);
        writeFrame(2, {});
        for (int frame = 3; frame < 6; ++frame) writeFrame(frame, box(8, 8, 8 + frame));
        const Outcome outcome = mesh({"--overwrite"});
        ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
        const double spacing = manifest(5)["spacing"];
        EXPECT_NEAR(spacing, kSpacing, 0.01);
        EXPECT_NE(outcome.err.find("measured in frames 1, 3 and 5"), std::string::npos) << outcome.err;
        for (int frame = 1; frame < 6; ++frame) EXPECT_EQ(manifest(frame)["spacing"], spacing) << frame;
        // Only the frame of another spacing is told.
        const bool sparse = first.position[1].x > 1;
        EXPECT_EQ(outcome.err.find("a.0001.ply: the particle spacing of this frame is 3") != std::string::npos, sparse)
            << outcome.err;
        EXPECT_EQ(manifest(1)["warnings"].size(), sparse ? 1U : 0U) << manifest(1)["warnings"];
        EXPECT_EQ(manifest(5)["warnings"].size(), 0U) << manifest(5)["warnings"];
    }
}

TEST_F(JobSpacing, FilesMeshedOneByOneWithTheSpacingOfTheLogAreThoseOfTheSequence) {
    writeFrame(1, box(12, 12, 1));
    writeFrames(2, 4);
    const Outcome outcome = mesh();
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    const std::string option = "--spacing ";
    const std::size_t at = outcome.err.find(option) + option.size();
    const std::string spacing = outcome.err.substr(at, outcome.err.find('\n', at) - at);
    const auto meshes = meshesIn("out");
    for (int frame = 1; frame <= 4; ++frame) {
        const std::string one = numbered("out/a", frame, ".ply");
        const Outcome alone = runProgram(
            {"mesh", numbered("in/a", frame, ".ply"), one, "--spacing", spacing, "--overwrite"}, folder_.path());
        ASSERT_EQ(alone.exit_code, 0) << alone.err;
    }
    EXPECT_EQ(meshesIn("out"), meshes);
    for (const char* chunk : {"1/2", "2/2"}) ASSERT_EQ(mesh({"--chunk", chunk, "--overwrite"}).exit_code, 0);
    EXPECT_EQ(meshesIn("out"), meshes);
}

TEST_F(JobSpacing, UnevenlySpacedParticlesAreAdvisedThePresetForThem) {
    const auto isAdvised = [&](const std::vector<std::string>& options) {
        const Outcome outcome = mesh(options);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return outcome.err.find("--preset flip") != std::string::npos;
    };
    writeFrame(1, box(10, 10, 10));
    EXPECT_FALSE(isAdvised({}));
    Random random(1);
    Particles seeded = box(10, 10, 10);
    for (Vec3f& p : seeded.position) p = Vec3f(random.cube() * (5 * kSpacing));
    writeFrame(1, seeded);
    EXPECT_TRUE(isAdvised({"--overwrite"}));
    EXPECT_FALSE(isAdvised({"--overwrite", "--preset", "flip"}));
    EXPECT_FALSE(isAdvised({"--overwrite", "--radius", "2dx"}));
    EXPECT_FALSE(isAdvised({"--overwrite", "--spacing", "0.1"}));
}

TEST_F(JobSpacing, AnUncertainSpacingIsAskedFor) {
    const auto isAsked = [&](const std::vector<std::string>& options) {
        const Outcome outcome = mesh(options);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return outcome.err.find("give it with --spacing") != std::string::npos;
    };
    writeFrame(1, box(10, 10, 10));
    EXPECT_FALSE(isAsked({}));
    Particles stretched = box(10, 10, 10);
    for (Vec3f& p : stretched.position) p *= 1 + p.length();  // ever farther apart
    writeFrame(1, stretched);
    EXPECT_TRUE(isAsked({"--overwrite"}));
    EXPECT_FALSE(isAsked({"--overwrite", "--spacing", "0.1"}));
}

TEST_F(JobSpacing, ARadiusInTheWrongUnitIsAskedAbout) {
    writeFrame(1, box(9, 9, 9));
    const Outcome refused = mesh({"--radius", "6"});
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_NE(refused.err.find("times the particle spacing 0.1"), std::string::npos) << refused.err;
    EXPECT_NE(refused.err.find("Did you mean 6dx"), std::string::npos) << refused.err;
    EXPECT_FALSE(exists("out/a.0001.ply"));
    EXPECT_EQ(mesh({"--radius", "6", "--spacing", "4"}).exit_code, 0);
    writeFrame(2, box(18, 18, 18));
    EXPECT_EQ(mesh({"--radius", "1.5"}).exit_code, 2);
    for (const std::vector<std::string>& absurd : {std::vector<std::string>{"--radius", "1000dx"},
                                                   {"--radius", "0.15", "--spacing", "1e12"},
                                                   {"--radius", "1e6dx", "--spacing", "0.1"}})
        EXPECT_EQ(mesh(absurd).exit_code, 2) << absurd[1];
}

TEST_F(JobSpacing, ARadiusThatDoesNotSuitTheParticlesIsToldWhateverWayItWasGiven) {
    writeFrame(1, box(6, 6, 6));
    writeFrame(2, box(6, 6, 6));
    struct Case {
        std::vector<std::string> options;
        std::string warning;  ///< empty: none
    };
    const std::string scale = "times the particle spacing of this frame", drift = "is used for all frames";
    for (const Case& c :
         {Case{{"--radius", "0.15"}, ""}, Case{{"--radius", "1.5dx"}, ""}, Case{{"--radius", "0.7dx"}, scale},
          Case{{"--radius", "4dx"}, scale}, Case{{"--radius", "0.15", "--spacing", "0.16"}, drift},
          Case{{"--radius", "0.6"}, scale}, Case{{"--radius", "0.05"}, drift}, Case{{"--spacing", "0.3"}, scale}}) {
        std::vector<std::string> options = c.options;
        options.push_back("--overwrite");
        const Outcome outcome = mesh(options);
        ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
        for (int frame = 1; frame <= 2; ++frame) {
            const std::string warnings = manifest(frame)["warnings"].dump();
            EXPECT_EQ(warnings.find("spacing") != std::string::npos, !c.warning.empty()) << c.options[1] << warnings;
            EXPECT_NE(warnings.find(c.warning), std::string::npos) << c.options[1] << warnings;
        }
        EXPECT_EQ(outcome.err.find("warning: ") != std::string::npos, !c.warning.empty()) << outcome.err;
        EXPECT_NEAR(manifest(1)["frame_spacing"].get<double>(), kSpacing, 0.01);
    }
}

TEST_F(JobSpacing, WhatBecomesOfTheLiquidWithAnUnusualRadiusIsTold) {
    writeFrame(1, box(6, 6, 6));
    for (const auto& [radius, fate] :
         {std::pair("0.04", "most particles become drops"), std::pair("0.4dx", "most particles become drops"),
          std::pair("0.7dx", "sheets get holes"), std::pair("4dx", "parts that are far apart melt together")}) {
        const Outcome outcome = mesh({"--radius", radius, "--overwrite"});
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        const std::size_t at = outcome.err.find(fate);
        EXPECT_NE(at, std::string::npos) << radius << outcome.err;
        EXPECT_NE(outcome.err.find("Use 0.8 to 3 times, such as --radius 0.1", at), std::string::npos) << outcome.err;
    }
}

TEST_F(JobSpacing, ARadiusThatTheSizesOfParticlesCancelIsTold) {
    Particles particles = box(6, 6, 6);
    Attribute pscale;
    pscale.name = "pscale";
    pscale.real.assign(particles.size(), 0.1F);
    particles.attributes = {pscale};
    writeFrame(1, particles);
    const auto isTold = [&](std::vector<std::string> options) {
        options.insert(options.end(), {"--radius-attribute", "pscale", "--overwrite"});
        const Outcome outcome = mesh(options);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return outcome.err.find("(surface.radius) alone does not change the size of the balls") != std::string::npos;
    };
    EXPECT_TRUE(isTold({"--radius", "0.2"}));
    EXPECT_FALSE(isTold({}));
    EXPECT_FALSE(isTold({"--radius", "2dx"}));
    EXPECT_FALSE(isTold({"--radius", "0.2", "--spacing", "0.1"}));
}

TEST_F(JobSpacing, OfEmptyFramesIsNotNeeded) {
    writeFrame(1, {});
    for (const char* dimension : {"3", "2"}) {
        const Outcome outcome = mesh({"--dimension", dimension, "--overwrite"});
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        EXPECT_EQ(manifest(1)["status"], "empty");
    }
    writeFrame(2, box(3, 1, 1));
    const Outcome unknown = mesh({"--overwrite"});
    EXPECT_EQ(unknown.exit_code, 2);
    EXPECT_NE(unknown.err.find("Give it with --spacing"), std::string::npos) << unknown.err;
}

}  // namespace
}  // namespace betamesh
