// The ball boundary as a cloud of weighted, directed points: what smoothing averages over.

#pragma once

#include "core/moving.h"

#include <vector>

namespace betamesh {

/// One point that stands for a piece of the boundary: its mean, and how the piece lies about it. The cloud as a whole,
/// a measure on positions and directions, changes continuously in time, whatever appears, vanishes or changes
/// neighbours on the boundary.
struct BoundarySample {
    Moving position;   ///< world units
    Moving direction;  ///< outwards, length <= 1: short where the boundary is sharply creased
    Rate weight;       ///< world units of length, >= 0
    Rate spread = 0;   ///< mean squared distance of the piece from its position, square world units
    Rate bulge = 0;    ///< mean of (x - position) · (direction at x), world units: positive where the piece is convex
};

using BoundarySamples = std::vector<BoundarySample>;

}  // namespace betamesh
