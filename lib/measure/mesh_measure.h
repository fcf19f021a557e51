// What a mesh is, in numbers.

#pragma once

#include "core/mesh.h"

#include <limits>
#include <span>

namespace betamesh {

struct MeshMeasure {
    std::size_t components = 0;      ///< pieces that share no vertex
    std::int64_t euler = 0;          ///< used vertices - edges + triangles
    double volume = 0;               ///< enclosed, world units cubed; meaningful for closed meshes
    double area = 0;                 ///< world units squared
    std::size_t unpaired_edges = 0;  ///< directed edges used more often than their opposites; 0 when closed
};

/// same    result for any thread count
/// cost    O(triangles log triangles)
MeshMeasure measureMesh(const Mesh& mesh);

inline constexpr std::uint32_t kNoPiece = std::numeric_limits<std::uint32_t>::max();

/// Groups of triangles that share no vertex.
struct Pieces {
    std::vector<std::uint32_t> of_vertex;  ///< kNoPiece where no triangle uses it
    std::uint32_t count = 0;               ///< numbered in the order of their first vertices
};

/// in      triangles of vertices that exist
Pieces piecesOf(std::size_t vertices, std::span<const Triangle> triangles);

/// World units squared.
inline double areaOf(const Vec3& a, const Vec3& b, const Vec3& c) { return cross(b - a, c - a).length() / 2; }

/// Between the origin and a triangle, negative where the triangle faces it. World units cubed.
inline double volumeBelow(const Vec3& a, const Vec3& b, const Vec3& c) { return dot(a, cross(b, c)) / 6; }

}  // namespace betamesh
