// Points inside the faces of the ball boundary: in fixed directions from each ball, and towards balls near contact.

#pragma once

#include "base/dual.h"
#include "base/icosphere.h"
#include "exact/snapped_particles.h"
#include "skin/ball_boundary.h"
#include "skin/constants.h"

#include <cstdint>
#include <vector>

namespace betamesh {

/// Points begin[b] … begin[b + 1] - 1 lie on ball b, in directions that no other ball covers.
///
/// The rim distance of a point says how far it is from the rim of its face, continuously in time. It is the least over
/// all caps, each cut out of the sphere by another ball, of (cos α - cos β) / (sin α · min(1, sin α / kWideCapSine)),
/// with α the half-angle of the cap and β the angle between its axis and the point. On wide caps that is about the
/// angle to the rim in radians; round narrow caps it rises faster, so that a ball which barely touches has no influence
/// at a distance.
struct FacePoints {
    /// A point in the direction of a ball that is about to touch this one.
    struct Contact {
        DualVec3 direction;  ///< unit vector
        Dual weight;         ///< contact weight: 0 where the gap is kContactGap radii of the smaller ball, 1 where they
                             ///< touch
    };
    Icosphere directions;
    std::vector<Contact> contact;
    std::vector<std::uint32_t> begin{0};
    std::vector<std::uint32_t> direction;  ///< of each point: a fixed direction, then contacts
    std::vector<Dual> rim_distance;        ///< of each point, in (0, kMaxRimDistance]; the latter without caps

    /// Unit vector from the ball's centre.
    DualVec3 outwards(std::uint32_t point) const {
        if (const Contact* contact_point = contactOf(point)) return contact_point->direction;
        return {directions.position[direction[point]], Vec3(0)};
    }
    /// Null if the point is in a fixed direction.
    const Contact* contactOf(std::uint32_t point) const {
        const std::size_t fixed = directions.position.size();
        return direction[point] < fixed ? nullptr : &contact[direction[point] - fixed];
    }
};

/// The points in those of the fixed directions that are exposed on each ball, and towards balls less than kContactGap
/// away. Rim distances carry the rate of change of points that move with the liquid.
///
/// in      a boundary computed with these directions; its balls with their motion
/// same    result for any thread count and particle order
/// cost    O(points + balls near contact · neighbours)
FacePoints facePoints(const SnappedParticles& particles, const BallBoundary& boundary,
                      const std::vector<DualVec3>& balls, Icosphere directions);

}  // namespace betamesh
