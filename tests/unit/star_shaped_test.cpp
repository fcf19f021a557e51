#include "skin/star_shaped.h"

#include "base/icosphere.h"
#include "support/oracles.h"

#include <gtest/gtest.h>

#include <random>

namespace betamesh {
namespace {

std::vector<std::array<Vec3, 3>> cornersOf(const Icosphere& sphere) {
    std::vector<std::array<Vec3, 3>> corners;
    for (const auto& [a, b, c] : sphere.triangles)
        corners.push_back({sphere.position[a], sphere.position[b], sphere.position[c]});
    return corners;
}

TEST(StarShaped, SpheresWithVerticesInAndOutAlongTheirDirections) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> length(0.2, 3);
    for (int trial = 0; trial < 50; ++trial) {
        Icosphere sphere = icosphere(3);
        const Vec3 centre(length(random), -10 * length(random), 100 * length(random));
        for (Vec3& p : sphere.position) p = centre + p * length(random);
        EXPECT_TRUE(isStarShaped(centre, cornersOf(sphere)));
        EXPECT_FALSE(isStarShaped(centre + Vec3(4, 0, 0), cornersOf(sphere))) << "seen from outside";
        for (Triangle& t : sphere.triangles) std::swap(t[0], t[1]);
        EXPECT_FALSE(isStarShaped(centre, cornersOf(sphere))) << "inside out";
    }
}

TEST(StarShaped, NothingThatCrossesItself) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> step(-1, 1);
    int shaped = 0, crossing = 0;
    for (int trial = 0; trial < 300; ++trial) {
        Icosphere sphere = icosphere(2);
        const double most = 0.02 * (trial % 50);
        for (Vec3& p : sphere.position) p += Vec3(step(random), step(random), step(random)) * most;
        const bool crosses = crossesItself(sphere.position, sphere.triangles),
                   star_shaped = isStarShaped(Vec3(0), cornersOf(sphere));
        EXPECT_FALSE(star_shaped && crosses) << "trial " << trial;
        shaped += star_shaped;
        crossing += crosses;
    }
    EXPECT_GT(shaped, 20);
    EXPECT_GT(crossing, 20);
}

TEST(StarShaped, NotWhatCoversDirectionsTwice) {
    const Icosphere sphere = icosphere(2);
    auto twice = cornersOf(sphere);
    for (auto corners : cornersOf(sphere)) {
        for (Vec3& p : corners) p *= 2;
        twice.push_back(corners);
    }
    EXPECT_FALSE(isStarShaped(Vec3(0), twice)) << "two spheres, one round the other";
    EXPECT_FALSE(isStarShaped(Vec3(0), {})) << "nothing covers no direction";
}

}  // namespace
}  // namespace betamesh
