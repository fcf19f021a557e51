// The surface's own motion.

#pragma once

#include "base/dual.h"
#include "exact/snapped_particles.h"
#include "skin/ball_boundary.h"
#include "skin/beta_mesh.h"

namespace betamesh {

/// The balls' centres and how they move: velocity zero where the particles have none.
std::vector<DualVec3> ballCentres(const BallBoundary& boundary, const Particles& particles);

/// The pure beta vertices and how they move. A vertex c on the spheres round p1, p2, p3 keeps its distance r
/// from each: (c - p_m)·ċ = (c - p_m)·v_m, three equations for ċ. They are solved exactly while
/// |q1·(q2 × q3)| / r³ >= 0.05, q_m = c - p_m; below, where the balls barely meet or two particles nearly
/// coincide, the solution is drawn smoothly towards the rigid motion of the particles within 2r of p1.
///
/// out     one row per vertex of the boundary, world units and world units per second
/// same    result for any thread count and particle order
/// cost    O(vertices)
std::vector<DualVec3> boundaryVertices(const Particles& particles, const SnappedParticles& snapped,
                                   const BallBoundary& boundary, const std::vector<DualVec3>& balls);

}  // namespace betamesh
