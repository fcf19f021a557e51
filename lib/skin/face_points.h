// The ball boundary -> points inside its faces.

#pragma once

#include "core/ball_boundary.h"
#include "core/face_points.h"
#include "exact/snapped_particles.h"

namespace betamesh {

/// In those of fixed directions that are exposed on each ball, and towards other balls less than 0.1 radii away. Their
/// clearance changes as that of points which move with the liquid.
///
/// in      a boundary that was asked for these directions; its balls with their motion
/// same    result for any thread count and particle order
/// cost    O(points + balls that nearly touch others · neighbours)
FacePoints facePoints(const SnappedParticles& particles, const BallBoundary& boundary, const std::vector<Moving>& balls,
                      Icosphere directions);

}  // namespace betamesh
