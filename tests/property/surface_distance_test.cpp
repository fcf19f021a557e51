// Distances between surfaces, and displacements of particles.

#include "base/icosphere.h"
#include "base/parallel.h"
#include "base/random.h"
#include "betamesh/coherence.h"
#include "support/oracles.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace betamesh {
namespace {

Mesh sphere(const Vec3& centre, double radius, int cuts = 8) {
    const Icosphere ball = icosphere(cuts);
    Mesh mesh{ball.position, {}, ball.triangles, {}};
    for (Vec3& p : mesh.position) p = p * radius + centre;
    return mesh;
}

// Triangles of all sizes, some degenerate.
Mesh soup(std::uint64_t seed) {
    Random random(seed);
    Mesh mesh;
    const std::size_t triangles = 1 + random.below(40);
    for (std::size_t t = 0; t < triangles; ++t) {
        const Vec3 centre = random.cube() * 3;
        const double size = std::pow(10, random.between(-3, 0.5));
        const auto first = static_cast<std::uint32_t>(mesh.position.size());
        for (int m = 0; m < 3; ++m) mesh.position.push_back(centre + random.cube() * size);
        if (random.below(8) == 0) mesh.position.back() = mesh.position[first];
        mesh.triangles.push_back({first, first + 1, first + 2});
    }
    return mesh;
}

// The largest distance from points all over a mesh, by brute force.
double farthestByBruteForce(const Mesh& from, const Mesh& to, int cuts) {
    double farthest = 0;
    for (const Triangle& t : from.triangles) {
        const Vec3 &a = from.position[t[0]], &b = from.position[t[1]], &c = from.position[t[2]];
        for (int i = 0; i <= cuts; ++i)
            for (int j = 0; i + j <= cuts; ++j)
                farthest = std::max(farthest, distanceTo(to, a + (b - a) * i / cuts + (c - a) * j / cuts));
    }
    return farthest;
}

TEST(SurfaceDistance, AgreesWithBruteForce) {
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        const Mesh one = soup(seed), other = soup(seed + 1000);
        const SurfaceDistance found = surfaceDistance(one, other, {0.05});
        const double expected = std::max(farthestByBruteForce(one, other, 24), farthestByBruteForce(other, one, 24));
        // Both sample at most this far apart; the longest side is 11.
        EXPECT_NEAR(found.max, expected, 11.0 / 24);
        EXPECT_GE(found.max, expected - 11.0 / 64);
        const double at_worst = std::max(distanceTo(one, found.worst), distanceTo(other, found.worst));
        EXPECT_NEAR(found.max, at_worst, 1e-12);
        EXPECT_LE(found.rms, found.max);
        EXPECT_LE(found.quantile999, found.max);
    }
}

// Balls that vanish count only if they are thicker than the limit; balls that move count as before.
TEST(SurfaceDistance, IgnoresThinLiquid) {
    for (const double small : {0.05, 0.1, 0.2}) {
        SCOPED_TRACE("radius " + std::to_string(small));
        Mesh before = sphere(Vec3(0), 1, 24);
        const Mesh drop = sphere(Vec3(3, 0, 0), small, 12);
        const auto first = static_cast<std::uint32_t>(before.position.size());
        before.position.insert(before.position.end(), drop.position.begin(), drop.position.end());
        for (const auto& [a, b, c] : drop.triangles) before.triangles.push_back({a + first, b + first, c + first});
        const Mesh after = sphere(Vec3(0, 0, 0.01), 1, 24);
        const double all = surfaceDistance(before, after).max;
        EXPECT_NEAR(all, 2 + small, 0.02);
        for (const double thinner : {0.25, 0.5, 1.0, 1.6}) {
            const SurfaceDistance distance = surfaceDistance(before, after, {.thinner = thinner * small});
            EXPECT_EQ(distance.max, all) << thinner;
        }
        for (const double thinner : {2.6, 4.0}) {
            const SurfaceDistance distance = surfaceDistance(before, after, {.thinner = thinner * small});
            EXPECT_NEAR(distance.max, 0.01, 0.002) << thinner;
            EXPECT_TRUE(surfaceDistance(before, after, {.beyond = 0.02, .thinner = thinner * small}).far.empty());
        }
    }
}

TEST(SurfaceDistance, IsTheSameBothWaysAndForEveryThreadCount) {
    const Mesh one = sphere(Vec3(0), 1, 40), other = sphere(Vec3(0.01, 0, 0.3), 1.1, 37);
    const SurfaceDistance two_threads = surfaceDistance(one, other), back = surfaceDistance(other, one);
    SurfaceDistance one_thread;
    withThreads(1, [&] { one_thread = surfaceDistance(one, other); });
    EXPECT_EQ(two_threads.max, one_thread.max);
    EXPECT_EQ(two_threads.rms, one_thread.rms);
    EXPECT_EQ(two_threads.quantile999, one_thread.quantile999);
    EXPECT_EQ(two_threads.worst, one_thread.worst);
    EXPECT_EQ(two_threads.max, back.max);
    EXPECT_EQ(two_threads.quantile999, back.quantile999);
    EXPECT_NEAR(two_threads.rms, back.rms, 1e-12);
}

