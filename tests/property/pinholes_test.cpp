// Holes in sheets open gradually.

#include "betamesh/skin.h"
#include "mesh/triangle_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace betamesh {
namespace {

constexpr double kRadius = 1.5;  // in spacings, as by default

// Rows of particles in a plane; each three neighbours lie about on a circle of radius (1 + excess) · kRadius.
Particles sheet(double excess, unsigned seed) {
    const double side = std::numbers::sqrt3 * kRadius * (1 + excess);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> off(-0.02, 0.02);
    Particles particles;
    for (int row = 0; row < 9; ++row)
        for (int i = 0; i < 9; ++i)
            particles.position.emplace_back(Vec3((i + row % 2 * 0.5) * side + off(random),
                                                 row * side * std::numbers::sqrt3 / 2 + off(random), off(random)));
    return particles;
}

Mesh skinOf(const Particles& particles) {
    SkinParams params;
    params.radius = kRadius;
    params.spacing = 1;
    return skinFrame(particles, params).mesh;
}

bool isSeenThrough(const TriangleTree& tree, double x, double y) {
    bool is_hit = false;
    tree.forTriangles(
        [&](const Box& box) { return box.min.x <= x && box.max.x >= x && box.min.y <= y && box.max.y >= y; },
        [&](std::uint32_t triangle) {
            const auto& [a, b, c] = tree.triangles()[triangle];
            const auto side = [&](std::uint32_t from, std::uint32_t to) {
                const Vec3 &p = tree.position()[from], &q = tree.position()[to];
                return (q.x - p.x) * (y - p.y) - (q.y - p.y) * (x - p.x);
            };
            const auto [least, most] = std::minmax({side(a, b), side(b, c), side(c, a)});
            is_hit = least >= 0 || most <= 0;
            return !is_hit;
        });
    return !is_hit;
}

// Radius of a circle with the mean area of the holes in the middle of a sheet.
double holeRadius(double excess, unsigned seed) {
    const Mesh mesh = skinOf(sheet(excess, seed));
    const TriangleTree tree(mesh.position, mesh.triangles);
    const double side = std::numbers::sqrt3 * kRadius * (1 + excess), height = side * std::numbers::sqrt3 / 2;
    constexpr int kRays = 150;
    int through = 0;
    for (int i = 0; i < kRays * kRays; ++i)
        through += isSeenThrough(tree, (2.5 + 3.0 * (i % kRays) / kRays) * side,
                                 (2 + 4.0 * (i / kRays) / kRays) * height);  // 24 holes
    return std::sqrt(3 * side * 4 * height * through / (kRays * kRays) / 24 / std::numbers::pi);
}

// Nothing is seen of a hole that has just opened, though balls of that radius leave one of up to 0.43 spacings.
TEST(Pinholes, AreNoSpecks) {
    for (const unsigned seed : {1u, 2u})
        for (const double excess : {0.002, 0.005, 0.01, 0.02, 0.04})
            EXPECT_LE(holeRadius(excess, seed), 0.02) << excess << ' ' << seed;
}

TEST(Pinholes, BecomeHoles) {
    double before = 0;
    for (const double excess : {0.07, 0.1, 0.14}) {
        const double radius = holeRadius(excess, 1);
        EXPECT_GE(radius, before) << excess;
        before = radius;
    }
    EXPECT_GE(before, 0.4);
}

}  // namespace
}  // namespace betamesh
