// Velocities of the pure beta vertices, from the motion of the balls they touch.

#pragma once

#include "base/dual.h"
#include "exact/snapped_particles.h"
#include "skin/ball_boundary.h"
#include "skin/beta_mesh.h"

namespace betamesh {

/// Centres and velocities of the balls; velocities are zero if the particles have none.
std::vector<DualVec3> ballCentres(const BallBoundary& boundary, const Particles& particles);

/// The pure beta vertices with their velocities. A vertex c on the spheres round p1, p2, p3 keeps its distance r from
/// each of them: q_m·ċ = q_m·v_m + r ṙ_m with q_m = c - p_m, three equations for ċ. They are solved exactly where
/// |q1·(q2 × q3)| / r³ >= kWellConditioned. Below that, where the balls barely meet or two particles nearly coincide,
/// the solution is blended continuously into the rigid motion of the particles within two radii of p1.
///
/// out     one row per vertex of the boundary; world units, world units per second
/// same    result for any thread count and particle order
/// cost    O(vertices)
std::vector<DualVec3> boundaryVertices(const Particles& particles, const SnappedParticles& snapped,
                                       const BallBoundary& boundary, const std::vector<DualVec3>& balls);

}  // namespace betamesh
