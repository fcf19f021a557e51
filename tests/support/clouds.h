// Awkward clouds: what every stage has to survive, each with a name for SCOPED_TRACE.

#pragma once

#include "betamesh/particles.h"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace betamesh {

/// The radius is that of the balls, in the units of the particles. All clouds have id = row and a velocity
/// of up to one radius per second that differs from particle to particle, among duplicates too.
struct Cloud {
    std::string name;
    Particles particles;
    double radius = 0;
};

/// Nothing, a few, degenerate, flat, thin, dense, huge and plain random ones. Where exactness is the point
/// (contact at 2r, r-balls through four points and more) coordinates and radius are exact in float32.
/// Most have fewer than 400 particles, a few about 2,000.
std::vector<Cloud> awkwardClouds();

/// 3 to 40 particles in a box whose mean spacing dx gives r/dx from 0.6 to 3. A third is snapped to a small
/// integer grid with a radius that makes exact ties, some are flattened to a plane or a line, some hold
/// exact duplicates.
Cloud randomCloud(std::uint64_t seed);

/// Checks all awkward clouds and random ones from seed 0 on, each under its name, up to the first failure.
void forEveryCloud(std::uint64_t random_clouds, const std::function<void(const Cloud&)>& check);

/// The same particles in another order: all arrays permuted alike.
Particles shuffled(const Particles& particles, std::uint64_t seed);

/// n particles all over a sphere round the origin, but for rounding: balls of its radius all pass by one point.
Particles spiralOnSphere(std::size_t n, double radius);

}  // namespace betamesh
