// The alpha mesh of a plane: particles joined by segments.

#pragma once

#include "base/dual.h"
#include "betamesh/curves.h"
#include "planar/disc_boundary.h"

namespace betamesh {

/// A view of the boundary: one oriented segment per vertex, curve after curve. What is thin is gone round: its segments
/// come twice, once each way. Isolated particles are not in it.
///
/// out     vertices are the discs that some segment uses
/// cost    O(segments)
/// source  beta mesh paper, section 3.2
Curves alphaCurves(const DiscBoundary& boundary, const std::vector<DualVec3>& discs);

/// Segments whose reverse is there, too. Each of the two counts.
std::size_t doubleSidedSegments(const DiscBoundary& boundary);

}  // namespace betamesh
