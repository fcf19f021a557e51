// Samples between parts of the liquid that are too close for the rolling ball to fit between them.

#pragma once

#include "base/dual.h"
#include "skin/arcs.h"
#include "skin/ball_boundary.h"
#include "skin/face_points.h"
#include "skin/outer_boundary.h"
#include "skin/skin_lengths.h"

#include <vector>

namespace betamesh {

/// Adds samples to those of the outer boundary, which does not reach into gaps narrower than its balls. Otherwise the
/// surface would stay on the balls of the joining radius there: two sheets that come near would become thick at once.
///
/// In the middle of a gap a smaller ball rolls. Where the nearest particles on both sides are at distance d, its radius
/// is sqrt(d² - a²), with a the joining radius. It is as large as the rolling ball where d is the outer radius, and
/// vanishes where the balls of the joining radius meet. So the surface moves gradually as a gap closes, and the gap
/// remains open until they do.
///
/// Rays lead away from the balls at points inside arcs and faces. A sample lies where such a ray is as near to another
/// ball as to its own, if that one is opposite. OuterSamples::squared_offset tells how much smaller their rolling balls
/// are. Samples have the velocity of the ball at which their ray begins; that the rolling ball shrinks as a gap closes
/// is not in it.
///
/// in      the boundary with its balls, points on its arcs and inside its faces; lengths: in spacings; spacing: of the
///         particles with the largest balls, world units
/// same    result for any thread count and particle order
/// cost    O(points · exposed balls within two outer radii)
/// source  medial axes by shrinking balls: Ma, Bae, Choi 2012
void addNarrowGaps(const BallBoundary& boundary, const std::vector<DualVec3>& balls, const ArcNetwork& network,
                   const FacePoints& points, const SkinLengths& lengths, double spacing, OuterSamples& samples);

}  // namespace betamesh
