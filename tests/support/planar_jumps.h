// Single events of moving particles in a plane, and how far the curves around the discs jump there.

#pragma once

#include "betamesh/particles.h"
#include "betamesh/skin_params.h"

#include <string>
#include <utility>
#include <vector>

namespace betamesh {

constexpr double kDiscRadius = 1.5;  // spacings are 1

/// A moment at which the boundary of moving discs changes its combinatorics. Kinds of events, by the numbers of
/// vertices that vanish and appear; each includes its reverse:
///
///     birth    1 -> 2  a disc emerges at a vertex
///     contact  0 -> 2  two discs touch
///     hole     0 -> 3  a hole opens between three discs
struct PlanarEvent {
    std::string kind, name;
    Particles particles;  // at time 0
    double time;
};

/// Near the origin, where floats are finest; speeds up to one spacing per second. Seeds that are even make dense
/// clouds.
Particles movingPlanarCloud(std::uint64_t seed);

/// Where the particles are at that time.
Particles movedInPlane(const Particles& start, double time);

/// At most 24 events of each kind, sorted by kind. Found by bisection in the first call.
const std::vector<PlanarEvent>& planarEvents();

/// The curves that are compared at events, and their names, in the order of the table in property/README.md.
const std::vector<std::pair<std::string, SkinParams>>& comparedCurves();
const SkinParams& comparedCurve(const std::string& name);

/// The two-sided distance of the curves half the span before and after the event, in radii.
double planarJumpAcross(const PlanarEvent& event, double span, const SkinParams& params);

}  // namespace betamesh
