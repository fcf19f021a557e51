#include "skin/face_point_placement.h"

#include "base/intersection_circle.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace betamesh {

CompressedRows<NearTangentNeighbour> nearTangentNeighbours(const BallBoundary& boundary,
                                                           const std::vector<DualVec3>& balls,
                                                           const ArcNetwork& network, const FacePoints& points) {
    return sortedIntoRows<NearTangentNeighbour>(balls.size(), balls.size(), [&](std::size_t b, const auto& visit) {
        const Dual radius = boundary.worldRadiusOf(b);
        for (const std::uint32_t l : network.at_ball[b]) {
            const ArcLine& line = network.line[l];
            if (line.radius.value >= kWideCapSine * radius.value) continue;
            const std::uint32_t other = line.balls[line.balls[0] == b ? 1 : 0];
            const DualVec3 offset = balls[other] - balls[b];
            const Dual distance = length(offset), r = boundary.worldRadiusOf(other);
            visit(b, NearTangentNeighbour{offset / distance, heightOfIntersection(distance, radius, r)});
        }
        for (std::uint32_t p = points.begin[b]; p < points.begin[b + 1]; ++p)
            if (const FacePoints::Contact* contact = points.contactOf(p))
                visit(b, NearTangentNeighbour{contact->direction,
                                              1 + (1 - contact->weight) * (kOffsetFull * kWideCapSine)});
    });
}

FacePointPlacement::FacePointPlacement(const FacePoints& points, const ArcSubdivision& subdivision)
    : points_(points), gradual_(subdivision.appearance == Appearance::gradual) {
    // Each of n directions has a cell of area 4π / n, the area of two equilateral triangles of side `spacing_`.
    const double n = static_cast<double>(points.directions.position.size());
    spacing_ = std::sqrt(8 * std::numbers::pi / (std::sqrt(3.0) * n));
    double volume = 0;
    for (const auto& [a, b, c] : points.directions.triangles) {
        const std::vector<Vec3>& p = points.directions.position;
        volume += dot(p[a], cross(p[b], p[c])) / 6;
    }
    lowering_depth_ = subdivision.is_retracted
                          ? kLoweringDepthSagittas * subdivision.max_angle * subdivision.max_angle / 8
                          : kLoweringDepth * spacing_ * spacing_;
    flip_distance_ = (subdivision.is_retracted ? kRetractedFlipDistance : kFlipDistance) * spacing_ * spacing_;
    offset_ = std::cbrt(4 * std::numbers::pi / 3 / volume) - 1;
}

}  // namespace betamesh
