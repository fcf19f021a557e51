#include "skin/pinholes.h"

#include "base/parallel.h"
#include "skin/ball_powers.h"
#include "skin/constants.h"
#include "skin/place.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace betamesh {

namespace {

struct Pinhole : Place {
    double narrowing;  // 0 to 1
};

// The balls near edges across which the surface turns; elsewhere, drawing it together would change nothing.
std::vector<std::uint32_t> ballsNearTurns(const BallBoundary& boundary, const DeformingMesh& surface) {
    std::vector<std::uint8_t> turns(surface.size(), 0);
    for (const Triangle& t : surface.mesh().triangles)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = t[k], b = t[(k + 1) % 3];
            if (surface.normals()[a].dot(surface.normals()[b]) < static_cast<float>(kPinholeTurn))
                turns[a] = turns[b] = 1;
        }
    const PointGroups& groups = surface.groups();
    std::vector<std::uint8_t> has_turns(groups.size());
    for (std::size_t group = 0; group < groups.size(); ++group)
        has_turns[group] = std::any_of(turns.begin() + groups.begin(group), turns.begin() + groups.begin(group + 1),
                                       [](std::uint8_t turning) { return turning != 0; });
    return indicesWhere(boundary.position.size(), [&](std::uint32_t ball) {
        const Vec3 centre = boundary.centre(ball);
        const double reach = (1 + kPinholeReach) * boundary.worldRadiusOf(ball).value;
        bool is_near = false;
        groups.forGroupsNear(
            Box(centre, centre), [&](double) { return reach; },
            [&](std::uint32_t group, std::uint32_t) { is_near |= has_turns[group] != 0; });
        return is_near;
    });
}

class PinholeFinder {
public:
    PinholeFinder(const BallBoundary& boundary, const std::vector<std::uint32_t>& balls)
        : powers_(boundary, balls), balls_(balls) {}

    std::vector<Pinhole> find() const {
        using Found = std::vector<Pinhole>;
        return concatenate(parallelParts<Found>(balls_.size(), 64, [&](auto first, auto last, Found& found) {
            for (std::size_t i = first; i < last; ++i) addAt(balls_[i], found);
        }));
    }

private:
    // Those between a ball and two others that are as large, with higher rows, or larger.
    void addAt(std::uint32_t ball, std::vector<Pinhole>& found) const {
        const double own = powers_.squaredRadius(ball), widest = square(2 * kPinholeRadius) * own;
        const auto farthest = [&](double squared_radius) { return std::sqrt(squared_radius + widest); };
        const Vec3 centre = powers_.centre(ball);
        std::vector<std::uint32_t> near;
        powers_.forBallsNear(centre, farthest(own) + std::sqrt(widest), [&](std::uint32_t other) {
            const double theirs = powers_.squaredRadius(other);
            if (std::pair(theirs, other) > std::pair(own, ball) &&
                (powers_.centre(other) - centre).length2() < square(farthest(own) + farthest(theirs)))
                near.push_back(other);
        });
        if (near.size() > kMaxPinholeNeighbours) return;
        std::sort(near.begin(), near.end());
        // Seen from the middle, two of the three sides subtend at least a right angle. So one of those at this ball
        // does.
        const double shortest = 2 * own * (1 - square(kPinholeMembrane));
        const auto far = std::stable_partition(near.begin(), near.end(), [&](std::uint32_t other) {
            return (powers_.centre(other) - centre).length2() < shortest;
        });
        for (auto b = far; b != near.end(); ++b)
            for (auto c = near.begin(); c != b; ++c) add({ball, *b, *c}, found);
    }

