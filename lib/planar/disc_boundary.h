// Particles in a plane -> the boundary of the union of their discs.

#pragma once

#include "core/disc_boundary.h"
#include "exact/snapped_particles.h"

namespace betamesh {

/// Finds every vertex by exact signs: the oriented segments of particles whose r-disc on the right is empty.
///
/// in      n >= 0 particles of one z
/// out     vertices sorted by their first disc, then by direction; curves by their smallest vertices. All are closed,
///         whatever the input
/// same    result for any thread count and particle order
/// cost    O(n) for a bounded number of neighbours within two radii
/// source  beta mesh paper, sections 3.2 and 3.3, in two dimensions
DiscBoundary discBoundary(const SnappedParticles& particles);

}  // namespace betamesh
