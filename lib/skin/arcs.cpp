#include "skin/arcs.h"

#include "base/angles.h"
#include "base/intersection_circle.h"
#include "base/parallel.h"
#include "exact/predicates.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace betamesh {

namespace {

double angleBetween(const Vec3& a, const Vec3& b) { return angleOf(cross(a, b).length(), dot(a, b)); }

// The angle of an arc, in radians. Computed from the angles of the two apex particles, whose order is exact, so that an
// arc of nearly zero length is never taken for a full turn.
double arcAngle(const BallBoundary& boundary, const IntersectionCircle& circle, std::uint32_t start) {
    const std::uint32_t end = boundary.twin[start];
    const std::uint32_t low = boundary.triangle[start / 3][start % 3];
    const std::uint32_t high = boundary.triangle[end / 3][end % 3];
    const auto apexOf = [&](std::uint32_t h) {
        return boundary.triangle[previousInTriangle(h) / 3][previousInTriangle(h) % 3];
    };
    const std::uint32_t first = apexOf(start), last = apexOf(end);
    const Vec3 first_apex = circle.fromAxis(boundary.centre(first)), last_apex = circle.fromAxis(boundary.centre(last));
    const double covered_before = angleBetween(first_apex, circle.fromAxis(boundary.vertex[start / 3]));
    const double covered_after = angleBetween(last_apex, circle.fromAxis(boundary.vertex[end / 3]));

    double between = kTwoPi;  // from apex to apex, counter-clockwise
    if (first != last) {
        const Vec3i origin = boundary.position[low], axis = boundary.position[high] - origin;
        const Vec3i a = boundary.position[first] - origin, b = boundary.position[last] - origin;
        const int side = turn(axis, a, b);
        const double angle = angleBetween(first_apex, last_apex);
        if (side != 0)
            between = side > 0 ? angle : kTwoPi - angle;
        else
            between = sameSide(axis, a, b) > 0 ? kTwoPi : std::numbers::pi;
    }
    return std::max(0.0, between - covered_before - covered_after);
}

// Positions of the points along an arc, as fractions of its angle. Symmetric, as the two balls may change their order.
class Subdivision {
public:
    explicit Subdivision(std::uint32_t segments) : count_(segments), segment_(1.0 / segments) {}

    // Segments no longer than 1, one or an even number, whose ends change continuously with the length of the arc.
    // Before more are needed, points fade in inside the single segment or inside the two in the middle, whose halves
    // then grow until they are as long as the rest. least: 1 or 2; with 2 there is a point even at fade weight 0.
    Subdivision(Dual length, std::uint32_t least)
        : Subdivision(length.value <= 1 ? 1 : 2 * static_cast<std::uint32_t>(std::ceil(length.value / 2))) {
        const Dual grown = (length - (count_ - 2)) / kRegrowLength;
        if (count_ > 2 && grown.value < 1) {
            segment_ = 1 / (count_ - 2 + grown * 2);
            first_growing_ = count_ / 2 - 2;
        }
        const Dual progress = (length - (count_ - kFadeInLength)) / kFadeInLength;
        if (progress.value <= 0 && count_ >= least) return;
        fading_ = std::min(count_, 2U);
        fade_weight_ = smoothStep(progress);
    }

    std::uint32_t segments() const { return count_ + fading_; }
    // Points fading in from the chords beside them: how many (0 to 2), and the first; a second one is two points on.
    std::uint32_t fading() const { return fading_; }
    std::uint32_t firstFading() const { return (count_ + 1) / 2; }
    Dual fadeWeight() const { return fade_weight_; }

    // Fraction of the angle at point m, 0 to segments().
    Dual at(std::uint32_t m) const {
        const std::uint32_t passed = m < firstFading() ? 0 : std::min((m - firstFading()) / 2 + 1, fading_);
        const bool is_fading = passed > 0 && m == firstFading() + 2 * (passed - 1);
        return is_fading ? (withoutFading(m - passed) + withoutFading(m - passed + 1)) * 0.5
                         : withoutFading(m - passed);
    }

private:
    // The same for point m when points fading in are not counted.
    Dual withoutFading(std::uint32_t m) const {
        if (m <= first_growing_) return segment_ * m;
        if (m >= first_growing_ + 4) return 1 - segment_ * (count_ - m);
        return 0.5 + (0.5 - segment_ * first_growing_) * (0.5 * (static_cast<double>(m) - first_growing_ - 2));
    }

