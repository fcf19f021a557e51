// Which parts of a triangle mesh meet: sides of triangles in an edge, vertices in a place. Found by sorting.

#pragma once

#include "base/index.h"
#include "betamesh/mesh.h"

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace betamesh {


/// Those of so many vertices that are corners of triangles, ascending.
std::vector<std::uint32_t> verticesOf(std::span<const Triangle> triangles, std::size_t vertices);

/// One side of a triangle: side 3t + m runs from corner m of triangle t to the next one.
struct TriangleSide {
    std::uint32_t low, high;  ///< its two vertices
    std::uint32_t side;
    std::int32_t direction;  ///< +1 from low to high, -1 back
};

/// All sides, those of one edge next to each other, in the order of their triangles.
///
/// same    result for any thread count
/// cost    O(triangles) where few triangles share a vertex
std::vector<TriangleSide> sortedSides(std::span<const Triangle> triangles);

/// Of each side 3t + m, the triangle beyond it, or kInvalidIndex where not exactly two meet at the edge. sides: sorted.
std::vector<std::uint32_t> trianglesAcross(const std::vector<TriangleSide>& sides);

/// Of each vertex, the first vertex at the same position; itself where the position is not finite.
///
/// same    result for any thread count
/// cost    O(n log n)
std::vector<std::uint32_t> placesOfVertices(const std::vector<Vec3>& position);

/// Where, from one of sorted sides on, those of the same edge end.
inline std::size_t endOfEdge(std::span<const TriangleSide> sides, std::size_t at) {
    const std::size_t first = at;
    while (at < sides.size() && sides[at].low == sides[first].low && sides[at].high == sides[first].high) ++at;
    return at;
}

/// Calls visit(sides) for each edge.
template <typename Visit>
void forEveryEdge(const std::vector<TriangleSide>& sides, const Visit& visit) {
    for (std::size_t begin = 0, end; begin < sides.size(); begin = end) {
        end = endOfEdge(sides, begin);
        visit(std::span(sides).subspan(begin, end - begin));
    }
}

}  // namespace betamesh
