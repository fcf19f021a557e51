// The unit sphere as a subdivided icosahedron.

#pragma once

#include "betamesh/mesh.h"

namespace betamesh {

struct Icosphere {
    std::vector<Vec3> position;
    std::vector<Triangle> triangles;  ///< counter-clockwise seen from outside
};

/// The icosphere whose icosahedron edges are divided into `cuts` >= 1 segments: 20 cuts² triangles, 10 cuts² + 2
/// vertices.
Icosphere icosphere(std::uint32_t cuts);
/// The coarsest icosphere whose edges subtend at most about `angle` radians.
Icosphere icosphereOf(double angle);

/// Directions as one array per axis, padded with copies of the last one to a multiple of kLanes.
struct DirectionColumns {
    std::vector<float> x, y, z;

    explicit DirectionColumns(const std::vector<Vec3>& directions);
    std::size_t size() const { return x.size(); }
};

}  // namespace betamesh
