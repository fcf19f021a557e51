
#include "skin/smooth_coherent.h"

#include "base/dual_packs.h"
#include "base/octaves.h"
#include "base/parallel.h"
#include "base/sample_groups.h"
#include "skin/constants.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <span>
#include <utility>

namespace betamesh {

namespace {

// Fields of a sample: position, velocity, direction, weight, variance and convexity, each with its rate; of the
// variance half the rate. Lengths are in radii of the largest ball.
enum Field {
    kX,
    kY,
    kZ,
    kVx,
    kVy,
    kVz,
    kDx,
    kDy,
    kDz,
    kDxRate,
    kDyRate,
    kDzRate,
    kW,
    kWRate,
    kVariance,
    kHalfVarianceRate,
    kConvexity,
    kConvexityRate,
    kFields
};
using Sample = SampleFields<kFields>;

// Sums over samples, with their rates: Σk, Σk y, Σk d, Σk y·d, Σk |y|². One lane per vertex.
enum Sum { kWeight, kOffset, kDirection = kOffset + 3, kAlong = kDirection + 3, kSquare, kSums };
struct Sums {
    Lanes value[kSums], rate[kSums];
    Lanes mean[3], mean_rate[3];  // Σ w K d / Σ w K

    Dual number(int s, std::size_t lane) const { return {value[s][lane], rate[s][lane]}; }
    DualVec3 vector(int s, std::size_t lane) const { return vectorOf(value + s, rate + s, lane); }
    Dual squareOfMean(std::size_t lane) const {
        const DualVec3 m = vectorOf(mean, mean_rate, lane);
        return dot(m, m);
    }

private:
    static DualVec3 vectorOf(const Lanes* value, const Lanes* rate, std::size_t lane) {
        return {Vec3(value[0][lane], value[1][lane], value[2][lane]),
                Vec3(rate[0][lane], rate[1][lane], rate[2][lane])};
    }
};

// A sample relative to a vertex: offset and its rate, mean squared distance |y|² of the piece and half its rate, and
// t = (1 - |y|²/width²)₊.
template <typename Pack>
struct RelativeSample {
    Pack px, py, pz, vx, vy, vz, square, half_square_rate, t;

    // Number: a float for all vertices, or one per vertex.
    template <typename Number>
    __attribute__((always_inline))
    RelativeSample(const Sample& f, const Pack (&x)[3], const Pack (&v)[3], const Number& inverse_square_width)
        : px(f[kX] - x[0]),
          py(f[kY] - x[1]),
          pz(f[kZ] - x[2]),
          vx(f[kVx] - v[0]),
          vy(f[kVy] - v[1]),
          vz(f[kVz] - v[2]),
          square(px * px + py * py + pz * pz + f[kVariance]),
          half_square_rate(px * vx + py * vy + pz * vz + f[kHalfVarianceRate]),
          t(1.0F - square * inverse_square_width) {
        t = t > 0 ? t : Pack{};
    }
};

// A sample relative to the mean direction m: d·m, y·m and their rates.
template <typename Pack>
struct Facing {
    Pack facing, facing_rate, height, height_rate;

