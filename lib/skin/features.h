// What of the liquid is told apart: tendrils, bubbles, and the components of the mesh.

#pragma once

#include "betamesh/skin_params.h"
#include "skin/ball_boundary.h"
#include "skin/beta_mesh.h"

namespace betamesh {

/// Particles of threads that are a single particle thick: no alpha triangle uses them, but a degenerate edge
/// does. IndexRows of SnappedParticles, ascending.
std::vector<std::uint32_t> tendrilParticles(const BallBoundary& boundary);

/// Leaves bubbles out of a mesh: the voids, closed components that face inwards, into which no empty ball of diameter
/// bubble_gap fits between the particles; without a bubble_gap those that enclose less than bubble_volume. What floats
/// in them leaves, too, and becomes part of the liquid round them; voids inside of that are judged by themselves. All
/// other components stay as they are, in their order.
///
/// in      the complete tessellation of that boundary, its vertices not yet moved
/// out     how many were filled; vertices that no triangle uses are left out
/// same    result for any thread count and particle order
/// cost    O(triangles); 1-4 µs for each ball round a void that is large enough to need a closer look
std::size_t fillBubbles(BetaMesh& mesh, const BallBoundary& boundary, const Features& features);

/// Sets mesh.component. Components are numbered by volume, the largest first: 0 is the main body, bubbles come
/// last. Between equal ones the lexicographically first vertex decides.
///
/// same    numbers for any thread count
/// cost    O(triangles)
void labelComponents(Mesh& mesh);

}  // namespace betamesh
