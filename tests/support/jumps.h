// Single events of moving clouds of particles, and how far the surfaces of the balls jump there.

#pragma once

#include "betamesh/particles.h"
#include "betamesh/skin_params.h"

#include <string>
#include <utility>
#include <vector>

namespace betamesh {

constexpr double kEventRadius = 1.5;  // of the balls, in spacings, as by default

/// A moment at which the boundary of the union of moving balls changes its combinatorics.
struct SingleEvent {
    std::string kind;     // as kindOf() in support/events.h says
    bool in_block;        // not in a thin sheet or in spray
    Particles particles;  // at time 0
    double time;
    std::string name;
};

/// At most eight events of each kind from blocks, and as many from sheets with gaps and from spray, sorted by kind.
/// Found by bisection in the first call, which takes seconds.
const std::vector<SingleEvent>& singleEvents();

/// The surfaces that are compared at events, and their names, in the order of the table in property/README.md.
const std::vector<std::pair<std::string, SkinParams>>& comparedSurfaces();
const SkinParams& comparedSurface(const std::string& name);

/// The two-sided distance of the surfaces half the span before and after that time, in radii.
double jumpAcross(const Particles& start, double time, double span, const SkinParams& params);

}  // namespace betamesh
