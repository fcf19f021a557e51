// Displacements of a curve's vertices: their smoothed versions, and moves without crossings.

#pragma once

#include "planar/boundary_curves.h"

namespace betamesh {

/// Smoothed values: for each vertex x the mean of all vertices' values with weights (1 - d²/width²)₊² times the length
/// of curve that a vertex represents, where d is the distance from x, along whatever curve. The mean is a continuous
/// function of x: vertices that coincide have equal means, and a vertex that appears where another one is changes
/// nothing.
///
/// in      width: at vertices of scale 1, in proportion elsewhere; world units
/// same    bytes for any thread count
/// cost    O(vertices · vertices within the width)
std::vector<DualVec3> smoothedValues(const std::vector<DualVec3>& values, const BetaCurve& curve, double width);

/// Replaces the scales of vertices, which jump from disc to disc, by smoothed values that vary continuously. Nothing
/// happens where all scales are 1.
///
/// in      spacing: of the particles of scale 1, world units
void smoothScales(BetaCurve& curve, double spacing);

/// Moves every vertex by its displacement, or by less: where edges would cross, the displacements of their ends and of
/// a few vertices beside these are shortened until none cross. Crossings shallower than 1e-9 units are ignored.
///
/// in      a curve without crossings; unit: a length of the order of the displacements, world units
/// same    bytes for any thread count
/// cost    O(vertices) if edges have similar lengths
void moveWithoutCrossings(BetaCurve& curve, const std::vector<DualVec3>& displacement, double unit);

}  // namespace betamesh