    __attribute__((always_inline))
    Facing(const Sample& f, const RelativeSample<Pack>& y, const Pack (&m)[3], const Pack (&m_rate)[3])
        : facing(f[kDx] * m[0] + f[kDy] * m[1] + f[kDz] * m[2]),
          facing_rate(f[kDx] * m_rate[0] + f[kDy] * m_rate[1] + f[kDz] * m_rate[2] + f[kDxRate] * m[0] +
                      f[kDyRate] * m[1] + f[kDzRate] * m[2]),
          height(y.px * m[0] + y.py * m[1] + y.pz * m[2]),
          height_rate(y.vx * m[0] + y.vy * m[1] + y.vz * m[2] + y.px * m_rate[0] + y.py * m_rate[1] +
                      y.pz * m_rate[2]) {}
};

// Is any of these values, none of which is negative, above zero?
template <std::size_t kWidth>
__attribute__((always_inline)) inline bool anyAbove(const Floats<kWidth>& values) {
    typename VectorOf<std::uint64_t, kWidth / 2>::Type bits;
    std::memcpy(&bits, &values, sizeof bits);
    std::uint64_t any = 0;
    for (std::size_t i = 0; i < kWidth / 2; ++i) any |= bits[i];
    return any != 0;
}

// 1 / (|mean|² + kMinSquaredMean), and the relative rate of the denominator.
template <typename Pack>
__attribute__((always_inline)) inline void invert(const Pack (&mean)[3], const Pack (&rate)[3], Pack& inverse,
                                                  Pack& growth) {
    inverse = 1.0F / (mean[0] * mean[0] + mean[1] * mean[1] + mean[2] * mean[2] + kMinSquaredMean);
    growth = 2 * (mean[0] * rate[0] + mean[1] * rate[1] + mean[2] * rate[2]) * inverse;
}

// Accumulates the sums of a sphere fit; derivatives are written out. With dual numbers instead (a struct of two packs
// and its operators) a frame without a skin took 1.03 to 1.15 times the whole program's user time, depending on how the
// compiler keeps the fields of a sample in registers. Lengths are in radii; x, v: the vertices and their velocities.
// Among balls of different radii the lengths of a vertex, such as the width, are `scale` times those of the largest.
// Samples are visited in order, and those out of reach or facing away add zero: results do not depend on the
// instruction set or on how vertices are grouped.
template <bool kScaled>
struct FitSums {
    SampleSubset<kFields> samples;
    float inverse_square_width;
    const Lanes (&point)[3], (&velocity)[3];
    const Lanes& scale;
    Sums& sums;

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()(std::size_t first) const {
        using Pack = Floats<kWidth>;
        Pack x[3], v[3];
        getLanes<kWidth>(point, first, x);
        getLanes<kWidth>(velocity, first, v);
        const Pack zero{}, one = zero + 1.0F;
        using Number = std::conditional_t<kScaled, Pack, float>;
        Number square_scale, inverse_square;
        if constexpr (kScaled) {
            getLanes<kWidth>(scale, first, square_scale);
            square_scale *= square_scale;
            inverse_square = inverse_square_width / square_scale;
        } else {
            square_scale = 1;
            inverse_square = inverse_square_width;
        }
        const Number four_inverse_square_width = 4 * inverse_square;

        Pack mean[4] = {}, mean_rate[4] = {};
        for (const Sample& f : samples) {
            const RelativeSample<Pack> y(f, x, v, inverse_square);
            const Pack k = f[kW] * y.t * y.t;
            const Pack k_rate = f[kWRate] * y.t * y.t - f[kW] * y.t * y.half_square_rate * four_inverse_square_width;
            mean[0] += k * f[kDx];
            mean[1] += k * f[kDy];
            mean[2] += k * f[kDz];
            mean[3] += k;
            mean_rate[0] += k_rate * f[kDx] + k * f[kDxRate];
            mean_rate[1] += k_rate * f[kDy] + k * f[kDyRate];
            mean_rate[2] += k_rate * f[kDz] + k * f[kDzRate];
            mean_rate[3] += k_rate;
        }
        const Pack weight = mean[3] > 0 ? mean[3] : one;  // without any all of them are zero
        Pack m[3], m_rate[3];
        for (int k = 0; k < 3; ++k) {
            m[k] = mean[k] / weight;
            m_rate[k] = (mean_rate[k] - m[k] * mean_rate[3]) / weight;
        }
        Pack inverse_mean, growth;
        invert(m, m_rate, inverse_mean, growth);

        Pack value[kSums] = {}, rate[kSums] = {};
        for (const Sample& f : samples) {
            const RelativeSample<Pack> y(f, x, v, inverse_square);
            const Facing<Pack> n(f, y, m, m_rate);
            const Pack facing = n.facing > 0 ? n.facing : zero;
            if (!anyAbove<kWidth>(facing * y.t)) continue;  // adds zero
            const Pack distance = one / (y.square + square_scale);
            const Pack steepness = n.height * distance * (inverse_mean / kMaxSquaredSlope);
            Pack level = one - n.height * steepness;
            level = level > 0 ? level : zero;
            const Pack level_rate =
                steepness * (n.height * (growth + (y.half_square_rate + y.half_square_rate) * distance) -
                             n.height_rate - n.height_rate);
            // k = w · facing² · level² · t² · inverse_mean
            const Pack root = facing * level * y.t, gate = root * root * inverse_mean, k = f[kW] * gate;
            const Pack gate_rate = root *
                                       ((n.facing_rate * level + facing * level_rate) * y.t * 2.0F -
                                        facing * level * y.half_square_rate * four_inverse_square_width) *
                                       inverse_mean -
                                   gate * growth;
            const Pack k_rate = f[kWRate] * gate + f[kW] * gate_rate;
            const float dx = f[kDx], dy = f[kDy], dz = f[kDz], dx_rate = f[kDxRate], dy_rate = f[kDyRate],
                        dz_rate = f[kDzRate];
            const Pack along = y.px * dx + y.py * dy + y.pz * dz + f[kConvexity];
            value[kWeight] += k;
            rate[kWeight] += k_rate;
            value[kOffset] += k * y.px;
            value[kOffset + 1] += k * y.py;
            value[kOffset + 2] += k * y.pz;
            rate[kOffset] += k_rate * y.px + k * y.vx;
            rate[kOffset + 1] += k_rate * y.py + k * y.vy;
            rate[kOffset + 2] += k_rate * y.pz + k * y.vz;
            value[kDirection] += k * dx;
            value[kDirection + 1] += k * dy;
            value[kDirection + 2] += k * dz;
            rate[kDirection] += k_rate * dx + k * dx_rate;
            rate[kDirection + 1] += k_rate * dy + k * dy_rate;
            rate[kDirection + 2] += k_rate * dz + k * dz_rate;
            value[kAlong] += k * along;
            rate[kAlong] += k_rate * along + k * (y.vx * dx + y.vy * dy + y.vz * dz + y.px * dx_rate + y.py * dy_rate +
                                                  y.pz * dz_rate + f[kConvexityRate]);
            value[kSquare] += k * y.square;
            rate[kSquare] += k_rate * y.square + k * (y.half_square_rate + y.half_square_rate);
        }
        setLanes<kWidth>(sums.value, first, value);
        setLanes<kWidth>(sums.rate, first, rate);
        setLanes<kWidth>(sums.mean, first, m);
        setLanes<kWidth>(sums.mean_rate, first, m_rate);
    }
};

// Steps from vertices onto the spheres fitted near them, and the gradients of the spheres there.
struct Fits {
    DualVec3Pack step, direction;
    DualPack trust;  // near 1 with many samples that agree; 0 without samples or where they face all directions
};

BETAMESH_EVERY_CPU
void fitSpheres(const Sums& sums, const Lanes& scale, Fits& fits) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const double square_scale = static_cast<double>(scale[lane]) * static_cast<double>(scale[lane]);
        const bool any = sums.value[kWeight][lane] > 0;  // otherwise all sums are zero
        const Dual weight = any ? sums.number(kWeight, lane) : Dual(1);
        const DualVec3 a = sums.vector(kOffset, lane) / weight, b = sums.vector(kDirection, lane) / weight;
        const Dual c = sums.number(kAlong, lane) / weight, e = sums.number(kSquare, lane) / weight;
        const Dual variance = e - dot(a, a) + kFitVariance * square_scale;
        const Dual uq = (c - dot(a, b)) / (variance * 2);
        const DualVec3 ul = b - a * (uq * 2);
        const Dual minus_uc = dot(ul, a) + uq * e, slope = dot(ul, ul) + 1e-6;
        const Dual root = squareRoot(slope * slope + uq * minus_uc * slope * 4);
        const double half_trust = kHalfTrustWeight * square_scale;
        const Dual squared = weight * weight, agreement = sums.squareOfMean(lane) / kHalfTrustDirection,
                   cubed = agreement * agreement * agreement;
        const Dual trust = squared / (squared + half_trust * half_trust) * (cubed / (cubed + 1));
        fits.step.set(lane, ul * (minus_uc * 2 / (slope + root)));
        fits.direction.set(lane, ul);
        fits.trust.set(lane, any ? trust : Dual(0));
    }
}

