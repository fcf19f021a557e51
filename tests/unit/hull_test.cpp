#include "skin/hull.h"
#include "base/index.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>

namespace betamesh {
namespace {

constexpr double kRadius = 0x1p38;

Vec3i onGrid(const Vec3& direction) {
    const Vec3 p = direction.normalized() * kRadius;
    return {std::llround(p.x), std::llround(p.y), std::llround(p.z)};
}

// Round the cap from this height on, with all the rest on its left.
void addLoop(int points, double height, double turned, LoopsOnSphere& loops) {
    const double radius = std::sqrt(1 - height * height);
    const auto circle = static_cast<std::uint32_t>(loops.is_hole.size());
    for (int k = 0; k < points; ++k) {
        const double angle = turned - 2 * std::numbers::pi * k / points;
        const double side = height > 0 ? 1 : -1;  // the one at the other pole runs the other way
        loops.point.push_back(onGrid({radius * std::cos(angle), side * radius * std::sin(angle), height}));
        loops.circles.push_back({circle, circle});
    }
    loops.loop_begin.push_back(static_cast<std::uint32_t>(loops.point.size()));
    loops.is_hole.push_back(1);
}

// Two caps cut off, and free points in between.
LoopsOnSphere someLoops(std::mt19937& random) {
    std::uniform_real_distribution<double> share(0, 1), step(-1, 1);
    LoopsOnSphere loops;
    const double top = 0.3 + 0.6 * share(random), bottom = -0.3 - 0.6 * share(random);
    addLoop(5 + static_cast<int>(10 * share(random)), top, share(random), loops);
    addLoop(5 + static_cast<int>(10 * share(random)), bottom, share(random), loops);
    for (auto left = static_cast<int>(60 * share(random)); left > 0;) {
        const Vec3 p = Vec3(step(random), step(random), step(random)).normalized();
        if (p.z > top - 0.01 || p.z < bottom + 0.01) continue;
        loops.point.push_back(onGrid(p));
        --left;
    }
    return loops;
}

// +1 where p is above the triangle.
int sideOf(const Vec3i& a, const Vec3i& b, const Vec3i& c, const Vec3i& p) {
    using Int = __int128;
    const Vec3i u = b - a, v = c - a, w = p - a;
    const Int volume = (Int{u.y} * v.z - Int{u.z} * v.y) * w.x + (Int{u.z} * v.x - Int{u.x} * v.z) * w.y +
                       (Int{u.x} * v.y - Int{u.y} * v.x) * w.z;
    return (volume > 0) - (volume < 0);
}

using Ways = std::map<std::array<std::uint32_t, 2>, std::uint32_t>;

// By ends, the triangle that each side belongs to.
Ways sidesOf(const LoopFilling& filling) {
    Ways sides;
    for (std::uint32_t t = 0; t < filling.triangles.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::array ends{filling.triangles[t][k], filling.triangles[t][(k + 1) % 3]};
            EXPECT_TRUE(sides.emplace(ends, t).second) << "the side is used twice";
        }
    return sides;
}

void expectLoopsFilled(const LoopsOnSphere& loops, const Ways& sides) {
    for (std::size_t l = 0; l + 1 < loops.loop_begin.size(); ++l) {
        const std::uint32_t begin = loops.loop_begin[l], n = loops.loop_begin[l + 1] - begin;
        for (std::uint32_t k = 0; k < n; ++k) {
            const std::uint32_t a = begin + k, b = begin + (k + 1) % n;
            EXPECT_TRUE(sides.contains({a, b}) && !sides.contains({b, a})) << "loop " << l << ", edge " << k;
        }
    }
}

TEST(BoundedHull, NoPointLiesAboveATriangle) {
    std::mt19937 random(3);
    HullFiller hull;
    LoopFilling filling;
    for (int trial = 0; trial < 200; ++trial) {
        const LoopsOnSphere loops = someLoops(random);
        ASSERT_TRUE(hull.fill(loops, filling)) << "trial " << trial;
        EXPECT_TRUE(filling.new_point.empty());
        for (const auto& [a, b, c] : filling.triangles)
            for (const Vec3i& p : loops.point)
                ASSERT_LE(sideOf(loops.point[a], loops.point[b], loops.point[c], p), 0) << "trial " << trial;
        expectLoopsFilled(loops, sidesOf(filling));
    }
}

TEST(BoundedHull, WhatLiesAcrossASideHasItBackwards) {
    std::mt19937 random(5);
    HullFiller hull;
    LoopFilling filling;
    for (int trial = 0; trial < 200; ++trial) {
        LoopsOnSphere loops = someLoops(random);
        const bool coincide = trial % 2 == 0;
        if (coincide) loops.point[loops.loop_begin[1]] = loops.point[loops.loop_begin[1] + 1] + Vec3i(0, 0, 1);
        ASSERT_TRUE(hull.fill(loops, filling)) << "trial " << trial;
        ASSERT_EQ(filling.across.size(), filling.triangles.size());
        const Ways sides = sidesOf(filling);
        expectLoopsFilled(loops, sides);
        int across = 0, beyond = 0;
        for (std::size_t t = 0; t < filling.triangles.size(); ++t)
            for (std::size_t k = 0; k < 3; ++k) {
                const auto back = sides.find({filling.triangles[t][(k + 1) % 3], filling.triangles[t][k]});
                if (filling.across[t][k] != kInvalidIndex) {
                    ASSERT_TRUE(back != sides.end() && back->second == filling.across[t][k]) << "trial " << trial;
                    ++across;
                }
                beyond += back != sides.end();
            }
        if (coincide)
            EXPECT_LT(across, beyond) << "a sliver tells the two apart";
        else
            EXPECT_EQ(across, beyond);
    }
}

}  // namespace
}  // namespace betamesh
