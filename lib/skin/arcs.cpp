
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

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kRisesOver = 0.2, kGrowsOver = 0.25;    // lengths of the longest segment
constexpr double kLongestSegment = 2, kShortest = 1e-4;  // radians; shorter arcs are straight
// Of what is round a face, the square of the mean direction: up to the first it lies several ways, from the second on
// one way, as round a small patch. Of that mean, the share that is towards the balls beyond: up to the first the patch
// is what is exposed, from the second on it is what is hidden.
constexpr double kSeveralWays = 0.5, kOneWay = 0.7;
constexpr double kExposed = 0.35, kHiddenPatch = 0.6;
constexpr double kLeastShare = 0.02;  // of points that rise, so that they are never on one line

double angleBetween(const Vec3& a, const Vec3& b) { return angleOf(cross(a, b).length(), dot(a, b)); }

// The angle of an arc. From the angles of the two apex particles, whose order is exact, so that an arc of
// length nearly zero is never taken for a full turn.
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

// Where the points of an arc are, as shares of its angle; the same from either end, as balls may change their order.
class Cut {
public:
    explicit Cut(std::uint32_t segments) : count_(segments), share_(1.0 / segments) {}

    // Into equal segments no longer than 1, one or an even number, at places that change continuously with the length
    // of all. Before more are needed, points rise inside the one, or inside the two in the middle, whose halves then
    // grow until they are as long as the rest. least: one or two, though the point between two may not have begun to.
    Cut(Dual length, std::uint32_t least)
        : Cut(length.value <= 1 ? 1 : 2 * static_cast<std::uint32_t>(std::ceil(length.value / 2))) {
        const Dual grown = (length - (count_ - 2)) / kGrowsOver;
        if (count_ > 2 && grown.value < 1) {
            share_ = 1 / (count_ - 2 + grown * 2);
            growing_ = count_ / 2 - 2;
        }
        const Dual rise = (length - (count_ - kRisesOver)) / kRisesOver;
        if (rise.value <= 0 && count_ >= least) return;
        rising_ = std::min(count_, 2U);
        share_of_rising_ = smoothStep(rise);
    }

    std::uint32_t segments() const { return count_ + rising_; }
    // Points that have come only so far from the chords between those beside them: how many, and the first; the second
    // is next but one.
    std::uint32_t fading() const { return rising_; }
    std::uint32_t firstRising() const { return (count_ + 1) / 2; }
    Dual shareOfRising() const { return share_of_rising_; }

    // Of point m, 0 to segments().
    Dual at(std::uint32_t m) const {
        const std::uint32_t passed = m < firstRising() ? 0 : std::min((m - firstRising()) / 2 + 1, rising_);
        const bool rises = passed > 0 && m == firstRising() + 2 * (passed - 1);
        return rises ? (risen(m - passed) + risen(m - passed + 1)) * 0.5 : risen(m - passed);
    }

private:
    // Without those that rise.
    Dual risen(std::uint32_t m) const {
        if (m <= growing_) return share_ * m;
        if (m >= growing_ + 4) return 1 - share_ * (count_ - m);
        return 0.5 + (0.5 - share_ * growing_) * (0.5 * (static_cast<double>(m) - growing_ - 2));
    }

    std::uint32_t count_;                        // of segments
    Dual share_;                                 // of each but the four that grow
    std::uint32_t growing_ = ~std::uint32_t{0};  // the first of these
    std::uint32_t rising_ = 0;
    Dual share_of_rising_;
};

// Of an angle of a circle, an arc or half of all. share: its radius in those of the sphere; per_radian: segments wanted
// of a great circle.
Cut cutFor(Dual angle, Dual share, std::uint32_t least, int segments, Dual per_radian,
           const ArcSubdivision& subdivision) {
    const Dual same_sagitta = angle * squareRoot(share);  // on a great circle
    const Dual wanted = same_sagitta * per_radian, fewest = angle / kLongestSegment;
    const Dual length = wanted.value > fewest.value ? wanted : fewest;
    const auto whole = [&](Dual number) {
        return std::max(least, static_cast<std::uint32_t>(std::ceil(number.value)));
    };
    if (segments > 0 && same_sagitta.value > kShortest)
        return Cut(std::max(whole(fewest), static_cast<std::uint32_t>(segments)));
    return subdivision.appearance == Appearance::gradual ? Cut(length, least) : Cut(whole(length));
}

