// Where the points inside faces lie: on the sphere, or lowered below it near rims; and how they fade in.

#pragma once

#include "base/compressed_rows.h"
#include "base/dual.h"
#include "skin/arcs.h"
#include "skin/constants.h"
#include "skin/face_points.h"

#include <span>
#include <vector>

namespace betamesh {

/// A neighbour that barely touches a ball, or is about to. Seen from the ball it covers, or will cover, a narrow cap,
/// and there is space beside that where the cosine of the angle to `towards` is far below `rim`.
struct NearTangentNeighbour {
    DualVec3 towards;  ///< unit vector
    Dual rim;          ///< cosine of the cap's half-angle; above 1 if the balls do not touch yet
};

/// The near-tangent neighbours of each ball that no wider cap covers; on others the rim of the wider cap is nearer.
CompressedRows<NearTangentNeighbour> nearTangentNeighbours(const BallBoundary& boundary,
                                                           const std::vector<DualVec3>& balls,
                                                           const ArcNetwork& network, const FacePoints& points);

/// Positions of face points relative to their balls, in ball radii. Points are rows of FacePoints. With
/// Appearance::on_boundary all lie on the sphere, and those too close to a rim are not used. With Appearance::gradual
/// they are lowered below the sphere near rims, until the hull passes over them.
class FacePointPlacement {
public:
    FacePointPlacement(const FacePoints& points, const ArcSubdivision& subdivision);

    bool isUsed(std::uint32_t p) const {
        return gradual_ || (points_.rim_distance[p].value >= kMinRimSpacings * spacing_ && !points_.contactOf(p));
    }
    bool isLowered(std::uint32_t p) const {
        return gradual_ && (points_.rim_distance[p].value < kLoweringRimSpacings * spacing_ || points_.contactOf(p));
    }
    DualVec3 at(std::uint32_t p) const {
        const DualVec3 direction = points_.outwards(p);
        if (!isLowered(p)) return direction;
        const Dual near_rim = nearnessToRim(p), gap = oneMinusContact(p);
        return direction *
               (1 - (near_rim * near_rim * lowering_depth_ + gap * gap * (kContactDepth * spacing_ * spacing_)));
    }

    /// Is a point far enough from any rim for a volume-compensating offset?
    bool hasVolumeOffset(std::uint32_t p) const {
        return gradual_ && points_.rim_distance[p].value > kOffsetBegins && !points_.contactOf(p);
    }
    /// That offset, outwards, in radii: it gives an isolated drop the volume of its ball. It fades out towards
    /// near-tangent neighbours, so that two drops do not grow into each other: unlike rim distances, distances from
    /// narrow caps are not scaled up here.
    DualVec3 volumeOffset(std::uint32_t p, std::span<const NearTangentNeighbour> near_tangent) const {
        const DualVec3 outwards = points_.outwards(p);
        Dual margin = points_.rim_distance[p];
        for (const auto& [towards, rim] : near_tangent) {
            const Dual here = (rim - dot(outwards, towards)) / kWideCapSine;
            if (here.value < margin.value) margin = here;
        }
        return outwards * (smoothStep((margin - kOffsetBegins) / (kOffsetFull - kOffsetBegins)) * offset_);
    }

    /// Rim distance of the vertex at a point: contact points approach 0, as the rim of the common circle will be there.
    Dual rimDistance(std::uint32_t p) const {
        return points_.contactOf(p) ? points_.rim_distance[p] * oneMinusContact(p) : points_.rim_distance[p];
    }

    /// Height over the facet beneath, in radii, from which on a point is not blended towards it.
    double freeHeight() const { return kFreeHeight * spacing_ * spacing_; }
    /// Fade weight of a lowered point at this height over the facet beneath it, in radii: 0 on the facet, 1 where the
    /// point is not lowered or is free.
    Dual fadeWeight(std::uint32_t p, Dual height) const {
        const Dual near_rim = nearnessToRim(p), gap = oneMinusContact(p);
        const Dual lowering = near_rim.value < gap.value ? gap : near_rim;
        const Dual strength = lowering.value < kFullBlendDepth ? lowering / kFullBlendDepth : Dual(1);
        return 1 - strength * (1 - smoothStep(height / freeHeight()));
    }

    /// Distance between the diagonals of a quad, in radii, below which an edge flip is in progress.
    double flipDistance() const { return flip_distance_; }

private:
    // From 0, where a point is not lowered, to 1 at the rim of its face. Touching balls have no rim at the contact.
    Dual nearnessToRim(std::uint32_t p) const {
        const Dual below = 1 - points_.rim_distance[p] / (kLoweringRimSpacings * spacing_);
        if (below.value <= 0) return 0;
        return points_.contactOf(p) ? below * oneMinusContact(p) : below;
    }
    // 1 - contact weight of a contact point: 0 where the balls touch, 1 where the gap is kContactGap. 0 for others.
    Dual oneMinusContact(std::uint32_t p) const {
        const FacePoints::Contact* contact = points_.contactOf(p);
        return contact ? 1 - contact->weight : Dual(0);
    }

    const FacePoints& points_;
    bool gradual_;
    double spacing_;                                  // angle between neighbouring directions, radians
    double lowering_depth_, flip_distance_, offset_;  // radii
};

}  // namespace betamesh
