// Single events: moments at which the boundary of the union of moving balls changes its combinatorics.

#pragma once

#include "betamesh/particles.h"
#include "betamesh/skin_params.h"
#include "support/oracles.h"

#include <array>
#include <cstdint>
#include <functional>
#include <set>
#include <string>

namespace betamesh {

/// The combinatorics of the boundary of the union of balls, in rows of particles.
struct Combinatorics {
    TriangleSet triangles;
    std::set<std::array<std::uint32_t, 2>> circles;
    bool operator==(const Combinatorics&) const = default;
};

/// Of balls of params.radius, or of those that params.radius_attribute gives.
Combinatorics combinatoricsOf(const Particles& particles, const SkinParams& params);

/// Kinds of events, by the numbers of vertices (oriented triangles of particles) that vanish and appear:
///
///     flip     2 -> 2  four particles become cocircular on the boundary, an arc shrinks to a point and another grows
///     birth    1 -> 3  a ball emerges at a vertex: a face of three arcs
///     void     0 -> 4  a bubble inside a tetrahedron
///     hole     0 -> 2  three balls begin to share two points, their centres an acute triangle: the opening between
///                      them closes
///     graze    0 -> 2  the same with an obtuse one: a ball reaches an arc or circle and cuts it
///     contact  circles only: two balls touch
///
/// Each includes its reverse; "several" is none of these. at: the particles at that moment.
std::string kindOf(const Combinatorics& before, const Combinatorics& after, const Particles& at);

/// Bisects a time interval until single events are isolated or the interval cannot be halved, and calls found(time,
/// kind) for each. particlesAt(time)
void findEvents(double begin, double end, const SkinParams& params, const std::function<Particles(double)>& particlesAt,
                const std::function<void(double, const std::string&)>& found);

/// About as many particles as fit into a box of this many spacings, near the origin, where floats are finest; spacing
/// 1, speeds up to one spacing per second. jitter: of the lattice, spacings; keep: share of its places that are taken.
Particles movingCloud(std::uint64_t seed, std::array<int, 3> size, double jitter, double keep);

}  // namespace betamesh
