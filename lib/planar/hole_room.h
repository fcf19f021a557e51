// Which holes have room for larger discs.

#pragma once

#include "planar/disc_boundary.h"

#include <vector>

namespace betamesh {

/// For each cycle of a boundary whether a larger disc, that of the wider boundary, fits between the particles in the
/// region that the cycle borders. It does where the wider boundary has a vertex in there: in holes exactly; outside
/// liquid a single particle or two far apart leave none.
///
/// in      boundaries of the same particles; that of the larger radius may leave out some that nearly coincide
/// same    result for any thread count
/// cost    O(vertices)
std::vector<bool> cyclesWithRoom(const DiscBoundary& boundary, const DiscBoundary& wider);

}  // namespace betamesh
