
#include "skin/retract.h"

#include "base/parallel.h"
#include "skin/constants.h"

#include <algorithm>
#include <cmath>

namespace betamesh {

namespace {

// All lengths are in particle spacings.
constexpr auto kReachSlack = static_cast<float>(kDirectionBand + 0.01);  // beyond the nearest sample
constexpr std::size_t kMaxSamplesNear = 4096;                            // outer samples visited per group of vertices
constexpr double kOuterCell = 3;  // edge of the cells in which outer samples are grouped

// Depth beyond the skin for a true volume, from the exposed share of an outer ball. None on arcs, where parts of the
// liquid meet: there the skin itself has to make them meet at contact.
double extraDepth(double exposure) {
    return kThreadExtraDepth * smoothStep((exposure - kThreadExposure) / kThreadExposureFade).value +
           kDropExtraDepth * smoothStep((exposure - kDropExposure) / kDropExposureFade).value;
}

// The last fields, the inverse of the particle spacing at the sample and the change of the rolling ball's radius over
// that radius, exist only where spacings differ.
enum Field { kX, kY, kZ, kVx, kVy, kVz, kWeight, kExtra, kFading, kInverseScale, kGrowth };
template <bool kScaled>
constexpr std::size_t kFieldsOf = kScaled ? kGrowth + 1 : kInverseScale;
template <bool kScaled>
using Samples = SampleRuns<kFieldsOf<kScaled>>;

// Sums over the outer samples in a band beyond the nearest one, with weights w: Σ w (x - y), Σ w v, Σ w, Σ w extra; and
// the squared distance of the nearest. Where spacings differ, offsets and distances are in spacings at the sample, the
// last sums are Σ w / spacing and Σ w growth, and v has the growth of the rolling ball towards x.
enum Sum { kAway, kVelocity = kAway + 3, kWeights = kVelocity + 3, kExtras, kNearest, kInverseScales, kGrowths, kSums };
template <bool kScaled>
struct OuterSums {
    Samples<kScaled> samples;
    const Lanes (&point)[3];
    Lanes (&sums)[kSums];

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()(std::size_t first) const {
        using Pack = Floats<kWidth>;
        Pack x[3];
        getLanes<kWidth>(point, first, x);
        const Pack zero{}, one = zero + 1.0F;
        Pack nearest = zero + 1e30F;
        const auto setSquare = [](const auto& f, const Pack(&p)[3], Pack& square) __attribute__((always_inline)) {
            square = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
            if constexpr (kScaled) square *= f[kInverseScale] * f[kInverseScale];
            square += f[kFading];
        };
        samples.forEach(
            x, [&](const auto& f, const Pack(&p)[3]) __attribute__((always_inline)) {
                Pack square;
                setSquare(f, p, square);
                nearest = square < nearest ? square : nearest;
            });
        Pack root = (nearest + one) * 0.5F;  // Newton's method; the width of the band needs no more accuracy
        for (int i = 0; i < 3; ++i) root = (root + nearest / root) * 0.5F;
        constexpr auto band = static_cast<float>(kDirectionBand);
        const Pack inverse = one / (band * band + 2 * band * root);
        Pack sum[kSums] = {};
        samples.forEach(
            x, [&](const auto& f, const Pack(&p)[3]) __attribute__((always_inline)) {
                Pack square;
                setSquare(f, p, square);
                Pack t = one - (square - nearest) * inverse;
                t = t > 0 ? t : zero;
                const Pack w = t * t * f[kWeight];
                Pack away = w;
                if constexpr (kScaled) {
                    away *= f[kInverseScale];
                    sum[kInverseScales] += away;
                    const Pack growth = w * f[kGrowth];
                    sum[kGrowths] += growth;
                    for (std::size_t k = 0; k < 3; ++k) sum[kVelocity + k] -= growth * p[k];
                }
                sum[kAway] -= away * p[0];
                sum[kAway + 1] -= away * p[1];
                sum[kAway + 2] -= away * p[2];
                sum[kVelocity] += w * f[kVx];
                sum[kVelocity + 1] += w * f[kVy];
                sum[kVelocity + 2] += w * f[kVz];
                sum[kWeights] += w;
                sum[kExtras] += w * f[kExtra];
            });
        sum[kNearest] = nearest;
        setLanes<kWidth>(sums, first, sum);
    }
};

// How far a vertex is from the skin, and in which direction.
struct Approach {
    Vec3f inwards{0};    // unit vector away from the outer boundary; zero where that is out of reach
    float gap = 0;       // displacement along it that gives the right depth; negative where the vertex is too deep
    float in_reach = 0;  // 1, fading to 0 deep below the skin
    Vec3f velocity{0};   // of the skin there
    float distance = 0;  // to the nearest outer sample, in spacings there; larger for samples that fade
    float scale = 1;     // particle spacing there
    float growth = 0;    // its rate, over the spacing; 1 / s
};

class OuterBoundary {
public:
    OuterBoundary(const OuterSamples& samples, const SkinLengths& lengths, double spacing)
        : rolling_(lengths.rolling()),
          spacing_(spacing),
          position_(samples.point.size()),
          sample_(samples.point.size()) {
        std::vector<std::uint32_t> order;
        parallelFor(position_.size(), 8192, [&](std::size_t i) { position_[i] = samples.point[i].position; });
        groups_ = PointGroups(position_, kOuterCell * spacing, samples.scale, order);
        position_ = inOrder(position_, order);
        groups_.fitBoxes(position_);
        const float offset = samples.scale.empty() ? kNewSampleSquaredOffset : kNewSampleSquaredOffsetOfUnequal;
        parallelFor(sample_.size(), 8192, [&](std::size_t i) {
            const std::uint32_t row = order[i];
            const double extra = lengths.volume_true ? extraDepth(samples.exposure[row]) : 0;
            sample_[i] = {Vec3f(samples.point[row].velocity), samples.weight[row], static_cast<float>(extra),
                          samples.fading[row] * offset};
        });
        if (!samples.scale.empty()) scale_ = inOrder(samples.scale, order);
        if (!samples.growth.empty()) growth_ = inOrder(samples.growth, order);
    }

