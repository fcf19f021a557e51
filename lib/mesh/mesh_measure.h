// What measureMesh() and other measures of meshes share.

#pragma once

#include "betamesh/check.h"
#include "mesh/components.h"

namespace betamesh {

/// The triangles whose vertices exist and are within the range of the exact predicates (isInRange).
std::vector<Triangle> measurableTriangles(const Mesh& mesh);

/// Area of a triangle, world units squared.
inline double areaOf(const Vec3& a, const Vec3& b, const Vec3& c) { return cross(b - a, c - a).length() / 2; }

}  // namespace betamesh
