// How the triangles round each vertex face.

#pragma once

#include "core/angles.h"
#include "core/mesh.h"
#include "core/parallel.h"

#include <algorithm>
#include <array>
#include <numbers>
#include <span>

namespace betamesh {

/// Means weighted by the angles of the triangles there: the one mean that does not change when a plane polygon is
/// triangulated in another way. Unit vectors; zero for vertices without triangles.
///
/// in      positionOf(v): where vertex v < vertices is
/// same    result for any thread count
template <typename PositionOf>
std::vector<Vec3> vertexNormals(std::size_t vertices, std::span<const Triangle> triangles,
                                const PositionOf& positionOf) {
    struct Corners {
        Vec3f normal;  // of the triangle
        std::array<float, 3> angle;
    };
    std::vector<Corners> corners(triangles.size());
    parallelFor(corners.size(), 1024, [&](std::size_t i) {
        const Triangle& t = triangles[i];
        const Vec3 &a = positionOf(t[0]), &b = positionOf(t[1]), &c = positionOf(t[2]);
        const Vec3 ab = b - a, bc = c - b, ca = a - c, across = cross(ab, bc);
        const double doubled_area = across.length();
        const double at_a = angleOf(doubled_area, -dot(ca, ab)), at_b = angleOf(doubled_area, -dot(ab, bc));
        corners[i].angle = {static_cast<float>(at_a), static_cast<float>(at_b),
                            static_cast<float>(std::numbers::pi - at_a - at_b)};
        corners[i].normal = doubled_area > 0 ? Vec3f(across / doubled_area) : Vec3f(0, 0, 0);
    });
    // Every task goes through all triangles and adds up what is at its vertices: always in the same order.
    constexpr std::size_t kTasks = 8;
    std::vector<Vec3> normals(vertices, Vec3(0, 0, 0));
    parallelRanges(normals.size(), std::max<std::size_t>(normals.size() / kTasks, 4096),
                   [&](std::size_t begin, std::size_t end) {
                       for (std::size_t i = 0; i < corners.size(); ++i)
                           for (std::size_t m = 0; m < 3; ++m)
                               if (const std::uint32_t v = triangles[i][m]; v >= begin && v < end)
                                   normals[v] += Vec3(corners[i].normal * corners[i].angle[m]);
                       for (std::size_t v = begin; v < end; ++v) normals[v].normalize();
                   });
    return normals;
}

}  // namespace betamesh