    std::uint32_t count_;                          // segments, not counting points fading in
    Dual segment_;                                 // fraction of the angle in each segment but the four that grow
    std::uint32_t first_growing_ = kInvalidIndex;  // first of the four segments that grow, if any
    std::uint32_t fading_ = 0;
    Dual fade_weight_;
};

// The subdivision of an arc, or of half a circle. relative_radius: of the circle, in radii of the smaller ball.
Subdivision subdivisionOf(Dual angle, Dual relative_radius, std::uint32_t least, const ArcSubdivision& subdivision) {
    const Dual great_circle_angle = angle * squareRoot(relative_radius);  // of the same sagitta
    const Dual wanted = great_circle_angle / subdivision.max_angle, fewest = angle / kMaxSegmentAngle;
    const Dual length = wanted.value > fewest.value ? wanted : fewest;
    const auto roundedUp = [&](Dual number) {
        return std::max(least, static_cast<std::uint32_t>(std::ceil(number.value)));
    };
    const int segments = subdivision.segments;
    if (segments > 0 && great_circle_angle.value > kStraightArcAngle)
        return Subdivision(std::max(roundedUp(fewest * segments), static_cast<std::uint32_t>(segments)));
    return subdivision.appearance == Appearance::gradual ? Subdivision(length, least) : Subdivision(roundedUp(length));
}

DualVec3 pointAt(const IntersectionCircle& circle, Dual angle) {
    return circle.centre() + circle.outwards(angle) * circle.radius();
}

// Sets points m = first to last of an arc or circle, whose network points are pointOf(m), where the subdivision puts
// them, counting angles from `from`. pointOf(first - 1) and pointOf(last + 1) are the neighbours of the ends. Returns
// one past the last fading point added.
template <typename PointOf>
FadingVertex* setPoints(const IntersectionCircle& circle, Dual from, Dual angle, const Subdivision& division,
                        std::uint32_t first, std::uint32_t last, const PointOf& pointOf, ArcNetwork& network,
                        FadingVertex* fading) {
    const auto at = [&](std::uint32_t m) { return pointAt(circle, from + angle * division.at(m)); };
    for (std::uint32_t m = first; m <= last; ++m) network.point[pointOf(m)] = at(m);
    for (std::uint32_t k = 0; k < division.fading(); ++k) {
        const std::uint32_t m = division.firstFading() + 2 * k, before = pointOf(m - 1), after = pointOf(m + 1);
        DualVec3& point = network.point[pointOf(m)];
        *fading++ = {pointOf(m), {before, after, after, after}, {0.5, 0.5, 0, 0}, division.fadeWeight(), point};
        const Dual weight = kMinFadeWeight + division.fadeWeight() * (1 - kMinFadeWeight);
        point = point * weight + (at(m - 1) + at(m + 1)) * (0.5 * (1 - weight));
    }
    return fading;
}

}  // namespace

std::vector<float> ArcNetwork::pointMeans(const BallBoundary& boundary,
                                          const std::function<double(std::size_t)>& ofBall) const {
    std::vector<float> mean(point.size());
    for (std::size_t v = 0; v < vertices; ++v) {
        double sum = 0;
        for (const std::uint32_t ball : boundary.triangle[v]) sum += ofBall(ball);
        mean[v] = static_cast<float>(sum / 3);
    }
    const auto setLine = [&](std::size_t l, std::uint32_t begin, std::uint32_t end) {
        for (std::uint32_t p = begin; p < end; ++p)
            mean[p] = static_cast<float>((ofBall(line[l].balls[0]) + ofBall(line[l].balls[1])) / 2);
    };
    const std::size_t arcs = arc_start.size();
    for (std::size_t a = 0; a < arcs; ++a) setLine(a, arc_begin[a], arc_begin[a + 1]);
    for (std::size_t k = 0; k + 1 < circle_begin.size(); ++k) setLine(arcs + k, circle_begin[k], circle_begin[k + 1]);
    return mean;
}

std::vector<float> ArcNetwork::pointScales(const BallBoundary& boundary) const {
    if (boundary.radius_of.empty()) return {};
    return pointMeans(boundary, [&](std::size_t ball) { return boundary.scaleOf(ball); });
}

