
#include "skin/boundary_samples.h"

#include "base/angles.h"
#include "base/intersection_circle.h"
#include "base/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace betamesh {

namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kLongestPiece = 0.8;        // radians
constexpr double kLift = 0.5;                // of the way from the arc to the sphere round its centre
constexpr double kAreaWeight = 3;            // length that stands for an area, times the radius
constexpr double kRim = 0.2, kInside = 0.7;  // faces count in full from this rim_distance on, not below the first
constexpr double kTight = 0.4;   // squared radii: up to this spread all that is exposed of a ball counts as one sample
constexpr double kLoose = 0.55;  // and from this on as four, towards the corners of a tetrahedron

// sin(x) / x, of small x >= 0.
Dual sinc(Dual x) {
    const auto [sine, cosine] = sineCosine(x.value);
    if (x.value < 1e-4) return {1 - x.value * x.value / 6, -x.value * x.rate / 3};
    return {sine / x.value, (cosine - sine / x.value) / x.value * x.rate};
}

// How far from its middle a line counts.
Dual liftedOf(Dual radius, double sphere_radius) { return radius * (1 - kLift) + kLift * sphere_radius; }

// A piece of a circle that covers an angle, round its middle.
BoundarySample pieceAt(const IntersectionCircle& circle, Dual angle, Dual covered) {
    const Dual lifted = liftedOf(circle.radius(), circle.sphereRadius());
    const Dual level = circle.radius() / circle.sphereRadius(), flat = sinc(covered / 2), curved = 1 - flat * flat;
    const DualVec3 outwards = circle.outwards(angle) * flat;
    return {circle.centre() + outwards * lifted, outwards * level, circle.radius() * covered, lifted * lifted * curved,
            lifted * level * curved};
}

// Points on a ball, of weights of their own, as one: all turn with the ball.
class PointsOnBall {
public:
    void add(const Vec3& direction, Dual weight) {
        weight_ = weight_ + weight;
        towards_ = towards_ + DualVec3{direction, {0, 0, 0}} * weight;
    }
    Dual weight() const { return weight_; }
    // Σ weight · direction
    const DualVec3& direction() const { return towards_; }

private:
    Dual weight_;
    DualVec3 towards_;
};

// Samples as one: their mean, and how they lie about it. Sums are taken from an origin near them.
class MomentAccumulator {
public:
    explicit MomentAccumulator(const DualVec3& origin = {}) : origin_(origin) {}
    // Half of a line round the ball that is the origin: all of its pieces, the smallest ones.
    void addHalf(const ArcLine& line, const DualVec3& middle, double radius) {
        const Dual weight = line.length * 0.5, lifted = liftedOf(line.radius, radius), level = line.radius / radius;
        weight_ = weight_ + weight;
        offset_ = offset_ + (middle - origin_) * weight + line.outwards * (lifted * 0.5);
        direction_ = direction_ + line.outwards * (level * 0.5);
        square_ = square_ + (radius * radius - line.radius * line.radius + lifted * lifted) * weight;
        along_ = along_ + level * lifted * weight;
    }
    // Of the ball that is the origin.
    void add(const PointsOnBall& points, double radius) {
        const Dual weight = points.weight();
        const DualVec3& direction = points.direction();
        weight_ = weight_ + weight;
        offset_ = offset_ + direction * radius;
        direction_ = direction_ + direction;
        square_ = square_ + weight * (radius * radius);
        along_ = along_ + weight * radius;
    }
    // A sample as it adds to sums, at an offset from their origin.
    struct Summand {
        DualVec3 offset, direction;
        Dual weight, square, along;

        Summand(const BoundarySample& sample, const DualVec3& origin)
            : offset(sample.position - origin),
              direction(sample.direction),
              weight(sample.weight),
              square(dot(offset, offset) + sample.spread),
              along(dot(offset, direction) + sample.bulge) {}
    };
    void add(const Summand& sample, Dual share) {
        const Dual weight = sample.weight * share;
        weight_ = weight_ + weight;
        offset_ = offset_ + sample.offset * weight;
        direction_ = direction_ + sample.direction * weight;
        square_ = square_ + sample.square * weight;
        along_ = along_ + sample.along * weight;
    }
    BoundarySample sample() const {
        if (!(weight_.value > 0)) return {};
        const DualVec3 offset = offset_ / weight_, direction = direction_ / weight_;
        return {origin_ + offset, direction, weight_, square_ / weight_ - dot(offset, offset),
                along_ / weight_ - dot(offset, direction)};
    }

private:
    DualVec3 origin_, offset_, direction_;
    Dual weight_, square_, along_;
};

constexpr std::size_t kCorners = 4;

// How a unit vector is shared out among the corners of a tetrahedron: nearly all goes to the nearest one. (With powers
// lower than the twelfth, sheets are less flat along some axes than along others; with higher ones, they move faster
// where holes open.)
template <typename Number>
std::array<Number, kCorners> sharesOf(Number x, Number y, Number z) {
    const auto twelfthPower = [](Number number) {
        const Number square = number * number, fourth = square * square;
        return fourth * fourth * fourth;
    };
    constexpr double kLength = std::numbers::sqrt3;  // of (1, 1, 1)
    std::array<Number, kCorners> share{twelfthPower(kLength + x + y + z), twelfthPower(kLength + x - y - z),
                                       twelfthPower(kLength + y - x - z), twelfthPower(kLength + z - x - y)};
    const Number sum = share[0] + share[1] + share[2] + share[3];
    for (Number& part : share) part = part / sum;
    return share;
}