TEST(SurfaceDistance, OfAMovingSphereIsItsDisplacement) {
    for (const double way : {1e-6, 1e-3, 0.05}) {
        const Mesh before = sphere(Vec3(100, 0, 0), 1, 60), after = sphere(Vec3(100, 0, way), 1, 60);
        const SurfaceDistance found = surfaceDistance(before, after);
        EXPECT_NEAR(found.max, way, 0.002 * way);
        EXPECT_NEAR(found.rms, way / std::sqrt(3.0), 0.02 * way);  // |cos θ| over a sphere
        EXPECT_NEAR(found.quantile999, 0.999 * way, 0.002 * way);  // |cos θ| is uniform on a sphere
        EXPECT_NEAR(std::abs(found.worst.z - way / 2), 1, 0.01 + way);
    }
}

TEST(SurfaceDistance, OfSpheresOfTwoSizes) {
    const SurfaceDistance found = surfaceDistance(sphere(Vec3(1, 2, 3), 1, 60), sphere(Vec3(1, 2, 3), 1.5, 60));
    EXPECT_NEAR(found.max, 0.5, 1e-3);
    EXPECT_NEAR(found.rms, 0.5, 1e-3);
    EXPECT_NEAR(found.quantile999, 0.5, 1e-3);
}

TEST(SurfaceDistance, OfEqualSurfacesIsZero) {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        const Mesh mesh = soup(seed);
        const SurfaceDistance found = surfaceDistance(mesh, mesh);
        EXPECT_EQ(found.max, 0);
        EXPECT_EQ(found.rms, 0);
        EXPECT_EQ(found.quantile999, 0);
        EXPECT_GT(found.samples, 0u);
    }
    // A different triangulation of the same surface.
    Mesh square;
    square.position = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    square.triangles = {{0, 1, 2}, {0, 2, 3}};
    Mesh flipped = square;
    flipped.triangles = {{0, 1, 3}, {1, 2, 3}};
    EXPECT_EQ(surfaceDistance(square, flipped).max, 0);
}

TEST(SurfaceDistance, OfEmptyOrBrokenMeshes) {
    const Mesh nothing, ball = sphere(Vec3(0), 1);
    EXPECT_EQ(surfaceDistance(nothing, nothing).max, 0);
    EXPECT_EQ(surfaceDistance(nothing, ball).max, std::numeric_limits<double>::infinity());
    EXPECT_EQ(surfaceDistance(ball, nothing).max, std::numeric_limits<double>::infinity());

    Mesh broken = ball;
    broken.position.emplace_back(std::nan(""), 0, 0);
    broken.triangles.push_back({0, 1, static_cast<std::uint32_t>(broken.position.size() - 1)});
    broken.triangles.push_back({0, 1, 1000000});
    EXPECT_EQ(surfaceDistance(ball, broken).max, 0);

    Mesh point;  // without area
    point.position = {{0, 0, 2}};
    point.triangles = {{0, 0, 0}};
    const SurfaceDistance found = surfaceDistance(ball, point);
    EXPECT_NEAR(found.max, 3, 0.1);
    EXPECT_TRUE(std::isfinite(found.rms));
}

TEST(ParticleMotion, IsMatchedByIdOrByRow) {
    Particles before, after;
    before.position = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
    after.position = {{2, 0, 0.5f}, {0, 0, 0.25f}, {7, 0, 0}};
    ASSERT_TRUE(particleMotion(before, after));
    EXPECT_EQ(particleMotion(before, after)->max, 5);  // by row
    EXPECT_EQ(particleMotion(before, after)->farthest, Vec3(2, 0, 0));

    before.id = {10, 11, 12};
    after.id = {12, 10, 99};
    EXPECT_EQ(particleMotion(before, after)->matched, 2u);
    EXPECT_EQ(particleMotion(before, after)->max, 0.5);
    after.position.pop_back();
    after.id.pop_back();
    EXPECT_EQ(particleMotion(before, after)->max, 0.5);
    after.id.clear();
    EXPECT_FALSE(particleMotion(before, after));
    EXPECT_EQ(particleMotion(Particles{}, Particles{})->matched, 0u);
    after.id = {12, 10};
    EXPECT_FALSE(particleMotion(before, after)->repeated_id);
    before.id = {11, 12, 11};
    EXPECT_EQ(particleMotion(before, after)->repeated_id, 11u);
    before.id = {1, 2, 3};
    after.id = {~std::uint64_t{0}, ~std::uint64_t{0}};  // -1, which often means none
    EXPECT_EQ(particleMotion(before, after)->repeated_id, ~std::uint64_t{0});
}

TEST(ParticleMotion, MovedParticlesFollowTheirVelocity) {
    Particles particles;
    particles.position = {{1, 2, 3}, {4, 5, 6}};
    particles.velocity = {{0, 0, 2}, {-1, 0, 0}};
    const Particles later = advected(particles, 0.25);
    EXPECT_EQ(later.position[0], Vec3f(1, 2, 3.5f));
    EXPECT_EQ(later.position[1], Vec3f(3.75f, 5, 6));
    EXPECT_EQ(particleMotion(particles, later)->max, 0.5);
}

}  // namespace
}  // namespace betamesh