ArcNetwork arcPoints(const BallBoundary& boundary, const std::vector<DualVec3>& balls, std::vector<DualVec3> vertices,
                     const ArcSubdivision& subdivision) {
    const auto circleBetween = [&](std::uint32_t a, std::uint32_t b) {
        return IntersectionCircle(balls[a], boundary.worldRadiusOf(a), balls[b], boundary.worldRadiusOf(b));
    };
    ArcNetwork network;
    network.vertices = vertices.size();
    network.point = std::move(vertices);
    network.arc_of.resize(boundary.twin.size());
    const auto from = [&](std::uint32_t h) { return boundary.triangle[h / 3][h % 3]; };
    network.arc_start =
        indicesWhere(boundary.twin.size(), [&](std::uint32_t h) { return from(h) < from(boundary.twin[h]); });
    parallelFor(network.arc_start.size(), 4096, [&](std::size_t a) {
        const std::uint32_t start = network.arc_start[a];
        network.arc_of[start] = network.arc_of[boundary.twin[start]] = static_cast<std::uint32_t>(a);
    });

    const std::size_t arcs = network.arc_start.size(), circles = boundary.circle.size();
    const auto circleOfArc = [&](std::size_t a) {
        const std::uint32_t start = network.arc_start[a];
        IntersectionCircle circle = circleBetween(from(start), from(boundary.twin[start]));
        circle.setZeroTowards(network.point[start / 3]);
        return circle;
    };
    const auto subdivisionOfArc = [&](std::size_t a) {
        const std::uint32_t start = network.arc_start[a], end = boundary.twin[start];
        const bool one_triplet = start / 3 == reverseSide(boundary, end / 3);
        return subdivisionOf(network.arc_angle[a], network.relativeRadius(a, boundary), one_triplet ? 2 : 1,
                             subdivision);
    };
    const auto subdivisionOfHalf = [&](std::size_t k) {
        return subdivisionOf(std::numbers::pi, network.relativeRadius(arcs + k, boundary), 2, subdivision);
    };
    const auto circleAt = [&](std::size_t k) { return circleBetween(boundary.circle[k][0], boundary.circle[k][1]); };
    firstTouchResize(network.line, arcs + circles);
    firstTouchResize(network.arc_angle, arcs);
    parallelFor(arcs, 512, [&](std::size_t a) {
        const std::uint32_t start = network.arc_start[a], end = boundary.twin[start];
        const IntersectionCircle circle = circleOfArc(a);
        network.arc_angle[a] = circle.angleOfPoint(network.point[end / 3], arcAngle(boundary, circle, start));
        network.line[a] = {{from(start), from(end)},
                           circle.radius(),
                           circle.radius() * network.arc_angle[a],
                           cross(circle.axis(), network.point[start / 3] - network.point[end / 3])};
    });
    for (std::size_t k = 0; k < circles; ++k) {
        const Dual of_circle = circleAt(k).radius();
        network.line[arcs + k] = {boundary.circle[k], of_circle, of_circle * kTwoPi, {}};
    }
    network.at_ball =
        sortedIntoRows<std::uint32_t>(balls.size(), network.line.size(), [&](std::size_t l, const auto& visit) {
            for (const std::uint32_t b : network.line[l].balls) visit(b, static_cast<std::uint32_t>(l));
        });

    std::vector<std::uint32_t> inside(arcs + circles), fading_inside(arcs + circles);
    parallelFor(arcs, 512, [&](std::size_t a) {
        const Subdivision division = subdivisionOfArc(a);
        inside[a] = division.segments() - 1;
        fading_inside[a] = division.fading();
    });
    for (std::size_t k = 0; k < circles; ++k) {
        const Subdivision division = subdivisionOfHalf(k);
        inside[arcs + k] = 2 * division.segments();
        fading_inside[arcs + k] = 2 * division.fading();
    }
    std::vector<std::uint32_t> begin = exclusiveScan(inside);
    for (std::uint32_t& b : begin) b += static_cast<std::uint32_t>(network.vertices);
    network.arc_begin.assign(begin.begin(), begin.begin() + static_cast<std::ptrdiff_t>(arcs + 1));
    network.circle_begin.assign(begin.begin() + static_cast<std::ptrdiff_t>(arcs), begin.end());
    firstTouchResize(network.point, begin.back());

    const std::vector<std::uint32_t> fading = exclusiveScan(fading_inside);
    firstTouchResize(network.fading, fading.back());
    parallelFor(arcs, 512, [&](std::size_t a) {
        if (inside[a] == 0) return;
        const std::uint32_t start = network.arc_start[a], end = boundary.twin[start];
        const auto pointOf = [&](std::uint32_t m) {
            return m == 0 ? start / 3 : m > inside[a] ? end / 3 : network.arc_begin[a] + m - 1;
        };
        const IntersectionCircle circle = circleOfArc(a);
        setPoints(circle, 0, network.arc_angle[a], subdivisionOfArc(a), 1, inside[a], pointOf, network,
                  network.fading.data() + fading[a]);
    });
    parallelFor(circles, 64, [&](std::size_t k) {
        IntersectionCircle circle = circleAt(k);
        circle.setZeroAnywhere();
        const Subdivision division = subdivisionOfHalf(k);
        FadingVertex* next = network.fading.data() + fading[arcs + k];
        for (const std::uint32_t half : {0U, 1U}) {
            const auto pointOf = [&](std::uint32_t m) {
                return network.circle_begin[k] + (half * division.segments() + m) % inside[arcs + k];
            };
            next = setPoints(circle, half * std::numbers::pi, std::numbers::pi, division, 0, division.segments() - 1,
                             pointOf, network, next);
        }
    });
    return network;
}

}  // namespace betamesh
