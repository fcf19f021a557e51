// A triangle mesh and the spheres that stand beside it. Row i of every array is vertex i or sphere i.

#pragma once

#include "betamesh/particles.h"

#include <array>
#include <optional>

namespace betamesh {

/// Three vertices, counter-clockwise seen from outside the liquid.
using Triangle = std::array<std::uint32_t, 3>;

/// Lengths in world units, time in seconds.
/// position has n rows; velocity has n rows or none; every attribute has n rows; component, where there is one, has
/// a row for each triangle.
struct Mesh {
    std::vector<Vec3> position;
    std::vector<Vec3> velocity;  ///< world units per second
    std::vector<Triangle> triangles;
    std::vector<Attribute> attributes;
    std::optional<std::vector<std::int32_t>> component{};  ///< the connected piece that each triangle belongs to
};

/// Points with a radius: what the paper calls external beta vertices.
/// Every array has n rows, save velocity and id, which may have none.
struct Spheres {
    std::vector<Vec3> position;
    std::vector<Vec3> velocity;  ///< world units per second
    std::vector<float> radius;   ///< world units
    std::vector<std::uint64_t> id;

    std::size_t size() const { return position.size(); }
};

}  // namespace betamesh
