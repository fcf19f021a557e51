#include "skin/meetings.h"

#include "base/angles.h"
#include "base/parallel.h"
#include "skin/ball_powers.h"
#include "skin/constants.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace betamesh {

namespace {

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

void addTips(const BallBoundary& boundary, const FacePoints& points, double spacing, std::vector<Meeting>& found) {
    for (std::size_t ball = 0; ball < boundary.position.size(); ++ball)
        for (std::uint32_t p = points.begin[ball]; p < points.begin[ball + 1]; ++p) {
            const FacePoints::Contact* contact = points.contactOf(p);
            if (!contact) continue;
            const Vec3& axis = contact->direction.position;
            if (std::array{axis.x, axis.y, axis.z} < std::array{-axis.x, -axis.y, -axis.z})
                continue;  // the other ball has this contact, too
            const double radius = boundary.worldRadiusOf(ball).value, weight = contact->weight.value;
            found.push_back({{boundary.centre(ball) + axis * (radius * (1 + (1 - weight) * kContactGap / 2)), axis,
                              spacing * boundary.scaleOf(ball), kNeckLength, kNeckWidth},
                             smoothStep(2 * weight - 1).value,
                             0});
        }
}

void addNecks(const BallPowers& powers, const std::vector<Pair>& pairs, double spacing, std::vector<Meeting>& found) {
    for (const Pair& pair : pairs) {
        const auto& [a, b] = pair.balls;
        const double there = powers.spacingOf(pair.balls, spacing), radius = pair.radius / there;
        const double nearness = within(radius, kThinNeck) * smoothStep(2 * pair.exposed - 1).value;
        const Vec3 from = powers.centre(a), way = powers.centre(b) - from;
        const double distance = way.length();
        if (!(nearness > 0) || !(distance > 0)) continue;
        const double along = (distance + (powers.squaredRadius(a) - powers.squaredRadius(b)) / distance) / 2;
        const Vec3 axis = way / distance;
        found.push_back({{from + axis * along, axis, there, kNeckLength, kNeckWidth},
                         nearness,
                         std::min(kLeastNeck, radius / 2) * nearness});
    }
}

// Finds holes and membranes: where three balls, each two of which meet on the boundary, have their spheres' common
// points close to their plane, or would have, were they a little larger.
class HoleFinder {
public:
    HoleFinder(const BallPowers& powers, const std::vector<Pair>& pairs, double spacing)
        : powers_(powers), pairs_(pairs), spacing_(spacing) {}

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
        const Triangle balls{one.balls[0], one.balls[1], two.balls[1]};
        const auto [offset, axis, inside, power] = powers_.middleOf(balls);
        double nearness = smoothStep(inside / kHoleInside).value;
        if (!(nearness > 0)) return;
        const double there = powers_.spacingOf(balls, spacing_);
        nearness *= 1 - std::min(1.0, std::sqrt(std::abs(power)) / (kThinMembrane * there));
        if (!(nearness > 0)) return;
        const std::array third{balls[1], balls[2]};
        const auto three = std::lower_bound(pairs_.begin(), pairs_.end(), third,
                                            [](const Pair& pair, const auto& sought) { return pair.balls < sought; });
        if (three == pairs_.end() || three->balls != third) return;
        nearness *= smoothStep(std::min({one.radius, two.radius, three->radius}) / (kHoleCircle * there)).value;
        const Vec3 middle = powers_.centre(balls[0]) + offset;
        const double faded = kHoleCovered * square(there), reach = kThinMembrane * there;
        const auto exposure = [&](const Vec3& point, double its_power) {  // below 0 where other balls cover it
            return (powers_.leastPower(point, balls, reach) - its_power) / faded;
        };
        nearness *= smoothStep(1 + exposure(middle, power)).value;
        for (const Pair* pair : {&one, &two, &*three}) {  // the point of its circle that is nearest to the middle
            if (!(nearness > 0)) return;
            const Vec3 from = powers_.centre(pair->balls[0]), axis_of_pair = powers_.centre(pair->balls[1]) - from;
            const Vec3 along = axis_of_pair.normalized(), across = middle - from - along * dot(middle - from, along);
            nearness *= smoothStep(exposure(middle + across * (pair->radius / across.length() - 1), 0)).value;
        }
        if (nearness > 0) found.push_back({{middle, axis, there, kHoleLength, kHoleWidth}, nearness, 0});
    }

    const BallPowers& powers_;
    const std::vector<Pair>& pairs_;
    double spacing_;
};

}  // namespace

std::vector<Meeting> meetings(const BallBoundary& boundary, const ArcNetwork& network, const FacePoints& points,
                              double spacing) {
    const std::vector<Pair> pairs = pairsOf(network);
    const BallPowers powers(boundary, allRows(boundary.position.size()));
    std::vector<Meeting> found = HoleFinder(powers, pairs, spacing).find();
    addTips(boundary, points, spacing, found);
    addNecks(powers, pairs, spacing, found);
    return found;
}

std::vector<float> keepMeetings(const std::vector<Meeting>& meetings, const std::vector<Vec3>& retracted,
                                DeformingMesh& surface) {
    const std::vector<Vec3>& position = surface.position();
    std::vector<float> kept(surface.size(), 1);
    if (meetings.empty()) return kept;
    constexpr double kFarthest = 1;  // smoothing moves vertices by less
    for (const Meeting& meeting : meetings)
        forVerticesNear(meeting, kFarthest, retracted, surface, [&](std::uint32_t v, double along, const Vec3& across) {
            const double share = within(std::abs(along), meeting.length) * within(across.length(), meeting.width);
            kept[v] = std::min(kept[v], static_cast<float>(1 - meeting.nearness * share));
        });
    std::vector<Vec3f> step(surface.size(), Vec3f(0));
    for (std::size_t v = 0; v < kept.size(); ++v)
        if (kept[v] < 1) step[v] = Vec3f((retracted[v] - position[v]) / surface.spacing()) * (1 - kept[v]);
    surface.move(step);
    std::fill(step.begin(), step.end(), Vec3f(0));
    for (const Meeting& neck : meetings)
        forVerticesNear(neck, kFarthest, position, surface, [&](std::uint32_t v, double along, const Vec3& across) {
            const double least = neck.least * within(std::abs(along), neck.length), r = across.length();
            if (!(r > 0)) return;
            const double pushed = std::sqrt(r * r + least * least) - r;
            step[v] += Vec3f(across * (pushed * within(r, neck.width) / r * (neck.unit / surface.spacing())));
        });
    surface.move(step);
    surface.measure();
    return kept;
}

}  // namespace betamesh
