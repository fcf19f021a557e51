// Adjacency of a triangle mesh, found by sorting: triangle sides that share an edge, vertices at the same position.

#pragma once

#include "base/index.h"
#include "betamesh/mesh.h"

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace betamesh {

/// The vertices, of [0, vertices), that triangles use, ascending.
std::vector<std::uint32_t> verticesOf(std::span<const Triangle> triangles, std::size_t vertices);

/// One side of a triangle (a half-edge). Side 3t + m runs from corner m of triangle t to the next corner.
struct TriangleSide {
    std::uint32_t low, high;  ///< its two vertices, low < high
    std::uint32_t side;
    std::int32_t direction;  ///< +1 from low to high, -1 back
};

/// All sides, sorted by edge (low, then high) and then by triangle.
///
/// same    result for any thread count
/// cost    O(triangles) where few triangles share a vertex
std::vector<TriangleSide> sortedSides(std::span<const Triangle> triangles);

/// For each side 3t + m the triangle across its edge, or kInvalidIndex where the edge does not have exactly two
/// triangles. sides: from sortedSides().
std::vector<std::uint32_t> trianglesAcross(const std::vector<TriangleSide>& sides);

/// For each vertex the first vertex at the same position; the vertex itself if its position is not finite.
///
/// same    result for any thread count
/// cost    O(n log n)
std::vector<std::uint32_t> placesOfVertices(const std::vector<Vec3>& position);

/// For sorted sides: one past the last side that belongs to the same edge as side `at`.
inline std::size_t endOfEdge(std::span<const TriangleSide> sides, std::size_t at) {
    const std::size_t first = at;
    while (at < sides.size() && sides[at].low == sides[first].low && sides[at].high == sides[first].high) ++at;
    return at;
}

/// Calls visit(sides) for each edge. sides: from sortedSides().
template <typename Visit>
void forEveryEdge(const std::vector<TriangleSide>& sides, const Visit& visit) {
    for (std::size_t begin = 0, end; begin < sides.size(); begin = end) {
        end = endOfEdge(sides, begin);
        visit(std::span(sides).subspan(begin, end - begin));
    }
}

}  // namespace betamesh
