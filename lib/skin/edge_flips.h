// Edge flips in progress: edges of a convex surface that are about to be replaced by the other diagonal of their quad.

#pragma once

#include "base/dual.h"
#include "betamesh/mesh.h"

#include <optional>
#include <vector>

namespace betamesh {

/// When four points of a hull become coplanar, its edge is replaced by the other diagonal of the quad. The hull itself
/// does not jump then, but its smoothed image, whose four points are not coplanar, would. So while the flip is in
/// progress a vertex stands where the diagonals pass each other: on the edge at first, half-way to the other diagonal
/// when the two meet, which is the same from either side.
struct EdgeFlip {
    std::array<std::uint32_t, 4> corner;    ///< ends of the edge, then of the other diagonal
    std::array<std::uint32_t, 2> triangle;  ///< on either side of the edge
    std::array<Dual, 4> weight;             ///< of the corners in the vertex; they sum to 1
    DualVec3 on_edge;                       ///< position of the vertex before any smoothing
    Dual remoteness;  ///< 0 where the diagonals meet, far from their ends; 1 where the flip begins

    /// Weight of the other diagonal, 0 to 0.5: how far the flip has progressed.
    double otherWeight() const { return weight[2].value + weight[3].value; }
};

/// Is the distance between the line through a, b and that through c, d less than `farthest`?
inline bool passNear(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, double farthest) {
    const Vec3 normal = cross(b - a, d - c);
    const double volume = dot(c - a, normal);
    return volume * volume < farthest * farthest * normal.length2();
}

/// The flip in progress of the edge from at[0] to at[1], whose quad has the other diagonal from at[2] to at[3]. None if
/// the diagonals are `farthest` or more apart, or pass each other outside the quad. The caller sets corner and
/// triangle.
std::optional<EdgeFlip> edgeFlip(const std::array<DualVec3, 4>& at, double farthest);

/// Keeps of several flips with a triangle in common the least remote one, and removes the others: each changes the
/// quads of the others when it happens. So that flips change continuously nevertheless, the weight of the other
/// diagonal grows from 0, where a second flip is as remote.
void keepNearestFlips(std::vector<EdgeFlip>& edges);

/// Splits both triangles of each edge at its vertex; no two edges have a triangle in common. EdgeFlip::triangle counts
/// from row `first` of the triangles on; the vertices get numbers from `first_vertex` on.
void splitFlippingEdges(const std::vector<EdgeFlip>& edges, std::size_t first, std::uint32_t first_vertex,
                        std::vector<Triangle>& triangles);

}  // namespace betamesh
