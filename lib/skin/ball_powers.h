// The balls of a boundary by place, to be asked for powers: squared distances to centres less squared radii.

#pragma once

#include "skin/ball_boundary.h"
#include "skin/neighbourhoods.h"

#include <algorithm>
#include <vector>

namespace betamesh {

/// Chosen balls of a boundary, all in world units.
class BallPowers {
public:
    /// balls: rows of the boundary, ascending; it is referred to
    ///
    /// cost    O(balls)
    BallPowers(const BallBoundary& boundary, const std::vector<std::uint32_t>& balls);

    Vec3 centre(std::uint32_t ball) const { return boundary_.centre(ball); }
    double squaredRadius(std::uint32_t ball) const {
        const double radius = boundary_.worldRadiusOf(ball).value;
        return radius * radius;
    }
    /// Spacing of the smallest particle of some balls, if that of the largest ball is `of_largest`.
    template <typename Balls>
    double spacingOf(const Balls& balls, double of_largest) const {
        double scale = 1;
        for (const std::uint32_t ball : balls) scale = std::min(scale, boundary_.scaleOf(ball));
        return of_largest * scale;
    }

    /// Calls visit(ball) for the chosen balls that come within reach of a point, and a few more.
    template <typename Visit>
    void forBallsNear(const Vec3& point, double reach, const Visit& visit) const {
        groups_.forGroupsNear(
            Box(point, point), [&](double scale) { return scale * boundary_.worldRadius() + reach; },
            [&](std::uint32_t group, std::uint32_t) {
                for (std::uint32_t i = groups_.begin(group); i < groups_.begin(group + 1); ++i) visit(ball_[i]);
            });
    }
    /// The least power of a point to the chosen balls within reach of it, but for three.
    double leastPower(const Vec3& point, const Triangle& without, double reach) const;

    /// The point in the plane of three centres that has the same power to the three balls.
    struct Middle {
        Vec3 offset;    ///< from the first centre
        Vec3 normal;    ///< of the plane, unit vector
        double inside;  ///< the least of its barycentric coordinates: above 0 inside the triangle of the centres
        double power;   ///< below 0 where the spheres have common points, as far above the plane as its root
    };
    /// With inside = -1 if the centres are collinear.
    Middle middleOf(const Triangle& balls) const;

private:
    const BallBoundary& boundary_;
    PointGroups groups_;
    std::vector<std::uint32_t> ball_;  // in groups_
};

}  // namespace betamesh
