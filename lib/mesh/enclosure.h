// Which points does a mesh enclose?

#pragma once

#include "betamesh/mesh.h"

namespace betamesh {

/// How far each point is outside: 0 where the mesh encloses it, where it lies on the surface, or within one of
/// the spheres beside it; else the distance to the nearest triangle, infinite where there is none. Enclosed
/// means that the winding number is positive (negative for meshes whose volume is); that is decided exactly.
///
/// in      any mesh: triangles with missing vertices or positions that are not finite are left out; finite points
/// same    result for any thread count
/// cost    for each point O(triangles above it + log triangles), more where it is far outside
std::vector<double> distancesOutside(const Mesh& mesh, const Spheres& beside, const std::vector<Vec3>& points);

}  // namespace betamesh
