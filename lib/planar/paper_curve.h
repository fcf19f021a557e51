// The boundary of discs -> the paper's beta mesh of a plane.

#pragma once

#include "betamesh/mesh.h"
#include "planar/beta_curve.h"
#include "planar/disc_boundary.h"

namespace betamesh {

/// A line for each cycle: its pure beta vertices, and after each the alphabeta vertex of the arc that begins there, at
/// the projection of the particle onto the straight line between the arc's ends: half-way. Vertex v of the line's cycle
/// becomes vertices 2k and 2k + 1, k its place in boundary.cycle.item.
///
/// cost    O(vertices)
/// source  beta mesh paper, section 3.4.2 and Figure 8 (a)
BetaCurve paperCurve(const DiscBoundary& boundary, const std::vector<DualVec3>& vertices);

}  // namespace betamesh
