// Voids of the liquid: what floats in them, and into which of them an empty ball fits.

#pragma once

#include "base/index.h"
#include "mesh/components.h"
#include "skin/ball_boundary.h"
#include "skin/beta_mesh.h"

namespace betamesh {

/// For each piece of a mesh the smallest of these voids that it floats in; kInvalidIndex where there is none, and for pieces
/// that are no bodies.
///
/// in      the complete tessellation of that boundary, its vertices not yet moved, and its pieces; voids: pieces that
///         face inwards, those that enclose more first; is_body: of each piece, whether it faces outwards
/// same    result for any thread count
/// cost    O(triangles), and O(bodies in the box round a void) for each
std::vector<std::uint32_t> voidsRoundBodies(const BetaMesh& mesh, const BallBoundary& boundary, const Components& pieces,
                                            const std::vector<std::uint32_t>& voids, const std::vector<bool>& is_body);

/// Of each piece, whether it is a void with room for a ball of this radius that holds no particle, those of bodies that
/// float in the void included.
///
/// A void is the space between one piece that faces inwards and the bodies that float in it. There is room in it where
/// the boundary of the union of balls of the larger radius has a vertex in it: a part of that boundary which closes off
/// a space is never made of full circles and bare spheres alone, as its outermost ball is exposed on the far side.
///
/// The balls that bound the void decide, with radius r. Let x be a point of the void and q any particle: the way from x
/// to q leaves the void at a point y on one of these balls, of particle b say, and no particle is nearer to y than b.
/// So b is no farther from x than q: |x - b| <= |x - y| + |y - b| <= |x - y| + |y - q| = |x - q|.
///
/// Nor are others in the way where the balls of several voids are looked at together. They have vertices outside the
/// voids as well. Which void one is in is told by a particle that it touches: x at distance R from particle b, towards
/// b. Balls round points of that way shrink in the one round x, so there is no particle in them, and the way stays in
/// the space that x is in as far as b's own ball: x is in the void if and only if the way ends on a triangle of it.
///
/// in      as above; void_of: of each void that is in question, itself, of each body that floats in one, that void,
///         of all other pieces kInvalidIndex; radius: above that of the boundary's balls, world units
/// out     true for all voids that no ball fits into the middle of, where there are more than 20,000 particles round
///         these in each cell as wide as the ball
/// same    result for any thread count and particle order
/// cost    O(triangles + balls that bound these voids), the latter at 1-4 µs while few of them lie within two radii
std::vector<bool> voidsWithRoom(const BetaMesh& mesh, const BallBoundary& boundary, const Components& pieces,
                                std::vector<std::uint32_t> void_of, double radius);

}  // namespace betamesh
