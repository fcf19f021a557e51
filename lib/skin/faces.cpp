#include "skin/faces.h"

#include "base/angles.h"
#include "base/compressed_rows.h"
#include "base/intersection_circle.h"
#include "base/parallel.h"
#include "base/union_find.h"
#include "exact/neighbour_finder.h"
#include "skin/exposed_region.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace betamesh {

namespace {

constexpr double kAngleMargin = 1e-9;         // radians: closer calls are left undecided, never guessed
constexpr int kGreatCirclesPerArc = 16;       // tried in turn, from different points of the arc
constexpr std::size_t kManyNeighbours = 256;  // from here on only those that bound the exposed part are looked at

// Is the cap of a wider than that of b?
bool isWider(const Neighbour& a, const Neighbour& b) {
    // the caps' planes are at distances p / 2|u|
    using Int = __int128;
    const auto p = static_cast<Int>(a.power), q = static_cast<Int>(b.power);
    if ((p < 0) != (q < 0)) return p < 0;
    const Int nearer = p * p * static_cast<std::int64_t>(b.squaredDistance()),
              farther = q * q * static_cast<std::int64_t>(a.squaredDistance());
    return nearer != farther && (nearer < farther) != (p < 0);
}

// The number of connected groups that the neighbours' caps on one sphere form, by exact signs.
std::size_t capGroups(std::vector<Neighbour> neighbours, std::int64_t radius) {
    // The widest caps first: a cap within another meets no third cap that the other does not meet, and in dense cells
    // nearly all caps are within another. While the caps so far form one group, it is enough to meet one of them.
    std::sort(neighbours.begin(), neighbours.end(), isWider);
    std::vector<OffsetBall> caps;
    std::vector<std::uint32_t> met;
    UnionFind touching(neighbours.size());
    const auto groups = [&] { return touching.groups() - (neighbours.size() - caps.size()); };
    const auto isWithinAnother = [&](const OffsetBall& cap) {
        met.clear();
        const bool one_group = groups() == 1;
        for (std::uint32_t b = 0; b < caps.size() && !(one_group && !met.empty()); ++b) {
            if (ballExists(caps[b], cap, radius))
                met.push_back(b);
            else if (coversCircle(cap, caps[b], radius) || coversCircle(caps[b], cap, radius))
                return true;  // the latter where both have the same circle
        }
        return false;
    };
    for (const Neighbour& neighbour : neighbours) {
        const OffsetBall cap = neighbour.ball();
        if (isWithinAnother(cap)) continue;
        const auto number = static_cast<std::uint32_t>(caps.size());
        for (const std::uint32_t b : met) touching.join(b, number);
        caps.push_back(cap);
    }
    return groups();
}

// An exposed arc on the unit sphere of its ball: counter-clockwise round `axis` from angle `begin`, `sweep` radians
// long.
struct Arc {
    Vec3 axis, x, y;  // orthonormal
    double height;    // of the circle's plane along the axis, radii
    double begin, sweep;
    std::uint32_t cycle;  // index among the cycles of the ball

