#include "skin/ball_powers.h"

#include "base/chosen_rows.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace betamesh {

BallPowers::BallPowers(const BallBoundary& boundary, const std::vector<std::uint32_t>& balls) : boundary_(boundary) {
    std::vector<Vec3> centre;
    std::vector<float> scale;
    for (const std::uint32_t ball : balls) {
        centre.push_back(boundary.centre(ball));
        if (!boundary.radius_of.empty()) scale.push_back(static_cast<float>(boundary.scaleOf(ball)));
    }
    std::vector<std::uint32_t> order;
    groups_ = PointGroups(centre, boundary.worldRadius(), scale, order);
    groups_.fitBoxes(chosenRows(centre, order));
    ball_ = chosenRows(balls, order);
}

double BallPowers::leastPower(const Vec3& point, const Triangle& without, double reach) const {
    double least = std::numeric_limits<double>::infinity();
    forBallsNear(point, reach, [&](std::uint32_t ball) {
        if (std::find(without.begin(), without.end(), ball) == without.end())
            least = std::min(least, (point - centre(ball)).length2() - squaredRadius(ball));
    });
    return least;
}

BallPowers::Middle BallPowers::middleOf(const Triangle& balls) const {
    const auto& [a, b, c] = balls;
    const Vec3 from = centre(a), u = centre(b) - from, v = centre(c) - from, normal = cross(u, v);
    const double square_of_normal = normal.length2(), r2 = squaredRadius(a);
    if (!(square_of_normal > 0)) return {Vec3(0), Vec3(0), -1, 0};
    const double uu = u.length2(), vv = v.length2(), uv = dot(u, v);
    const double to_b = (uu + r2 - squaredRadius(b)) / 2, to_c = (vv + r2 - squaredRadius(c)) / 2;
    const double s = (to_b * vv - to_c * uv) / square_of_normal, t = (to_c * uu - to_b * uv) / square_of_normal;
    const Vec3 offset = u * s + v * t;
    return {offset, normal / std::sqrt(square_of_normal), std::min({s, t, 1 - s - t}), offset.length2() - r2};
}

}  // namespace betamesh
