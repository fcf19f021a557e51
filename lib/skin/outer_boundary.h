// Samples of the boundary of the union of larger balls: what the depth of the skin is measured from.

#pragma once

#include "base/dual.h"
#include "betamesh/particles.h"
#include "exact/snapped_particles.h"
#include "skin/ball_boundary.h"

#include <vector>

namespace betamesh {

/// Points on the boundary of a union of balls. Each has:
struct OuterSamples {
    std::vector<DualVec3> point;     ///< world units, world units per second
    std::vector<float> weight;     ///< its share of the boundary, >= 0: spacings of arc length, square spacings of face
    std::vector<float> fading;     ///< 0 where it is fully there, towards 1 where it has only just appeared
    std::vector<float> isolation;  ///< inside faces the share of the ball that is exposed, from 0 to 1; on arcs 0
};

/// Samples the boundary of the union of balls of a larger radius round the same particles. Balls that are buried at the
/// smaller radius are buried at the larger one, too: only those exposed in `boundary` are looked at.
///
/// in      all particles within four smaller radii of the surface; spacing: of the particles, world units
/// out     samples no farther than half a radius apart, every vertex of the boundary among them. They appear and vanish
///         continuously in time
/// same    result for any thread count and particle order
/// cost    O(exposed balls · neighbours within two radii)
OuterSamples outerSamples(const Particles& particles, const SnappedParticles& snapped, const BallBoundary& boundary,
                          double radius, double spacing);

}  // namespace betamesh
