// How the triangles round each vertex face.

#pragma once

#include "core/mesh.h"
#include "core/parallel.h"

#include <algorithm>
#include <array>
#include <memory>
#include <span>

namespace betamesh {

/// Corners of triangles, some at a time.
inline constexpr std::size_t kTrianglesAtOnce = 64;
using TriangleCorners = std::array<std::array<std::array<double, kTrianglesAtOnce>, 3>, 3>;  ///< [corner][axis]

/// What a triangle adds to the normals of its corners: its own, times the angle there.
struct CornerNormals {
    Vec3f normal;                ///< of unit length; zero without area
    std::array<float, 3> angle;  ///< radians, to 1e-7
};

/// Of the first `count` triangles.
void cornerNormals(const TriangleCorners& at, std::size_t count, CornerNormals* normals);

/// Means weighted by the angles of the triangles there: the one mean that does not change when a plane polygon is
/// triangulated in another way. Unit vectors; zero for vertices without triangles.
///
/// in      positionOf(v): where vertex v < vertices is
/// same    result for any thread count and instruction set
template <typename PositionOf>
std::vector<Vec3> vertexNormals(std::size_t vertices, std::span<const Triangle> triangles,
                                const PositionOf& positionOf) {
    constexpr std::size_t kBlock = 1024 * kTrianglesAtOnce;  // what is known of one stays in the cache
    const std::size_t triangle_count = triangles.size();
    const auto corners = std::make_unique_for_overwrite<CornerNormals[]>(std::min(kBlock, triangle_count));
    std::vector<Vec3> normals(vertices, Vec3(0, 0, 0));
    for (std::size_t block = 0; block < triangle_count; block += kBlock) {
        const std::span<const Triangle> part = triangles.subspan(block, std::min(kBlock, triangle_count - block));
        parallelRanges((part.size() + kTrianglesAtOnce - 1) / kTrianglesAtOnce, 16,
                       [&](std::size_t first, std::size_t last) {
                           TriangleCorners at{};
                           for (std::size_t begin = first * kTrianglesAtOnce; begin < last * kTrianglesAtOnce;
                                begin += kTrianglesAtOnce) {
                               const std::size_t count = std::min(kTrianglesAtOnce, part.size() - begin);
                               for (std::size_t i = 0; i < count; ++i)
                                   for (std::size_t m = 0; m < 3; ++m) {
                                       const Vec3& p = positionOf(part[begin + i][m]);
                                       for (int k = 0; k < 3; ++k) at[m][static_cast<std::size_t>(k)][i] = p[k];
                                   }
                               cornerNormals(at, count, &corners[begin]);
                           }
                       });
        parallelShares(vertices, [&](std::size_t, std::size_t begin, std::size_t end) {
            for (std::size_t i = 0; i < part.size(); ++i)
                for (std::size_t m = 0; m < 3; ++m)
                    if (const std::uint32_t v = part[i][m]; v >= begin && v < end)
                        normals[v] += Vec3(corners[i].normal * corners[i].angle[m]);
        });
    }
    parallelFor(vertices, 4096, [&](std::size_t v) { normals[v].normalize(); });
    return normals;
}

}  // namespace betamesh
