// Connected pieces of a triangle mesh.

#pragma once

#include "base/index.h"
#include "betamesh/mesh.h"

#include <limits>
#include <span>

namespace betamesh {


/// Groups of triangles that share no vertex.
struct Components {
    std::vector<std::uint32_t> of_vertex;  ///< kInvalidIndex where no triangle uses it
    std::uint32_t count = 0;               ///< numbered in the order of their first vertices
};

/// in      triangles of vertices that exist
Components componentsOf(std::size_t vertices, std::span<const Triangle> triangles);

/// Between the origin and a triangle, negative where the triangle faces it. World units cubed.
inline double volumeBelow(const Vec3& a, const Vec3& b, const Vec3& c) { return dot(a, cross(b, c)) / 6; }

}  // namespace betamesh
