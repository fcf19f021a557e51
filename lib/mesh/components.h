// Connected components of a triangle mesh.

#pragma once

#include "base/index.h"
#include "betamesh/mesh.h"

#include <limits>
#include <span>

namespace betamesh {

/// Connected components, numbered in the order of their first vertices. Triangles are connected by shared vertices.
struct Components {
    std::vector<std::uint32_t> of_vertex;  ///< component of each vertex; kInvalidIndex where no triangle uses it
    std::uint32_t count = 0;
};

/// in      triangles whose vertices exist
Components componentsOf(std::size_t vertices, std::span<const Triangle> triangles);

/// Signed volume of the tetrahedron of the origin and a triangle; negative where the triangle faces the origin. The sum
/// over a closed mesh is the volume that it encloses. World units cubed.
inline double volumeBelow(const Vec3& a, const Vec3& b, const Vec3& c) { return dot(a, cross(b, c)) / 6; }

}  // namespace betamesh
