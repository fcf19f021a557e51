
#include "skin/retract.h"

#include "base/chosen_rows.h"
#include "base/parallel.h"
#include "skin/constants.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace betamesh {

namespace {

// All lengths are in particle spacings.
constexpr auto kReachSlack = static_cast<float>(kDirectionBand + 0.01);  // beyond the nearest sample
constexpr std::size_t kMaxSamplesNear = 4096;                            // outer samples visited per group of vertices
constexpr double kOuterCell = 3;       // edge of the cells in which outer samples are grouped
constexpr double kMinDistance = 1e-6;  // from an outer sample: can be divided by

// Depth beyond the skin for a true volume, from the exposed share of an outer ball. None on arcs, where parts of the
// liquid meet: there the skin itself has to make them meet at contact.
double extraDepth(double exposure) {
    return kThreadExtraDepth * smoothStep((exposure - kThreadExposure) / kThreadExposureFade).value +
           kDropExtraDepth * smoothStep((exposure - kDropExposure) / kDropExposureFade).value;
}

// The last fields, the inverse of the particle spacing at the sample and the change of the rolling ball's radius over
// that radius, exist only where spacings differ.
enum Field { kX, kY, kZ, kVx, kVy, kVz, kWeight, kExtra, kOffset, kInverseScale, kGrowth };
template <bool kScaled>
constexpr std::size_t kFieldsOf = kScaled ? kGrowth + 1 : kInverseScale;
template <bool kScaled>
using Samples = SampleRuns<kFieldsOf<kScaled>>;

// Sums over the outer samples in a band beyond the nearest one, with weights w: Σ w (x - y), Σ w v, Σ w, Σ w extra,
// Σ w offset; and the squared distance of the nearest, with its offset. Where spacings differ, offsets and distances
// are in spacings at the sample, the last sums are Σ w / spacing and Σ w growth, and v has the growth of the rolling
// ball towards x.
enum Sum {
    kAway,
    kVelocity = kAway + 3,
    kWeights = kVelocity + 3,
    kExtras,
    kOffsets,
    kNearest,
    kInverseScales,
    kGrowths,
    kSums
};
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
            square += f[kOffset];
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
                sum[kOffsets] += w * f[kOffset];
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
    float distance = 0;  // to the nearest outer sample, in spacings there; larger for those with an offset
    float of_outer = 0;  // 1; 0 where a much smaller ball rolls
    float scale = 1;     // particle spacing there
    float growth = 0;    // its rate, over the spacing; 1 / s
};

template <bool kScaled>
class OuterBoundary {
public:
    OuterBoundary(const OuterSamples& samples, const SkinLengths& lengths, double spacing)
        : rolling_(lengths.rolling()), position_(samples.point.size()), table_(tableOf(samples, lengths, spacing)) {}

    // Distance beyond which no outer sample matters.
    double maxReach() const { return rolling_ + kReachFade + kDirectionBand; }
    // Sets the approaches of all groups of vertices but those that are left out.
    // reachOf(group): distance beyond which no outer sample matters, in spacings at the sample; negative: left out
    template <typename ReachOf>
    void approach(const DeformingMesh& surface, const ReachOf& reachOf, std::vector<Approach>& approach) const {
        forGroups(
            surface.groups(), surface.position(), table_, kMaxSamplesNear,
            [&](std::size_t group) { return reachOf(group) * surface.spacing(); },
            [&](const PointGroup& group, Samples<kScaled> samples) {
                Lanes sums[kSums];
                forLanes(OuterSums<kScaled>{samples, group.position, sums});
                for (std::size_t lane = 0; lane < group.size; ++lane)
                    approach[group.row[lane]] = approachOf(sums, lane);
            });
    }

private:
    SampleTable<kFieldsOf<kScaled>> tableOf(const OuterSamples& samples, const SkinLengths& lengths, double spacing) {
        std::vector<std::uint32_t> order;
        parallelFor(position_.size(), 8192, [&](std::size_t i) { position_[i] = samples.point[i].position; });
        groups_ = PointGroups(position_, kOuterCell * spacing, samples.scale, order);
        position_ = chosenRows(position_, order);
        groups_.fitBoxes(position_);
        const auto fill = [&](std::uint32_t i, SampleFields<kFieldsOf<kScaled>>& f) {
            const std::uint32_t row = order[i];
            const Vec3f velocity(samples.point[row].velocity);
            f[kVx] = velocity.x, f[kVy] = velocity.y, f[kVz] = velocity.z;
            f[kWeight] = samples.weight[row];
            f[kExtra] = lengths.volume_true ? static_cast<float>(extraDepth(samples.exposure[row])) : 0;
            f[kOffset] = samples.squared_offset[row];
            if constexpr (kScaled) {
                const float scale = samples.scale[row];
                f[kInverseScale] = 1 / scale;
                f[kGrowth] = samples.growth.empty() ? 0 : samples.growth[row] / (static_cast<float>(rolling_) * scale);
            }
        };
        return {groups_, position_, spacing, fill, chosenRows(samples.scale, order)};
    }

