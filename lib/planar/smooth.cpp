
#include "planar/smooth.h"

#include "base/cell_grid.h"
#include "base/simd.h"
#include "planar/curve_displacement.h"
#include "planar/scaled_points.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace betamesh {

void smoothAsInPaper(BetaCurve& curve, int passes) {
    std::vector<DualVec3> middle(curve.vertex.size());
    std::vector<Dual> weight(curve.vertex.size());
    for (int pass = 0; pass < passes; ++pass) {
        forEveryVertex(curve, [&](std::uint32_t before, std::uint32_t v, std::uint32_t after) {
            if (curve.pure[v]) return;
            middle[v] = (curve.vertex[before] + curve.vertex[after]) * 0.5;
            weight[v] = length(curve.vertex[after] - curve.vertex[before]);
        });
        forEveryVertex(curve, [&](std::uint32_t before, std::uint32_t v, std::uint32_t after) {
            const Dual sum = weight[before] + weight[after];
            if (!curve.pure[v] || !(sum.value > 0)) return;
            curve.vertex[v] = (middle[before] * weight[before] + middle[after] * weight[after]) / sum;
        });
        forEveryVertex(curve, [&](std::uint32_t before, std::uint32_t v, std::uint32_t after) {
            if (!curve.pure[v]) curve.vertex[v] = (curve.vertex[before] + curve.vertex[after]) * 0.5;
        });
    }
}

void resolveIntersections(const DiscBoundary& boundary, const std::vector<DualVec3>& discs, BetaCurve& curve) {
    for (std::size_t k = 0; k < boundary.cycle.item.size(); ++k) {
        const auto [from, to] = boundary.segment[boundary.cycle.item[k]];
        DualVec3& vertex = curve.vertex[2 * k];
        const DualVec3 along = discs[to] - discs[from], offset = vertex - discs[from];
        if (crossZ(along.position, offset.position) > 0)
            vertex = discs[from] + along * (dot(offset, along) / dot(along, along));
    }
    forEveryVertex(curve, [&](std::uint32_t before, std::uint32_t v, std::uint32_t after) {
        if (curve.pure[v]) return;
        const DualVec3& particle = discs[boundary.segment[boundary.cycle.item[v / 2]][1]];
        const Vec3 &a = curve.vertex[before].position, &b = curve.vertex[v].position, &c = curve.vertex[after].position;
        if (crossZ(b - a, particle.position - a) < 0 || crossZ(c - b, particle.position - b) < 0)
            curve.vertex[v] = particle;
    });
}

namespace {

constexpr double kFarthest = 0.5;       // radii: longest displacement of a vertex
constexpr double kOwnWeight = 0.25;     // radii: weight of the unmoved vertex against the samples
constexpr double kVariance = 1e-3;      // squared radii: added to the samples' variance, keeps single samples straight
constexpr double kLeastMean = 0.01;     // added to |m|²
constexpr double kSteepest = 0.2;       // squared slope at which a sample seen from the vertex has weight 0
constexpr double kMeanReach = 0.5;      // widths: radius of the mean direction
constexpr double kOpposedMean = 0.2;    // |m|² below which opposite directions nearby reduce the displacement
constexpr double kDisagreement = 0.25;  // mean squared difference of directions that halves it; 0.08 for bumps

// A pack of dual numbers, eight lanes in double precision.
constexpr std::size_t kPackSize = 8;
using Pack = Doubles<kPackSize>;
struct alignas(kPackSize * sizeof(double)) Duals {
    Pack value{}, rate{};

