#include "skin/meetings.h"

#include "base/angles.h"
#include "base/chosen_rows.h"
#include "base/parallel.h"
#include "skin/constants.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace betamesh {

namespace {

// 1 up to half of the reach, then down to 0.
double within(double distance, double reach) { return 1 - smoothStep(2 * distance / reach - 1).value; }

double square(double x) { return x * x; }

// Two balls that meet on the boundary.
struct Pair {
    std::array<std::uint32_t, 2> balls;  // ascending
    double radius;                       // of the circle in which they meet, world units
    double exposed;                      // share of the circle that no other ball covers
};

// Ascending.
std::vector<Pair> pairsOf(const ArcNetwork& network) {
    std::vector<Pair> pairs;
    for (const ArcLine& line : network.line)
        pairs.push_back({line.balls, line.radius.value, line.length.value / (kTwoPi * line.radius.value)});
    std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.balls < b.balls; });
    std::size_t kept = 0;
    for (const Pair& pair : pairs)
        if (kept > 0 && pairs[kept - 1].balls == pair.balls)
            pairs[kept - 1].exposed += pair.exposed;
        else
            pairs[kept++] = pair;
    pairs.resize(kept);
    return pairs;
}

// Spacing of the particles of two or three balls, world units.
template <typename Balls>
double spacingOf(const BallBoundary& boundary, const Balls& balls, double of_largest) {
    double scale = 1;
    for (const std::uint32_t ball : balls) scale = std::min(scale, boundary.scaleOf(ball));
    return of_largest * scale;
}

void addTips(const BallBoundary& boundary, const FacePoints& points, double spacing, std::vector<Meeting>& found) {
    for (std::size_t ball = 0; ball < boundary.position.size(); ++ball)
        for (std::uint32_t p = points.begin[ball]; p < points.begin[ball + 1]; ++p) {
            const FacePoints::Contact* contact = points.contactOf(p);
            if (!contact) continue;
            const Vec3& axis = contact->direction.position;
            if (std::array{axis.x, axis.y, axis.z} < std::array{-axis.x, -axis.y, -axis.z})
                continue;  // the other ball has this contact, too
            const double radius = boundary.worldRadiusOf(ball).value, weight = contact->weight.value;
            found.push_back({boundary.centre(ball) + axis * (radius * (1 + (1 - weight) * kContactGap / 2)), axis,
                             spacing * boundary.scaleOf(ball), kNeckLength, kNeckWidth,
                             smoothStep(2 * weight - 1).value, 0});
        }
}

void addNecks(const BallBoundary& boundary, const std::vector<Pair>& pairs, double spacing,
              std::vector<Meeting>& found) {
    for (const Pair& pair : pairs) {
        const auto& [a, b] = pair.balls;
        const double there = spacingOf(boundary, pair.balls, spacing), radius = pair.radius / there;
        const double nearness = within(radius, kThinNeck) * smoothStep(2 * pair.exposed - 1).value;
        const Vec3 from = boundary.centre(a), way = boundary.centre(b) - from;
        const double distance = way.length();
        if (!(nearness > 0) || !(distance > 0)) continue;
        const double r = boundary.worldRadiusOf(a).value, other = boundary.worldRadiusOf(b).value;
        const double along = (distance + (square(r) - square(other)) / distance) / 2;
        const Vec3 axis = way / distance;
        found.push_back({from + axis * along, axis, there, kNeckLength, kNeckWidth, nearness,
                         std::min(kLeastNeck, radius / 2) * nearness});
    }
}

// Finds holes and membranes: where three balls, each two of which meet on the boundary, have their spheres' common
// points close to their plane, or would have, were they a little larger.
class HoleFinder {
public:
    HoleFinder(const BallBoundary& boundary, const std::vector<Pair>& pairs, double spacing)
        : boundary_(boundary), pairs_(pairs), spacing_(spacing) {
        std::vector<float> scale;
        for (std::size_t ball = 0; ball < boundary.position.size(); ++ball) {
            centre_.push_back(boundary.centre(ball));
            if (!boundary.radius_of.empty()) scale.push_back(static_cast<float>(boundary.scaleOf(ball)));
        }
        groups_ = PointGroups(centre_, boundary.worldRadius(), scale, order_);
        groups_.fitBoxes(chosenRows(centre_, order_));
    }

