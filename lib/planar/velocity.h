// The curve's own motion.

#pragma once

#include "exact/snapped_particles.h"
#include "planar/beta_curve.h"
#include "planar/disc_boundary.h"

namespace betamesh {

/// The discs' centres and how they move in the plane: velocity zero where the particles have none.
std::vector<DualVec3> movingDiscs(const DiscBoundary& boundary, const Particles& particles);

/// The vertices and how they move. A vertex c on the circles round p1 and p2 keeps its distance r from both:
/// (c - p_m)·ċ = (c - p_m)·v_m, two equations for ċ. They are solved exactly while |q1 × q2| / r² >= 0.05,
/// q_m = c - p_m; below, where the discs barely meet or nearly coincide, the solution is drawn smoothly towards the
/// rigid motion of the discs within 2r.
///
/// out     one row per vertex of the boundary, world units and world units per second
/// same    result for any thread count and particle order
/// cost    O(vertices)
std::vector<DualVec3> boundaryVertices(const DiscBoundary& boundary, const std::vector<DualVec3>& discs);

/// Turns the velocities of vertices, which so far follow points of the tessellation, into the curve's: along its normal
/// they stay; across it they become those of the rigid motion of the discs within 2r of the vertex, (1 - d²/4r²)² their
/// weight. A lone drop moves as its particle.
///
/// same    bytes for any thread count and particle order
/// cost    O(vertices)
void projectTangentialVelocity(const DiscBoundary& boundary, const std::vector<DualVec3>& discs, BetaCurve& curve);

}  // namespace betamesh