    void add(const Triangle& balls, std::vector<Pinhole>& found) const {
        const auto [offset, axis, inside, power] = powers_.middleOf(balls);
        if (!(inside > 0)) return;
        const double r2 = powers_.squaredRadius(balls[0]), size = std::sqrt(std::abs(power) / r2);
        double narrowing =
            power > 0 ? 1 - smoothStep(size / kPinholeRadius - 1).value : 1 - smoothStep(size / kPinholeMembrane).value;
        narrowing *= smoothStep(inside / kHoleInside).value;
        if (!(narrowing > 0)) return;
        const Vec3 middle = powers_.centre(balls[0]) + offset;
        const double covered = powers_.leastPower(middle, balls, 2 * kPinholeRadius * std::sqrt(r2)) - power;
        narrowing *= smoothStep(1 + covered / (kPinholeCovered * r2)).value;
        for (std::size_t k = 0; k < 3 && narrowing > 0; ++k)
            narrowing *= 1 - smoothStep(gapBetween(balls[k], balls[(k + 1) % 3], balls) / (kPinholeSide * r2)).value;
        if (narrowing > 0) found.push_back({{middle, axis, std::sqrt(r2), kPinholeLength, kPinholeWidth}, narrowing});
    }

    // The least power of the middle between two of three balls, or 0 where these or others close the gap between them.
    double gapBetween(std::uint32_t from, std::uint32_t to, const Triangle& balls) const {
        const Vec3 way = powers_.centre(to) - powers_.centre(from);
        const double square_of_way = way.length2(), r2 = powers_.squaredRadius(from);
        const double share = (1 + (r2 - powers_.squaredRadius(to)) / square_of_way) / 2;
        const double gap = share * share * square_of_way - r2;
        if (!(gap > 0)) return 0;
        return std::max(0.0, std::min(gap, powers_.leastPower(powers_.centre(from) + way * share, balls, 0)));
    }

    BallPowers powers_;
    const std::vector<std::uint32_t>& balls_;
};

// Calls visit(vertex, across, share) for the vertices around a pinhole, as forVerticesNear(); share: 1, and 0 at the
// end of its reach.
template <typename Visit>
void forVerticesAround(const Pinhole& hole, const DeformingMesh& surface, const Visit& visit) {
    forVerticesNear(hole, 0, surface.position(), surface, [&](std::uint32_t v, double along, const Vec3& across) {
        visit(v, across, within(std::abs(along), hole.length) * within(across.length(), hole.width));
    });
}

// The middle of what is steep around a pinhole, from its own middle, in its unit.
Vec3 middleOfWalls(const Pinhole& hole, const DeformingMesh& surface) {
    Vec3 sum(0);
    double weight = kPinholeArea;
    forVerticesAround(hole, surface, [&](std::uint32_t v, const Vec3& across, double share) {
        const double area = static_cast<double>(surface.area(v)) * square(surface.spacing() / hole.unit);
        const double steep = 1 - square(dot(Vec3(surface.normals()[v]), hole.axis));
        sum += across * (area * square(steep) * share);
        weight += area * square(steep) * share;
    });
    return sum / weight;
}

}  // namespace

void narrowPinholes(const BallBoundary& boundary, DeformingMesh& surface) {
    const std::vector<std::uint32_t> balls = ballsNearTurns(boundary, surface);
    std::vector<Pinhole> pinholes = PinholeFinder(boundary, balls).find();
    for (int round = 0; round < kPinholeRounds && !pinholes.empty(); ++round) {
        std::vector<Vec3> sum(surface.size(), Vec3(0));
        std::vector<double> weight(surface.size(), 0);
        for (Pinhole& hole : pinholes) {
            hole.middle += middleOfWalls(hole, surface) * hole.unit;
            forVerticesAround(hole, surface, [&](std::uint32_t v, const Vec3& across, double share) {
                const double r2 = across.length2() + square(kPinholeLeast);
                const double added = (square(kPinholeNarrowing) - square(kPinholeLeast)) * hole.narrowing;
                share *= 1 - std::sqrt(r2 / (r2 + added));
                sum[v] += across * (share * share * hole.unit / surface.spacing());
                weight[v] += share;
            });
        }
        std::vector<Vec3f> step(surface.size(), Vec3f(0));  // means, as one hole may be between several three balls
        for (std::size_t v = 0; v < step.size(); ++v)
            if (weight[v] > 0) step[v] = Vec3f(-sum[v] / weight[v]);
        surface.move(step);
        surface.measure();
    }
}

}  // namespace betamesh
