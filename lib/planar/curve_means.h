// Means of values of vertices over what is near them in the plane, whatever curve it belongs to.

#pragma once

#include "planar/beta_curve.h"

namespace betamesh {

/// Half the length of the two edges at each vertex: what a vertex stands for, world units.
std::vector<Dual> vertexLengths(const BetaCurve& curve);

/// For each vertex x the mean of all vertices' values, (1 - d²/width²)₊² times their length the weights, d the distance
/// from x. A continuous function of x: vertices that coincide have the same mean, and one that appears where another is
/// changes nothing.
///
/// same    bytes for any thread count
/// cost    O(vertices · vertices within the width)
std::vector<DualVec3> meansOf(const std::vector<DualVec3>& values, const BetaCurve& curve, double width);

}  // namespace betamesh
