// The union of balls as it is, bumps and all: the ground truth to look at.

#pragma once

#include "base/dual.h"
#include "exact/snapped_particles.h"
#include "skin/ball_boundary.h"

namespace betamesh {

/// A sphere of 500 triangles round every exposed ball, less the triangles that lie wholly inside one other
/// ball. Spheres poke into each other: a picture of the union, not a closed surface. Every vertex moves with
/// its particle.
///
/// same    bytes for any thread count and particle order
/// cost    O(exposed balls)
Mesh unionOfBalls(const SnappedParticles& particles, const BallBoundary& boundary, const std::vector<DualVec3>& balls);

}  // namespace betamesh
