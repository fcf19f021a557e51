// Cycles of arcs -> faces: which cycles bound the same exposed piece of a sphere.

#pragma once

#include "exact/snapped_particles.h"
#include "skin/ball_boundary.h"

namespace betamesh {

/// Fills boundary.face and boundary.face_ball from everything else in it.
///
/// On a sphere, n disjoint cycles part n + 1 regions, exposed and covered: with C connected groups of caps
/// there are n + 1 - C faces. Mostly that says all: one face, or a face for each cycle. Otherwise cycles are
/// joined along great circles that leave one and meet another first, until that many faces are left.
///
/// same    result for any thread count
/// cost    O(faces); balls with several cycles O(k²) in their k neighbours
void groupFaces(const SnappedParticles& particles, BallBoundary& boundary);

}  // namespace betamesh
