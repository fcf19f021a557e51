
#include "skin/boundary_samples.h"

#include "base/angles.h"
#include "base/intersection_circle.h"
#include "base/parallel.h"
#include "skin/constants.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace betamesh {

namespace {

// sin(x) / x for x >= 0; a series near 0.
Dual sinc(Dual x) {
    const auto [sine, cosine] = sineCosine(x.value);
    if (x.value < 1e-4) return {1 - x.value * x.value / 6, -x.value * x.rate / 3};
    return {sine / x.value, (cosine - sine / x.value) / x.value * x.rate};
}

// Distance from the centre of a circle at which samples of it are placed.
Dual liftedRadius(Dual radius, Dual sphere_radius) { return radius * (1 - kArcLift) + kArcLift * sphere_radius; }

// The sample of a piece of a circle on a sphere of a radius: an arc of angle `covered` with its middle at `angle`.
BoundarySample arcSample(const IntersectionCircle& circle, Dual sphere_radius, Dual angle, Dual covered) {
    const Dual lifted = liftedRadius(circle.radius(), sphere_radius);
    const Dual level = circle.radius() / sphere_radius, flat = sinc(covered / 2), curved = 1 - flat * flat;
    const DualVec3 outwards = circle.outwards(angle) * flat;
    return {circle.centre() + outwards * lifted, outwards * level, circle.radius() * covered, lifted * lifted * curved,
            lifted * level * curved};
}

// Sums over weighted points at fixed directions of a ball: weights, and weights times directions.
class DirectionSum {
public:
    void add(const Vec3& direction, Dual weight) {
        weight_ = weight_ + weight;
        direction_ = direction_ + DualVec3{direction, {0, 0, 0}} * weight;
    }
    Dual weight() const { return weight_; }
    const DualVec3& direction() const { return direction_; }

private:
    Dual weight_;
    DualVec3 direction_;
};

// Merges samples into one with the same mean and second moments. Sums are relative to an origin near them.
class MomentAccumulator {
public:
    explicit MomentAccumulator(const DualVec3& origin = {}) : origin_(origin) {}
    // Adds half of an arc or circle around the ball at the origin, integrated exactly; middle: the circle's centre.
    void addHalf(const ArcLine& line, const DualVec3& middle, Dual radius) {
        const Dual weight = line.length * 0.5, lifted = liftedRadius(line.radius, radius), level = line.radius / radius;
        weight_ = weight_ + weight;
        offset_ = offset_ + (middle - origin_) * weight + line.outwards * (lifted * 0.5);
        direction_ = direction_ + line.outwards * (level * 0.5);
        square_ = square_ + (radius * radius - line.radius * line.radius + lifted * lifted) * weight;
        along_ = along_ + level * lifted * weight;
    }
    // Adds points on the ball at the origin.
    void add(const DirectionSum& points, Dual radius) {
        const Dual weight = points.weight();
        const DualVec3& direction = points.direction();
        weight_ = weight_ + weight;
        offset_ = offset_ + direction * radius;
        direction_ = direction_ + direction;
        square_ = square_ + weight * (radius * radius);
        along_ = along_ + weight * radius;
    }
    // A sample relative to the origin, as it is added to the sums.
    struct Summand {
        DualVec3 offset, direction;
        Dual weight, square, along;

        Summand(const BoundarySample& sample, const DualVec3& origin)
            : offset(sample.position - origin),
              direction(sample.direction),
              weight(sample.weight),
              square(dot(offset, offset) + sample.variance),
              along(dot(offset, direction) + sample.convexity) {}
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

// Weights of the corners of a tetrahedron for a unit vector; they sum to 1, and the nearest corner gets nearly all.
// With powers below the twelfth, sheets are less flat along some axes than along others; with higher powers, they move
// faster where holes open.
template <typename Number>
std::array<Number, kCorners> cornerWeights(Number x, Number y, Number z) {
    const auto twelfthPower = [](Number number) {
        const Number square = number * number, fourth = square * square;
        return fourth * fourth * fourth;
    };
    constexpr double kLength = std::numbers::sqrt3;  // of (1, 1, 1)
    std::array<Number, kCorners> weight{twelfthPower(kLength + x + y + z), twelfthPower(kLength + x - y - z),
                                        twelfthPower(kLength + y - x - z), twelfthPower(kLength + z - x - y)};
    const Number sum = weight[0] + weight[1] + weight[2] + weight[3];
    for (Number& part : weight) part = part / sum;
    return weight;
}

// A point on a ball: its direction from the centre, its weight, and the share of that for each corner.
struct WeightedDirection {
    Vec3 direction;
    Dual weight;
    const std::array<double, kCorners>& corner_weight;
};

// The samples of the exposed part of one ball: one, four towards the corners of a tetrahedron, or both with shares of
// the weight.
struct ExposedBall {
    BoundarySample whole;
    std::array<BoundarySample, kCorners> part;

