// The unit sphere as a subdivided icosahedron.

#pragma once

#include "betamesh/mesh.h"

namespace betamesh {

struct Icosphere {
    std::vector<Vec3> position;
    std::vector<Triangle> triangles;  ///< counter-clockwise seen from outside
};

/// Every edge of the icosahedron is cut into `cuts` >= 1 pieces: 20 cuts² triangles, 10 cuts² + 2 vertices.
Icosphere icosphere(std::uint32_t cuts);
/// Whose edges are at most this many radians long, about.
Icosphere icosphereOf(double angle);

/// Directions by column, filled up to whole registers with the last one.
struct DirectionColumns {
    std::vector<float> x, y, z;

    explicit DirectionColumns(const std::vector<Vec3>& directions);
    std::size_t size() const { return x.size(); }
};

}  // namespace betamesh
