// Connected components of a triangle mesh.

#pragma once

#include "base/index.h"
#include "betamesh/mesh.h"

#include <limits>
#include <span>
#include <vector>

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
inline double signedVolume(const Vec3& a, const Vec3& b, const Vec3& c) { return dot(a, cross(b, c)) / 6; }

/// Volume enclosed by each component, world units cubed; negative if it faces inwards. positionOf(vertex)
template <typename PositionOf>
std::vector<double> enclosedVolumes(const Components& components, std::span<const Triangle> triangles,
                                    const PositionOf& positionOf) {
    std::vector<double> volume(components.count, 0);
    std::vector<std::uint32_t> origin(components.count, kInvalidIndex);
    for (const Triangle& t : triangles) {
        const std::uint32_t component = components.of_vertex[t[0]];
        if (origin[component] == kInvalidIndex) origin[component] = t[0];
        const Vec3 o = positionOf(origin[component]);
        volume[component] += signedVolume(positionOf(t[0]) - o, positionOf(t[1]) - o, positionOf(t[2]) - o);
    }
    return volume;
}

}  // namespace betamesh