    std::vector<Meeting> find() const {
        using Meetings = std::vector<Meeting>;
        return concatenate(parallelParts<Meetings>(pairs_.size(), 4096, [&](auto first, auto last, Meetings& found) {
            for (std::size_t i = first; i < last; ++i)
                for (std::size_t j = i + 1; j < pairs_.size() && pairs_[j].balls[0] == pairs_[i].balls[0]; ++j)
                    add(pairs_[i], pairs_[j], found);
        }));
    }

private:
    void add(const Pair& one, const Pair& two, std::vector<Meeting>& found) const {
        const std::uint32_t a = one.balls[0], b = one.balls[1], c = two.balls[1];
        const Vec3 u = centre_[b] - centre_[a], v = centre_[c] - centre_[a], normal = cross(u, v);
        const double square_of_normal = normal.length2(), r2 = squaredRadiusOf(a);
        if (!(square_of_normal > 0)) return;
        // The point of their plane that has the same power to the three, in barycentric coordinates: inside the
        // triangle where a hole is.
        const double uu = u.length2(), vv = v.length2(), uv = dot(u, v);
        const double to_b = (uu + r2 - squaredRadiusOf(b)) / 2, to_c = (vv + r2 - squaredRadiusOf(c)) / 2;
        const double s = (to_b * vv - to_c * uv) / square_of_normal, t = (to_c * uu - to_b * uv) / square_of_normal;
        double nearness = smoothStep(std::min({s, t, 1 - s - t}) / kHoleInside).value;
        if (!(nearness > 0)) return;
        const Vec3 offset = u * s + v * t;
        const Triangle balls{a, b, c};
        const double power = offset.length2() - r2, there = spacingOf(boundary_, balls, spacing_);
        nearness *= 1 - std::min(1.0, std::sqrt(std::abs(power)) / (kThinMembrane * there));
        if (!(nearness > 0)) return;
        const std::array third{b, c};
        const auto three = std::lower_bound(pairs_.begin(), pairs_.end(), third,
                                            [](const Pair& pair, const auto& sought) { return pair.balls < sought; });
        if (three == pairs_.end() || three->balls != third) return;
        nearness *= smoothStep(std::min({one.radius, two.radius, three->radius}) / (kHoleCircle * there)).value;
        const Vec3 middle = centre_[a] + offset;
        const double faded = kHoleCovered * square(there), reach = kThinMembrane * there;
        const auto exposure = [&](const Vec3& point, double its_power) {  // below 0 where other balls cover it
            return (leastPower(point, balls, reach) - its_power) / faded;
        };
        nearness *= smoothStep(1 + exposure(middle, power)).value;
        for (const Pair* pair : {&one, &two, &*three}) {  // the point of its circle that is nearest to the middle
            if (!(nearness > 0)) return;
            const Vec3 from = centre_[pair->balls[0]], axis = (centre_[pair->balls[1]] - from).normalized();
            const Vec3 across = middle - from - axis * dot(middle - from, axis);
            nearness *= smoothStep(exposure(middle + across * (pair->radius / across.length() - 1), 0)).value;
        }
        if (!(nearness > 0)) return;
        found.push_back({middle, normal / std::sqrt(square_of_normal), there, kHoleLength, kHoleWidth, nearness, 0});
    }

    double squaredRadiusOf(std::uint32_t ball) const { return square(boundary_.worldRadiusOf(ball).value); }

