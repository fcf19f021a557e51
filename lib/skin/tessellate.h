// The ball boundary -> a closed mesh of all of it: sheets, rims, tendrils, drops, bubbles.

#pragma once

#include "skin/arc_network.h"
#include "skin/arcs.h"
#include "skin/ball_boundary.h"
#include "skin/beta_mesh.h"
#include "skin/face_points.h"

namespace betamesh {

/// Every exposed piece of every ball as part of one convex hull: the hull of the points on its arcs and circles
/// and of some points inside. Each ball's part ends at its arcs, whose points both neighbours share, so the
/// whole is closed, oriented and manifold. Facets of one hull cannot cross, nor can those of two balls, each
/// of which stays in its own Voronoi cell.
///
/// Points inside faces appear and vanish with their rim_distance from the rim. Appearance::on_boundary: as far from the
/// rim as good triangles need. Appearance::gradual: they sink below the sphere, where what is made of them
/// moves far deeper than the chords of arcs, until the hull passes over them. Edges of a hull that are about to turn have
/// a vertex each (see core/turning_edges.h), and points far from any rim swell when smoothed.
///
/// in      a boundary with its faces; its balls' motion; points on its arcs, and inside its faces
/// out     vertices: the network's points, then those inside faces, then those on edges that turn; every one lies on
///         the union's boundary or, where it sinks or turns, inside
/// same    bytes for any thread count and particle order
/// cost    O(boundary); smoothed, about 31 triangles per exposed ball of a dam break, 180 on a lone drop
/// source  beta mesh paper, section 3.4, completed
BetaMesh completeTessellation(const BallBoundary& boundary, const std::vector<DualVec3>& balls, ArcNetwork network,
                              FacePoints points, const ArcSubdivision& subdivision);

}  // namespace betamesh
