// Samples of the boundary of the union of larger balls, from which the depth of the skin is measured.

#pragma once

#include "base/dual.h"
#include "betamesh/particles.h"
#include "exact/snapped_particles.h"
#include "skin/arcs.h"
#include "skin/ball_boundary.h"
#include "skin/skin_lengths.h"

#include <vector>

namespace betamesh {

/// Points on the boundary of a union of balls. Row i of every array is sample i.
struct OuterSamples {
    std::vector<DualVec3> point;  ///< world units, world units per second
    std::vector<float> weight;    ///< >= 0: length of arc in particle spacings there, or area of face in their squares
    /// Added to squared distances from the sample, in squared spacings there: 0 for a permanent sample, more for one
    /// that has just appeared, or where a smaller ball rolls.
    std::vector<float> squared_offset;
    std::vector<float> exposure;  ///< inside faces the exposed share of the ball, 0 to 1; 0 on arcs
    std::vector<float> scale;     ///< of the ball that rolls there, in those beside the largest balls; empty: all 1
    std::vector<float> growth;    ///< of the ball that rolls there: change of its radius, world units per second; empty
                                  ///< where no ball changes, otherwise `scale` is not
};

/// The points of a network, with those that fade in in full: on the arc.
std::vector<DualVec3> unfadedPoints(const ArcNetwork& network);

/// For each point of a network the length of arc that it stands for, in particle spacings there. Of a point that fades
/// in, the part that it lacks belongs to its neighbours.
std::vector<float> weightsOfPoints(const BallBoundary& boundary, const ArcNetwork& network,
                                   const std::vector<DualVec3>& unfaded, double spacing);

/// Samples the boundary of the union of balls of radius outer() around the same particles. Balls of one radius that are
/// covered at the smaller radius are covered at the larger one, too; only those exposed in `boundary` are examined.
///
/// Among balls of different radii all are enlarged in proportion. The ball that rolls at a point touches the skin of
/// the nearest particle: where small particles lie beside large ones it is so small that they stay inside the surface.
///
/// in      all particles within two larger radii of the surface, with different radii within three; lengths: in
///         spacings; spacing: of the particles with the largest balls, world units
/// out     samples at most half a radius apart, including every vertex of the boundary; their weights change
///         continuously in time
/// same    result for any thread count and particle order
/// cost    O(exposed balls · neighbours within two radii)
OuterSamples outerSamples(const Particles& particles, const SnappedParticles& snapped, const BallBoundary& boundary,
                          const SkinLengths& lengths, double spacing);

}  // namespace betamesh
