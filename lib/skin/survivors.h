// Which balls may be exposed at all: most particles of a liquid are buried, and leave here.

#pragma once

#include "core/exposure.h"
#include "exact/snapped_particles.h"

namespace betamesh {

/// Culls particles whose whole sphere is certainly inside other balls. Never wrong, only conservative: a
/// patch counts as covered when it lies inside one neighbour's cap with room for rounding.
///
/// out     every particle with an exposed point, and a few without
/// same    result for any thread count
/// cost    O(n); about fourteen neighbours are looked at for a buried particle
/// source  direction masks: Le Grand & Merz 1993
Survivors survivors(const SnappedParticles& particles);

}  // namespace betamesh