    Approach approachOf(const Lanes (&sums)[kSums], std::size_t lane) const {
        const double nearest = sums[kNearest][lane], reached = std::sqrt(nearest);
        double in_reach = 1 - smoothStep((reached - rolling_) / kReachFade).value;
        const float weight = sums[kWeights][lane];
        if (!(in_reach > 0) || !(weight > 0)) return Approach{.distance = static_cast<float>(reached)};
        const auto vector = [&](int s) { return Vec3f(sums[s][lane], sums[s + 1][lane], sums[s + 2][lane]); };
        const Vec3f away = vector(kAway);
        const double offset = sums[kOffsets][lane] / static_cast<double>(weight), square = rolling_ * rolling_;
        const double distance = std::sqrt(std::max(0.0, nearest - offset));
        const double rolling = std::sqrt(std::max(0.0, square - offset));  // radius of the ball that rolls here
        const double depth = rolling - distance - sums[kExtras][lane] / static_cast<double>(weight);
        const double of_outer = 1 - smoothStep(offset / (kGapOffset * square)).value;
        if (depth < 0) in_reach *= of_outer;
        // Between the two sides of a hole, the distance grows only by this share of a step.
        const double gain = std::clamp(away.length() / (weight * std::max(distance, kMinDistance)), kLeastGain, 1.0);
        const double scale = kScaled ? weight / static_cast<double>(sums[kInverseScales][lane]) : 1;
        return {away.normalized(),
                static_cast<float>(depth / gain * scale),
                static_cast<float>(in_reach),
                vector(kVelocity) / weight,
                static_cast<float>(reached),
                static_cast<float>(of_outer),
                static_cast<float>(scale),
                sums[kGrowths][lane] / weight};
    }

    double rolling_;
    std::vector<Vec3> position_;
    PointGroups groups_;
    SampleTable<kFieldsOf<kScaled>> table_;
};

template <bool kScaled>
class Retraction {
public:
    Retraction(const OuterSamples& samples, const SkinLengths& lengths, DeformingMesh& surface)
        : outer_(samples, lengths, surface.spacing()), surface_(surface) {}