    [[gnu::always_inline]] friend Duals operator+(const Duals& a, const Duals& b) {
        return {a.value + b.value, a.rate + b.rate};
    }
    [[gnu::always_inline]] friend Duals operator-(const Duals& a, const Duals& b) {
        return {a.value - b.value, a.rate - b.rate};
    }
    [[gnu::always_inline]] friend Duals operator*(const Duals& a, const Duals& b) {
        return {a.value * b.value, a.rate * b.value + a.value * b.rate};
    }
    [[gnu::always_inline]] friend Duals operator*(const Duals& a, double s) { return {a.value * s, a.rate * s}; }
};

[[gnu::always_inline]] inline Duals broadcast(Dual a) { return {Pack{} + a.value, Pack{} + a.rate}; }
[[gnu::always_inline]] inline Duals positivePart(const Duals& a) {
    const Pack zero{};
    return {a.value > 0 ? a.value : zero, a.value > 0 ? a.rate : zero};
}
[[gnu::always_inline]] inline Duals inverse(const Duals& a) {
    const Pack value = 1.0 / a.value;
    return {value, -value * value * a.rate};
}
[[gnu::always_inline]] inline Dual total(const Duals& a) {
    Dual sum;
    for (std::size_t l = 0; l < kPackSize; ++l) sum = sum + Dual(a.value[l], a.rate[l]);
    return sum;
}

// A pack of samples; unused lanes have weight 0. Lengths in radii, positions relative to the centre of a cell.
struct alignas(kPackSize * sizeof(double)) SamplePack {
    Duals x, y, dx, dy, weight;
};

struct Fit {
    DualVec3 step;       // radii of the discs there
    DualVec3 direction;  // gradient of the fitted circle
    Dual trust;          // 0 without samples, near 1 with many consistent ones
};

struct Sums {
    Dual mean_square, weight, along, square;  // mean_square: |m|²
    DualVec3 offset, direction;
};

BETAMESH_EVERY_CPU
void sumUp(const SamplePack* packs, std::size_t n, double inverse_square_width, const DualVec3& at,
           double inverse_scale, Sums& sums) {
    const Duals one = broadcast(1), x = broadcast({at.position.x, at.velocity.x}),
                y = broadcast({at.position.y, at.velocity.y});
    const auto kernel = [&](const Duals& square, double inverse_square) __attribute__((always_inline)) {
        const Duals t = positivePart(one - square * inverse_square);
        return t * t;
    };
    const double inverse_square_near = inverse_square_width / (kMeanReach * kMeanReach);
    Duals mean_x, mean_y, mean_weight;
    for (std::size_t i = 0; i < n; ++i) {
        const SamplePack& s = packs[i];
        const Duals px = (s.x - x) * inverse_scale, py = (s.y - y) * inverse_scale,
                    k = s.weight * kernel(px * px + py * py, inverse_square_near);
        mean_x = mean_x + k * s.dx;
        mean_y = mean_y + k * s.dy;
        mean_weight = mean_weight + k;
    }
    const Dual near = total(mean_weight);
    if (!(near.value > 0)) return;
    const Dual mx = total(mean_x) / near, my = total(mean_y) / near, mean_square = mx * mx + my * my,
               inverse_mean = 1 / (mean_square + kLeastMean);
    const Duals m_x = broadcast(mx), m_y = broadcast(my), gate = broadcast(inverse_mean),
                steep = broadcast(inverse_mean * (1 / kSteepest));
    Duals weight, offset_x, offset_y, direction_x, direction_y, along, square;
    for (std::size_t i = 0; i < n; ++i) {
        const SamplePack& s = packs[i];
        const Duals px = (s.x - x) * inverse_scale, py = (s.y - y) * inverse_scale, pp = px * px + py * py;
        const Duals height = px * m_x + py * m_y;
        const Duals level = positivePart(one - height * height * inverse(pp + one) * steep);
        const Duals facing = positivePart(s.dx * m_x + s.dy * m_y) * level;
        const Duals k = s.weight * kernel(pp, inverse_square_width) * facing * facing * gate;
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

// inverse_scale: of the unit of weights over that of positions
Fit fitCircle(const Sums& sums, double inverse_scale) {
    const Dual weight = sums.weight;
    if (!(weight.value > 0)) return {};
    const DualVec3 a = sums.offset / weight, b = sums.direction / weight;
    const Dual c = sums.along / weight, e = sums.square / weight;
    const Dual opening = c - dot(a, b), bend = opening / (e - dot(a, a) + kVariance), uq = bend / 2;
    const DualVec3 ul = b - a * bend;
    const Dual minus_uc = dot(ul, a) + uq * e, slope = dot(ul, ul) + 1e-6;
    const Dual root = squareRoot(slope * slope + uq * minus_uc * slope * 4);
    const Dual squared = weight * weight * (inverse_scale * inverse_scale),
               missed = (1 - dot(b, b) - opening * bend) * (1 / kDisagreement);
    const Dual share = sums.mean_square * (1 / kOpposedMean), agreed = share * share * share * share;
    const Dual trust =
        squared / (squared + kOwnWeight * kOwnWeight) * agreed / (1 + agreed) / (1 + missed * missed * missed * missed);
    return {ul * (minus_uc * 2 / (slope + root)), ul, trust};
}

void set(Duals& rates, std::size_t lane, Dual number) {
    rates.value[lane] = number.value;
    rates.rate[lane] = number.rate;
}

// The fits at those of some moving points that are of one class.
template <typename PointAt>
void fitAllOf(const ScaleClass& points, const PointAt& pointAt, const std::vector<double>& scale_at,
              const BoundarySamples& samples, const CurveSmoothing& params, std::vector<Fit>& fits) {
    const double scale = 1 / params.radius, reach = params.width * points.largest,
                 edge = std::max(reach / 4, 0.5 * params.radius * points.largest);
    const auto samplePosition = [&](std::size_t i) { return samples[i].position.position; };
    const CellGrid sample_cells(samples.size(), std::max(reach, edge), samplePosition);
    const CellGrid cells(points.row.size(), edge, [&](std::size_t k) { return pointAt(points.row[k]).position; });
    const double inverse_square_width = 1 / (params.width * scale * params.width * scale);
    forCellsAndNeighbours(
        reach, cells, sample_cells, samplePosition, [&](std::uint32_t cell, std::span<const std::uint32_t> around) {
            const DualVec3 middle{cells.lowestCorner(cell) + Vec3(edge / 2), Vec3(0)};
            std::vector<SamplePack> packs((around.size() + kPackSize - 1) / kPackSize);
            for (std::size_t i = 0; i < around.size(); ++i) {
                const BoundarySample& sample = samples[around[i]];
                const DualVec3 offset = (sample.position - middle) * scale;
                const DualVec3& d = sample.direction;
                SamplePack& pack = packs[i / kPackSize];
                const std::size_t lane = i % kPackSize;
                set(pack.x, lane, {offset.position.x, offset.velocity.x});
                set(pack.y, lane, {offset.position.y, offset.velocity.y});
                set(pack.dx, lane, {d.position.x, d.velocity.x});
                set(pack.dy, lane, {d.position.y, d.velocity.y});
                set(pack.weight, lane, sample.weight * scale);
            }
            for (const std::uint32_t k : cells.rowsOf(cell)) {
                const std::uint32_t row = points.row[k];
                const double inverse = scale_at.empty() ? 1 : 1 / scale_at[row];
                Sums sums;
                sumUp(packs.data(), packs.size(), inverse_square_width, (pointAt(row) - middle) * scale, inverse, sums);
                fits[row] = fitCircle(sums, inverse);
            }
        });
}

// The fit at each of n moving points. scale: of the discs at each point; empty: all 1.
template <typename PointAt>
std::vector<Fit> fitAll(std::size_t n, const PointAt& pointAt, const std::vector<double>& scale_at,
                        const BoundarySamples& samples, const CurveSmoothing& params) {
    std::vector<Fit> fits(n);
    for (const ScaleClass& points : scaleClasses(n, scale_at))
        fitAllOf(points, pointAt, scale_at, samples, params, fits);
    return fits;
}
// The step smoothly limited to the length `farthest`; clearly shorter steps are almost unchanged.
DualVec3 limited(const DualVec3& step, double farthest) {
    const Dual s2 = dot(step, step) / (farthest * farthest), s4 = s2 * s2, s8 = s4 * s4;
    return step / squareRoot(squareRoot(squareRoot(squareRoot(1 + s8 * s8))));
}

}  // namespace

void smoothCoherently(BetaCurve& curve, DiscSamples all, const CurveSmoothing& params) {
    BoundarySamples& samples = all.sample;
    std::vector<double> sample_scale;
    for (const Dual& scale : all.scale) sample_scale.push_back(scale.value);
    std::vector<DualVec3> smooth = curve.vertex;
    for (int pass = 0; pass < params.passes; ++pass) {
        const auto fits = fitAll(
            smooth.size(), [&](std::size_t v) -> const DualVec3& { return smooth[v]; }, curve.scales(), samples,
            params);
        for (std::size_t v = 0; v < smooth.size(); ++v)
            smooth[v] = smooth[v] + fits[v].step * fits[v].trust * (params.radius * curve.scaleOf(v).value);
        if (pass + 1 == params.passes) break;
        const auto of_samples = fitAll(
            samples.size(), [&](std::size_t i) -> const DualVec3& { return samples[i].position; }, sample_scale,
            samples, params);
        for (std::size_t i = 0; i < samples.size(); ++i) {
            const Fit& fit = of_samples[i];
            const double radius = sample_scale.empty() ? params.radius : params.radius * sample_scale[i];
            samples[i].position = samples[i].position + fit.step * fit.trust * radius;
            samples[i].direction = samples[i].direction + (fit.direction - samples[i].direction) * fit.trust;
        }
    }
    std::vector<DualVec3> displacement(smooth.size());
    for (std::size_t v = 0; v < smooth.size(); ++v)
        displacement[v] = limited(smooth[v] - curve.vertex[v], kFarthest * params.radius * curve.scaleOf(v).value);
    moveWithoutCrossings(curve, displacement, params.radius * curve.leastScale());
}

}  // namespace betamesh