    Vec3 at(double angle) const {
        const double rho = std::sqrt(std::max(0.0, 1 - height * height));
        const SineCosine at = sineCosine(angle);
        return axis * height + (x * at.cosine + y * at.sine) * rho;
    }
    double angleTo(const Vec3& p) const { return angleOf(dot(p, y), dot(p, x)); }
};

double positiveAngle(double angle) {
    angle = std::fmod(angle, kTwoPi);
    return angle < 0 ? angle + kTwoPi : angle;
}

// The full circle of a ball with another, as an arc.
Arc circleOf(const BallBoundary& boundary, std::uint32_t ball, std::uint32_t other, std::uint32_t cycle) {
    const Vec3 offset = toDouble(boundary.position[other] - boundary.position[ball]);
    const double distance = offset.length();
    Arc arc;
    arc.axis = offset / distance;
    const Vec3 aside = std::abs(arc.axis.x) < 0.5 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
    arc.x = cross(arc.axis, aside).normalized();
    arc.y = cross(arc.axis, arc.x);
    const auto radius = static_cast<double>(boundary.radiusOf(ball)), r = static_cast<double>(boundary.radiusOf(other));
    arc.height = heightOfIntersection(distance, radius, r);
    arc.begin = 0;
    arc.sweep = kTwoPi;
    arc.cycle = cycle;
    return arc;
}

// All arcs round the cycles of one ball.
std::vector<Arc> arcsOf(const BallBoundary& boundary, std::uint32_t ball, std::span<const std::uint32_t> cycles) {
    std::vector<Arc> arcs;
    const auto rows = static_cast<std::uint32_t>(boundary.cycle.size());
    for (std::uint32_t c = 0; c < cycles.size(); ++c) {
        if (cycles[c] >= rows) {
            const auto& circle = boundary.circle[(cycles[c] - rows) / 2];
            arcs.push_back(circleOf(boundary, ball, circle[0] == ball ? circle[1] : circle[0], c));
            continue;
        }
        const auto cycle = boundary.cycle[cycles[c]];
        for (std::size_t e = 0; e < cycle.size(); ++e) {
            // clockwise round the cap from this vertex to the next
            const std::uint32_t h = cycle[e], next = cycle[(e + 1) % cycle.size()];
            const std::uint32_t back = previousInTriangle(h);
            Arc arc = circleOf(boundary, ball, boundary.triangle[back / 3][back % 3], c);
            const double from = arc.angleTo(boundary.vertex[next / 3] - boundary.centre(ball));
            const double to = arc.angleTo(boundary.vertex[h / 3] - boundary.centre(ball));
            arc.begin = from;
            arc.sweep = positiveAngle(to - from);
            arcs.push_back(arc);
        }
    }
    return arcs;
}

// The cycle that the great circle from `start`, a point of arcs[own], in the direction `heading` meets first; none if
// that is too close to call.
std::optional<std::uint32_t> firstCycleMet(const std::vector<Arc>& arcs, std::size_t own, const Vec3& start,
                                           const Vec3& heading) {
    constexpr double kNotMet = 4 * std::numbers::pi;
    double first = kNotMet, undecided = kNotMet;  // angles to the first cycle met, and to the first close call
    std::size_t met = arcs.size();
    for (std::size_t a = 0; a < arcs.size(); ++a) {
        const bool own_circle = arcs[a].axis == arcs[own].axis;
        if (own_circle && arcs[a].height > 1 - kAngleMargin) continue;  // the balls touch in a point
        const double along = dot(start, arcs[a].axis), across = dot(heading, arcs[a].axis);
        const double reach = std::sqrt(along * along + across * across), nearest = angleOf(across, along);
        if (reach < arcs[a].height - kAngleMargin) continue;
        if (reach < arcs[a].height + kAngleMargin) {
            undecided = std::min(undecided, positiveAngle(nearest - 1e-3));
            continue;
        }
        const double cosine = arcs[a].height / reach;
        double angle = positiveAngle(nearest - angleOf(std::sqrt(1 - cosine * cosine), cosine));
        const bool meets_at_start = angle < kAngleMargin || angle > kTwoPi - kAngleMargin;
        if (meets_at_start && !own_circle) return std::nullopt;
        if (meets_at_start) angle = kTwoPi;
        if (met < arcs.size() && arcs[a].axis == arcs[met].axis) continue;  // another arc of the circle met
        undecided = std::min(undecided, std::max(angle, first));
        if (angle < first) first = angle, met = a;
    }
    if (met == arcs.size() || undecided - first < kAngleMargin) return std::nullopt;
    const auto [sine, cosine] = sineCosine(first);
    const Vec3 hit = start * cosine + heading * sine;
    for (const Arc& arc : arcs) {  // several arcs may lie on that circle
        if (arc.axis != arcs[met].axis) continue;
        const double angle = positiveAngle(arc.angleTo(hit) - arc.begin);
        if (angle > kAngleMargin && angle < arc.sweep - kAngleMargin) return arc.cycle;
    }
    return std::nullopt;
}

// Joins cycles that exposed pieces of great circles connect, until `faces` groups are left.
void joinAlongGreatCircles(const std::vector<Arc>& arcs, std::size_t faces, UnionFind& groups) {
    for (int round = 0; round < kGreatCirclesPerArc; ++round)
        for (std::size_t a = 0; a < arcs.size(); ++a) {
            if (groups.groups() <= faces) return;
            // low-discrepancy fractions: multiples of the golden ratio and of 1 / the plastic number
            const double fraction = std::fmod(0.5 + round * 0.6180339887498949, 1.0);
            const double tilt = (std::fmod(0.5 + round * 0.7548776662466927, 1.0) - 0.5) * std::numbers::pi * 0.9;
            const Vec3 start = arcs[a].at(arcs[a].begin + fraction * arcs[a].sweep);
            Vec3 outward = start * arcs[a].height - arcs[a].axis;
            if (!(outward.length() > kAngleMargin)) outward = arcs[a].x;  // the balls touch in a point
            outward.normalize();
            const auto [sine, cosine] = sineCosine(tilt);
            const Vec3 heading = outward * cosine + cross(start, outward) * sine;
            if (const auto cycle = firstCycleMet(arcs, a, start, heading)) groups.join(arcs[a].cycle, *cycle);
        }
}

}  // namespace

