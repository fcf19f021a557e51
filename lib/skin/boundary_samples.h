// The ball boundary as weighted samples with directions: what coherent smoothing averages over.

#pragma once

#include "base/dual.h"
#include "skin/arcs.h"
#include "skin/ball_boundary.h"
#include "skin/face_points.h"

#include <vector>

namespace betamesh {

/// A sample that represents a piece of the boundary by its mean position and direction and its second moments. All
/// samples together are a measure on positions and directions that changes continuously in time, even where parts of
/// the boundary appear, vanish or change their neighbours.
struct BoundarySample {
    DualVec3 position;   ///< world units
    DualVec3 direction;  ///< mean outward normal, length <= 1: short where the piece is strongly curved
    Dual weight;         ///< world units of length, >= 0
    Dual variance = 0;   ///< mean of |x - position|² over the piece, square world units
    Dual convexity = 0;  ///< mean of (x - position) · (normal at x) over the piece, world units; > 0 where it is convex
};

using BoundarySamples = std::vector<BoundarySample>;

/// A BoundarySample in single precision, in radii of the largest ball except for its position: compact, and what sums
/// read.
struct SampleInRadii {
    Vec3 position;  ///< world units
    Vec3f velocity, direction, direction_rate;
    float weight, weight_rate, variance, half_variance_rate, convexity, convexity_rate;
    float scale = 1;  ///< radius of its ball in those of the largest

    SampleInRadii() = default;
    SampleInRadii(const BoundarySample& sample, double radius, double ball_scale)
        : position(sample.position.position),
          velocity(sample.position.velocity / radius),
          direction(sample.direction.position),
          direction_rate(sample.direction.velocity),
          weight(static_cast<float>(sample.weight.value / radius)),
          weight_rate(static_cast<float>(sample.weight.rate / radius)),
          variance(static_cast<float>(sample.variance.value / (radius * radius))),
          half_variance_rate(static_cast<float>(sample.variance.rate / (2 * radius * radius))),
          convexity(static_cast<float>(sample.convexity.value / radius)),
          convexity_rate(static_cast<float>(sample.convexity.rate / radius)),
          scale(static_cast<float>(ball_scale)) {}
};
using SamplesInRadii = std::vector<SampleInRadii>;

/// Samples of a ball boundary. The exposed part of a ball gives one sample where it is a small patch, as in the surface
/// of a liquid, and four, one towards each corner of a tetrahedron, where it is large, as on drops, sheets and edges.
/// In between the weight moves continuously from the one to the four.
///
/// The samples of a ball represent half the length of the arcs and full circles around it. That measure changes
/// continuously when arcs appear, vanish or change their neighbours, and it is smoother than the faces, whose area is
/// dominated by the bumps of single balls. Arcs are the valleys between balls; each is therefore lifted by kArcLift
/// towards the sphere of radius r round its centre. Its direction is the mean of the two spheres' normals. Faces far
/// from any arc count by their area, which fades out near arcs. Among balls of different radii the weights of a ball's
/// samples are multiplied by its radius in those of the largest: small balls have more arcs per area.
///
/// in      a boundary, its balls, its arcs and its face points, with their velocities
/// same    result for any thread count
/// cost    O(arcs + points)
SamplesInRadii boundarySamples(const BallBoundary& boundary, const std::vector<DualVec3>& balls,
                               const ArcNetwork& network, const FacePoints& points);

}  // namespace betamesh
