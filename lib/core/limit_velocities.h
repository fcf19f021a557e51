// How fast a surface may be said to move.

#pragma once

#include "core/moving.h"

#include <vector>

namespace betamesh {

/// Turns the velocities of vertices, which so far follow points of the tessellation, into such as a shutter can be open
/// over. Across a vertex' normal they become the liquid's: that of the rigid motion which fits the balls within reach
/// best, (1 - d²/reach²)⁴ their weight. Along it they stay, as far as these balls leave that motion themselves: up to
/// 0.7 of the root mean square of what they do beside it. So rims and necks that race where balls are about to meet or
/// to part are as fast as the liquid, and where that moves as a rigid body its surface does so exactly.
///
/// in      reach: more than the distance of any vertex to the nearest ball, or the vertex stays as it is; normals of
///         the vertices, zero where there is none
/// same    bytes for any thread count and particle order
/// cost    O(vertices · balls within reach)
void limitVelocities(const std::vector<Moving>& balls, double reach, const std::vector<Vec3>& normals,
                     std::vector<Moving>& vertices);

}  // namespace betamesh
