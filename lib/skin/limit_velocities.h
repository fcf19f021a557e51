// Vertex velocities for motion blur, limited by the motion of the liquid near each vertex.

#pragma once

#include "skin/ball_boundary.h"
#include "skin/beta_mesh.h"

namespace betamesh {

/// A smooth factor that keeps a length below a limit, both given by their squares: 1 unless the length is near the
/// limit.
double limitingFactor(double square, double limit);

/// Replaces the instantaneous velocities of tessellation points by velocities that are valid over a shutter interval.
/// The tangential part becomes that of the rigid motion that fits the balls within reach best, with weights
/// (1 - d²/reach²)⁴. The normal part keeps its difference from that motion, limited to kMaxRelativeVelocity times the
/// root mean square of the balls' own differences and of the changes of their radii. Rims and necks, whose
/// instantaneous speed is unbounded while balls meet or part, are therefore no faster than the liquid; where the liquid
/// moves as a rigid body, the surface does so exactly. Among balls of different radii, the reach is as large as the
/// spacing at the vertex, and a ball counts by the square of its radius.
///
/// in      reach: of vertices beside the largest balls, world units; a vertex farther than its reach from all balls
///         keeps its velocity. normals: of the vertices, zero where there is none
/// same    bytes for any thread count and particle order
/// cost    O(vertices · balls within reach)
void limitVelocities(const BallBoundary& boundary, const std::vector<DualVec3>& balls, double reach,
                     const std::vector<Vec3>& normals, BetaMesh& mesh);

}  // namespace betamesh
