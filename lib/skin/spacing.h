// The particle spacing dx, estimated from the particles themselves.

#pragma once

#include "betamesh/vec3.h"

#include <optional>
#include <vector>

namespace betamesh {

/// The median over distinct particles of the mean distance to their six nearest neighbours, world units. That is 0.84
/// to 1.01 of the nominal spacing on SPH, FLIP and jittered lattices; the nearest neighbour alone gives 0.50 to 0.78.
///
/// in      the positions of n >= 0 particles
/// out     nothing if there are fewer than seven distinct particles
/// same    value for any thread count and particle order
/// cost    O(n log n)
std::optional<double> spacing(std::vector<Vec3f> positions);

}  // namespace betamesh