    // The least power of a point to the other balls within reach of it.
    double leastPower(const Vec3& point, const Triangle& balls, double reach) const {
        double least = std::numeric_limits<double>::infinity();
        groups_.forGroupsNear(
            Box(point, point), [&](double scale) { return scale * boundary_.worldRadius() + reach; },
            [&](std::uint32_t group, std::uint32_t) {
                for (std::uint32_t i = groups_.begin(group); i < groups_.begin(group + 1); ++i)
                    if (const std::uint32_t d = order_[i]; std::find(balls.begin(), balls.end(), d) == balls.end())
                        least = std::min(least, (point - centre_[d]).length2() - squaredRadiusOf(d));
            });
        return least;
    }

    const BallBoundary& boundary_;
    const std::vector<Pair>& pairs_;
    double spacing_;
    std::vector<Vec3> centre_;
    PointGroups groups_;
    std::vector<std::uint32_t> order_;  // of the balls in groups_
};

// Calls visit(meeting, vertex, along, across) for the vertices near meetings: how far from the middle along the axis,
// and the offset from the axis, both in particle spacings there.
template <typename Visit>
void forVerticesNear(const std::vector<Meeting>& meetings, const std::vector<Vec3>& position,
                     const DeformingMesh& surface, const Visit& visit) {
    const PointGroups& groups = surface.groups();
    for (const Meeting& meeting : meetings) {
        const double farthest = std::max(meeting.length, meeting.width) + 1;  // smoothing moves vertices by less than 1
        const Vec3 reach(farthest * meeting.spacing);
        groups.forGroupsNear(
            Box(meeting.middle - reach, meeting.middle + reach), [](double) { return 0.0; },
            [&](std::uint32_t group, std::uint32_t) {
                for (std::uint32_t v = groups.begin(group); v < groups.begin(group + 1); ++v) {
                    const Vec3 offset = (position[v] - meeting.middle) / meeting.spacing;
                    const double along = dot(offset, meeting.axis);
                    const Vec3 across = offset - meeting.axis * along;
                    if (std::abs(along) < meeting.length && across.length2() < square(meeting.width))
                        visit(meeting, v, along, across);
                }
            });
    }
}

}  // namespace

std::vector<Meeting> meetings(const BallBoundary& boundary, const ArcNetwork& network, const FacePoints& points,
                              double spacing) {
    const std::vector<Pair> pairs = pairsOf(network);
    std::vector<Meeting> found = HoleFinder(boundary, pairs, spacing).find();
    addTips(boundary, points, spacing, found);
    addNecks(boundary, pairs, spacing, found);
    return found;
}

std::vector<float> keepMeetings(const std::vector<Meeting>& meetings, const std::vector<Vec3>& retracted,
                                DeformingMesh& surface) {
    const std::vector<Vec3>& position = surface.position();
    std::vector<float> kept(surface.size(), 1);
    if (meetings.empty()) return kept;
    forVerticesNear(
        meetings, retracted, surface, [&](const Meeting& meeting, std::uint32_t v, double along, const Vec3& across) {
            const double share = within(std::abs(along), meeting.length) * within(across.length(), meeting.width);
            kept[v] = std::min(kept[v], static_cast<float>(1 - meeting.nearness * share));
        });
    std::vector<Vec3f> step(surface.size(), Vec3f(0));
    for (std::size_t v = 0; v < kept.size(); ++v)
        if (kept[v] < 1) step[v] = Vec3f((retracted[v] - position[v]) / surface.spacing()) * (1 - kept[v]);
    surface.move(step);
    std::fill(step.begin(), step.end(), Vec3f(0));
    forVerticesNear(
        meetings, position, surface, [&](const Meeting& neck, std::uint32_t v, double along, const Vec3& across) {
            const double least = neck.least * within(std::abs(along), neck.length), r = across.length();
            if (!(r > 0)) return;
            const double pushed = std::sqrt(r * r + least * least) - r;
            step[v] += Vec3f(across * (pushed * within(r, neck.width) / r * (neck.spacing / surface.spacing())));
        });
    surface.move(step);
    surface.measure();
    return kept;
}

}  // namespace betamesh
