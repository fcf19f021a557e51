// What of the liquid is told apart: tendrils, bubbles, and the components of the mesh.

#pragma once

#include "core/ball_boundary.h"
#include "core/beta_mesh.h"

namespace betamesh {

/// Particles of threads that are a single particle thick: no alpha triangle uses them, but a degenerate edge
/// does. Rows of SnappedParticles, ascending.
std::vector<std::uint32_t> tendrilParticles(const BallBoundary& boundary);

/// Leaves bubbles out of a mesh: closed components that face inwards and enclose less than so much volume, in world
/// units cubed, and whatever is inside them. All others stay as they are, in their order.
///
/// in      the complete tessellation of balls of that radius
/// out     how many were filled; vertices that no triangle uses are left out
/// same    bytes for any thread count
/// cost    O(triangles), and more where bubbles are large enough to hold drops
std::size_t fillBubbles(BetaMesh& mesh, double radius, double volume);

/// Sets mesh.component. Components are numbered by volume, the largest first: 0 is the main body, bubbles come
/// last. Between equal ones the lexicographically first vertex decides.
///
/// same    numbers for any thread count
/// cost    O(triangles)
void labelComponents(Mesh& mesh);

}  // namespace betamesh
