#include "betamesh/skin_params.h"

#include "betamesh/error.h"

#include <gtest/gtest.h>

#include <limits>

namespace betamesh {
namespace {

SkinParams withSkin(std::optional<double> skin) {
    SkinParams params;
    params.radius = 1.5;
    params.skin = skin;
    return params;
}

TEST(SkinParams, TheSpacingIsTwoThirdsOfTheRadiusUnlessItIsGiven) {
    SkinParams params = withSkin({});
    EXPECT_DOUBLE_EQ(particleSpacing(params), 1);
    params.spacing = 0.75;
    EXPECT_DOUBLE_EQ(particleSpacing(params), 0.75);
}

TEST(SkinParams, TheSkinIsDeepOnTheCompleteTessellationAlone) {
    EXPECT_DOUBLE_EQ(skinDepth(withSkin({})), 0.55);
    EXPECT_DOUBLE_EQ(skinDepth(withSkin(0.25)), 0.25);
    EXPECT_EQ(skinDepth(withSkin(0)), 0);
    SkinParams small = withSkin({});
    small.spacing = 10;
    EXPECT_DOUBLE_EQ(skinDepth(small), 0.8 * small.radius);
    for (const auto skin : {std::optional<double>(), std::optional(0.25)}) {
        SkinParams other = withSkin(skin);
        other.tessellation = Tessellation::paper;
        EXPECT_EQ(skinDepth(other), 0);
        other.tessellation = Tessellation::complete;
        for (const SurfaceKind kind : {SurfaceKind::alpha, SurfaceKind::union_}) {
            other.surface = kind;
            EXPECT_EQ(skinDepth(other), 0);
        }
    }
}

TEST(SkinParams, InTwoDimensionsTheSkinIsTrueToTheArea) {
    EXPECT_DOUBLE_EQ(skinDepth(withSkin({}), 2), 0.5);
    EXPECT_NEAR(isolatedSkinDepth(withSkin({})) * isolatedSkinDepth(withSkin({})) * 3.14159265, 1, 1e-6);
    for (const double given : {0.0, 0.25}) {
        EXPECT_EQ(skinDepth(withSkin(given), 2), given);
        EXPECT_EQ(isolatedSkinDepth(withSkin(given)), given);
    }
    SkinParams rough = withSkin({});
    rough.passes = 0;
    EXPECT_EQ(skinDepth(rough, 2), 0);
    EXPECT_EQ(isolatedSkinDepth(rough), 0);
    rough.skin = 0.25;
    EXPECT_EQ(skinDepth(rough, 2), 0.25);
}

TEST(SkinParams, ASkinLiesBetweenTheParticlesAndTheirBalls) {
    EXPECT_NO_THROW(requireSkin(withSkin({})));
    EXPECT_NO_THROW(requireSkin(withSkin(0)));
    EXPECT_NO_THROW(requireSkin(withSkin(1.499)));
    for (const double wrong : {-0.1, 1.5, 2.0, std::numeric_limits<double>::quiet_NaN()})
        EXPECT_THROW(requireSkin(withSkin(wrong)), Error) << wrong;
    SkinParams paper = withSkin(0.5);
    paper.tessellation = Tessellation::paper;
    EXPECT_THROW(requireSkin(paper), Error);
    paper.skin = 0;
    EXPECT_NO_THROW(requireSkin(paper));
}

}  // namespace
}  // namespace betamesh
