// The particle spacing dx, estimated from the particles themselves.

#pragma once

#include "betamesh/vec3.h"

#include <optional>
#include <vector>

namespace betamesh {

/// The median over distinct particles of the mean distance to their six nearest, world units: 0.84 to
/// 1.01 of the nominal spacing on SPH, FLIP and jittered lattices. The plain nearest neighbour is 0.50 to
/// 0.78 of it and would ruin the radius.
///
/// in      the positions of n >= 0 particles
/// out     nothing when fewer than seven distinct particles exist
/// same    value for any thread count and particle order
/// cost    O(n log n)
std::optional<double> spacing(std::vector<Vec3f> positions);

}  // namespace betamesh