// As in ArcNetwork: the lines round a face change continuously, and so does this.
std::vector<Dual> calmness(const BallBoundary& boundary, const std::vector<DualVec3>& balls, const ArcNetwork& network) {
    const double radius = boundary.worldRadius();
    const std::size_t cycles = boundary.cycle.size(), arcs = network.arc_start.size();
    std::vector<Dual> calm;
    firstTouchResize(calm, boundary.twin.size());
    parallelFor(boundary.face.size(), 1024, [&](std::size_t f) {
        const std::uint32_t b = boundary.face_ball[f];
        DualVec3 along, across;  // sums of ways to the lines, and to the centres of their circles
        Dual length;
        const auto add = [&](std::size_t l) {
            const ArcLine& line = network.line[l];
            const std::uint32_t other = line.balls[line.balls[0] == b];
            across = across + (balls[other] - balls[b]) * (line.length * 0.5);
            along = along + line.outwards * line.radius;
            length = length + line.length;
        };
        for (const std::uint32_t c : boundary.face[f])
            if (c >= cycles)
                add(arcs + (c - cycles) / 2);
            else
                for (const std::uint32_t h : boundary.cycle[c]) add(network.arc_of[h]);
        along = along + across;
        const Dual square = dot(along, along), full = length * radius;
        Dual of_face = 0;
        if (square.value > 0) {
            const Dual one_way = (square / (full * full) - kSeveralWays) / (kOneWay - kSeveralWays);
            const Dual hidden = (dot(along, across) / square - kExposed) / (kHiddenPatch - kExposed);
            of_face = smoothStep(one_way) * (1 - smoothStep(hidden));
        }
        for (const std::uint32_t c : boundary.face[f])
            if (c < cycles)
                for (const std::uint32_t h : boundary.cycle[c]) calm[h] = of_face;
    });
    return calm;
}

DualVec3 pointAt(const IntersectionCircle& circle, Dual angle) {
    return circle.centre() + circle.outwards(angle) * circle.radius();
}

// Places points m = first to last of an arc or circle, whose numbers are pointOf(m), where its cut says from an angle
// on; pointOf(first - 1) and pointOf(last + 1) are its ends. Returns one past the last that rises.
template <typename PointOf>
FadingVertex* placePoints(const IntersectionCircle& circle, Dual from, Dual angle, const Cut& cut, std::uint32_t first,
                          std::uint32_t last, const PointOf& pointOf, ArcNetwork& network, FadingVertex* fading) {
    const auto at = [&](std::uint32_t m) { return pointAt(circle, from + angle * cut.at(m)); };
    for (std::uint32_t m = first; m <= last; ++m) network.point[pointOf(m)] = at(m);
    for (std::uint32_t k = 0; k < cut.fading(); ++k) {
        const std::uint32_t m = cut.firstRising() + 2 * k, before = pointOf(m - 1), after = pointOf(m + 1);
        DualVec3& point = network.point[pointOf(m)];
        *fading++ = {pointOf(m), {before, after, after, after}, {0.5, 0.5, 0, 0}, cut.shareOfRising(), point};
        const Dual held = kLeastShare + cut.shareOfRising() * (1 - kLeastShare);
        point = point * held + (at(m - 1) + at(m + 1)) * (0.5 * (1 - held));
    }
    return fading;
}

}  // namespace

