// Properties of surfaces that are laid flat against walls.

#include "skin/walls.h"

#include "betamesh/check.h"
#include "betamesh/coherence.h"
#include "betamesh/error.h"
#include "betamesh/skin.h"
#include "support/clouds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace betamesh {
namespace {

SkinParams withWalls(std::vector<Wall> walls, double spacing = 1) {
    SkinParams params;
    params.radius = 1.5 * spacing;
    params.spacing = spacing;
    params.walls = std::move(walls);
    return params;
}

Particles jittered(int nx, int ny, int nz, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> off(-0.3, 0.3);
    Particles particles;
    for (int z = 0; z < nz; ++z)
        for (int y = 0; y < ny; ++y)
            for (int x = 0; x < nx; ++x) {
                particles.position.emplace_back(Vec3(x + off(random), y + off(random), z + off(random)));
                particles.velocity.emplace_back(Vec3(off(random), off(random), off(random)));
            }
    return particles;
}

TEST(Walls, TheSurfaceIsFlatAgainstThem) {
    const Particles slab = jittered(30, 30, 5, 1);
    const auto bottomOf = [&](const SkinParams& params, double& tilt, double& height) {
        const Mesh mesh = skinFrame(slab, params).mesh;
        double area = 0;
        tilt = height = 0;
        for (const Triangle& t : mesh.triangles) {
            const Vec3 &a = mesh.position[t[0]], &b = mesh.position[t[1]], &c = mesh.position[t[2]];
            const Vec3 middle = (a + b + c) / 3, normal = cross(b - a, c - a);
            const double size = normal.length();
            if (middle.z > 0.5 || std::min(middle.x, middle.y) < 3 || std::max(middle.x, middle.y) > 26) continue;
            const double angle = std::acos(std::clamp(-normal.z / size, -1.0, 1.0));
            tilt += size > 0 ? angle * angle * size : 0;
            area += size;
            for (const Vec3& p : {a, b, c}) height = std::max(height, std::abs(p.z + 0.5));
        }
        tilt = std::sqrt(tilt / area) * 180 / std::numbers::pi;
        return mesh;
    };
    double tilt, height, free_tilt, free_height;
    const Mesh mesh = bottomOf(withWalls({{Vec3(0, 0, -1), 0.5}}), tilt, height);
    const Mesh free = bottomOf(withWalls({}), free_tilt, free_height);
    EXPECT_LE(height, 0.01);  // few particles leave the surface more than 0.5 away
    EXPECT_LE(tilt, 0.25);
    EXPECT_GE(free_height, 0.05);
    EXPECT_GE(free_tilt, 1);
    ASSERT_EQ(mesh.triangles, free.triangles);
    for (std::size_t v = 0; v < free.position.size(); ++v)
        if (std::abs(free.position[v].z + 0.5) > 2) {
            EXPECT_EQ(mesh.position[v], free.position[v]);
        }
}

TEST(Walls, LeaveEveryCloudClosedWithoutCrossings) {
    forEveryCloud(60, [](const Cloud& cloud) {
        if (cloud.particles.size() > 1000 || cloud.particles.size() == 0) return;
        Vec3 low(cloud.particles.position[0]), middle(0);
        for (const Vec3f& p : cloud.particles.position) {
            for (int k = 0; k < 3; ++k) low[k] = std::min(low[k], static_cast<double>(p[k]));
            middle += Vec3(p) / static_cast<double>(cloud.particles.size());
        }
        const double spacing = cloud.radius / 1.5;
        const Vec3 slope = Vec3(1, 2, 3).normalized();
        // Below all particles, through their middle and at a slope.
        const std::vector<Wall> walls{
            {Vec3(-1, 0, 0), -low.x}, {Vec3(0, -1, 0), -low.y + 0.5 * spacing}, {slope, dot(slope, middle)}};
        const Mesh mesh = skinFrame(cloud.particles, withWalls(walls, spacing)).mesh;
        EXPECT_EQ(faultsOf(checkMesh(mesh)), std::vector<std::string_view>{});
        for (std::size_t v = 0; v < mesh.position.size(); ++v) {
            ASSERT_TRUE(std::isfinite(mesh.position[v].length2()));
            ASSERT_TRUE(mesh.velocity.empty() || std::isfinite(mesh.velocity[v].length2()));
        }
    });
}

TEST(Walls, KeepTheOrderOfDistancesAndMoveVelocitiesAlong) {
    const Wall wall{Vec3(2, -1, 2) / 3, 0.7};
    double last = -1e9;
    for (double distance = -3; distance <= 3; distance += 0.001) {
        const DualVec3 point{wall.normal * (wall.offset - distance) + Vec3(1, 2, 0), Vec3(0.3, -0.2, 0.5)};
        const DualVec3 laid = laidAgainst(wall, 1.1, point);
        const double after = dot(wall.normal, laid.position);
        EXPECT_GT(-after, last);
        last = -after;
        constexpr double kStep = 1e-6;
        const DualVec3 later = laidAgainst(wall, 1.1, {point.position + point.velocity * kStep, point.velocity});
        EXPECT_NEAR(((later.position - laid.position) / kStep - laid.velocity).length(), 0, 1e-5);
        const double off = (wall.offset - dot(wall.normal, point.position)) / 1.1;
        EXPECT_TRUE(std::abs(off) <= 1.25 || laid.position == point.position);
        EXPECT_TRUE(std::abs(off) >= 0.5 || std::abs(wall.offset - after) <= 0.0051 * 1.1);
    }
}

TEST(Walls, LeaveTheSurfaceContinuousInTime) {
    for (unsigned seed = 1; seed <= 6; ++seed) {
        const Particles before = jittered(8, 8, 4, seed);
        constexpr double kStep = 1e-4;
        Particles after = before;
        for (std::size_t i = 0; i < after.size(); ++i)
            after.position[i] += after.velocity[i] * static_cast<float>(kStep);
        const auto jump = [&](const SkinParams& params) {
            const Mesh from = skinFrame(before, params).mesh, to = skinFrame(after, params).mesh;
            return surfaceDistance(from, to).max;
        };
        // The displacement grows at most 2.25 times as fast as the distance.
        EXPECT_LE(jump(withWalls({{Vec3(0, 0, -1), 0.4}, {Vec3(1, 0, 0), 7.2}})), 3 * jump(withWalls({})) + 2 * kStep);
    }
}

TEST(Walls, OfAnotherSurfaceOrWithoutDirectionAreAnError) {
    const Particles block = jittered(3, 3, 3, 1);
    SkinParams params = withWalls({{Vec3(0, 1, 0), 0}});
    params.tessellation = Tessellation::paper;
    EXPECT_THROW(skinFrame(block, params), Error);
    EXPECT_THROW(skinFrame(block, withWalls({{Vec3(0, 2, 0), 0}})), Error);
    EXPECT_THROW(skinFrame(block, withWalls({{Vec3(0, 1, 0), std::nan("")}})), Error);
}

}  // namespace
}  // namespace betamesh
