// Removes the self-intersections that moving the vertices of a mesh has caused.

#pragma once

#include "skin/ball_boundary.h"
#include "skin/beta_mesh.h"

namespace betamesh {

/// Reduces the displacements of vertices, by as little as possible, until no two triangles cross. Vertices near a
/// crossing keep the locally averaged displacement, which cannot cause crossings. Of the rest of its displacement, each
/// vertex keeps the fraction at which the first two triangles would meet. Vertices near it along the surface are
/// limited, too: fractions differ by at most the distance in radii, which are those of balls as large as
/// BetaMesh::scale says. Fractions change continuously as the liquid moves,
/// and velocities are differentiated through them.
///
/// Before that, it can move the corners of crossing triangles: to the means of their one-rings, which opens folds of
/// slivers, and back through what they have passed through, by at most kMovesBack · kMoveBack radii. This undoes hardly
/// any displacement, but does not change continuously. If no displacement is left to reduce, it can finally move
/// crossing triangles apart by a few units of single precision.
///
/// Positions are rounded to those that files hold before they are tested, so the written mesh is the tested one.
///
/// in      from: positions of the vertices before the displacement, where no two triangles cross except by rounding.
///         moves_corners: as said above. is_last: no other initial positions can be tried, so triangles that cross even
///         there are moved apart
/// out     rounded positions; the number of pairs of triangles that still cross: 0 but where so many balls meet so near
///         each other that single precision cannot tell them apart
/// same    bytes for any thread count
/// cost    O(triangles), plus the pairs of triangles near each other
/// source  a surface over a plane does not cross itself: Volino & Magnenat-Thalmann 1994
std::size_t resolveSelfIntersections(const BallBoundary& boundary, const DualPoints& from, BetaMesh& mesh,
                                     bool moves_corners = false, bool is_last = true);

}  // namespace betamesh