    // Distance beyond which no outer sample matters.
    double maxReach() const { return rolling_ + kReachFade + kDirectionBand; }
    // reach: per vertex, beyond which no outer sample matters, in spacings at the sample; empty if not known yet
    std::vector<Approach> approaches(const DeformingMesh& surface, const std::vector<float>& reach) const {
        return scale_.empty() ? approachesAmong<false>(surface, reach) : approachesAmong<true>(surface, reach);
    }

private:
    template <bool kScaled>
    std::vector<Approach> approachesAmong(const DeformingMesh& surface, const std::vector<float>& reach) const {
        constexpr std::size_t kFields = kFieldsOf<kScaled>;
        std::vector<Approach> approach(surface.size());
        const PointGroups& groups = surface.groups();
        const auto reachOf = [&](std::size_t group) {
            if (reach.empty()) return maxReach();
            const auto begin = reach.begin() + groups.begin(group), end = reach.begin() + groups.begin(group + 1);
            return std::min(maxReach(), static_cast<double>(*std::max_element(begin, end)));
        };
        forGroups<kFields>(
            groups, surface.position(), groups_, position_, spacing_, kMaxSamplesNear,
            [&](std::size_t group) { return reachOf(group) * spacing_; },
            [&](std::uint32_t i, SampleFields<kFields>& f) {
                const Sample& s = sample_[i];
                f[kVx] = s.velocity.x, f[kVy] = s.velocity.y, f[kVz] = s.velocity.z;
                f[kWeight] = s.weight, f[kExtra] = s.extra, f[kFading] = s.squared_offset;
                if constexpr (kScaled) {
                    f[kInverseScale] = 1 / scale_[i];
                    f[kGrowth] = growth_.empty() ? 0 : growth_[i] / (static_cast<float>(rolling_) * scale_[i]);
                }
            },
            [&](const PointGroup& group, Samples<kScaled> samples) {
                Lanes sums[kSums];
                forLanes(OuterSums<kScaled>{samples, group.position, sums});
                for (std::size_t lane = 0; lane < group.size; ++lane)
                    approach[group.row[lane]] = approachOf(sums, lane);
            },
            scale_);
        return approach;
    }

