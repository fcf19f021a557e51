// A triangle mesh, and spheres for particles that are not part of the mesh.

#pragma once

#include "betamesh/particles.h"

#include <array>
#include <optional>

namespace betamesh {

/// Three vertices, counter-clockwise seen from outside the liquid.
using Triangle = std::array<std::uint32_t, 3>;

/// Row i of position, velocity and every attribute is vertex i. Lengths in world units, time in seconds.
/// position has n rows; velocity has n rows or none; every attribute has n rows; component, if present, has one row per
/// triangle.
struct Mesh {
    std::vector<Vec3> position;
    std::vector<Vec3> velocity;  ///< world units per second
    std::vector<Triangle> triangles;
    std::vector<Attribute> attributes;                     ///< of vertices
    std::optional<std::vector<std::int32_t>> component{};  ///< connected component of each triangle
};

/// Points with a radius; the paper calls them external beta vertices. Row i of every array is sphere i.
/// Every array has n rows, except velocity, id and particle, which may be empty.
struct Spheres {
    std::vector<Vec3> position;
    std::vector<Vec3> velocity;  ///< world units per second
    std::vector<float> radius;   ///< world units
    std::vector<std::uint64_t> id;
    std::vector<std::uint32_t> particle{};  ///< row of the particle that the sphere stands for
    std::vector<Attribute> attributes{};    ///< requested attributes of these particles

    /// Number of spheres.
    std::size_t size() const { return position.size(); }
};

}  // namespace betamesh
