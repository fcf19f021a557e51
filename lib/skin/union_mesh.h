// The union of balls as spheres: a reference to compare surfaces with.

#pragma once

#include "base/dual.h"
#include "exact/snapped_particles.h"
#include "skin/ball_boundary.h"

namespace betamesh {

/// A sphere of 500 triangles for every exposed ball, without the triangles that lie wholly inside one other ball. The
/// spheres intersect: this shows the union but is no closed surface. Every vertex moves with its particle.
///
/// same    bytes for any thread count and particle order
/// cost    O(exposed balls)
Mesh unionOfBalls(const SnappedParticles& particles, const BallBoundary& boundary, const std::vector<DualVec3>& balls);

}  // namespace betamesh