    // All vertices step by a share of their gaps, averaged over a kernel.
    void step(double share, double width) {
        updateApproaches();
        std::vector<Vec3f> step(surface_.size());
        parallelFor(step.size(), 4096, [&](std::size_t v) {
            const Approach& a = approach_[v];
            const double scale = surface_.scale(v), longest = kMaxStepInKernels * width * scale,
                         longest_outwards = std::min(kMaxOutwardStep * scale, longest);
            const double length = std::clamp(a.gap * share, -longest_outwards, longest) * a.in_reach;
            step[v] = a.inwards * static_cast<float>(length);
        });
        step = surface_.kernelMeans(width, step);
        move(step);
    }
    // Vertices step that are still far from the skin, as on the rims of holes: most of what is near them is flat and
    // has arrived, and shortens mean steps.
    void catchUp() {
        updateApproaches();
        std::vector<Vec3f> step(surface_.size());
        parallelFor(step.size(), 4096, [&](std::size_t v) {
            const Approach& a = approach_[v];
            const double scale = surface_.scale(v), longest = kCatchUpKernel * scale;
            const double lag = std::max(0.0, std::abs(a.gap) - kLagging * scale) * kCatchUpGain * a.in_reach;
            const double length = a.gap > 0 ? std::min(lag, longest) : -std::min(lag, kMaxOutwardStep * scale);
            step[v] = a.inwards * static_cast<float>(length);
        });
        step = surface_.kernelMeansOfFew(kCatchUpKernel, step);
        parallelFor(step.size(), 8192, [&](std::size_t v) {
            const float longest = static_cast<float>(kMaxStepInKernels * kCatchUpKernel) * surface_.scale(v);
            step[v] = limitedTo(step[v], longest);
        });
        move(step);
    }
    void refine(double radius, double edge_factor) {
        surface_.refine(radius, edge_factor);
        approach_.clear(), reach_.clear(), has_moved_.clear();
    }
    // Replaces velocities by those of the skin.
    void setVelocities(bool with_growth) {
        std::vector<Vec3f> velocity(surface_.size());
        parallelFor(velocity.size(), 4096, [&](std::size_t v) {
            const Vec3f own(surface_.mesh().vertex[v].velocity);
            velocity[v] = own + (approach_[v].velocity - own) * (approach_[v].in_reach * approach_[v].of_outer);
        });
        velocity = surface_.kernelMeans(kVelocityKernel, velocity);
        if (with_growth) addGrowth(velocity);
        surface_.setVelocities(velocity);
    }

private:
    // Updates the approaches of groups of vertices some of which have moved.
    void updateApproaches() {
        approach_.resize(surface_.size());
        const PointGroups& groups = surface_.groups();
        const auto largestOf = [&](const auto& values, std::size_t group) {
            return *std::max_element(values.begin() + groups.begin(group), values.begin() + groups.begin(group + 1));
        };
        outer_.approach(
            surface_,
            [&](std::size_t group) -> double {
                if (reach_.empty()) return outer_.maxReach();
                if (largestOf(has_moved_, group) == 0) return -1;
                return std::min(outer_.maxReach(), static_cast<double>(largestOf(reach_, group)));
            },
            approach_);
    }
    void move(std::vector<Vec3f>& step) {
        surface_.move(step);
        reach_.resize(surface_.size());
        has_moved_.resize(surface_.size());
        parallelFor(reach_.size(), 8192, [&](std::size_t v) {
            has_moved_[v] = step[v] != Vec3f(0);
            reach_[v] = approach_[v].distance + step[v].length() / approach_[v].scale + kReachSlack;
        });
    }
    // A mean over a surface that grows in proportion to itself lies beneath that surface, as does the mean of its
    // velocities.
    void addGrowth(std::vector<Vec3f>& mean_velocity) const {
        const Vec3 origin = surface_.position().empty() ? Vec3(0) : surface_.position()[0];
        std::vector<Vec3f> position(surface_.size());
        parallelFor(position.size(), 8192,
                    [&](std::size_t v) { position[v] = Vec3f(surface_.position()[v] - origin); });
        const std::vector<Vec3f> mean = surface_.kernelMeans(kVelocityKernel, position);
        parallelFor(position.size(), 8192, [&](std::size_t v) {
            mean_velocity[v] += (position[v] - mean[v]) * (approach_[v].growth * approach_[v].in_reach);
        });
    }

    OuterBoundary<kScaled> outer_;
    DeformingMesh& surface_;
    std::vector<Approach> approach_;
    std::vector<float> reach_;             // beyond which no outer sample matters, in spacings at the sample
    std::vector<std::uint8_t> has_moved_;  // in the last step
};

template <bool kScaled>
void retractFrom(const OuterSamples& outer, const SkinLengths& lengths, DeformingMesh& surface) {
    surface.smoothScales();
    Retraction<kScaled> retraction(outer, lengths, surface);
    // Wide steps approach the skin evenly; narrower ones correct what averaging has left of the gap.
    const double wide_steps = std::min(kMaxWideSteps, std::ceil((lengths.joining - lengths.skin) / kWideStep));
    for (double left = wide_steps; left > 0; --left) retraction.step(1 / left, kWideKernel);
    const bool is_coarse = lengths.isCoarse();
    for (const double width : is_coarse ? std::span<const double>(kCoarseNarrowKernels) : kNarrowKernels)
        retraction.step(1, width);
    for (int i = 0; i < (is_coarse ? 0 : kCatchUpsBefore); ++i) retraction.catchUp();
    retraction.refine(lengths.joining, lengths.edge_factor);
    for (int i = 0; i < (is_coarse ? 1 : kCatchUpsAfter); ++i) retraction.catchUp();
    retraction.setVelocities(!outer.growth.empty());
    surface.measure();
}

}  // namespace

void retract(const OuterSamples& outer, const SkinLengths& lengths, DeformingMesh& surface) {
    if (outer.scale.empty())
        retractFrom<false>(outer, lengths, surface);
    else
        retractFrom<true>(outer, lengths, surface);
}

}  // namespace betamesh