std::array<float, kFields - 3> fieldsOf(const SampleInRadii& s) {
    return {s.velocity.x,  s.velocity.y,       s.velocity.z,         s.direction.x,      s.direction.y,
            s.direction.z, s.direction_rate.x, s.direction_rate.y,   s.direction_rate.z, s.weight,
            s.weight_rate, s.variance,         s.half_variance_rate, s.convexity,        s.convexity_rate};
}

// Fits spheres at pointAt(row) for all rows, at most kLanes at a time and on several threads: calls prefetch(row) for
// each row of a group, then visit(rows, fits). Lengths of fits are in radii of the largest ball. scale: of each row;
// empty: all 1.
template <typename PointAt, typename Prefetch, typename Visit>
void fitAll(const std::vector<std::uint32_t>& rows, const PointAt& pointAt, const std::vector<float>& scale,
            const SampleCloud<kFields>& cloud, const CoherentSmoothing& params, const Prefetch& prefetch,
            const Visit& visit) {
    const double inverse_radius = 1 / params.radius, width = params.width * inverse_radius;
    const auto inverse_square_width = static_cast<float>(1 / (width * width));
    cloud.forPoints(
        rows.size(), [&](std::size_t i) { return pointAt(rows[i]).position; }, Grouping::compact,
        [&](const PointGroup& group, SampleSubset<kFields> near) {
            std::uint32_t row[kLanes];
            Lanes v[3], own_scale;
            for (std::size_t lane = 0; lane < kLanes; ++lane) {
                row[lane] = rows[group.row[lane]];
                prefetch(row[lane]);
                const Vec3f velocity(pointAt(row[lane]).velocity * inverse_radius);
                for (int k = 0; k < 3; ++k) v[k][lane] = velocity[k];
                own_scale[lane] = scale.empty() ? 1 : scale[row[lane]];
            }
            Sums sums;
            if (scale.empty())
                forLanes(FitSums<false>{near, inverse_square_width, group.position, v, own_scale, sums});
            else
                forLanes(FitSums<true>{near, inverse_square_width, group.position, v, own_scale, sums});
            Fits fits;
            fitSpheres(sums, own_scale, fits);
            visit(std::span<const std::uint32_t>(row, group.size), fits);
        });
}

