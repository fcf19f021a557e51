// Properties of meshes that are cut off at a box.

#include "mesh/clip_mesh.h"

#include "betamesh/check.h"
#include "betamesh/error.h"
#include "betamesh/skin.h"
#include "mesh/polygon_triangles.h"
#include "support/clouds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace betamesh {
namespace {

double roundedToFloat(double x) { return static_cast<double>(static_cast<float>(x)); }

TEST(ClipMesh, LeavesEveryCloudClosedAndInTheBox) {
    std::uint64_t seed = 0;
    std::size_t meshes = 0, crossing = 0;
    forEveryCloud(120, [&](const Cloud& cloud) {
        if (cloud.particles.size() > 1000) return;
        SkinParams params;
        params.radius = cloud.radius;
        const Mesh mesh = skinFrame(cloud.particles, params).mesh;
        if (mesh.position.empty()) return;
        Vec3 low = mesh.position[0], high = low;
        for (const Vec3& p : mesh.position)
            for (int k = 0; k < 3; ++k) low[k] = std::min(low[k], p[k]), high[k] = std::max(high[k], p[k]);
        std::mt19937 random(seed++);
        std::uniform_real_distribution<double> share(0, 0.45);
        const Vec3 size = high - low;
        for (int k = 0; k < 3; ++k) {
            low[k] = roundedToFloat(low[k] + size[k] * share(random));
            high[k] = roundedToFloat(high[k] - size[k] * share(random));
        }
        const Mesh clipped = clippedToBox(mesh, low, high);
        for (const Vec3& p : clipped.position)
            for (int k = 0; k < 3; ++k) {
                ASSERT_GE(p[k], low[k]);
                ASSERT_LE(p[k], high[k]);
            }
        const MeshCheck check = checkMesh(clipped);
        EXPECT_FALSE(check.open_edges || check.misoriented_edges || check.nonmanifold_edges);
        crossing += check.crossings.count > 0;
        ++meshes;
        EXPECT_LE(measureMesh(clipped).volume, measureMesh(mesh).volume * (1 + 1e-6));
    });
    EXPECT_GT(meshes, 200U);
    EXPECT_LE(crossing, meshes / 100);  // on lattices, cut slivers within a rounding of each other
}

TEST(ClipMesh, OfABlockIsABoxWithInterpolatedColumns) {
    Particles block;
    for (int i = 0; i < 1000; ++i) {
        const Vec3 p(i % 10, i / 10 % 10, i / 100);
        block.position.emplace_back(p);
        block.velocity.emplace_back(p * 2);
    }
    block.attributes = {{"x", 1, {}, {}}, {"row", 1, {}, {}}};
    for (std::size_t i = 0; i < block.size(); ++i) {
        block.attributes[0].real.push_back(block.position[i].x);
        block.attributes[1].integer.push_back(static_cast<std::int32_t>(i));
    }
    SkinParams params;
    params.radius = 1.5;
    params.spacing = 1;
    params.attributes = {"x", "row"};
    params.surface_attributes.thickness = true;
    params.surface_attributes.normals = true;
    params.components = true;
    params.features.droplets = Droplets::points;
    block.position[0] = Vec3f(-20, 0, 0);  // becomes a sphere, which is outside
    params.box = Box(Vec3(2.25, 3, -5), Vec3(7.5, 20, 4.125));
    const SkinnedFrame frame = skinFrame(block, params);
    const Mesh& mesh = frame.mesh;
    EXPECT_EQ(frame.spheres.size(), 0U);
    EXPECT_EQ(faultsOf(checkMesh(mesh)), std::vector<std::string_view>{});
    const auto volumeBetween = [&](double low, double high) {
        SkinParams part = params;
        part.box->min.x = low, part.box->max.x = high;
        return measureMesh(skinFrame(block, part).mesh).volume;
    };
    EXPECT_NEAR(measureMesh(mesh).volume / (5.25 * (9.55 - 3) * (4.125 + 0.55)), 1, 0.04);  // with rounded edges
    EXPECT_NEAR(volumeBetween(2.25, 4.375) + volumeBetween(4.375, 7.5), measureMesh(mesh).volume, 1e-4);
    ASSERT_EQ(mesh.component->size(), mesh.triangles.size());
    ASSERT_EQ(mesh.velocity.size(), mesh.position.size());
    ASSERT_EQ(mesh.attributes.size(), 4U);
    for (const Attribute& column : mesh.attributes) {
        ASSERT_EQ(column.real.size() + column.integer.size(), mesh.position.size() * column.components);
        if (column.name != "N") continue;
        for (std::size_t i = 0; i < column.real.size(); i += 3)
            EXPECT_NEAR(Vec3f(column.real[i], column.real[i + 1], column.real[i + 2]).length(), 1, 1e-5);
    }
    std::size_t on_face = 0;
    for (std::size_t v = 0; v < mesh.position.size(); ++v) {
        EXPECT_NEAR(static_cast<double>(mesh.attributes[0].real[v]), mesh.position[v].x, 1.6);
        on_face += mesh.position[v].x == 2.25 || mesh.position[v].x == 7.5;
    }
    EXPECT_GT(on_face, 20U);

    params.tessellation = Tessellation::paper;
    EXPECT_THROW(skinFrame(block, params), Error);
    params.tessellation = Tessellation::complete;
    params.box = Box(Vec3(1, 0, 0), Vec3(1, 2, 2));
    EXPECT_THROW(skinFrame(block, params), Error);
    params.box = Box(Vec3(100, 0, 0), Vec3(102, 2, 2));
    EXPECT_TRUE(skinFrame(block, params).mesh.position.empty());
}

TEST(PolygonTriangles, FillASquareWithHoles) {
    const std::vector<PlanePoint> point{{0, 0}, {9, 0}, {9, 9}, {0, 9}, {1, 1}, {1, 2},
                                        {2, 2}, {2, 1}, {5, 5}, {5, 7}, {7, 7}, {7, 5}};
    const std::vector<Triangle> triangles = polygonTriangles(point, {{0, 1, 2, 3}, {4, 5, 6, 7}, {8, 9, 10, 11}});
    EXPECT_EQ(triangles.size(), 14U);
    double area = 0;
    for (const auto& [a, b, c] : triangles) {
        EXPECT_GT(orientation(point[a], point[b], point[c]), 0);
        area += orientation(point[a], point[b], point[c]) / 2;
    }
    EXPECT_NEAR(area, 81 - 1 - 4, 1e-12);
}

}  // namespace
}  // namespace betamesh
