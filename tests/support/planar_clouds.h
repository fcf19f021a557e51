// Awkward clouds in a plane, and slow answers about them.

#pragma once

#include "support/clouds.h"

#include <array>
#include <set>

namespace betamesh {

/// Nothing, a few, collinear, cocircular, lattices at their critical radii, thin, dense, far away; z is the same for
/// all particles of a cloud.
std::vector<Cloud> awkwardPlanarClouds();

/// 1 to 40 particles with r/dx from 0.6 to 3; half of them on a small grid with a radius that makes exact ties, some
/// with exact duplicates.
Cloud randomPlanarCloud(std::uint64_t seed);

/// Checks all awkward clouds and random ones from seed 0 on, each under its name, up to the first failure.
void forEveryPlanarCloud(std::uint64_t random_clouds, const std::function<void(const Cloud&)>& check);

/// Oriented segments of particle rows.
using SegmentSet = std::set<std::array<std::uint32_t, 2>>;

/// Every ordered pair and every other particle, in whole numbers of 1,000 bits with a radius that really is larger, by
/// less than decides anything but ties: knows nothing of tie rules. O(n³).
SegmentSet bruteForceAlphaSegments(const Particles& particles, double radius);

}  // namespace betamesh
