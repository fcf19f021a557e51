// Points inside the faces of the ball boundary, in fixed directions from each ball and towards balls about to touch it.

#pragma once

#include "base/dual.h"
#include "base/icosphere.h"
#include "exact/snapped_particles.h"
#include "skin/ball_boundary.h"

#include <cstdint>
#include <vector>

namespace betamesh {

/// Points begin[b] … begin[b + 1] - 1 lie on ball b, in directions that no other ball covers.
///
/// Clearance tells how far a point is from the rim of its face, continuously in time: the least over all caps,
/// each cut out of the sphere by another ball, of (cos α - cos β) / (sin α · min(1, sin α / kWideCap)), α the
/// half-angle of the cap, β the angle between its axis and the point. On wide caps about the angle to the rim in
/// radians; round narrow ones it rises quicker, so that a ball which only begins to touch changes nothing at a
/// distance.
struct FacePoints {
    struct Contact {
        DualVec3 direction;  ///< unit vector
        Dual touching;     ///< 0 where the other ball is too far to matter, 1 where the two touch
    };
    Icosphere directions;
    std::vector<Contact> contact;
    std::vector<std::uint32_t> begin{0};
    std::vector<std::uint32_t> direction;  ///< of each point; contacts are numbered after the fixed directions
    std::vector<Dual> rim_distance;           ///< of each point, > 0; kFullClearance where there is no cap

    /// Unit vector.
    DualVec3 outwards(std::uint32_t point) const {
        if (const Contact* touching = contactOf(point)) return touching->direction;
        return {directions.position[direction[point]], Vec3(0)};
    }
    /// Null for a point in a fixed direction.
    const Contact* contactOf(std::uint32_t point) const {
        const std::size_t fixed = directions.position.size();
        return direction[point] < fixed ? nullptr : &contact[direction[point] - fixed];
    }
};
inline constexpr double kFullClearance = 10;
inline constexpr double kWideCap = 0.28;

/// In those of fixed directions that are exposed on each ball, and towards other balls less than 0.1 radii away. Their
/// rim_distance changes as that of points which move with the liquid.
///
/// in      a boundary that was asked for these directions; its balls with their motion
/// same    result for any thread count and particle order
/// cost    O(points + balls that nearly touch others · neighbours)
FacePoints facePoints(const SnappedParticles& particles, const BallBoundary& boundary, const std::vector<DualVec3>& balls,
                      Icosphere directions);

}  // namespace betamesh