ArcNetwork arcPoints(const BallBoundary& boundary, const std::vector<DualVec3>& balls,
                     std::vector<DualVec3> vertices, const ArcSubdivision& subdivision) {
    const double radius = boundary.worldRadius();
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
        IntersectionCircle circle(balls[from(start)], balls[from(boundary.twin[start])], radius);
        circle.beginTowards(network.point[start / 3]);
        return circle;
    };
    const bool by_calm = subdivision.segments == 0 && subdivision.flat_angle > subdivision.max_angle;
    const auto cutOfArc = [&](std::size_t a) {
        const std::uint32_t start = network.arc_start[a], end = boundary.twin[start];
        const bool one_triplet = start / 3 == reverseSide(boundary, end / 3);
        Dual per_radian = 1 / subdivision.max_angle;
        if (!network.flatness.empty()) {
            const Dual one = network.flatness[start], other = network.flatness[end];
            per_radian = per_radian + (one.value < other.value ? one : other) *
                                          (1 / subdivision.flat_angle - 1 / subdivision.max_angle);
        }
        return cutFor(network.arc_angle[a], network.line[a].radius / radius, one_triplet ? 2 : 1, subdivision.segments,
                      per_radian, subdivision);
    };
    const auto cutOfHalf = [&](std::size_t k) {
        return cutFor(kTurn / 2, network.line[arcs + k].radius / radius, 2, (subdivision.segments + 1) / 2,
                      1 / subdivision.max_angle, subdivision);
    };
    const auto circleAt = [&](std::size_t k) {
        return IntersectionCircle(balls[boundary.circle[k][0]], balls[boundary.circle[k][1]], radius);
    };
    firstTouchResize(network.line, arcs + circles);
    firstTouchResize(network.arc_angle, arcs);
    parallelFor(arcs, 512, [&](std::size_t a) {
        const std::uint32_t start = network.arc_start[a], end = boundary.twin[start];
        const IntersectionCircle circle = circleOfArc(a);
        network.arc_angle[a] = circle.angleRate(network.point[end / 3], arcAngle(boundary, circle, start));
        network.line[a] = {{from(start), from(end)},
                           circle.radius(),
                           circle.radius() * network.arc_angle[a],
                           cross(circle.axis(), network.point[start / 3] - network.point[end / 3])};
    });
    for (std::size_t k = 0; k < circles; ++k) {
        const Dual of_circle = circleAt(k).radius();
        network.line[arcs + k] = {boundary.circle[k], of_circle, of_circle * kTurn, {}};
    }
    network.at_ball =
        sortedIntoRows<std::uint32_t>(balls.size(), network.line.size(), [&](std::size_t l, const auto& visit) {
            for (const std::uint32_t b : network.line[l].balls) visit(b, static_cast<std::uint32_t>(l));
        });
    if (by_calm) network.flatness = calmness(boundary, balls, network);

    std::vector<std::uint32_t> inside(arcs + circles), rise(arcs + circles);
    parallelFor(arcs, 512, [&](std::size_t a) {
        const Cut cut = cutOfArc(a);
        inside[a] = cut.segments() - 1;
        rise[a] = cut.fading();
    });
    for (std::size_t k = 0; k < circles; ++k) {
        const Cut cut = cutOfHalf(k);
        inside[arcs + k] = 2 * cut.segments();
        rise[arcs + k] = 2 * cut.fading();
    }
    std::vector<std::uint32_t> begin = exclusiveScan(inside);
    for (std::uint32_t& b : begin) b += static_cast<std::uint32_t>(network.vertices);
    network.arc_begin.assign(begin.begin(), begin.begin() + static_cast<std::ptrdiff_t>(arcs + 1));
    network.circle_begin.assign(begin.begin() + static_cast<std::ptrdiff_t>(arcs), begin.end());
    firstTouchResize(network.point, begin.back());

    const std::vector<std::uint32_t> fading = exclusiveScan(rise);
    firstTouchResize(network.fading, fading.back());
    parallelFor(arcs, 512, [&](std::size_t a) {
        if (inside[a] == 0) return;
        const std::uint32_t start = network.arc_start[a], end = boundary.twin[start];
        const auto pointOf = [&](std::uint32_t m) {
            return m == 0 ? start / 3 : m > inside[a] ? end / 3 : network.arc_begin[a] + m - 1;
        };
        const IntersectionCircle circle = circleOfArc(a);
        placePoints(circle, 0, network.arc_angle[a], cutOfArc(a), 1, inside[a], pointOf, network,
                    network.fading.data() + fading[a]);
    });
    parallelFor(circles, 64, [&](std::size_t k) {
        IntersectionCircle circle = circleAt(k);
        circle.beginAnywhere();
        const Cut cut = cutOfHalf(k);
        FadingVertex* next = network.fading.data() + fading[arcs + k];
        for (const std::uint32_t half : {0U, 1U}) {
            const auto pointOf = [&](std::uint32_t m) {
                return network.circle_begin[k] + (half * cut.segments() + m) % inside[arcs + k];
            };
            next = placePoints(circle, half * kTurn / 2, kTurn / 2, cut, 0, cut.segments() - 1, pointOf, network, next);
        }
    });
    return network;
}

}  // namespace betamesh
