// Clouds of discs of different radii in a plane, and an oracle for them.

#pragma once

#include "exact/snapped_particles.h"
#include "support/planar_clouds.h"

namespace betamesh {

struct UnequalDiscs {
    std::string name;
    Particles particles;
    std::vector<double> radius;  ///< of each disc
};

/// Grid points with radii of half-integers and others: nearly every predicate is a tie, discs touch from inside and
/// outside, and centres coincide.
UnequalDiscs tiedDiscs(std::uint64_t seed);

/// Calls check for the awkward planar clouds and n / 12 random ones with radii of every pattern, and for tied clouds,
/// with the cloud's name as trace, until a check fails.
void forEveryUnequalDiscs(std::uint64_t n, const std::function<void(const UnequalDiscs&)>& check);

/// The same discs in reverse order.
UnequalDiscs reversed(const UnequalDiscs& cloud);

/// Every ordered pair against every other disc, in 3,000 bits, with squared radii R² + η + ε that differ in every disc.
/// O(n³).
SegmentSet perturbedAlphaSegments(const SnappedParticles& snapped);

}  // namespace betamesh
