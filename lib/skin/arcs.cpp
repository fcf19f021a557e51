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

// Makes a network step by step: its arcs, then the lines of arcs and circles, the number of points on each, the points.
class ArcNetworkMaker {
public:
    ArcNetworkMaker(const BallBoundary& boundary, const std::vector<DualVec3>& balls, const ArcSubdivision& subdivision,
                    ArcNetwork& network)
        : boundary_(boundary), balls_(balls), subdivision_(subdivision), network_(network) {}

    void listArcs() {
        network_.arc_of.resize(boundary_.twin.size());
        network_.arc_start =
            indicesWhere(boundary_.twin.size(), [&](std::uint32_t h) { return ballOf(h) < ballOf(boundary_.twin[h]); });
        parallelFor(network_.arc_start.size(), 4096, [&](std::size_t a) {
            const std::uint32_t start = network_.arc_start[a];
            network_.arc_of[start] = network_.arc_of[boundary_.twin[start]] = static_cast<std::uint32_t>(a);
        });
    }

    void measureLines() {
        firstTouchResize(network_.line, arcs() + circles());
        firstTouchResize(network_.arc_angle, arcs());
        parallelFor(arcs(), 512, [&](std::size_t a) {
            const std::uint32_t start = network_.arc_start[a], end = boundary_.twin[start];
            const IntersectionCircle circle = circleOfArc(a);
            network_.arc_angle[a] = circle.angleOfPoint(network_.point[end / 3], arcAngle(boundary_, circle, start));
            network_.line[a] = {{ballOf(start), ballOf(end)},
                                circle.radius(),
                                circle.radius() * network_.arc_angle[a],
                                cross(circle.axis(), network_.point[start / 3] - network_.point[end / 3])};
        });
        for (std::size_t k = 0; k < circles(); ++k) {
            const Dual radius = fullCircle(k).radius();
            network_.line[arcs() + k] = {boundary_.circle[k], radius, radius * kTwoPi, {}};
        }
        network_.at_ball =
            sortedIntoRows<std::uint32_t>(balls_.size(), network_.line.size(), [&](std::size_t l, const auto& visit) {
                for (const std::uint32_t b : network_.line[l].balls) visit(b, static_cast<std::uint32_t>(l));
            });
    }

    void countPoints() {
        inside_.resize(arcs() + circles());
        std::vector<std::uint32_t> fading(arcs() + circles());
        parallelFor(arcs(), 512, [&](std::size_t a) {
            const Subdivision division = subdivisionOfArc(a);
            inside_[a] = division.segments() - 1;
            fading[a] = division.fading();
        });
        for (std::size_t k = 0; k < circles(); ++k) {
            const Subdivision division = subdivisionOfHalf(k);
            inside_[arcs() + k] = 2 * division.segments();
            fading[arcs() + k] = 2 * division.fading();
        }
        std::vector<std::uint32_t> begin = exclusiveScan(inside_);
        for (std::uint32_t& b : begin) b += static_cast<std::uint32_t>(network_.vertices);
        network_.arc_begin.assign(begin.begin(), begin.begin() + static_cast<std::ptrdiff_t>(arcs() + 1));
        network_.circle_begin.assign(begin.begin() + static_cast<std::ptrdiff_t>(arcs()), begin.end());
        firstTouchResize(network_.point, begin.back());
        first_fading_ = exclusiveScan(fading);
        firstTouchResize(network_.fading, first_fading_.back());
    }

    void setPointsInsideArcs() {
        parallelFor(arcs(), 512, [&](std::size_t a) {
            if (inside_[a] == 0) return;
            const std::uint32_t start = network_.arc_start[a], end = boundary_.twin[start];
            const auto pointOf = [&](std::uint32_t m) {
                return m == 0 ? start / 3 : m > inside_[a] ? end / 3 : network_.arc_begin[a] + m - 1;
            };
            setPoints(circleOfArc(a), 0, network_.arc_angle[a], subdivisionOfArc(a), 1, inside_[a], pointOf, network_,
                      network_.fading.data() + first_fading_[a]);
        });
    }

    void setPointsOnCircles() {
        parallelFor(circles(), 64, [&](std::size_t k) {
            IntersectionCircle circle = fullCircle(k);
            circle.setZeroAnywhere();
            const Subdivision division = subdivisionOfHalf(k);
            FadingVertex* next = network_.fading.data() + first_fading_[arcs() + k];
            for (const std::uint32_t half : {0U, 1U}) {
                const auto pointOf = [&](std::uint32_t m) {
                    return network_.circle_begin[k] + (half * division.segments() + m) % inside_[arcs() + k];
                };
                next = setPoints(circle, half * std::numbers::pi, std::numbers::pi, division, 0,
                                 division.segments() - 1, pointOf, network_, next);
            }
        });
    }

private:
    std::size_t arcs() const { return network_.arc_start.size(); }
    std::size_t circles() const { return boundary_.circle.size(); }
    // The ball at which a half-edge begins.
    std::uint32_t ballOf(std::uint32_t h) const { return boundary_.triangle[h / 3][h % 3]; }

    IntersectionCircle circleBetween(std::uint32_t a, std::uint32_t b) const {
        return IntersectionCircle(balls_[a], boundary_.worldRadiusOf(a), balls_[b], boundary_.worldRadiusOf(b));
    }
    // Angles are counted from the arc's first vertex.
    IntersectionCircle circleOfArc(std::size_t a) const {
        const std::uint32_t start = network_.arc_start[a];
        IntersectionCircle circle = circleBetween(ballOf(start), ballOf(boundary_.twin[start]));
        circle.setZeroTowards(network_.point[start / 3]);
        return circle;
    }
    IntersectionCircle fullCircle(std::size_t k) const {
        return circleBetween(boundary_.circle[k][0], boundary_.circle[k][1]);
    }

    Subdivision subdivisionOfArc(std::size_t a) const {
        const std::uint32_t start = network_.arc_start[a], end = boundary_.twin[start];
        const bool one_triplet = start / 3 == reverseSide(boundary_, end / 3);
        return subdivisionOf(network_.arc_angle[a], network_.relativeRadius(a, boundary_), one_triplet ? 2 : 1,
                             subdivision_);
    }
    // Of half a full circle.
    Subdivision subdivisionOfHalf(std::size_t k) const {
        return subdivisionOf(std::numbers::pi, network_.relativeRadius(arcs() + k, boundary_), 2, subdivision_);
    }

    const BallBoundary& boundary_;
    const std::vector<DualVec3>& balls_;
    const ArcSubdivision& subdivision_;
    ArcNetwork& network_;
    std::vector<std::uint32_t> inside_;        // number of points inside each arc, and on each circle
    std::vector<std::uint32_t> first_fading_;  // of each arc, then of each circle: its first row of ArcNetwork::fading
};

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
    ArcNetwork network;
    network.vertices = vertices.size();
    network.point = std::move(vertices);
    ArcNetworkMaker maker(boundary, balls, subdivision, network);
    maker.listArcs();
    maker.measureLines();
    maker.countPoints();
    maker.setPointsInsideArcs();
    maker.setPointsOnCircles();
    return network;
}

}  // namespace betamesh