    Approach approachOf(const Lanes (&sums)[kSums], std::size_t lane) const {
        const double distance = std::sqrt(static_cast<double>(sums[kNearest][lane]));
        const double in_reach = 1 - smoothStep((distance - rolling_) / kReachFade).value;
        const float weight = sums[kWeights][lane];
        if (!(in_reach > 0) || !(weight > 0)) return Approach{.distance = static_cast<float>(distance)};
        const auto vector = [&](int s) { return Vec3f(sums[s][lane], sums[s + 1][lane], sums[s + 2][lane]); };
        const double gap = rolling_ - distance - sums[kExtras][lane] / static_cast<double>(weight);
        const double scale = scale_.empty() ? 1 : weight / static_cast<double>(sums[kInverseScales][lane]);
        return {vector(kAway).normalized(),   static_cast<float>(gap * scale), static_cast<float>(in_reach),
                vector(kVelocity) / weight,   static_cast<float>(distance),    static_cast<float>(scale),
                sums[kGrowths][lane] / weight};
    }

    struct Sample {
        Vec3f velocity;
        float weight, extra, squared_offset;
    };

    double rolling_, spacing_;
    std::vector<Vec3> position_;
    std::vector<Sample> sample_;
    std::vector<float> scale_;   // particle spacing at each sample; empty: all 1
    std::vector<float> growth_;  // as OuterSamples::growth
    PointGroups groups_;
};

}  // namespace

namespace {

// A mean over a surface that grows in proportion to itself lies beneath that surface, as does the mean of its
// velocities.
void addGrowth(const std::vector<Approach>& approach, double width, const DeformingMesh& surface,
               std::vector<Vec3f>& mean_velocity) {
    const Vec3 origin = surface.position().empty() ? Vec3(0) : surface.position()[0];
    std::vector<Vec3f> position(surface.size());
    parallelFor(position.size(), 8192, [&](std::size_t v) { position[v] = Vec3f(surface.position()[v] - origin); });
    const std::vector<Vec3f> mean = surface.kernelMeans(width, position);
    parallelFor(position.size(), 8192, [&](std::size_t v) {
        mean_velocity[v] += (position[v] - mean[v]) * (approach[v].growth * approach[v].in_reach);
    });
}

}  // namespace

void retract(const OuterSamples& samples, const SkinLengths& lengths, DeformingMesh& surface) {
    const OuterBoundary outer(samples, lengths, surface.spacing());
    std::vector<float> reach;
    surface.smoothScales();
    // Wide steps approach the skin evenly; narrower ones correct what averaging has left of the gap.
    const auto wide_steps =
        static_cast<std::size_t>(std::min(kMaxWideSteps, std::ceil((lengths.joining - lengths.skin) / kWideStep)));
    const std::size_t steps = wide_steps + std::size(kNarrowKernels);
    for (std::size_t s = 0; s < steps; ++s) {
        const double fraction = s < wide_steps ? 1 / static_cast<double>(wide_steps - s) : 1;  // of the remaining gap
        const double width = s < wide_steps ? kWideKernel : kNarrowKernels[s - wide_steps];
        if (s == wide_steps + kRefineAfter) {
            surface.refine(lengths.joining, lengths.edge_factor);
            reach.clear();
        }
        const std::vector<Approach> approach = outer.approaches(surface, reach);
        std::vector<Vec3f> step(surface.size());
        parallelFor(step.size(), 4096, [&](std::size_t v) {
            const Approach& a = approach[v];
            const double scale = surface.scale(v), longest = kMaxStepInKernels * width * scale,
                         longest_outwards = std::min(kMaxOutwardStep * scale, longest);
            const double length = std::clamp(a.gap * fraction, -longest_outwards, longest) * a.in_reach;
            step[v] = a.inwards * static_cast<float>(length);
        });
        if (s + 1 == steps) {
            std::vector<Vec3f> velocity(surface.size());
            parallelFor(velocity.size(), 4096, [&](std::size_t v) {
                const Vec3f own(surface.mesh().vertex[v].velocity);
                velocity[v] = own + (approach[v].velocity - own) * approach[v].in_reach;
            });
            velocity = surface.kernelMeans(width, velocity);
            if (!samples.growth.empty()) addGrowth(approach, width, surface, velocity);
            surface.setVelocities(velocity);
        }
        step = surface.kernelMeans(width, step);
        surface.move(step);
        reach.resize(surface.size());
        parallelFor(reach.size(), 8192, [&](std::size_t v) {
            reach[v] = approach[v].distance + step[v].length() / approach[v].scale + kReachSlack;
        });
    }
    surface.measure();
}

}  // namespace betamesh
