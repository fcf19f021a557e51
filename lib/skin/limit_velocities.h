// Vertex velocities for motion blur, bounded by the motion of the liquid.

#pragma once

#include "base/dual.h"

#include <vector>

namespace betamesh {

/// Replaces velocities of vertices, which so far follow points of the tessellation, by ones that hold over a shutter.
/// The tangential part becomes that of the rigid motion which fits the balls within reach best, with weights
/// (1 - d²/reach²)⁴. The normal part keeps its difference from that motion, limited to 0.7 of the root mean square of
/// the balls' own differences. So rims and necks that race at the instant where balls are about to meet or to part are
/// no faster than the liquid, and where the liquid moves as a rigid body its surface does so exactly.
///
/// in      reach: more than the distance of any vertex to the nearest ball, or the vertex stays as it is; normals of
///         the vertices, zero where there is none
/// same    bytes for any thread count and particle order
/// cost    O(vertices · balls within reach)
void limitVelocities(const std::vector<DualVec3>& balls, double reach, const std::vector<Vec3>& normals,
                     std::vector<DualVec3>& vertices);

}  // namespace betamesh
