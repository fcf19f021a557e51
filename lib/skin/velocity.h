// The surface's own motion.

#pragma once

#include "core/ball_boundary.h"
#include "core/beta_mesh.h"
#include "core/moving.h"
#include "exact/snapped_particles.h"

namespace betamesh {

/// The balls' centres and how they move: velocity zero where the particles have none.
std::vector<Moving> movingBalls(const BallBoundary& boundary, const Particles& particles);

/// The pure beta vertices and how they move. A vertex c on the spheres round p1, p2, p3 keeps its distance r
/// from each: (c - p_m)·ċ = (c - p_m)·v_m, three equations for ċ. They are solved exactly while
/// |q1·(q2 × q3)| / r³ >= 0.05, q_m = c - p_m; below, where the balls barely meet or two particles nearly
/// coincide, the solution is drawn smoothly towards the rigid motion of the particles within 2r of p1.
///
/// out     one row per vertex of the boundary, world units and world units per second
/// same    result for any thread count and particle order
/// cost    O(vertices)
std::vector<Moving> movingVertices(const Particles& particles, const SnappedParticles& snapped,
                                   const BallBoundary& boundary, const std::vector<Moving>& balls);

/// Angular velocities at each ball, radians per second.
struct Spins {
    std::vector<Vec3> of_liquid;
    /// Of what the tessellation puts in fixed directions from a ball. The next frame puts it there again, whatever the
    /// liquid does: this is zero for most motions, so that velocities tell how the surface gets from one frame to the
    /// next, and that of the liquid where it moves as a rigid body, so that its surface moves with it exactly.
    std::vector<Vec3> of_points;
};

/// That of the rigid motion which explains a ball and those within 2r best, (1 - d²/4r²)² their weight; points turn by
/// the fourth power of how much it explains. Zero for all where the particles have no velocity.
///
/// same    result for any thread count and particle order
/// cost    O(balls)
Spins spinsOfBalls(const BallBoundary& boundary, const std::vector<Moving>& balls, const Particles& particles);

/// The velocity of the liquid at points: the mean of the rigid motions round the balls within 2r, (1 - d²/4r²)² their
/// weight; the point's own where there is none.
///
/// same    bytes for any thread count and particle order
/// cost    O(points)
std::vector<Vec3> liquidVelocities(const BallBoundary& boundary, const std::vector<Moving>& balls,
                                   const std::vector<Vec3>& spins, const std::vector<Moving>& points);

/// Turns the velocities of vertices, which so far follow points of the tessellation, into the surface's: along the
/// mesh's normal they stay; across it they become those of the liquid, the mean of the rigid motions round the balls
/// within 2r of the vertex, (1 - d²/4r²)² their weight. Vertices of a lone drop move as its particle.
///
/// same    bytes for any thread count and particle order
/// cost    O(vertices)
void slideWithParticles(const BallBoundary& boundary, const std::vector<Moving>& balls, const std::vector<Vec3>& spins,
                        BetaMesh& mesh);

}  // namespace betamesh
