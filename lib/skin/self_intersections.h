// Surfaces that face each other across little room, and do not pass through each other for all that moves them.

#pragma once

#include "skin/ball_boundary.h"
#include "skin/beta_mesh.h"

namespace betamesh {

/// Takes vertices back on the way that smoothing or an inset took them, by as little as it takes that no triangle
/// passes through another. What is near each other keeps its mean way, which parts nobody; of what each vertex goes
/// beside it, the share remains at which the first two triangles would meet. Vertices near them along the surface go
/// back too, by less; shares change by at most one per radius. They change continuously as the liquid moves, and
/// velocities follow them.
///
/// Where asked to, it first draws corners of triangles that cross to the means of the vertices round them, which opens
/// folds of slivers without taking anything back; that does not change continuously.
///
/// All of it happens among positions that files can hold, so that what is written is what was judged.
///
/// in      from: where each vertex of the mesh came from; no two triangles cross there but by rounding; loosenings: how
///         often to draw corners together at most; last: there is no other place to come from, so triangles that cross
///         even there are moved apart by a few of the steps between such positions
/// out     positions as files hold them; whether no triangles cross any more
/// same    bytes for any thread count
/// cost    a look at every triangle, and at those pairs that are near each other and face different ways
/// source  a surface over a plane does not cross itself: Volino & Magnenat-Thalmann 1994
bool resolveSelfIntersections(const BallBoundary& boundary, const DualPoints& from, BetaMesh& mesh, int loosenings = 0,
               bool last = true);

}  // namespace betamesh
