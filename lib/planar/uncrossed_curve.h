// Steps of vertices that let no two edges of a curve pass through each other.

#pragma once

#include "planar/beta_curve.h"

namespace betamesh {

/// Moves every vertex by its step, or by less: where edges would cross, the steps of their ends and of a few vertices
/// beside these along the curve are shortened until none do. Edges that cross by less than 1e-9 units, before or after,
/// do not count.
///
/// in      a curve without crossings; unit: a length of the order of the steps, world units
/// same    bytes for any thread count
/// cost    O(vertices) where edges are about as long as each other
void moveUncrossed(BetaCurve& curve, const std::vector<DualVec3>& step, double unit);

}  // namespace betamesh
