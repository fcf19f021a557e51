// Voids of the liquid: which components float in them, and which of them an empty ball fits into.
//
// A void is bounded by a component of the mesh that faces inwards, and by the liquid components, which face outwards,
// that float in it.

#pragma once

#include "base/index.h"
#include "mesh/components.h"
#include "skin/ball_boundary.h"
#include "skin/beta_mesh.h"

namespace betamesh {

/// For each liquid component the smallest of the given voids that it floats in; kInvalidIndex if it floats in none, and
/// for all other components.
///
/// in      the complete tessellation of that boundary, its vertices not yet moved, and its components; voids:
///         components that face inwards, by enclosed volume, the largest first; is_liquid: of each component, whether
///         it faces outwards
/// same    result for any thread count
/// cost    O(triangles), and per void O(liquid components in its bounding box)
std::vector<std::uint32_t> enclosingVoids(const BetaMesh& mesh, const BallBoundary& boundary,
                                          const Components& components, const std::vector<std::uint32_t>& voids,
                                          const std::vector<bool>& is_liquid);

/// For each component whether it is a void into which a ball of the given radius fits that contains no particle, not
/// even of the liquid components that float in the void.
///
/// A ball fits if the boundary of the union of balls of the larger radius has a vertex in the void: a part of that
/// boundary that encloses a space never consists of full circles and isolated spheres alone, as its outermost ball is
/// exposed on the far side.
///
/// Only the balls that bound the void matter. Let r be their radius, x a point of the void and q any particle. The
/// segment from x to q leaves the void at a point y on one of these balls, of particle b say, and no particle is nearer
/// to y than b. So b is no farther from x than q: |x - b| <= |x - y| + |y - b| <= |x - y| + |y - q| = |x - q|.
///
/// Balls of several voids can be looked at together. They have vertices outside the voids as well; which void a vertex
/// x is in is told by any particle b that its ball touches: balls round points of the segment from x to b lie within
/// the one round x, so they contain no particle, and the segment stays in the space of x until it meets b's own ball.
/// Hence x is in the void if and only if the segment meets a triangle of the void there.
///
/// in      mesh, boundary and components as above; void_of: of each void in question, itself; of each liquid component
///         that floats in one, that void; of all others kInvalidIndex; radius: above that of the boundary's balls,
///         world units
/// out     where there are more than 20,000 particles per cell as wide as the ball round the voids that no ball fits
///         the centroid of, true for all of these
/// same    result for any thread count and particle order
/// cost    O(triangles + balls that bound these voids), the latter at 1-4 µs while few of them lie within two radii
std::vector<bool> voidsFittingBall(const BetaMesh& mesh, const BallBoundary& boundary, const Components& components,
                                   std::vector<std::uint32_t> void_of, double radius);

}  // namespace betamesh
