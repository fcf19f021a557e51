// The ball boundary -> a closed mesh of all of it: sheets, rims, tendrils, drops, bubbles.

#pragma once

#include "skin/arcs.h"
#include "skin/ball_boundary.h"
#include "skin/beta_mesh.h"
#include "skin/face_points.h"

namespace betamesh {

/// The mesh of every exposed face of every ball is part of one convex hull per ball: the hull of the points on its arcs
/// and circles and of points inside its faces. It ends at the ball's arcs, whose points both balls share, so the whole
/// is closed, oriented and manifold. Facets of one hull cannot cross, nor can those of two balls, each of which stays
/// in its own Voronoi cell.
///
/// Points inside faces come and go with their distance from the rim. With Appearance::on_boundary they lie on the
/// sphere and keep the distance from rims that good triangles need. With Appearance::gradual they are lowered below the
/// sphere (deeper than the chords of arcs where the mesh is retracted afterwards) until the hull passes over them;
/// edges of a hull whose flip is in progress have a vertex (see skin/edge_flips.h), and points far from any rim get
/// volume-compensating offsets.
///
/// in      a boundary with its faces; its balls' motion; points on its arcs, and inside its faces
/// out     vertices: the network's points, then those inside faces, then those of edge flips; every one lies on the
///         union's boundary or, while it is lowered or belongs to an edge flip, inside
/// same    bytes for any thread count and particle order
/// cost    O(boundary); smoothed, about 31 triangles per exposed ball of a dam break, 180 on an isolated drop
/// source  beta mesh paper, section 3.4, completed
BetaMesh completeTessellation(const BallBoundary& boundary, const std::vector<DualVec3>& balls, ArcNetwork network,
                              FacePoints points, const ArcSubdivision& subdivision);

}  // namespace betamesh
