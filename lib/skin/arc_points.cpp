#include "skin/arc_points.h"

#include "core/parallel.h"
#include "exact/predicates.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace betamesh {

namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr std::uint32_t kMostSegments = 4096;

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
    // A unit vector across the axis, towards a point.
    Vec3 towards(const Vec3& point) const {
        const Vec3 offset = point - centre, across = offset - axis * dot(offset, axis);
        return across.length2() > 0 ? across.normalized() : anyAcross();
    }
    Vec3 anyAcross() const { return cross(axis, std::abs(axis.x) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0)).normalized(); }
    Vec3 at(const Vec3& x, double angle) const {
        return centre + (x * std::cos(angle) + cross(axis, x) * std::sin(angle)) * radius;
    }
};

double angleBetween(const Vec3& a, const Vec3& b) { return std::atan2(cross(a, b).length(), dot(a, b)); }

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

std::uint32_t segmentsFor(double angle, double circle_radius, double radius, std::uint32_t least,
                          const ArcSubdivision& subdivision) {
    if (subdivision.segments > 0) return std::max(least, static_cast<std::uint32_t>(subdivision.segments));
    const double wanted = std::ceil(angle * std::sqrt(circle_radius / radius) / subdivision.max_angle);
    return std::clamp(static_cast<std::uint32_t>(wanted), least, kMostSegments);
}

// ċ with the normal components that both spheres ask for, and otherwise nearest to the mean.
Vec3 velocityOnCircle(const Vec3& point, const Moving& a, const Moving& b) {
    const Vec3 mean = (a.velocity + b.velocity) / 2;
    const Vec3 q = (point - a.position).normalized(), s = (point - b.position).normalized();
    const double f = dot(q, a.velocity - mean), g = dot(s, b.velocity - mean), c = dot(q, s);
    const double determinant = std::max(1 - c * c, 1e-4);  // bounded where the spheres nearly coincide or just touch
    return mean + q * ((f - c * g) / determinant) + s * ((g - c * f) / determinant);
}

}  // namespace

ArcNetwork arcPoints(const BallBoundary& boundary, const std::vector<Moving>& balls, std::vector<Moving> vertices,
                     const ArcSubdivision& subdivision) {
    const double radius = boundary.worldRadius();
    ArcNetwork network;
    network.vertices = vertices.size();
    network.point = std::move(vertices);
    network.arc_of.resize(boundary.twin.size());
    const auto from = [&](std::uint32_t h) { return boundary.triangle[h / 3][h % 3]; };
    for (std::uint32_t h = 0; h < boundary.twin.size(); ++h) {
        if (from(h) > from(boundary.twin[h])) continue;
        network.arc_of[h] = network.arc_of[boundary.twin[h]] = static_cast<std::uint32_t>(network.arc_start.size());
        network.arc_start.push_back(h);
    }

    const std::size_t arcs = network.arc_start.size(), circles = boundary.circle.size();
    std::vector<std::uint32_t> inside(arcs + circles);
    network.arc_angle.resize(arcs);
    parallelFor(arcs, 512, [&](std::size_t a) {
        const std::uint32_t start = network.arc_start[a], end = boundary.twin[start];
        const Circle circle(boundary, from(start), from(end));
        network.arc_angle[a] = arcAngle(boundary, circle, start);
        const bool one_triplet = start / 3 == reverseSide(boundary, end / 3);
        inside[a] = segmentsFor(network.arc_angle[a], circle.radius, radius, one_triplet ? 2 : 1, subdivision) - 1;
    });
    for (std::size_t k = 0; k < circles; ++k) {
        const Circle circle(boundary, boundary.circle[k][0], boundary.circle[k][1]);
        inside[arcs + k] = segmentsFor(kTurn, circle.radius, radius, 3, subdivision);
    }
    std::vector<std::uint32_t> begin = placesOf(inside);
    for (std::uint32_t& b : begin) b += static_cast<std::uint32_t>(network.vertices);
    network.arc_begin.assign(begin.begin(), begin.begin() + static_cast<std::ptrdiff_t>(arcs + 1));
    network.circle_begin.assign(begin.begin() + static_cast<std::ptrdiff_t>(arcs), begin.end());
    network.point.resize(begin.back());

    const auto place = [&](const Circle& circle, const Vec3& x, double angle, std::uint32_t low, std::uint32_t high) {
        const Vec3 position = circle.at(x, angle);
        return Moving{position, velocityOnCircle(position, balls[low], balls[high])};
    };
    parallelFor(arcs, 512, [&](std::size_t a) {
        const std::uint32_t start = network.arc_start[a], low = from(start), high = from(boundary.twin[start]);
        const Circle circle(boundary, low, high);
        const Vec3 x = circle.towards(boundary.vertex[start / 3]);
        const std::uint32_t n = network.arcSize(a);
        for (std::uint32_t m = 0; m < n; ++m)
            network.point[network.arc_begin[a] + m] =
                place(circle, x, network.arc_angle[a] * (m + 1) / (n + 1), low, high);
    });
    parallelFor(circles, 64, [&](std::size_t k) {
        const auto [low, high] = boundary.circle[k];
        const Circle circle(boundary, low, high);
        const std::uint32_t n = network.circleSize(k);
        for (std::uint32_t m = 0; m < n; ++m)
            network.point[network.circle_begin[k] + m] = place(circle, circle.anyAcross(), kTurn * m / n, low, high);
    });
    return network;
}

}  // namespace betamesh
