// Awkward planar clouds, and oracles for them.

#pragma once

#include "support/clouds.h"

#include <array>
#include <set>

namespace betamesh {

/// Empty, tiny, collinear and cocircular clouds, lattices at their critical radii, thin, dense and distant ones; all
/// particles of a cloud have the same z.
std::vector<Cloud> awkwardPlanarClouds();

/// 1 to 40 particles with r/dx from 0.6 to 3; half of the clouds are on a small grid with a radius that gives exact
/// ties, some have exact duplicates.
Cloud randomPlanarCloud(std::uint64_t seed);

/// Calls check for all awkward clouds and for random ones from seed 0 on, with the cloud's name as trace, until a check
/// fails.
void forEveryPlanarCloud(std::uint64_t random_clouds, const std::function<void(const Cloud&)>& check);

/// Oriented segments of particle rows.
using SegmentSet = std::set<std::array<std::uint32_t, 2>>;

/// Every ordered pair against every other particle, without tie rules: in integers of 1,000 bits, with a radius
/// enlarged by so little that only ties are affected. O(n³).
SegmentSet bruteForceAlphaSegments(const Particles& particles, double radius);

}  // namespace betamesh
