// Vertex normals: angle-weighted means of the normals of incident triangles.

#pragma once

#include "base/parallel.h"
#include "betamesh/mesh.h"

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <span>
#include <utility>

namespace betamesh {

/// Corner positions of a batch of triangles.
inline constexpr std::size_t kTrianglesAtOnce = 64;
using TriangleCorners = std::array<std::array<std::array<double, kTrianglesAtOnce>, 3>, 3>;  ///< [corner][axis]

/// What a triangle contributes to the normals of its corners: its normal, weighted by the angle at the corner. Slivers
/// count less, with the square of their height: some are so narrow that their normals are arbitrary.
struct CornerNormals {
    Vec3f normal;                 ///< unit length; zero for degenerate triangles
    std::array<float, 3> weight;  ///< radians, error below 1e-7
};

/// Computes `normals` of the first `count` triangles of a batch.
void cornerNormals(const TriangleCorners& at, std::size_t count, CornerNormals* normals);

/// Angle-weighted normals, almost without slivers. Unlike other means they do not depend on how planar polygons are
/// triangulated, unless into slivers. Unit vectors; zero for vertices without triangles, or with slivers of no width
/// alone.
///
/// in      positionOf(v): position of vertex v < vertices
/// same    result for any thread count and instruction set
template <typename PositionOf>
std::vector<Vec3> vertexNormals(std::size_t vertices, std::span<const Triangle> triangles,
                                const PositionOf& positionOf) {
    constexpr std::size_t kTrianglesPerBlock = 64 * kTrianglesAtOnce;
    struct Block {
        std::span<const Triangle> triangles;
        std::unique_ptr<CornerNormals[]> corners;
    };
    std::size_t next = 0;
    const auto nextBlock = [&]() -> std::optional<std::span<const Triangle>> {
        if (next == triangles.size()) return std::nullopt;
        const std::size_t begin = std::exchange(next, std::min(next + kTrianglesPerBlock, triangles.size()));
        return triangles.subspan(begin, next - begin);
    };
    const auto normalsOf = [&](std::span<const Triangle> of_block) {
        Block block{of_block, std::make_unique_for_overwrite<CornerNormals[]>(of_block.size())};
        TriangleCorners at{};
        for (std::size_t begin = 0; begin < of_block.size(); begin += kTrianglesAtOnce) {
            const std::size_t count = std::min(kTrianglesAtOnce, of_block.size() - begin);
            for (std::size_t i = 0; i < count; ++i)
                for (std::size_t m = 0; m < 3; ++m) {
                    const Vec3& p = positionOf(of_block[begin + i][m]);
                    for (int k = 0; k < 3; ++k) at[m][static_cast<std::size_t>(k)][i] = p[k];
                }
            cornerNormals(at, count, &block.corners[begin]);
        }
        return block;
    };
    std::vector<Vec3> normals(vertices, Vec3(0, 0, 0));
    parallelInOrder(nextBlock, normalsOf, [&](Block&& block) {
        for (std::size_t i = 0; i < block.triangles.size(); ++i)
            for (std::size_t m = 0; m < 3; ++m)
                normals[block.triangles[i][m]] += Vec3(block.corners[i].normal * block.corners[i].weight[m]);
    });
    parallelFor(vertices, 4096, [&](std::size_t v) { normals[v].normalize(); });
    return normals;
}

}  // namespace betamesh
