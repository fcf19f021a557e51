// Edges of a convex surface that are about to give way to the other diagonal of their two triangles.

#pragma once

#include "base/dual.h"
#include "betamesh/mesh.h"

#include <optional>
#include <vector>

namespace betamesh {

/// Four points of a hull that come to lie in one plane: its edge then gives way to the other diagonal, and the hull
/// does not jump. What smoothing makes of them does not lie in one plane. So there is a vertex where the diagonals pass
/// each other: on the edge at first, half-way to the other diagonal when they meet, which is the same seen from either
/// side.
struct EdgeFlip {
    std::array<std::uint32_t, 4> corner;    ///< the edge, and the ends of the other diagonal
    std::array<std::uint32_t, 2> triangle;  ///< on either side
    std::array<Dual, 4> weight;             ///< of the corners in the vertex; they sum to 1
    DualVec3 on_edge;                         ///< where the vertex is before anything is smoothed

    double shareOfOther() const { return weight[2].value + weight[3].value; }
};

/// Do the lines through a, b and through c, d pass each other within `farthest`?
inline bool passNear(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, double farthest) {
    const Vec3 normal = cross(b - a, d - c);
    const double volume = dot(c - a, normal);
    return volume * volume < farthest * farthest * normal.length2();
}

/// at: the edge's ends and those of the other diagonal; farthest: from each other that these pass as the vertex
/// appears. None where they pass further apart, or outside the quad. Corners and triangles are left to the caller.
std::optional<EdgeFlip> edgeFlip(const std::array<DualVec3, 4>& at, double farthest);

/// Splits both triangles of each edge at its vertex, those edges first that are closest to turning: a triangle with
/// several then changes continuously. Triangles of an edge are numbered from `first` on, corners as in the triangles.
/// The vertices are numbered from `first_vertex` on, in the order of the edges.
void splitFlippingEdges(std::vector<EdgeFlip>& edges, std::size_t first, std::uint32_t first_vertex,
                       std::vector<Triangle>& triangles);

}  // namespace betamesh