// Share of a step that a vertex takes: 1 up to kStayBegins, 0 from kStayFull on.
Dual stepShare(Dual rim_distance) { return 1 - smoothStep((rim_distance - kStayBegins) / (kStayFull - kStayBegins)); }

// Displacements of a group of vertices.
struct Displacements {
    DualVec3Pack from, to;
    DualPack rim_distance;
    std::array<double, kLanes> longest;  // of the step to take
};

// Reduces displacements by the vertices' shares and smoothly limits their length to below `longest`; displacements that
// are not nearly as long do not change.
BETAMESH_EVERY_CPU
void limitDisplacements(Displacements& moves) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const double longest = moves.longest[lane];
        const DualVec3 from = moves.from[lane], step = (moves.to[lane] - from) * stepShare(moves.rim_distance[lane]);
        const Dual s2 = dot(step, step) / (longest * longest), s4 = s2 * s2, s8 = s4 * s4, s = 1 + s8 * s8;
        const double root = std::sqrt(std::sqrt(std::sqrt(std::sqrt(s.value))));
        moves.to.set(lane, from + step / Dual(root, root * s.rate / (16 * s.value)));
    }
}

// Blends the positions of vertices that fade in with those of their supports. Vertices on facets may be supports of
// each other; then the unblended positions count.
void blendFadingVertices(BetaMesh& mesh) {
    const auto blended = [&](const FadingVertex& fading) {
        DualVec3 from;
        for (std::size_t k = 0; k < 4; ++k) from = from + mesh.vertex[fading.support[k]] * fading.support_weight[k];
        return mesh.vertex[fading.vertex] * fading.fade + from * (1 - fading.fade);
    };
    for (const std::vector<FadingVertex>& group : mesh.fading) {
        std::vector<DualVec3> position(group.size());
        parallelFor(group.size(), 1024, [&](std::size_t i) { position[i] = blended(group[i]); });
        for (std::size_t i = 0; i < group.size(); ++i) mesh.vertex[group[i].vertex] = position[i];
    }
}

}  // namespace

class CoherentSmoother::Cloud : public SampleCloud<kFields> {
public:
    using SampleCloud::SampleCloud;
};

CoherentSmoother::CoherentSmoother(SamplesInRadii samples, const CoherentSmoothing& params)
    : params_(params), samples_(std::move(samples)) {
    for (const SampleInRadii& sample : samples_) {
        const std::size_t octave = octaveOf(static_cast<double>(sample.scale));
        octaves_ = std::max(octaves_, octave + 1);
    }
    if (std::ranges::any_of(samples_, [](const SampleInRadii& sample) { return sample.scale != 1; })) {
        std::vector<Vec3> position;
        std::vector<float> weight, scale;
        for (const SampleInRadii& sample : samples_) {
            position.push_back(sample.position);
            weight.push_back(sample.weight);
            scale.push_back(sample.scale);
        }
        scale_means_.emplace(position, weight, scale, params.width);
    }
    buildClouds(0);
}
CoherentSmoother::CoherentSmoother(CoherentSmoother&&) noexcept = default;
CoherentSmoother::~CoherentSmoother() = default;

bool CoherentSmoother::isLast(int pass) const { return pass + 1 >= params_.passes; }

void CoherentSmoother::buildClouds(int pass) {
    clouds_.clear();
    for (std::size_t octave = 0; octave < octaves_; ++octave)
        clouds_.emplace_back(
            samples_.size(), [&](std::size_t i) { return samples_[i].position; },
            [&](std::size_t i) { return fieldsOf(samples_[i]); }, params_.width * largestOfOctave(octave),
            params_.radius);
    if (isLast(pass)) std::exchange(samples_, {});  // large
}

