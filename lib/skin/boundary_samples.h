// The ball boundary as a cloud of weighted, directed points: what smoothing averages over.

#pragma once

#include "base/dual.h"
#include "skin/arc_network.h"
#include "skin/ball_boundary.h"
#include "skin/face_points.h"

#include <vector>

namespace betamesh {

/// One point that stands for a piece of the boundary: its mean, and how the piece lies about it. The cloud as a whole,
/// a measure on positions and directions, changes continuously in time, whatever appears, vanishes or changes
/// neighbours on the boundary.
struct BoundarySample {
    DualVec3 position;   ///< world units
    DualVec3 direction;  ///< outwards, length <= 1: short where the boundary is sharply creased
    Dual weight;       ///< world units of length, >= 0
    Dual spread = 0;   ///< mean squared distance of the piece from its position, square world units
    Dual bulge = 0;    ///< mean of (x - position) · (direction at x), world units: positive where the piece is convex
};

using BoundarySamples = std::vector<BoundarySample>;

/// The same in radii but for where it is, in single precision: as sums take it, and little to keep.
struct SampleInRadii {
    Vec3 position;  ///< world units
    Vec3f velocity, direction, turning;
    float weight, weight_rate, spread, half_spread_rate, bulge, bulge_rate;

    SampleInRadii() = default;
    SampleInRadii(const BoundarySample& sample, double radius)
        : position(sample.position.position),
          velocity(sample.position.velocity / radius),
          direction(sample.direction.position),
          turning(sample.direction.velocity),
          weight(static_cast<float>(sample.weight.value / radius)),
          weight_rate(static_cast<float>(sample.weight.rate / radius)),
          spread(static_cast<float>(sample.spread.value / (radius * radius))),
          half_spread_rate(static_cast<float>(sample.spread.rate / (2 * radius * radius))),
          bulge(static_cast<float>(sample.bulge.value / radius)),
          bulge_rate(static_cast<float>(sample.bulge.rate / radius)) {}
};
using SamplesInRadii = std::vector<SampleInRadii>;

/// One sample for what is exposed of a ball, where that is a small patch, as in the surface of a liquid; where it is
/// spread out, as on drops, sheets and edges, four, one towards each corner of a tetrahedron. In between there are
/// both, by shares, so that nothing jumps.
///
/// They stand for half of the length of the arcs and full circles round the ball: these change continuously when arcs
/// appear, vanish or change neighbours, and they are a calmer picture of the surface than the bulging faces are, whose
/// bumps' own normals cancel. Arcs are the valleys between the balls, so each counts half-way between itself and
/// the sphere of radius r round its centre; its direction is the mean of the two spheres' normals. Where arcs are
/// far away a face counts by its area; near arcs it fades out.
///
/// in      a boundary, its balls, its network of arcs and its face points, all with their motion
/// same    result for any thread count
/// cost    O(arcs + points)
SamplesInRadii boundarySamples(const BallBoundary& boundary, const std::vector<DualVec3>& balls,
                               const ArcNetwork& network, const FacePoints& points);

}  // namespace betamesh
