#include "skin/boundary_samples.h"

#include "core/angles.h"
#include "core/moving_circle.h"
#include "core/parallel.h"

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
constexpr double kRim = 0.2, kInside = 0.7;  // faces count in full from this clearance on, not below the first
constexpr double kTight = 0.35;  // squared radii: up to this spread all that is exposed of a ball counts as one sample
constexpr double kLoose = 0.5;   // and from this on as six, towards six sides

// sin(x) / x, of small x >= 0.
Rate sinc(Rate x) {
    const auto [sine, cosine] = sineCosine(x.value);
    if (x.value < 1e-4) return {1 - x.value * x.value / 6, -x.value * x.rate / 3};
    return {sine / x.value, (cosine - sine / x.value) / x.value * x.rate};
}

// How far from its middle a line counts.
Rate liftedOf(Rate radius, double sphere_radius) { return radius * (1 - kLift) + kLift * sphere_radius; }

// A piece of a circle that covers an angle, round its middle.
BoundarySample pieceAt(const MovingCircle& circle, Rate angle, Rate covered) {
    const Rate lifted = liftedOf(circle.radius(), circle.sphereRadius());
    const Rate level = circle.radius() / circle.sphereRadius(), flat = sinc(covered / 2), curved = 1 - flat * flat;
    const Moving outwards = circle.outwards(angle) * flat;
    return {circle.centre() + outwards * lifted, outwards * level, circle.radius() * covered, lifted * lifted * curved,
            lifted * level * curved};
}

// Points on a ball, of weights of their own, as one: all turn with the ball.
class PointsOnBall {
public:
    void add(const Vec3& direction, Rate weight) {
        weight_ = weight_ + weight;
        towards_ = towards_ + Moving{direction, {0, 0, 0}} * weight;
    }
    Rate weight() const { return weight_; }
    // Σ weight · direction
    Moving direction(const Vec3& spin) const { return towards_ + Moving{{0, 0, 0}, cross(spin, towards_.position)}; }

private:
    Rate weight_;
    Moving towards_;  // as the ball sees it
};

// Samples as one: their mean, and how they lie about it. Sums are taken from an origin near them.
class Together {
public:
    explicit Together(const Moving& origin = {}) : origin_(origin) {}
    // Half of a line round the ball that is the origin: all of its pieces, the smallest ones.
    void addHalf(const ArcLine& line, const Moving& middle, double radius) {
        const Rate weight = line.length * 0.5, lifted = liftedOf(line.radius, radius), level = line.radius / radius;
        weight_ = weight_ + weight;
        offset_ = offset_ + (middle - origin_) * weight + line.outwards * (lifted * 0.5);
        direction_ = direction_ + line.outwards * (level * 0.5);
        square_ = square_ + (radius * radius - line.radius * line.radius + lifted * lifted) * weight;
        along_ = along_ + level * lifted * weight;
    }
    // Of the ball that is the origin.
    void add(const PointsOnBall& points, const Vec3& spin, double radius) {
        const Rate weight = points.weight();
        const Moving direction = points.direction(spin);
        weight_ = weight_ + weight;
        offset_ = offset_ + direction * radius;
        direction_ = direction_ + direction;
        square_ = square_ + weight * (radius * radius);
        along_ = along_ + weight * radius;
    }
    // A sample as it adds to sums, at an offset from their origin.
    struct Summand {
        Moving offset, direction;
        Rate weight, square, along;

        Summand(const BoundarySample& sample, const Moving& origin)
            : offset(sample.position - origin),
              direction(sample.direction),
              weight(sample.weight),
              square(dot(offset, offset) + sample.spread),
              along(dot(offset, direction) + sample.bulge) {}
    };
    void add(const Summand& sample, Rate share) {
        const Rate weight = sample.weight * share;
        weight_ = weight_ + weight;
        offset_ = offset_ + sample.offset * weight;
        direction_ = direction_ + sample.direction * weight;
        square_ = square_ + sample.square * weight;
        along_ = along_ + sample.along * weight;
    }
    BoundarySample sample() const {
        if (!(weight_.value > 0)) return {};
        const Moving offset = offset_ / weight_, direction = direction_ / weight_;
        return {origin_ + offset, direction, weight_, square_ / weight_ - dot(offset, offset),
                along_ / weight_ - dot(offset, direction)};
    }

private:
    Moving origin_, offset_, direction_;
    Rate weight_, square_, along_;
};

// A point on a ball, seen from there, and how much it counts.
struct WeightedDirection {
    Vec3 direction;
    Rate weight;
};

// What is exposed of one ball, as one sample or as six towards the sides of a cube that turns with the liquid.
struct ExposedBall {
    BoundarySample whole;
    std::array<BoundarySample, 6> side;

