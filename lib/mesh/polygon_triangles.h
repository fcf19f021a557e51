// Triangulation of plane polygons with holes.

#pragma once

#include "base/index.h"
#include "betamesh/mesh.h"

#include <array>
#include <vector>

namespace betamesh {

using PlanePoint = std::array<double, 2>;

/// > 0 if a, b, c turn counter-clockwise, 0 if they are collinear. The sign is exact if the differences of coordinates
/// are, as for coordinates that are floats of similar size.
double orientation(const PlanePoint& a, const PlanePoint& b, const PlanePoint& c);

/// Divides the area that loops bound into triangles whose corners are vertices of the loops. The area lies on the left
/// of the loops: outer ones are counter-clockwise, holes clockwise. Every side of a loop is a side of exactly one
/// triangle, and every other side one of two triangles in opposite directions, whatever the loops: if loops cross, some
/// triangles are inverted or overlap.
///
/// in      loops: rows of `point`, each row in at most one loop, at least three in a loop
/// out     triangles, counter-clockwise
/// cost    O(n²) at worst for n points
/// source  Held 2001, FIST: fast industrial-strength triangulation of polygons
std::vector<Triangle> polygonTriangles(const std::vector<PlanePoint>& point,
                                       const std::vector<std::vector<std::uint32_t>>& loops);

}  // namespace betamesh
