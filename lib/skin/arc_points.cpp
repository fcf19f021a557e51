#include "skin/arc_points.h"

#include "core/angles.h"
#include "core/moving_circle.h"
#include "core/parallel.h"
#include "exact/predicates.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace betamesh {

namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr std::uint32_t kMostSegments = 4096;
constexpr double kFadesFrom = 0.8, kFadesTo = 1;         // lengths of a segment, in the longest allowed
constexpr double kLongestSegment = 2, kShortest = 1e-4;  // radians; shorter arcs are straight
constexpr double kLeastFading = 0.02;                    // points are never on one line

// The circle in which the spheres of two balls meet.
struct Circle {
    Vec3 centre, axis;
    double radius;

    Circle(const BallBoundary& boundary, std::uint32_t low, std::uint32_t high) {
        const Vec3 a = boundary.centre(low), b = boundary.centre(high);
        const double r = boundary.worldRadius(), half = (b - a).length() / 2;
        centre = (a + b) / 2;
        axis = (b - a).normalized();
        radius = std::sqrt(std::max(0.0, (r - half) * (r + half)));
    }
    // Towards a point, across the axis.
    Vec3 towards(const Vec3& point) const {
        const Vec3 offset = point - centre;
        return offset - axis * dot(offset, axis);
    }
};

double angleBetween(const Vec3& a, const Vec3& b) { return angleOf(cross(a, b).length(), dot(a, b)); }

// The angle of an arc. From the angles of the two apex particles, whose order is exact, so that an arc of
// length nearly zero is never taken for a full turn.
double arcAngle(const BallBoundary& boundary, const Circle& circle, std::uint32_t start) {
    const std::uint32_t end = boundary.twin[start];
    const std::uint32_t low = boundary.triangle[start / 3][start % 3];
    const std::uint32_t high = boundary.triangle[end / 3][end % 3];
    const auto apexOf = [&](std::uint32_t h) {
        return boundary.triangle[previousInTriangle(h) / 3][previousInTriangle(h) % 3];
    };
    const std::uint32_t first = apexOf(start), last = apexOf(end);
    const Vec3 first_apex = circle.towards(boundary.centre(first)), last_apex = circle.towards(boundary.centre(last));
    const double covered_before = angleBetween(first_apex, circle.towards(boundary.vertex[start / 3]));
    const double covered_after = angleBetween(last_apex, circle.towards(boundary.vertex[end / 3]));

    double between = kTurn;  // from apex to apex, counter-clockwise
    if (first != last) {
        const Vec3i origin = boundary.position[low], axis = boundary.position[high] - origin;
        const Vec3i a = boundary.position[first] - origin, b = boundary.position[last] - origin;
        const int side = turn(axis, a, b);
        const double angle = angleBetween(first_apex, last_apex);
        if (side != 0)
            between = side > 0 ? angle : kTurn - angle;
        else
            between = sameSide(axis, a, b) > 0 ? kTurn : std::numbers::pi;
    }
    return std::max(0.0, between - covered_before - covered_after);
}

// How an arc is cut. Fading: the odd ones of its points have only come this far from the chord between the even
// ones; less than 1 only where `count` is even.
struct Cut {
    std::uint32_t count;
    Rate fading = 1;
};

// angle: that of the arc on a great circle with the same sagitta.
Cut cutFor(Rate angle, std::uint32_t least, const ArcSubdivision& subdivision) {
    if (subdivision.segments > 0 && angle.value > kShortest)
        return {std::max(least, static_cast<std::uint32_t>(subdivision.segments))};
    const Rate wanted = angle / subdivision.max_angle;
    if (subdivision.appearance == Appearance::on_boundary)
        return {std::clamp(static_cast<std::uint32_t>(std::ceil(wanted.value)), least, kMostSegments)};
    std::uint32_t count = 1;
    while (count < least) count *= 2;
    if (least > 2 && wanted.value <= kFadesFrom * count) return {count};
    while (wanted.value > kFadesFrom * count && count < kMostSegments) count *= 2;
    const Rate t = (wanted * 2 / count - kFadesFrom) / (kFadesTo - kFadesFrom);
    return {count, count == 1 ? Rate(1) : smoothStep(t)};
}

// Point m of a circle, of so many parts of an angle.
Moving pointAt(const MovingCircle& circle, Rate angle, std::uint32_t m, std::uint32_t count) {
    return circle.centre() + circle.outwards(angle * (static_cast<double>(m) / count)) * circle.radius();
}

// Places the points of one arc or circle, whose numbers are pointOf(0) … pointOf(count), from m = first to last; of
// these the odd ones may be rising.
template <typename PointOf>
void placePoints(const MovingCircle& circle, Rate angle, const Cut& cut, std::uint32_t first, std::uint32_t last,
                 const PointOf& pointOf, ArcNetwork& network, RisingVertex* rising) {
    const bool fades = cut.fading.value < 1;
    for (std::uint32_t m = first; m <= last; ++m) {
        Moving& point = network.point[pointOf(m)];
        point = pointAt(circle, angle, m, cut.count);
        if (!fades || m % 2 == 0) continue;
        const std::uint32_t before = pointOf(m - 1), after = pointOf(m + 1);
        const Moving middle =
            (pointAt(circle, angle, m - 1, cut.count) + pointAt(circle, angle, m + 1, cut.count)) * 0.5;
        *rising++ = {pointOf(m), {before, after, after, after}, {0.5, 0.5, 0, 0}, cut.fading, point};
        const Rate held = kLeastFading + cut.fading * (1 - kLeastFading);  // never on one line
        point = point * held + middle * (1 - held);
    }
}

}  // namespace

