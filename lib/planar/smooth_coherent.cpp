
#include "planar/smooth_coherent.h"

#include "base/cell_order.h"
#include "base/simd.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace betamesh {

namespace {

constexpr double kFarthest = 0.5;    // that a vertex goes, in radii
constexpr double kOwnWeight = 0.25;  // of the vertex itself against the samples, in radii
constexpr double kRound = 1e-3;      // added to the samples' variance, in squared radii: keeps single ones straight
constexpr double kLeastMean = 0.01;  // added to |m|²
constexpr double kSteepest = 0.2;    // square of how steep a sample may lie
constexpr double kNear = 0.5;        // reach of what makes the mean direction, in that of the samples
constexpr double kTornMean = 0.2;    // |m|² where opposite directions nearby begin to hold a vertex back
constexpr double kDiscord = 0.25;    // mean square by which directions may miss those of the circle; bumps: 0.08

// As many numbers as the widest registers hold, each with its rate of change.
constexpr std::size_t kLanes = 8;
using Lanes = double __attribute__((vector_size(kLanes * sizeof(double))));
struct alignas(kLanes * sizeof(double)) Rates {
    Lanes value{}, rate{};

    [[gnu::always_inline]] friend Rates operator+(const Rates& a, const Rates& b) {
        return {a.value + b.value, a.rate + b.rate};
    }
    [[gnu::always_inline]] friend Rates operator-(const Rates& a, const Rates& b) {
        return {a.value - b.value, a.rate - b.rate};
    }
    [[gnu::always_inline]] friend Rates operator*(const Rates& a, const Rates& b) {
        return {a.value * b.value, a.rate * b.value + a.value * b.rate};
    }
    [[gnu::always_inline]] friend Rates operator*(const Rates& a, double s) { return {a.value * s, a.rate * s}; }
};

[[gnu::always_inline]] inline Rates lanesOf(Dual a) { return {Lanes{} + a.value, Lanes{} + a.rate}; }
[[gnu::always_inline]] inline Rates positive(const Rates& a) {
    const Lanes zero{};
    return {a.value > 0 ? a.value : zero, a.value > 0 ? a.rate : zero};
}
[[gnu::always_inline]] inline Rates inverse(const Rates& a) {
    const Lanes value = 1.0 / a.value;
    return {value, -value * value * a.rate};
}
[[gnu::always_inline]] inline Dual total(const Rates& a) {
    Dual sum;
    for (std::size_t l = 0; l < kLanes; ++l) sum = sum + Dual(a.value[l], a.rate[l]);
    return sum;
}

// Some samples; those that are none weigh nothing. Lengths in radii, positions from the middle of a cell.
struct alignas(kLanes * sizeof(double)) Block {
    Rates x, y, dx, dy, weight;
};

struct Fit {
    DualVec3 step;       // radii
    DualVec3 direction;  // of the fitted circle
    Dual trust;        // 0 without samples, towards 1 with many that agree
};

struct Sums {
    Dual mean_square, weight, along, square;  // mean_square: |m|²
    DualVec3 offset, direction;
};

BETAMESH_EVERY_CPU
void sumUp(const Block* blocks, std::size_t n, double inverse_square_width, const DualVec3& at, Sums& sums) {
    const Rates one = lanesOf(1), x = lanesOf({at.position.x, at.velocity.x}),
                y = lanesOf({at.position.y, at.velocity.y});
    const auto kernel = [&](const Rates& square, double inverse_square) __attribute__((always_inline)) {
        const Rates t = positive(one - square * inverse_square);
        return t * t;
    };
    const double inverse_square_near = inverse_square_width / (kNear * kNear);
    Rates mean_x, mean_y, mean_weight;
    for (std::size_t i = 0; i < n; ++i) {
        const Block& s = blocks[i];
        const Rates px = s.x - x, py = s.y - y, k = s.weight * kernel(px * px + py * py, inverse_square_near);
        mean_x = mean_x + k * s.dx;
        mean_y = mean_y + k * s.dy;
        mean_weight = mean_weight + k;
    }
    const Dual near = total(mean_weight);
    if (!(near.value > 0)) return;
    const Dual mx = total(mean_x) / near, my = total(mean_y) / near, mean_square = mx * mx + my * my,
               inverse_mean = 1 / (mean_square + kLeastMean);
    const Rates m_x = lanesOf(mx), m_y = lanesOf(my), gate = lanesOf(inverse_mean),
                steep = lanesOf(inverse_mean * (1 / kSteepest));
    Rates weight, offset_x, offset_y, direction_x, direction_y, along, square;
    for (std::size_t i = 0; i < n; ++i) {
        const Block& s = blocks[i];
        const Rates px = s.x - x, py = s.y - y, pp = px * px + py * py;
        const Rates height = px * m_x + py * m_y;
        const Rates level = positive(one - height * height * inverse(pp + one) * steep);
        const Rates facing = positive(s.dx * m_x + s.dy * m_y) * level;
        const Rates k = s.weight * kernel(pp, inverse_square_width) * facing * facing * gate;
        weight = weight + k;
        offset_x = offset_x + k * px;
        offset_y = offset_y + k * py;
        direction_x = direction_x + k * s.dx;
        direction_y = direction_y + k * s.dy;
        along = along + k * (px * s.dx + py * s.dy);
        square = square + k * pp;
    }
    const auto vector = [](Dual a, Dual b) { return DualVec3{{a.value, b.value, 0}, {a.rate, b.rate, 0}}; };
    sums = {mean_square,
            total(weight),
            total(along),
            total(square),
            vector(total(offset_x), total(offset_y)),
            vector(total(direction_x), total(direction_y))};
}

Fit fitCircle(const Sums& sums) {
    const Dual weight = sums.weight;
    if (!(weight.value > 0)) return {};
    const DualVec3 a = sums.offset / weight, b = sums.direction / weight;
    const Dual c = sums.along / weight, e = sums.square / weight;
    const Dual opening = c - dot(a, b), bend = opening / (e - dot(a, a) + kRound), uq = bend / 2;
    const DualVec3 ul = b - a * bend;
    const Dual minus_uc = dot(ul, a) + uq * e, slope = dot(ul, ul) + 1e-6;
    const Dual root = squareRoot(slope * slope + uq * minus_uc * slope * 4);
    const Dual squared = weight * weight, missed = (1 - dot(b, b) - opening * bend) * (1 / kDiscord);
    const Dual share = sums.mean_square * (1 / kTornMean), agreed = share * share * share * share;
    const Dual trust =
        squared / (squared + kOwnWeight * kOwnWeight) * agreed / (1 + agreed) / (1 + missed * missed * missed * missed);
    return {ul * (minus_uc * 2 / (slope + root)), ul, trust};
}

void setLane(Rates& rates, std::size_t lane, Dual number) {
    rates.value[lane] = number.value;
    rates.rate[lane] = number.rate;
}

// The fit at each of n points.
template <typename PointAt>
std::vector<Fit> fitAll(std::size_t n, const PointAt& pointAt, const BoundarySamples& samples,
                        const CurveSmoothing& params) {
    const double reach = params.width, scale = 1 / params.radius, edge = std::max(reach / 4, 0.5 * params.radius);
    const auto sampleAt = [&](std::size_t i) { return samples[i].position.position; };
    const CellOrder far(samples.size(), std::max(reach, edge), sampleAt);
    const CellOrder near(n, edge, [&](std::size_t i) { return pointAt(i).position; });
    std::vector<Fit> fits(n);
    forCellsWithin(reach, near, far, sampleAt, [&](std::uint32_t cell, std::span<const std::uint32_t> around) {
        const DualVec3 middle{near.lowestCorner(cell) + Vec3(edge / 2), Vec3(0)};
        std::vector<Block> blocks((around.size() + kLanes - 1) / kLanes);
        for (std::size_t i = 0; i < around.size(); ++i) {
            const BoundarySample& sample = samples[around[i]];
            const DualVec3 offset = (sample.position - middle) * scale;
            const DualVec3& d = sample.direction;
            Block& block = blocks[i / kLanes];
            const std::size_t lane = i % kLanes;
            setLane(block.x, lane, {offset.position.x, offset.velocity.x});
            setLane(block.y, lane, {offset.position.y, offset.velocity.y});
            setLane(block.dx, lane, {d.position.x, d.velocity.x});
            setLane(block.dy, lane, {d.position.y, d.velocity.y});
            setLane(block.weight, lane, sample.weight * scale);
        }
        for (const std::uint32_t row : near.rowsOf(cell)) {
            Sums sums;
            sumUp(blocks.data(), blocks.size(), 1 / (reach * scale * reach * scale), (pointAt(row) - middle) * scale,
                  sums);
            fits[row] = fitCircle(sums);
        }
    });
    return fits;
}

// Shorter than `farthest`, whatever the step; steps that are not nearly as long stay what they are.
DualVec3 limited(const DualVec3& step, double farthest) {
    const Dual s2 = dot(step, step) / (farthest * farthest), s4 = s2 * s2, s8 = s4 * s4;
    return step / squareRoot(squareRoot(squareRoot(squareRoot(1 + s8 * s8))));
}

}  // namespace

void smoothCoherently(BetaCurve& curve, BoundarySamples samples, const CurveSmoothing& params) {
    std::vector<DualVec3> smooth = curve.vertex;
    for (int pass = 0; pass < params.passes; ++pass) {
        const auto fits = fitAll(
            smooth.size(), [&](std::size_t v) -> const DualVec3& { return smooth[v]; }, samples, params);
        for (std::size_t v = 0; v < smooth.size(); ++v)
            smooth[v] = smooth[v] + fits[v].step * fits[v].trust * params.radius;
        if (pass + 1 == params.passes) break;
        const auto of_samples = fitAll(
            samples.size(), [&](std::size_t i) -> const DualVec3& { return samples[i].position; }, samples, params);
        for (std::size_t i = 0; i < samples.size(); ++i) {
            const Fit& fit = of_samples[i];
            samples[i].position = samples[i].position + fit.step * fit.trust * params.radius;
            samples[i].direction = samples[i].direction + (fit.direction - samples[i].direction) * fit.trust;
        }
    }
    for (std::size_t v = 0; v < smooth.size(); ++v)
        curve.vertex[v] = curve.vertex[v] + limited(smooth[v] - curve.vertex[v], kFarthest * params.radius);
}

}  // namespace betamesh