    // together: half of each line round the ball, which is the origin; forPieces(visit): calls visit(sample) for the
    // pieces of these lines, which are half this ball's; inside: points of its faces
    template <typename ForPieces>
    ExposedBall(const Moving& ball, const Vec3& spin, double radius, Together together, const ForPieces& forPieces,
                const std::vector<WeightedDirection>& inside) {
        PointsOnBall all;
        for (const auto& [direction, weight] : inside) all.add(direction, weight);
        together.add(all, spin, radius);
        whole = together.sample();
        const Rate apart = smoothStep((whole.spread / (radius * radius) - kTight) / (kLoose - kTight));
        whole.weight = whole.weight * (1 - apart);
        if (apart.value == 0) return;

        // Squares of a direction's components sum to one.
        std::array<Together, 6> towards;
        towards.fill(Together(ball));
        forPieces([&](const BoundarySample& piece) {
            const Together::Summand summand(piece, ball);
            const Moving direction = normalized(summand.offset);
            const Vec3 turning = direction.velocity - cross(spin, direction.position);  // as the cube sees it
            for (int k = 0; k < 3; ++k) {
                const Rate along(direction.position[k], turning[k]);
                towards[sideTowards(k, along.value)].add(summand, along * along * 0.5);
            }
        });
        std::array<PointsOnBall, 6> points;
        for (const auto& [direction, weight] : inside)
            for (int k = 0; k < 3; ++k)
                points[sideTowards(k, direction[k])].add(direction, weight * (direction[k] * direction[k]));
        for (std::size_t k = 0; k < side.size(); ++k) {
            towards[k].add(points[k], spin, radius);
            side[k] = towards[k].sample();
            side[k].weight = side[k].weight * apart;
        }
    }
    // Calls visit(sample) for those that weigh anything.
    template <typename Visit>
    void forSamples(const Visit& visit) const {
        if (whole.weight.value > 0) visit(whole);
        for (const BoundarySample& sample : side)
            if (sample.weight.value > 0) visit(sample);
    }

private:
    static std::size_t sideTowards(int axis, double along) { return static_cast<std::size_t>(2 * axis + (along > 0)); }
};

}  // namespace

SamplesInRadii boundarySamples(const BallBoundary& boundary, const std::vector<Moving>& balls,
                               const std::vector<Vec3>& spins, const ArcNetwork& network, const FacePoints& points) {
    const double radius = boundary.worldRadius();
    const std::size_t arcs = network.arc_start.size(), directions = points.directions.position.size();
    const double area = kAreaWeight * 2 * kTurn * radius / static_cast<double>(directions);
    const auto forPieces = [&](std::size_t l, const auto& visit) {
        const auto [low, high] = network.line[l].balls;
        MovingCircle circle(balls[low], balls[high], radius);
        Rate angle = kTurn;
        if (l < arcs) {
            circle.beginTowards(network.point[network.arc_start[l] / 3]);
            angle = network.arc_angle[l];
        } else {
            circle.beginAnywhere((spins[low] + spins[high]) / 2);
        }
        const int n = std::max(1, static_cast<int>(std::ceil(angle.value / kLongestPiece)));
        for (int k = 0; k < n; ++k) visit(pieceAt(circle, angle * ((k + 0.5) / n), angle / n));
    };

    constexpr std::size_t kBallsPerTask = 256;
    const std::size_t tasks = (balls.size() + kBallsPerTask - 1) / kBallsPerTask;
    std::vector<SamplesInRadii> parts(tasks);
    parallelFor(tasks, 1, [&](std::size_t task) {
        parts[task].reserve(kBallsPerTask);  // one each, nearly always
        std::vector<WeightedDirection> inside;
        for (std::size_t b = task * kBallsPerTask; b < std::min(balls.size(), (task + 1) * kBallsPerTask); ++b) {
            Together lines(balls[b]);
            for (const std::uint32_t l : network.at_ball[b]) {
                const ArcLine& line = network.line[l];
                lines.addHalf(line, (balls[line.balls[0]] + balls[line.balls[1]]) * 0.5, radius);
            }
            inside.clear();
            for (std::uint32_t p = points.begin[b]; p < points.begin[b + 1]; ++p) {
                if (points.contactOf(p) || points.clearance[p].value <= kRim) continue;
                const Rate share = smoothStep((points.clearance[p] - kRim) / (kInside - kRim));
                inside.push_back({points.directions.position[points.direction[p]], share * area});
            }
            const auto forPiecesHere = [&](const auto& visit) {
                for (const std::uint32_t l : network.at_ball[b]) forPieces(l, visit);
            };
            const ExposedBall exposed(balls[b], spins[b], radius, lines, forPiecesHere, inside);
            exposed.forSamples([&](const BoundarySample& sample) { parts[task].emplace_back(sample, radius); });
        }
    });
    return joined(parts);
}

}  // namespace betamesh
