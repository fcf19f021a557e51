// The ball boundary -> points inside its faces.

#pragma once

#include "core/ball_boundary.h"
#include "core/face_points.h"
#include "exact/snapped_particles.h"

namespace betamesh {

/// Those of fixed directions, about `angle` radians apart, that are exposed on each ball, and those towards other balls
/// less than 0.1 radii away. Their clearance changes as that of points which move with the liquid.
///
/// in      a boundary; its balls with their motion and angular velocity; angle in (0, 1]
/// same    result for any thread count and particle order
/// cost    O(balls · directions + points · neighbours)
FacePoints facePoints(const SnappedParticles& particles, const BallBoundary& boundary, const std::vector<Moving>& balls,
                      const std::vector<Vec3>& spins, double angle);

}  // namespace betamesh
