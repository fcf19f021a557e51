// The boundary of discs -> samples of it.

#pragma once

#include "planar/disc_boundary.h"
#include "skin/boundary_samples.h"

namespace betamesh {

/// Components of all arcs and bare circles, cut at `directions` fixed directions from each centre; each stands for its
/// length, in its middle, and faces away from its centre. The measure changes continuously whatever happens to the
/// boundary: arcs come and go with length zero, even where discs begin to touch and cut an arc in two (its samples then
/// change a little).
///
/// cost    O(samples)
BoundarySamples boundarySamples(const DiscBoundary& boundary, const std::vector<DualVec3>& discs,
                                const std::vector<DualVec3>& vertices, int directions = 24);

}  // namespace betamesh
