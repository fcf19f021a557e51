// How the triangles round each vertex face.

#pragma once

#include "core/angles.h"
#include "core/mesh.h"
#include "core/parallel.h"

#include <algorithm>
#include <array>
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
        for (std::size_t m = 0; m < 3; ++m) {
            const Vec3& at = positionOf(t[m]);
            const Vec3 u = positionOf(t[(m + 1) % 3]) - at, v = positionOf(t[(m + 2) % 3]) - at;
            const Vec3 across = cross(u, v);
            const double doubled_area = across.length();
            corners[i].angle[m] = static_cast<float>(angleOf(doubled_area, dot(u, v)));
            corners[i].normal = doubled_area > 0 ? Vec3f(across / doubled_area) : Vec3f(0, 0, 0);
        }
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
