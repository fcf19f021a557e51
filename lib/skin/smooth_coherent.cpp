#include "skin/smooth_coherent.h"

#include "core/parallel.h"
#include "core/sample_blocks.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <span>

namespace betamesh {

namespace {

constexpr double kFarthest = 0.5;       // that a vertex goes, in radii
constexpr double kStayingBegins = 0.7;  // clearance up to which a vertex goes all the way
constexpr double kStaysWhole = 1.4;     // and from which it stays
constexpr double kOwnWeight = 1.5;      // of the vertex itself against the samples; on a plane surface they weigh 20
constexpr double kAgreement = 0.15;     // |m|² at which a step is half as long: where surfaces meet they face all ways
constexpr double kRound = 1e-3;         // added to the samples' variance, in squared radii: keeps single ones flat
constexpr float kLeastMean = 0.01F;     // added to |m|²
constexpr float kSteepest = 0.5F;       // square of how steep a sample may lie
constexpr float kSoft = 0.04F;          // added to squared distances between opposite sides, in squared radii
constexpr double kSheet = 4;            // thickness² · what sumOpposite finds on a plane sheet
constexpr double kShareOfThickness = 0.45;  // that an inset takes at most

// Of a sample: position, velocity, direction, its rate, weight, its rate, spread, half its rate, bulge, its rate;
// lengths in radii.
enum Field { kX, kY, kZ, kVx, kVy, kVz, kDx, kDy, kDz, kEx, kEy, kEz, kW, kU, kQ, kS, kB, kC, kFields };
using Block = SampleBlock<kFields>;

// The sums over samples, each with its rate: Σk, Σk y, Σk d, Σk y·d, Σk |y|².
enum Sum { kWeight, kOffset, kDirection = kOffset + 3, kAlong = kDirection + 3, kSquare, kSums };
struct Sums {
    double value[kSums], rate[kSums];
    float mean[3], mean_rate[3];         // Σ w K d / Σ w K
    float inverse_mean = 0, growth = 0;  // 1 / (|mean|² + kLeastMean), and minus its rate by itself