// A point on a ball, seen from there, how much it counts, and for which corners.
struct WeightedDirection {
    Vec3 direction;
    Dual weight;
    const std::array<double, kCorners>& share;
};

// What is exposed of one ball, as one sample or as four towards the corners of a tetrahedron.
struct ExposedBall {
    BoundarySample whole;
    std::array<BoundarySample, kCorners> part;

    // together: half of each line round the ball, which is the origin; forPieces(visit): calls visit(sample) for the
    // pieces of these lines, which are half this ball's; inside: points of its faces
    template <typename ForPieces>
    ExposedBall(const DualVec3& ball, double radius, MomentAccumulator together, const ForPieces& forPieces,
                const std::vector<WeightedDirection>& inside) {
        PointsOnBall all;
        for (const auto& [direction, weight, share] : inside) all.add(direction, weight);
        together.add(all, radius);
        whole = together.sample();
        const Dual apart = smoothStep((whole.spread / (radius * radius) - kTight) / (kLoose - kTight));
        whole.weight = whole.weight * (1 - apart);
        if (apart.value == 0) return;

        std::array<MomentAccumulator, kCorners> towards;
        towards.fill(MomentAccumulator(ball));
        forPieces([&](const BoundarySample& piece) {
            const MomentAccumulator::Summand summand(piece, ball);
            const DualVec3 direction = normalized(summand.offset);
            const auto along = [&](int k) { return Dual(direction.position[k], direction.velocity[k]); };
            const auto share = sharesOf(along(0), along(1), along(2));
            for (std::size_t k = 0; k < kCorners; ++k) towards[k].add(summand, share[k] * 0.5);
        });
        std::array<PointsOnBall, kCorners> points;
        for (const auto& [direction, weight, share] : inside)
            for (std::size_t k = 0; k < kCorners; ++k) points[k].add(direction, weight * share[k]);
        for (std::size_t k = 0; k < kCorners; ++k) {
            towards[k].add(points[k], radius);
            part[k] = towards[k].sample();
            part[k].weight = part[k].weight * apart;
        }
    }
    // Calls visit(sample) for those that weigh anything.
    template <typename Visit>
    void forSamples(const Visit& visit) const {
        if (whole.weight.value > 0) visit(whole);
        for (const BoundarySample& sample : part)
            if (sample.weight.value > 0) visit(sample);
    }
};

}  // namespace

SamplesInRadii boundarySamples(const BallBoundary& boundary, const std::vector<DualVec3>& balls,
                               const ArcNetwork& network, const FacePoints& points) {
    const double radius = boundary.worldRadius();
    const std::size_t arcs = network.arc_start.size(), directions = points.directions.position.size();
    const double area = kAreaWeight * 2 * kTurn * radius / static_cast<double>(directions);
    const auto forPieces = [&](std::size_t l, const auto& visit) {
        const auto [low, high] = network.line[l].balls;
        IntersectionCircle circle(balls[low], balls[high], radius);
        Dual angle = kTurn;
        if (l < arcs) {
            circle.beginTowards(network.point[network.arc_start[l] / 3]);
            angle = network.arc_angle[l];
        } else {
            circle.beginAnywhere();
        }
        const int n = std::max(1, static_cast<int>(std::ceil(angle.value / kLongestPiece)));
        for (int k = 0; k < n; ++k) visit(pieceAt(circle, angle * ((k + 0.5) / n), angle / n));
    };

    std::vector<std::array<double, kCorners>> share(directions);
    for (std::size_t d = 0; d < directions; ++d) {
        const Vec3& at = points.directions.position[d];
        share[d] = sharesOf(at.x, at.y, at.z);
    }

    constexpr std::size_t kBallsPerTask = 256;
    const std::size_t tasks = (balls.size() + kBallsPerTask - 1) / kBallsPerTask;
    std::vector<SamplesInRadii> parts(tasks);
    parallelFor(tasks, 1, [&](std::size_t task) {
        parts[task].reserve(kBallsPerTask);  // one each, nearly always
        std::vector<WeightedDirection> inside;
        for (std::size_t b = task * kBallsPerTask; b < std::min(balls.size(), (task + 1) * kBallsPerTask); ++b) {
            MomentAccumulator lines(balls[b]);
            for (const std::uint32_t l : network.at_ball[b]) {
                const ArcLine& line = network.line[l];
                lines.addHalf(line, (balls[line.balls[0]] + balls[line.balls[1]]) * 0.5, radius);
            }
            inside.clear();
            for (std::uint32_t p = points.begin[b]; p < points.begin[b + 1]; ++p) {
                if (points.contactOf(p) || points.rim_distance[p].value <= kRim) continue;
                const Dual free = smoothStep((points.rim_distance[p] - kRim) / (kInside - kRim));
                const std::uint32_t d = points.direction[p];
                inside.push_back({points.directions.position[d], free * area, share[d]});
            }
            const auto forPiecesHere = [&](const auto& visit) {
                for (const std::uint32_t l : network.at_ball[b]) forPieces(l, visit);
            };
            const ExposedBall exposed(balls[b], radius, lines, forPiecesHere, inside);
            exposed.forSamples([&](const BoundarySample& sample) { parts[task].emplace_back(sample, radius); });
        }
    });
    return concatenate(parts);
}

}  // namespace betamesh
