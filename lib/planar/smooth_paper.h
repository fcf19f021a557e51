// Positions -> calmer positions. Connectivity stays as it is, velocities follow.

#pragma once

#include "planar/beta_curve.h"
#include "planar/disc_boundary.h"

namespace betamesh {

/// The paper's smoothing of the paper's curve, `passes` times: every pure beta vertex moves to the mean of the middles
/// of the two faces round it, weighted by the distance between their ends; then every alphabeta vertex to the middle of
/// its own face. Thin features have no rims here and need no exception.
///
/// cost    O(passes · vertices)
/// source  beta mesh paper, Algorithm 4 and Figure 8 (b)
void smoothAsInPaper(BetaCurve& curve, int passes);

/// Step 4 of the paper, for its curve. A pure beta vertex that lies behind its alpha segment moves onto the segment's
/// line; then an alphabeta vertex whose particle lies to the right of either edge there moves to the particle.
///
/// cost    O(vertices)
/// source  beta mesh paper, section 3.4.2, step 4, and Figure 8 (d); the first half is ours, for smoothing stronger
///         than the paper's
void resolveIntersections(const DiscBoundary& boundary, const std::vector<DualVec3>& discs, BetaCurve& curve);

}  // namespace betamesh