void groupFaces(const SnappedParticles& particles, BallBoundary& boundary) {
    const std::size_t balls = boundary.position.size();
    const std::size_t rows = boundary.cycle.size();
    const auto ballOfCycle = [&](std::size_t c) {
        if (c >= rows) return boundary.circle[(c - rows) / 2][(c - rows) % 2];
        const std::uint32_t h = boundary.cycle[c][0];
        return boundary.triangle[h / 3][h % 3];
    };
    const IndexRows cycles_of = sortedIntoRows<std::uint32_t>(
        balls, rows + 2 * boundary.circle.size(),
        [&](std::size_t c, const auto& visit) { visit(ballOfCycle(c), static_cast<std::uint32_t>(c)); });

    // For each cycle of cycles_of the first cycle of its ball that it shares a face with.
    std::vector<std::uint32_t> group(cycles_of.item.size());
    parallelRanges(balls, kBallsPerTask, [&](std::size_t first_ball, std::size_t last_ball) {
        NeighbourFinder finder(particles);
        ExposedRegion region;
        std::vector<Neighbour> neighbours;
        for (auto ball = static_cast<std::uint32_t>(first_ball); ball < last_ball; ++ball) {
            const auto cycles = cycles_of[ball];
            if (cycles.size() < 2) continue;
            UnionFind groups(cycles.size());
            finder.find(boundary.snapped_row[ball], neighbours);
            const bool many = neighbours.size() >= kManyNeighbours;  // the caps of few cover as much as all
            const std::int64_t radius = boundary.radiusOf(ball);
            if (many) region.construct(neighbours, radius);
            const std::size_t groups_of_caps = capGroups(many ? region.neighbours() : neighbours, radius);
            const std::size_t faces = cycles.size() + 1 - groups_of_caps;
            if (faces == 1)
                for (std::uint32_t c = 1; c < cycles.size(); ++c) groups.join(0, c);
            else if (faces < cycles.size())
                joinAlongGreatCircles(arcsOf(boundary, ball, cycles), faces, groups);
            for (std::uint32_t c = 0; c < cycles.size(); ++c) group[cycles_of.begin[ball] + c] = groups.find(c);
        }
    });

    boundary.face = {};
    boundary.face_ball.clear();
    const auto endFace = [&](std::uint32_t ball) {
        boundary.face.begin.push_back(static_cast<std::uint32_t>(boundary.face.item.size()));
        boundary.face_ball.push_back(ball);
    };
    for (std::uint32_t ball = 0; ball < balls; ++ball) {
        const auto cycles = cycles_of[ball];
        const auto groups = std::span(group).subspan(cycles_of.begin[ball], cycles.size());
        for (std::uint32_t first = 0; first < cycles.size(); ++first) {
            if (groups[first] != first) continue;
            for (std::uint32_t c = first; c < cycles.size(); ++c)
                if (groups[c] == first) boundary.face.item.push_back(cycles[c]);
            endFace(ball);
        }
        if (cycles.empty()) endFace(ball);
    }
}

}  // namespace betamesh
