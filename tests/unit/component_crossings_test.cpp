#include "skin/component_crossings.h"

#include "skin/patch_tree.h"
#include "support/oracles.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace betamesh {
namespace {

// m times n quads round a ring, which no point sees all of.
BetaMesh ring(std::uint32_t m, std::uint32_t n, double radius, double thickness) {
    constexpr double kTurn = 6.283185307179586;
    BetaMesh mesh;
    for (std::uint32_t i = 0; i < m; ++i)
        for (std::uint32_t j = 0; j < n; ++j) {
            const double along = kTurn * i / m, round = kTurn * j / n, out = radius + thickness * std::cos(round);
            mesh.vertex.push_back(
                {Vec3(out * std::cos(along), out * std::sin(along), thickness * std::sin(round)), Vec3(0)});
        }
    const auto at = [&](std::uint32_t i, std::uint32_t j) { return i % m * n + j % n; };
    for (std::uint32_t i = 0; i < m; ++i)
        for (std::uint32_t j = 0; j < n; ++j) {
            mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    return mesh;
}

std::vector<Vec3> positionsOf(const BetaMesh& mesh) {
    std::vector<Vec3> positions;
    for (const DualVec3& v : mesh.vertex) positions.push_back(v.position);
    return positions;
}

bool crossesNothing(const BetaMesh& mesh, const std::vector<Vec3>& before, std::uint32_t cut = 0) {
    std::vector<std::uint64_t> room(mesh.vertex.size());
    const auto n = static_cast<std::uint32_t>(mesh.triangles.size());
    return ComponentCrossings(mesh, before, room).crossesNothing(std::vector<TriangleRange>{{0, cut}, {cut, n}});
}

TEST(ComponentCrossings, RingsThatStayAsTheyAreCrossNothing) {
    for (const double size : {1e-30, 1.0, 1e30})
        for (std::uint32_t n = 3; n < 12; ++n) {
            const BetaMesh mesh = ring(4 * n, n, 3 * size, size);
            for (const std::uint32_t cut : {0u, 1u, 7u, 64u})
                EXPECT_TRUE(crossesNothing(mesh, positionsOf(mesh), std::min<std::uint32_t>(cut, 8 * n * n)));
        }
}

TEST(ComponentCrossings, RingsThatShrinkPassThroughThemselves) {
    const BetaMesh from = ring(24, 10, 3, 1);
    for (const double radius : {2.0, 1.5, 1.2, 0.9, 0.6, 0.3}) {
        const BetaMesh to = ring(24, 10, radius, 1);
        EXPECT_EQ(crossesNothing(to, positionsOf(from)), radius > 1) << "radius " << radius;
        EXPECT_EQ(crossesItself(positionsOf(to), to.triangles), radius < 1);
    }
}

TEST(ComponentCrossings, NothingThatCrossesItself) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> step(-1, 1);
    const BetaMesh from = ring(16, 8, 2, 1);
    const std::vector<Vec3> before = positionsOf(from);
    int free = 0, crossing = 0;
    for (int trial = 0; trial < 400; ++trial) {
        BetaMesh mesh = from;
        const double most = 0.01 * (trial % 50);
        for (DualVec3& v : mesh.vertex)
            if (trial % 3 != 0 || step(random) > 0.8)
                v.position += Vec3(step(random), step(random), step(random)) * most;
        const bool crosses = crossesItself(positionsOf(mesh), mesh.triangles), is_free = crossesNothing(mesh, before);
        EXPECT_FALSE(is_free && crosses) << "trial " << trial;
        free += is_free;
        crossing += crosses;
    }
    EXPECT_GT(free, 50);
    EXPECT_GT(crossing, 50);
}

TEST(ComponentCrossings, NotWhatHasTurnedOver) {
    BetaMesh mesh = ring(16, 8, 2, 1);
    const std::vector<Vec3> before = positionsOf(mesh);
    mesh.vertex[0].position = before[9] + (before[9] - before[0]) * 0.1;
    EXPECT_FALSE(crossesNothing(mesh, before));
}

// Cones without a base, side by side, whose sides all face upwards.
BetaMesh cones(double distance, std::uint32_t sides) {
    constexpr double kTurn = 6.283185307179586;
    BetaMesh mesh;
    for (const double x : {0.0, distance}) {
        const auto tip = static_cast<std::uint32_t>(mesh.vertex.size());
        mesh.vertex.push_back({Vec3(x, 0, 1), Vec3(0)});
        for (std::uint32_t i = 0; i < sides; ++i) {
            const double angle = kTurn * i / sides;
            mesh.vertex.push_back({Vec3(x + std::cos(angle), 0.9 * std::sin(angle), 0), Vec3(0)});
            mesh.triangles.push_back({tip, tip + 1 + i, tip + 1 + (i + 1) % sides});
        }
    }
    return mesh;
}

TEST(ComponentCrossings, LayersThatFaceTheSameWayAreCompared) {
    const BetaMesh from = cones(3, 40);
    for (const double distance : {2.5, 2.1, 1.9, 1.5, 1.0, 0.5}) {
        const BetaMesh to = cones(distance, 40);
        EXPECT_EQ(crossesNothing(to, positionsOf(from)), distance > 2) << "distance " << distance;
        const PatchTree tree(to, positionsOf(from), 1);
        EXPECT_EQ(tree.candidatePairs().crossing.empty(), distance > 2) << "distance " << distance;
    }
}

}  // namespace
}  // namespace betamesh
