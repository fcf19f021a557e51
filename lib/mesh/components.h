// Connected pieces of a triangle mesh.

#pragma once

#include "betamesh/mesh.h"

#include <limits>
#include <span>

namespace betamesh {

inline constexpr std::uint32_t kNoPiece = std::numeric_limits<std::uint32_t>::max();

/// Groups of triangles that share no vertex.
struct Pieces {
    std::vector<std::uint32_t> of_vertex;  ///< kNoPiece where no triangle uses it
    std::uint32_t count = 0;               ///< numbered in the order of their first vertices
};

/// in      triangles of vertices that exist
Pieces piecesOf(std::size_t vertices, std::span<const Triangle> triangles);

/// Between the origin and a triangle, negative where the triangle faces it. World units cubed.
inline double volumeBelow(const Vec3& a, const Vec3& b, const Vec3& c) { return dot(a, cross(b, c)) / 6; }

}  // namespace betamesh