ArcNetwork arcPoints(const BallBoundary& boundary, const std::vector<Moving>& balls, const std::vector<Vec3>& spins,
                     std::vector<Moving> vertices, const ArcSubdivision& subdivision) {
    const double radius = boundary.worldRadius();
    ArcNetwork network;
    network.vertices = vertices.size();
    network.point = std::move(vertices);
    network.arc_of.resize(boundary.twin.size());
    const auto from = [&](std::uint32_t h) { return boundary.triangle[h / 3][h % 3]; };
    network.arc_start =
        rowsWhere(boundary.twin.size(), [&](std::uint32_t h) { return from(h) < from(boundary.twin[h]); });
    parallelFor(network.arc_start.size(), 4096, [&](std::size_t a) {
        const std::uint32_t start = network.arc_start[a];
        network.arc_of[start] = network.arc_of[boundary.twin[start]] = static_cast<std::uint32_t>(a);
    });

    const std::size_t arcs = network.arc_start.size(), circles = boundary.circle.size();
    const auto circleOfArc = [&](std::size_t a) {
        const std::uint32_t start = network.arc_start[a];
        MovingCircle circle(balls[from(start)], balls[from(boundary.twin[start])], radius);
        circle.beginTowards(network.point[start / 3]);
        return circle;
    };
    const auto sameSagitta = [&](const MovingCircle& circle, Rate angle) {
        return angle * squareRoot(circle.radius() / radius);
    };
    std::vector<Cut> cuts(arcs + circles);
    std::vector<std::uint32_t> inside(arcs + circles);
    network.arc_angle.resize(arcs);
    parallelFor(arcs, 512, [&](std::size_t a) {
        const std::uint32_t start = network.arc_start[a], end = boundary.twin[start];
        const MovingCircle circle = circleOfArc(a);
        network.arc_angle[a] = circle.movingAngle(network.point[end / 3],
                                                  arcAngle(boundary, Circle(boundary, from(start), from(end)), start));
        const bool one_triplet = start / 3 == reverseSide(boundary, end / 3);
        const auto least = static_cast<std::uint32_t>(std::ceil(network.arc_angle[a].value / kLongestSegment));
        cuts[a] =
            cutFor(sameSagitta(circle, network.arc_angle[a]), std::max(least, one_triplet ? 2U : 1U), subdivision);
        inside[a] = cuts[a].count - 1;
    });
    for (std::size_t k = 0; k < circles; ++k) {
        const MovingCircle circle(balls[boundary.circle[k][0]], balls[boundary.circle[k][1]], radius);
        cuts[arcs + k] = cutFor(sameSagitta(circle, kTurn), 4, subdivision);
        inside[arcs + k] = cuts[arcs + k].count;
    }
    std::vector<std::uint32_t> begin = placesOf(inside);
    for (std::uint32_t& b : begin) b += static_cast<std::uint32_t>(network.vertices);
    network.arc_begin.assign(begin.begin(), begin.begin() + static_cast<std::ptrdiff_t>(arcs + 1));
    network.circle_begin.assign(begin.begin() + static_cast<std::ptrdiff_t>(arcs), begin.end());
    resizeOnAll(network.point, begin.back());

    std::vector<std::uint32_t> fading(arcs + circles);
    for (std::size_t a = 0; a < fading.size(); ++a) fading[a] = cuts[a].fading.value < 1 ? cuts[a].count / 2 : 0;
    const std::vector<std::uint32_t> rising = placesOf(fading);
    resizeOnAll(network.rising, rising.back());
    parallelFor(arcs, 512, [&](std::size_t a) {
        if (inside[a] == 0) return;
        const std::uint32_t start = network.arc_start[a], end = boundary.twin[start];
        const auto pointOf = [&](std::uint32_t m) {
            return m == 0 ? start / 3 : m > inside[a] ? end / 3 : network.arc_begin[a] + m - 1;
        };
        placePoints(circleOfArc(a), network.arc_angle[a], cuts[a], 1, inside[a], pointOf, network,
                    network.rising.data() + rising[a]);
    });
    parallelFor(circles, 64, [&](std::size_t k) {
        MovingCircle circle(balls[boundary.circle[k][0]], balls[boundary.circle[k][1]], radius);
        circle.beginAnywhere((spins[boundary.circle[k][0]] + spins[boundary.circle[k][1]]) / 2);
        const auto pointOf = [&](std::uint32_t m) { return network.circle_begin[k] + m % cuts[arcs + k].count; };
        placePoints(circle, kTurn, cuts[arcs + k], 0, inside[arcs + k] - 1, pointOf, network,
                    network.rising.data() + rising[arcs + k]);
    });
    return network;
}

}  // namespace betamesh
