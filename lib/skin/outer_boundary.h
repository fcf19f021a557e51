// Samples of the boundary of the union of larger balls: what the skin's depth is measured from.

#pragma once

#include "core/moving.h"

#include <vector>

namespace betamesh {

/// Points on the boundary of a union of balls, with their velocities, and the measure that each stands for.
struct OuterSamples {
    std::vector<Moving> point;  ///< world units, world units per second
    std::vector<float> weight;  ///< of each, >= 0: length in `unit`s along arcs, area in square `unit`s inside faces
    std::vector<float> fading;  ///< 0 for samples that are there, up to 1 for those that have only just appeared
    std::vector<float> lone;    ///< how much of the ball is exposed, inside faces: 1 where all is; 0 along arcs
};

/// Samples the boundary of the union of balls of another, larger radius round the same centres.
///
/// in      balls: the exposed balls of the smaller radius; those that are buried there are buried here, too
/// out     samples at most about a quarter of the radius apart; every vertex of the boundary is one of them
/// same    result for any thread count
/// cost    O(balls) for a bounded number of neighbours
OuterSamples outerSamples(const std::vector<Moving>& balls, double radius, double unit);

}  // namespace betamesh
