// The ball boundary -> a closed mesh of all of it: sheets, rims, tendrils, drops, bubbles.

#pragma once

#include "core/arc_network.h"
#include "core/ball_boundary.h"
#include "core/beta_mesh.h"
#include "exact/snapped_particles.h"

namespace betamesh {

/// Every exposed piece of every ball as part of one convex hull: the hull of the points on its arcs and circles
/// and of some points inside. Each ball's part ends at its arcs, whose points both neighbours share, so the
/// whole is closed, oriented and manifold. Facets of one hull cannot cross, nor can those of two balls, each
/// of which stays in its own Voronoi cell.
///
/// in      a boundary with its faces; its balls' motion; points on its arcs; `point_angle`: radians between
///         neighbouring points inside a face, (0, 1]
/// out     vertices: the network's points, then those inside faces; every one lies on the union's boundary
/// same    bytes for any thread count and particle order
/// cost    O(boundary); about 15 triangles per ball on a plain surface, 300 on a lone drop
/// source  beta mesh paper, section 3.4, completed
BetaMesh completeTessellation(const SnappedParticles& particles, const BallBoundary& boundary,
                              const std::vector<Moving>& balls, const ArcNetwork& network, double point_angle);

}  // namespace betamesh