    Rate number(int s) const { return {value[s], rate[s]}; }
    Rate squareOfMean() const {
        const Moving m{{mean[0], mean[1], mean[2]}, {mean_rate[0], mean_rate[1], mean_rate[2]}};
        return dot(m, m);
    }
    Moving vector(int s) const { return {{value[s], value[s + 1], value[s + 2]}, {rate[s], rate[s + 1], rate[s + 2]}}; }
};

// All lengths here are in radii. x, v: the point and its velocity. Both loops and all sums run over the blocks in
// order, lane by lane, so every instruction set gives the same bytes.
BETAMESH_EVERY_CPU
void sumUp(const Block* blocks, std::size_t n, float inverse_square_width, const float* x, const float* v, Sums& sums) {
    const Lanes zero{}, one = zero + 1.0F;
    const float narrow = 4 * inverse_square_width;

    Lanes mean[4] = {}, mean_rate[4] = {};
    for (std::size_t i = 0; i < n; ++i) {
        const auto& f = blocks[i].field;
        const Lanes px = f[kX] - x[0], py = f[kY] - x[1], pz = f[kZ] - x[2];
        Lanes t = one - (px * px + py * py + pz * pz + f[kQ]) * inverse_square_width;
        const Lanes vx = f[kVx] - v[0], vy = f[kVy] - v[1], vz = f[kVz] - v[2];
        t = t > 0 ? t : zero;
        const Lanes k = f[kW] * t * t;
        const Lanes kr = f[kU] * t * t - f[kW] * t * (px * vx + py * vy + pz * vz + f[kS]) * narrow;
        mean[0] += k * f[kDx];
        mean[1] += k * f[kDy];
        mean[2] += k * f[kDz];
        mean[3] += k;
        mean_rate[0] += kr * f[kDx] + k * f[kEx];
        mean_rate[1] += kr * f[kDy] + k * f[kEy];
        mean_rate[2] += kr * f[kDz] + k * f[kEz];
        mean_rate[3] += kr;
    }
    std::fill_n(sums.value, +kSums, 0.0);
    std::fill_n(sums.rate, +kSums, 0.0);
    double means[4], mean_rates[4];
    addUpLanes(mean, means);
    addUpLanes(mean_rate, mean_rates);
    const Rate weight(means[3], mean_rates[3]);
    if (!(weight.value > 0)) return;
    float *m = sums.mean, *mr = sums.mean_rate;
    for (int k = 0; k < 3; ++k) {
        const Rate component = Rate(means[k], mean_rates[k]) / weight;
        m[k] = static_cast<float>(component.value);
        mr[k] = static_cast<float>(component.rate);
    }
    const float inverse_mean = sums.inverse_mean = 1 / (m[0] * m[0] + m[1] * m[1] + m[2] * m[2] + kLeastMean);
    const float growth = sums.growth = 2 * (m[0] * mr[0] + m[1] * mr[1] + m[2] * mr[2]) * inverse_mean;

    Lanes value[kSums] = {}, rate[kSums] = {};
    for (std::size_t i = 0; i < n; ++i) {
        const auto& f = blocks[i].field;
        const Lanes px = f[kX] - x[0], py = f[kY] - x[1], pz = f[kZ] - x[2];
        const Lanes vx = f[kVx] - v[0], vy = f[kVy] - v[1], vz = f[kVz] - v[2];
        const Lanes dx = f[kDx], dy = f[kDy], dz = f[kDz], ex = f[kEx], ey = f[kEy], ez = f[kEz];
        const Lanes square = px * px + py * py + pz * pz + f[kQ], approach = px * vx + py * vy + pz * vz + f[kS];
        Lanes t = one - square * inverse_square_width;
        t = t > 0 ? t : zero;
        Lanes facing = dx * m[0] + dy * m[1] + dz * m[2];
        facing = facing > 0 ? facing : zero;
        const Lanes turning = dx * mr[0] + dy * mr[1] + dz * mr[2] + ex * m[0] + ey * m[1] + ez * m[2];
        const Lanes height = px * m[0] + py * m[1] + pz * m[2];
        const Lanes rising = vx * m[0] + vy * m[1] + vz * m[2] + px * mr[0] + py * mr[1] + pz * mr[2];
        const Lanes distance = one / (square + 1.0F);
        const Lanes steepness = height * distance * (inverse_mean / kSteepest);
        Lanes level = one - height * steepness;
        level = level > 0 ? level : zero;
        const Lanes levelling = steepness * (height * (growth + (approach + approach) * distance) - rising - rising);
        // k = w · facing² · level² · t² · inverse_mean
        const Lanes root = facing * level * t, gate = root * root * inverse_mean, k = f[kW] * gate;
        const Lanes pull =
            root * ((turning * level + facing * levelling) * t * 2.0F - facing * level * approach * narrow) *
                inverse_mean -
            gate * growth;
        const Lanes kr = f[kU] * gate + f[kW] * pull;
        const Lanes along = px * dx + py * dy + pz * dz + f[kB];
        value[kWeight] += k;
        rate[kWeight] += kr;
        value[kOffset] += k * px;
        value[kOffset + 1] += k * py;
        value[kOffset + 2] += k * pz;
        rate[kOffset] += kr * px + k * vx;
        rate[kOffset + 1] += kr * py + k * vy;
        rate[kOffset + 2] += kr * pz + k * vz;
        value[kDirection] += k * dx;
        value[kDirection + 1] += k * dy;
        value[kDirection + 2] += k * dz;
        rate[kDirection] += kr * dx + k * ex;
        rate[kDirection + 1] += kr * dy + k * ey;
        rate[kDirection + 2] += kr * dz + k * ez;
        value[kAlong] += k * along;
        rate[kAlong] += kr * along + k * (vx * dx + vy * dy + vz * dz + px * ex + py * ey + pz * ez + f[kC]);
        value[kSquare] += k * square;
        rate[kSquare] += kr * square + k * (approach + approach);
    }
    addUpLanes(value, sums.value);
    addUpLanes(rate, sums.rate);
}

// How near the other side of the liquid is: Σ w (m·d)₋² (m·y)₋² / (|y|² + s)³ over samples that lie behind and face
// away, m of unit length; sums has been filled at the same point.
BETAMESH_EVERY_CPU
void sumOpposite(const Block* blocks, std::size_t n, float inverse_square_width, const float* x, const float* v,
                 const Sums& sums, double& value_out, double& rate_out) {
    const Lanes zero{}, one = zero + 1.0F;
    const float *m = sums.mean, *mr = sums.mean_rate;
    const float inverse_mean = sums.inverse_mean, growth = sums.growth, soft = kSoft;
    Lanes both[2] = {};
    for (std::size_t i = 0; i < n; ++i) {
        const auto& f = blocks[i].field;
        const Lanes px = f[kX] - x[0], py = f[kY] - x[1], pz = f[kZ] - x[2];
        const Lanes vx = f[kVx] - v[0], vy = f[kVy] - v[1], vz = f[kVz] - v[2];
        const Lanes dx = f[kDx], dy = f[kDy], dz = f[kDz], ex = f[kEx], ey = f[kEy], ez = f[kEz];
        const Lanes square = px * px + py * py + pz * pz + f[kQ], approach = px * vx + py * vy + pz * vz + f[kS];
        Lanes t = one - square * inverse_square_width;
        t = t > 0 ? t : zero;
        Lanes facing = dx * m[0] + dy * m[1] + dz * m[2];
        facing = facing < 0 ? facing : zero;
        Lanes height = px * m[0] + py * m[1] + pz * m[2];
        height = height < 0 ? height : zero;
        const Lanes turning = dx * mr[0] + dy * mr[1] + dz * mr[2] + ex * m[0] + ey * m[1] + ez * m[2];
        const Lanes rising = vx * m[0] + vy * m[1] + vz * m[2] + px * mr[0] + py * mr[1] + pz * mr[2];
        const Lanes distance = one / (square + soft), cube = distance * distance * distance;
        const Lanes root = facing * height * t * inverse_mean, term = root * root * cube;
        both[0] += f[kW] * term;
        both[1] += f[kU] * term + f[kW] * (root * cube * inverse_mean * 2.0F *
                                               ((turning * height + facing * rising) * t -
                                                facing * height * approach * (2 * inverse_square_width)) -
                                           term * (2 * growth + approach * distance * 6.0F));
    }
    double sum[2];
    addUpLanes(both, sum);
    value_out = sum[0];
    rate_out = sum[1];
}

// From a point onto the sphere fitted round it, and the direction of the sphere there.
struct Fit {
    Moving step, direction;
    Rate trust;  // towards 1 with many samples that agree, 0 without or where they face all ways
    Moving inset;
};

// Inwards, by `depth` at most, less where the liquid is thin, by nothing at a pinch.
Moving insetFrom(const Fit& fit, Rate opposite, double depth) {
    const Moving outwards = fit.direction / squareRoot(dot(fit.direction, fit.direction) + kLeastMean);
    const Rate inverse_square_thickness = opposite / kSheet;  // thickness^-2
    const Rate share = inverse_square_thickness * (depth * depth / (kShareOfThickness * kShareOfThickness));
    return outwards * fit.trust * (Rate(-depth) / squareRoot(squareRoot(1 + share * share)));
}

Fit fitSphere(const Sums& sums) {
    const Rate weight = sums.number(kWeight);
    if (!(weight.value > 0)) return {};
    const Moving a = sums.vector(kOffset) / weight, b = sums.vector(kDirection) / weight;
    const Rate c = sums.number(kAlong) / weight, e = sums.number(kSquare) / weight;
    const Rate variance = e - dot(a, a) + kRound;
    const Rate uq = (c - dot(a, b)) / (variance * 2);
    const Moving ul = b - a * (uq * 2);
    const Rate minus_uc = dot(ul, a) + uq * e, slope = dot(ul, ul) + 1e-6;
    const Rate root = squareRoot(slope * slope + uq * minus_uc * slope * 4);
    const Rate squared = weight * weight, agreement = sums.squareOfMean() / kAgreement,
               cubed = agreement * agreement * agreement;
    const Rate trust = squared / (squared + kOwnWeight * kOwnWeight) * (cubed / (cubed + 1));
    return {ul * (minus_uc * 2 / (slope + root)), ul, trust, {}};
}

std::vector<std::uint32_t> allRows(std::size_t n) {
    std::vector<std::uint32_t> rows(n);
    std::iota(rows.begin(), rows.end(), 0U);
    return rows;
}

std::array<float, kFields - 3> fieldsOf(const BoundarySample& sample, double radius) {
    std::array<float, kFields - 3> fields;
    const auto set = [&](Field field, const Vec3& value) {
        for (int k = 0; k < 3; ++k) fields[static_cast<std::size_t>(field + k - 3)] = static_cast<float>(value[k]);
    };
    set(kVx, sample.position.velocity / radius);
    set(kDx, sample.direction.position);
    set(kEx, sample.direction.velocity);
    fields[kW - 3] = static_cast<float>(sample.weight.value / radius);
    fields[kU - 3] = static_cast<float>(sample.weight.rate / radius);
    fields[kQ - 3] = static_cast<float>(sample.spread.value / (radius * radius));
    fields[kS - 3] = static_cast<float>(sample.spread.rate / (2 * radius * radius));
    fields[kB - 3] = static_cast<float>(sample.bulge.value / radius);
    fields[kC - 3] = static_cast<float>(sample.bulge.rate / radius);
    return fields;
}

// Calls take(row, the fit at pointAt(row)) for every row, on several threads; lengths in radii.
template <typename PointAt, typename Take>
void fitAll(const std::vector<std::uint32_t>& rows, const PointAt& pointAt, const BoundarySamples& samples,
            const CoherentSmoothing& params, const Take& take) {
    const double scale = 1 / params.radius, width = params.width * scale;
    const auto inverse_square_width = static_cast<float>(1 / (width * width));
    forPointsAmongSamples<kFields>(
        samples.size(), [&](std::size_t i) { return samples[i].position.position; },
        [&](std::size_t i) { return fieldsOf(samples[i], params.radius); }, rows.size(),
        [&](std::size_t i) { return pointAt(rows[i]).position; }, params.width, params.width / 2.5, params.radius,
        [&](std::uint32_t i, const Vec3f& x, std::span<const Block> blocks) {
            const std::uint32_t row = rows[i];
            const Vec3f v(pointAt(row).velocity * scale);
            Sums sums;
            sumUp(blocks.data(), blocks.size(), inverse_square_width, &x.x, &v.x, sums);
            Fit fit = fitSphere(sums);
            if (params.inset > 0 && fit.trust.value > 0) {
                Rate opposite;
                sumOpposite(blocks.data(), blocks.size(), inverse_square_width, &x.x, &v.x, sums, opposite.value,
                            opposite.rate);
                fit.inset = insetFrom(fit, opposite, params.inset * scale);
            }
            take(row, fit);
        });
}

// 1 up to kStayingBegins, 0 from kStaysWhole on.
Rate shareOfTheWay(Rate clearance) {
    return 1 - smoothStep((clearance - kStayingBegins) / (kStaysWhole - kStayingBegins));
}

// Shorter than `farthest`, whatever the step; steps that are not nearly as long stay what they are.
Moving limited(const Moving& step, double farthest) {
    const Rate s2 = dot(step, step) / (farthest * farthest), s4 = s2 * s2, s8 = s4 * s4;
    return step / squareRoot(squareRoot(squareRoot(squareRoot(1 + s8 * s8))));
}

// Vertices that only begin to rise stay near the edges and facets that they rise from. Those that rise from facets
// may have each other for corners: they see one another as if they were free.
void holdBack(BetaMesh& mesh) {
    const auto heldBack = [&](const RisingVertex& rising) {
        Moving from;
        for (std::size_t k = 0; k < 4; ++k) from = from + mesh.vertex[rising.from[k]] * rising.weight[k];
        return mesh.vertex[rising.vertex] * rising.share + from * (1 - rising.share);
    };
    const auto hold = [&](const std::vector<RisingVertex>& group) {
        std::vector<Moving> held(group.size());
        parallelFor(group.size(), 1024, [&](std::size_t i) { held[i] = heldBack(group[i]); });
        for (std::size_t i = 0; i < group.size(); ++i) mesh.vertex[group[i].vertex] = held[i];
    };
    for (const auto& group : mesh.rising) hold(group);
}

}  // namespace

void smoothCoherently(BetaMesh& mesh, BoundarySamples samples, const CoherentSmoothing& params) {
    std::vector<std::uint32_t> moving;  // vertices that do not stay where they are
    for (std::uint32_t v = 0; v < mesh.vertex.size(); ++v)
        if (params.inset > 0 || mesh.clearance.empty() || mesh.clearance[v].value < kStaysWhole) moving.push_back(v);
    for (const auto& group : mesh.rising)
        parallelFor(group.size(), 4096, [&](std::size_t i) { mesh.vertex[group[i].vertex] = group[i].whole; });

    const bool inwards = params.inset > 0;
    const std::vector<Moving> begin = params.passes > 1 ? mesh.vertex : std::vector<Moving>();
    const std::vector<Vec3> normals = inwards ? vertexNormals(mesh) : std::vector<Vec3>();
    std::vector<Moving> inset(inwards ? mesh.vertex.size() : 0);
    CoherentSmoothing now = params;
    for (int pass = 0; pass < std::max(params.passes, inwards ? 1 : 0); ++pass) {
        fitAll(
            moving, [&](std::uint32_t v) -> const Moving& { return mesh.vertex[v]; }, samples, now,
            [&](std::uint32_t v, const Fit& fit) {
                Moving& vertex = mesh.vertex[v];
                const Moving from = pass == 0 ? vertex : begin[v];
                if (now.inset > 0) {
                    // Between surfaces that nearly touch, the mean direction may be that of the other one.
                    const double length = fit.inset.position.length(), towards = -dot(normals[v], fit.inset.position);
                    if (length > 0) inset[v] = fit.inset * (smoothStep(2 * towards / length).value * params.radius);
                }
                if (params.passes > 0) vertex = vertex + fit.step * fit.trust * params.radius;
                if (pass + 1 < params.passes) return;
                const Rate share = mesh.clearance.empty() ? Rate(1) : shareOfTheWay(mesh.clearance[v]);
                vertex = from + limited((vertex - from) * share, kFarthest * params.radius);
                if (inwards) vertex = vertex + inset[v];
            });
        if (pass + 1 >= params.passes) break;
        now.inset = 0;
        BoundarySamples calmer = samples;
        fitAll(
            allRows(samples.size()), [&](std::uint32_t i) -> const Moving& { return samples[i].position; }, samples,
            now,
            [&](std::uint32_t i, const Fit& fit) {
                calmer[i].position = calmer[i].position + fit.step * fit.trust * params.radius;
                calmer[i].direction = calmer[i].direction + (fit.direction - calmer[i].direction) * fit.trust;
            });
        samples = std::move(calmer);
    }
    for (const auto& [v, step] : mesh.swelling) mesh.vertex[v] = mesh.vertex[v] + step;
    holdBack(mesh);
}

}  // namespace betamesh
