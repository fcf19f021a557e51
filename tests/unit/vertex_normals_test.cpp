// Properties of vertex normals.

#include "mesh/vertex_normals.h"

#include "base/icosphere.h"
#include "base/random.h"

#include <gtest/gtest.h>

#include <cmath>

namespace betamesh {

namespace {

std::vector<Vec3> normalsOf(const std::vector<Vec3>& position, const std::vector<Triangle>& triangles) {
    return vertexNormals(position.size(), triangles, [&](std::uint32_t v) -> const Vec3& { return position[v]; });
}

// Of triangles that are no slivers.
TEST(VertexNormals, AreAngleWeightedMeans) {
    Random random(1);
    for (const double size : {1e-30, 1e-3, 1.0, 1e12}) {
        std::vector<Vec3> position(300);
        for (Vec3& p : position) p = random.cube() * size;
        std::vector<Triangle> triangles;
        for (std::uint32_t v = 0; v + 7 < position.size(); ++v) {
            const Vec3 u = (position[v + 3] - position[v]) / size, w = (position[v + 7] - position[v]) / size;
            const double longest = std::max({u.length2(), w.length2(), (w - u).length2()});
            if (cross(u, w).length() > 0.21 * longest) triangles.push_back({v, v + 3, v + 7});
        }
        std::vector<Vec3> expected(position.size(), Vec3(0, 0, 0));
        for (const Triangle& t : triangles)
            for (std::size_t m = 0; m < 3; ++m) {
                const Vec3 u = (position[t[(m + 1) % 3]] - position[t[m]]) / size,
                           v = (position[t[(m + 2) % 3]] - position[t[m]]) / size, across = cross(u, v);
                expected[t[m]] += across.normalized() * std::atan2(across.length(), dot(u, v));
            }
        const std::vector<Vec3> normals = normalsOf(position, triangles);
        for (std::size_t v = 0; v < position.size(); ++v)
            EXPECT_LT((normals[v] - expected[v].normalized()).length(), 1e-5);
    }
}

// Two vertices of a plane nearly coincide, and one of them is a little higher: the slivers between them are steep.
TEST(VertexNormals, AreNotTurnedBySlivers) {
    for (const double gap : {1e-2, 1e-3, 1e-4}) {
        const std::vector<Vec3> position{{-1, -1, 0}, {1, -1, 0},         {1, 1, 0},
                                         {-1, 1, 0},  {-gap / 2, 0, gap}, {gap / 2, 0, 0}};
        const std::vector<Triangle> triangles{{0, 4, 3}, {1, 2, 5}, {0, 1, 5}, {0, 5, 4}, {2, 3, 4}, {2, 4, 5}};
        const std::vector<Vec3> normals = normalsOf(position, triangles);
        for (const Vec3& normal : normals) EXPECT_LT((normal - Vec3(0, 0, 1)).length(), 4 * gap) << gap;
    }
}

TEST(VertexNormals, AreTheSameForAnyThreadCount) {
    const Icosphere sphere = icosphere(20);
    std::vector<Vec3> on_one, on_many;
    withThreads(1, [&] { on_one = normalsOf(sphere.position, sphere.triangles); });
    for (const int threads : {2, 3, 8}) {
        withThreads(threads, [&] { on_many = normalsOf(sphere.position, sphere.triangles); });
        EXPECT_EQ(on_many, on_one);
    }
}

TEST(VertexNormals, IgnoreDegenerateTriangles) {
    const std::vector<Vec3> position{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 0, 0}, {5, 5, 5}};
    const std::vector<Vec3> normals = normalsOf(position, {{0, 1, 2}, {0, 1, 3}, {0, 0, 3}, {3, 3, 3}});
    for (const std::size_t v : {0, 1, 2}) EXPECT_EQ(normals[v], Vec3(0, 0, 1));
    for (const std::size_t v : {3, 4}) EXPECT_EQ(normals[v], Vec3(0, 0, 0));
}

}  // namespace

}  // namespace betamesh
