// Which balls may be exposed at all: most particles of a liquid are buried, and leave here.

#pragma once

#include "exact/snapped_particles.h"

namespace betamesh {

/// Culls particles that are surely buried (exact/buried.h), where that is not known already.
///
/// out     rows of every particle with an exposed point, and of a few without, ascending
/// same    result for any thread count and instruction set
/// cost    O(n), some 40 ns a particle where it is not known
std::vector<std::uint32_t> exposureCandidates(const SnappedParticles& particles);

}  // namespace betamesh
