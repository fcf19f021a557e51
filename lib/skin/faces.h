// Faces of the ball boundary: which cycles of arcs bound the same exposed piece of a sphere.

#pragma once

#include "exact/snapped_particles.h"
#include "skin/ball_boundary.h"

namespace betamesh {

/// Sets boundary.face and boundary.face_ball from the rest of the boundary.
///
/// On a sphere, n disjoint cycles separate n + 1 regions, exposed and covered: with C connected groups of caps there
/// are n + 1 - C faces. Mostly that settles it: there is one face, or one per cycle. Otherwise cycles are joined if a
/// great circle that leaves one meets the other first, until that many faces are left.
///
/// same    result for any thread count
/// cost    O(faces); O(k²) for balls with several cycles and k neighbours
void groupFaces(const SnappedParticles& particles, BallBoundary& boundary);

}  // namespace betamesh
