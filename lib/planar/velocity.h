// Velocities of discs, of the boundary's vertices and of the finished curve.

#pragma once

#include "planar/boundary_curves.h"

namespace betamesh {

/// The discs' centres with their velocities in the plane; zero velocities if the particles have none.
std::vector<DualVec3> movingDiscs(const DiscBoundary& boundary, const Particles& particles);

/// The vertices with their velocities. A vertex c on the circles around p1 and p2 keeps the radii as distances from
/// both: q_m·(ċ - v_m) = ṙ_m with the unit vectors q_m along c - p_m, two equations for ċ. They are solved exactly
/// where |q1 × q2| >= 0.05. Below, where the discs barely touch or nearly coincide, the solution is blended smoothly
/// with the rigid motion of the discs around: those within two radii, or within the sum of theirs and the vertex's own.
///
/// out     one row per vertex of the boundary, world units and world units per second
/// same    result for any thread count and particle order
/// cost    O(vertices)
std::vector<DualVec3> boundaryVertices(const DiscBoundary& boundary, const std::vector<DualVec3>& discs);

/// Replaces the instantaneous velocities of vertices by velocities that are valid over a shutter interval. The
/// tangential part, which depends on the tessellation, becomes that of the liquid: the rigid motion of the discs within
/// 2r of the vertex, weighted by (1 - d²/4r²)², where 2r is the sum of the disc's and of the vertex's radius. The
/// normal part keeps its difference from that motion, limited to the root mean square of the discs' own differences and
/// of the changes of their radii: the instantaneous speed is unbounded where discs meet or part. An isolated drop moves
/// like its particle.
///
/// same    bytes for any thread count and particle order
/// cost    O(vertices)
void limitVelocities(const DiscBoundary& boundary, const std::vector<DualVec3>& discs, BetaCurve& curve);

}  // namespace betamesh
