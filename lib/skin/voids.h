// Voids of the liquid: which components float in them, which of them an empty ball fits into, and filling the others.
//
// A void is bounded by a component of the mesh that faces inwards, and by the liquid components, which face outwards,
// that float in it.

#pragma once

#include "base/index.h"
#include "betamesh/skin_params.h"
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

/// For each component whether it is a void into which an empty ball fits, with room between it and the balls of all
/// particles, even of the liquid components that float in the void. Its radius is `radius` less that of the largest
/// ball of the boundary. With balls of one radius: whether a ball of the given radius fits that contains no particle.
///
/// Let e be the radius of the empty ball. It fits round a point if no ball that is larger by e contains that point. So
/// it fits if the boundary of the union of these larger balls has a vertex in the void: a space that the larger balls
/// enclose has extreme points, through which no segment within that space passes. Through a point of only one or two
/// spheres passes a tangent of both, which lies outside their balls. So extreme points are vertices.
///
/// Only the balls that bound the void matter. Let d_q = |x - q| - r_q be the distance of a point x of the void from the
/// surface of any ball q. The segment from x to the centre of q leaves the void at a point y on a ball b that bounds
/// it, and inside none. So d_b <= |x - y| + |y - b| - r_b = |x - y| <= |x - y| + |y - q| - r_q = d_q.
///
/// Balls of several voids can be looked at together. They have vertices outside the voids as well; which void a vertex
/// x is in is told by any ball b that the empty ball round x touches: of the segment from x to b, the points as near to
/// x as e are in none of the balls, so the segment stays in the space of x until it meets b. Hence x is in the void if
/// and only if the segment meets a triangle of the void there.
///
/// in      mesh, boundary and components as above; void_of: of each void in question, itself; of each liquid component
///         that floats in one, that void; of all others kInvalidIndex; radius: above that of the boundary's largest
///         ball, world units
/// out     where there are more than 20,000 particles per cell as wide as the ball round the voids that no ball fits
///         the centroid of, true for all of these
/// same    result for any thread count and particle order
/// cost    O(triangles + balls that bound these voids), the latter at 1-4 µs while few of them lie within two radii
std::vector<bool> voidsFittingBall(const BetaMesh& mesh, const BallBoundary& boundary, const Components& components,
                                   std::vector<std::uint32_t> void_of, double radius);

/// Removes bubbles from a mesh: voids, which are closed components that face inwards, into which no empty ball of
/// diameter bubble_gap fits between particles whose balls have the reference radius. With other balls, the room between
/// their surfaces counts: none for a ball whose radius is bubble_gap / 2 less the reference radius. Without a
/// bubble_gap, voids that enclose less than bubble_volume. Components that float in a removed void are removed with it,
/// as they become part of the liquid; voids inside those are judged by themselves. All other components stay as they
/// are, in their order.
///
/// in      the complete tessellation of that boundary, its vertices not yet moved; reference_radius: world units
/// out     the number of voids filled; vertices that no triangle uses are removed
/// same    result for any thread count and particle order
/// cost    O(triangles); 1-4 µs for each ball round a void that is large enough to need a closer look
std::size_t fillBubbles(BetaMesh& mesh, const BallBoundary& boundary, const Features& features,
                        double reference_radius);

}  // namespace betamesh