    // moments      of half of each arc and circle around the ball, with the ball as origin
    // forPieces    forPieces(visit) calls visit(sample) for pieces of these arcs and circles
    // inside       points of its faces
    template <typename ForPieces>
    ExposedBall(const DualVec3& ball, Dual radius, MomentAccumulator moments, const ForPieces& forPieces,
                const std::vector<WeightedDirection>& inside) {
        DirectionSum all;
        for (const auto& [direction, weight, corner_weight] : inside) all.add(direction, weight);
        moments.add(all, radius);
        whole = moments.sample();
        const Dual divided = smoothStep((whole.variance / (radius * radius) - kOneSampleSpread) /
                                        (kFourSamplesSpread - kOneSampleSpread));
        whole.weight = whole.weight * (1 - divided);
        if (divided.value == 0) return;

        std::array<MomentAccumulator, kCorners> corner;
        corner.fill(MomentAccumulator(ball));
        forPieces([&](const BoundarySample& piece) {
            const MomentAccumulator::Summand summand(piece, ball);
            const DualVec3 direction = normalized(summand.offset);
            const auto along = [&](int k) { return Dual(direction.position[k], direction.velocity[k]); };
            const auto corner_weight = cornerWeights(along(0), along(1), along(2));
            for (std::size_t k = 0; k < kCorners; ++k) corner[k].add(summand, corner_weight[k] * 0.5);
        });
        std::array<DirectionSum, kCorners> points;
        for (const auto& [direction, weight, corner_weight] : inside)
            for (std::size_t k = 0; k < kCorners; ++k) points[k].add(direction, weight * corner_weight[k]);
        for (std::size_t k = 0; k < kCorners; ++k) {
            corner[k].add(points[k], radius);
            part[k] = corner[k].sample();
            part[k].weight = part[k].weight * divided;
        }
    }
    // Calls visit(sample) for those with a weight.
    template <typename Visit>
    void forSamples(const Visit& visit) const {
        if (whole.weight.value > 0) visit(whole);
        for (const BoundarySample& sample : part)
            if (sample.weight.value > 0) visit(sample);
    }
};

// The centre of the circle in which two spheres meet.
DualVec3 circleCentre(const BallBoundary& boundary, const std::vector<DualVec3>& balls,
                      const std::array<std::uint32_t, 2>& pair) {
    const DualVec3 &a = balls[pair[0]], &b = balls[pair[1]], middle = (a + b) * 0.5;
    if (boundary.radius_of.empty() && boundary.radius_rate.empty()) return middle;
    return IntersectionCircle(a, boundary.worldRadiusOf(pair[0]), b, boundary.worldRadiusOf(pair[1])).centre();
}

}  // namespace

SamplesInRadii boundarySamples(const BallBoundary& boundary, const std::vector<DualVec3>& balls,
                               const ArcNetwork& network, const FacePoints& points) {
    const std::size_t arcs = network.arc_start.size(), directions = points.directions.position.size();
    const auto forPieces = [&](std::size_t l, Dual radius, const auto& visit) {
        const auto [low, high] = network.line[l].balls;
        IntersectionCircle circle(balls[low], boundary.worldRadiusOf(low), balls[high], boundary.worldRadiusOf(high));
        Dual angle = kTwoPi;
        if (l < arcs) {
            circle.setZeroTowards(network.point[network.arc_start[l] / 3]);
            angle = network.arc_angle[l];
        } else {
            circle.setZeroAnywhere();
        }
        const int n = std::max(1, static_cast<int>(std::ceil(angle.value / kMaxPieceAngle)));
        for (int k = 0; k < n; ++k) visit(arcSample(circle, radius, angle * ((k + 0.5) / n), angle / n));
    };

    std::vector<std::array<double, kCorners>> corner_weight(directions);
    for (std::size_t d = 0; d < directions; ++d) {
        const Vec3& at = points.directions.position[d];
        corner_weight[d] = cornerWeights(at.x, at.y, at.z);
    }

    return concatenate(parallelParts<SamplesInRadii>(
        balls.size(), kBallsPerTask, [&](std::size_t begin, std::size_t end, SamplesInRadii& samples) {
            samples.reserve(kBallsPerTask);  // most balls give one sample
            std::vector<WeightedDirection> inside;
            for (std::size_t b = begin; b < end; ++b) {
                const Dual radius = boundary.worldRadiusOf(b);
                const Dual area = kAreaWeight * 2 * kTwoPi * radius / static_cast<double>(directions);
                MomentAccumulator lines(balls[b]);
                for (const std::uint32_t l : network.at_ball[b])
                    lines.addHalf(network.line[l], circleCentre(boundary, balls, network.line[l].balls), radius);
                inside.clear();
                for (std::uint32_t p = points.begin[b]; p < points.begin[b + 1]; ++p) {
                    if (points.contactOf(p) || points.rim_distance[p].value <= kFaceSampleBegins) continue;
                    const Dual fade = smoothStep((points.rim_distance[p] - kFaceSampleBegins) /
                                                 (kFaceSampleFull - kFaceSampleBegins));
                    const std::uint32_t d = points.direction[p];
                    inside.push_back({points.directions.position[d], fade * area, corner_weight[d]});
                }
                const auto forPiecesHere = [&](const auto& visit) {
                    for (const std::uint32_t l : network.at_ball[b]) forPieces(l, radius, visit);
                };
                const ExposedBall exposed(balls[b], radius, lines, forPiecesHere, inside);
                const double scale = boundary.scaleOf(b);
                exposed.forSamples([&](BoundarySample sample) {
                    sample.weight = sample.weight * scale;
                    samples.emplace_back(sample, boundary.worldRadius(), scale);
                });
            }
        }));
}

}  // namespace betamesh