// One pass over the vertices of each octave. begin: where they were before the first pass; empty before that.
void CoherentSmoother::moveVertices(int pass, const Octaves& vertices, const ScaleMeans::Scales& scales,
                                    const std::vector<DualVec3>& begin, BetaMesh& mesh) const {
    const auto prefetch = [&](std::uint32_t v) {
        if (!mesh.rim_distance.empty()) __builtin_prefetch(&mesh.rim_distance[v]);
    };
    const auto move = [&](std::span<const std::uint32_t> rows, const Fits& fits) {
        Displacements moves;
        moves.longest.fill(1);
        for (std::size_t lane = 0; lane < rows.size(); ++lane) {
            const std::uint32_t v = rows[lane];
            const DualVec3& vertex = mesh.vertex[v];
            moves.from.set(lane, pass == 0 ? vertex : begin[v]);
            moves.to.set(lane, vertex + fits.step[lane] * fits.trust[lane] * params_.radius);
            if (!mesh.rim_distance.empty()) moves.rim_distance.set(lane, mesh.rim_distance[v]);
            moves.longest[lane] = kMaxSmoothingStep * params_.radius * (scales.least.empty() ? 1 : scales.least[v]);
        }
        if (isLast(pass)) limitDisplacements(moves);
        for (std::size_t lane = 0; lane < rows.size(); ++lane) mesh.vertex[rows[lane]] = moves.to[lane];
    };
    for (std::size_t octave = 0; octave < vertices.size(); ++octave)
        fitAll(
            vertices[octave], [&](std::uint32_t v) -> const DualVec3& { return mesh.vertex[v]; }, scales.mean,
            clouds_[std::min(octave, clouds_.size() - 1)], params_, prefetch, move);
}

// Smooths the samples for the next pass, as vertices among them would be smoothed.
void CoherentSmoother::smoothSamples(bool have_scales) {
    SamplesInRadii smoothed = samples_;
    const auto pointAt = [&](std::uint32_t i) -> DualVec3 {
        return {samples_[i].position, Vec3(samples_[i].velocity) * params_.radius};
    };
    const auto move = [&](std::span<const std::uint32_t> rows, const Fits& fits) {
        for (std::size_t lane = 0; lane < rows.size(); ++lane) {
            SampleInRadii& sample = smoothed[rows[lane]];
            const DualVec3 step = fits.step[lane] * fits.trust[lane];
            sample.position += step.position * params_.radius;
            sample.velocity += Vec3f(step.velocity);
            const DualVec3 direction{Vec3(sample.direction), Vec3(sample.direction_rate)};
            const DualVec3 turned = direction + (fits.direction[lane] - direction) * fits.trust[lane];
            sample.direction = Vec3f(turned.position);
            sample.direction_rate = Vec3f(turned.velocity);
        }
    };
    std::vector<float> scale;
    if (have_scales)
        for (const SampleInRadii& sample : samples_) scale.push_back(sample.scale);
    const Octaves samples = byOctave(allRows(samples_.size()), scale);
    for (std::size_t octave = 0; octave < samples.size(); ++octave)
        fitAll(
            samples[octave], pointAt, scale, clouds_[octave], params_, [](std::uint32_t) {}, move);
    samples_ = std::move(smoothed);
}

DualPoints CoherentSmoother::smooth(BetaMesh& mesh) {
    DualPoints from = dualPoints(mesh.vertex);
    std::vector<std::uint32_t> in_motion = indicesWhere(mesh.vertex.size(), [&](std::uint32_t v) {
        return mesh.rim_distance.empty() || mesh.rim_distance[v].value < kStayFull;
    });
    for (const auto& group : mesh.fading)
        parallelFor(group.size(), 4096, [&](std::size_t i) { mesh.vertex[group[i].vertex] = group[i].unfaded; });

    ScaleMeans::Scales scales{mesh.scale, mesh.scale};
    if (scale_means_)
        scale_means_->average(
            in_motion, [&](std::uint32_t v) { return mesh.vertex[v].position; }, scales);
    const Octaves moving = byOctave(std::move(in_motion), scales.mean);

    const std::vector<DualVec3> begin = params_.passes > 1 ? mesh.vertex : std::vector<DualVec3>();
    for (int pass = 0; pass < params_.passes; ++pass) {
        moveVertices(pass, moving, scales, begin, mesh);
        if (isLast(pass)) break;
        smoothSamples(!mesh.scale.empty());
        buildClouds(pass + 1);
    }
    for (const auto& [v, step] : mesh.volume_offsets) mesh.vertex[v] = mesh.vertex[v] + step;
    blendFadingVertices(mesh);
    return from;
}

}  // namespace betamesh
