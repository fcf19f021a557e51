// Points between parts of the liquid that are too close for the rolling disc to fit between them.

#pragma once

#include "planar/disc_boundary.h"
#include "planar/retract.h"

#include <vector>

namespace betamesh {

/// Points of the medial axis between discs that are opposite each other, where smaller discs roll: of radius
/// sqrt(d² - joining²) at distance d from the nearest particles. As addNarrowGaps() in three dimensions; rays lead away
/// from samples of arcs.
///
/// in      discs, vertices: those of the boundary, with velocities
/// cost    O(samples · exposed discs within two outer radii)
/// source  medial axes by shrinking balls: Ma, Bae, Choi 2012
std::vector<GapPoint> gapPoints(const DiscBoundary& boundary, const std::vector<DualVec3>& discs,
                                const std::vector<DualVec3>& vertices, const CurveSkin& skin);

}  // namespace betamesh
