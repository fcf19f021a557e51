
#include "skin/retract.h"

#include "base/parallel.h"

#include <algorithm>
#include <cmath>

namespace betamesh {

namespace {

// All lengths are in particle spacings.
constexpr double kBand = 0.25;         // outer points so much farther than the nearest one have a say in the direction
constexpr double kFadesBelow = 0.3;    // vertices so much deeper than the skin are out of reach, and stay
constexpr float kSlack = 0.26F;        // the band, and rounding
constexpr std::size_t kMostNear = 4096;  // outer points that count for a group of vertices
constexpr float kFadingSquare = 0.3F;  // added to the squared distance of an outer point that has only just appeared
constexpr double kOuterCell = 3;       // edge of the cells in which outer points are grouped

// Vertices approach the skin in wide steps, of at most kWideStep each, and arrive in narrower ones. kWide, kNarrower:
// widths of the kernel over which a step is averaged.
constexpr double kWideStep = 0.37, kMostWideSteps = 16, kWide = 1.3;
constexpr double kNarrower[] = {1.0, 0.8, 0.6};
constexpr std::size_t kRefinedAfter = 1;  // narrower steps: edges round holes grow until then
constexpr double kLongestStep = 0.2;  // in widths of the mean; of a field that changes slowly enough not to fold
constexpr double kLongestOutwards = 0.1;

// What volume asks for beyond the skin: threads expose a fifth of each outer ball, drops of one particle all of it. On
// arcs, where parts of the liquid meet, nothing: there the skin has to be what makes them meet at contact.
constexpr double kThreadExtra = 0.1, kDropExtra = -0.02;
double extraOf(double isolation) {
    return kThreadExtra * smoothStep((isolation - 0.1) / 0.1).value +
           kDropExtra * smoothStep((isolation - 0.8) / 0.2).value;
}

enum Field { kX, kY, kZ, kVx, kVy, kVz, kWeight, kExtra, kFading, kFields };
using Samples = SampleRuns<kFields>;

// Over the outer points in a band beyond the nearest one, w their weights: Σ w (x - y), Σ w v, Σ w, Σ w extra; and the
// squared distance of the nearest.
enum Sum { kAway, kVelocity = kAway + 3, kWeights = kVelocity + 3, kExtras, kNearest, kSums };
struct SumOuter {
    Samples samples;
    const Lanes (&point)[3];
    Lanes (&sums)[kSums];

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()(std::size_t first) const {
        using Some = Floats<kWidth>;
        Some x[3];
        getLanes<kWidth>(point, first, x);
        const Some zero{}, one = zero + 1.0F;
        Some nearest = zero + 1e30F;
        samples.forEach(x, [&](const auto& f, const Some(&p)[3]) __attribute__((always_inline)) {
            const Some square = p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + f[kFading];
            nearest = square < nearest ? square : nearest;
        });
        Some root = (nearest + one) * 0.5F;  // by Newton's method: near enough to say how wide the band is
        for (int i = 0; i < 3; ++i) root = (root + nearest / root) * 0.5F;
        constexpr auto band = static_cast<float>(kBand);
        const Some inverse = one / (band * band + 2 * band * root);
        Some sum[kSums] = {};
        samples.forEach(x, [&](const auto& f, const Some(&p)[3]) __attribute__((always_inline)) {
            const Some square = p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + f[kFading];
            Some t = one - (square - nearest) * inverse;
            t = t > 0 ? t : zero;
            const Some w = t * t * f[kWeight];
            sum[kAway] -= w * p[0];
            sum[kAway + 1] -= w * p[1];
            sum[kAway + 2] -= w * p[2];
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

// Where a vertex would go by itself.
struct Approach {
    Vec3f away{0};       // from the outer boundary: unit vector; zero where that is out of reach
    float gap = 0;       // to where it is deep enough; negative where it is too deep
    float in_reach = 0;  // 1, fading to 0 deep below the skin
    Vec3f velocity{0};   // of the outer boundary there
    float distance = 0;  // of its nearest point; what counts for more as points fade
};

class OuterBoundary {
public:
    OuterBoundary(const OuterSamples& samples, const SkinLengths& lengths, double spacing)
        : rolling_(lengths.rolling()),
          spacing_(spacing),
          position_(samples.point.size()),
          point_(samples.point.size()) {
        std::vector<std::uint32_t> order;
        parallelFor(position_.size(), 8192, [&](std::size_t i) { position_[i] = samples.point[i].position; });
        groups_ = PointGroups(position_, kOuterCell * spacing, order);
        position_ = inOrder(position_, order);
        groups_.fitBoxes(position_);
        parallelFor(point_.size(), 8192, [&](std::size_t i) {
            const std::uint32_t row = order[i];
            const double extra = lengths.volume_true ? extraOf(samples.isolation[row]) : 0;
            point_[i] = {Vec3f(samples.point[row].velocity), samples.weight[row], static_cast<float>(extra),
                         samples.fading[row] * kFadingSquare};
        });
    }

    double farthest() const { return rolling_ + kFadesBelow + kBand; }
    // reach: of each vertex; none: not known
    std::vector<Approach> approaches(const DeformingMesh& surface, const std::vector<float>& reach) const {
        std::vector<Approach> approach(surface.size());
        const PointGroups& groups = surface.groups();
        const auto reachOf = [&](std::size_t group) {
            if (reach.empty()) return farthest();
            const auto begin = reach.begin() + groups.begin(group), end = reach.begin() + groups.begin(group + 1);
            return std::min(farthest(), static_cast<double>(*std::max_element(begin, end)));
        };
        forGroups<kFields>(
            groups, surface.position(), groups_, position_, spacing_, kMostNear,
            [&](std::size_t group) { return reachOf(group) * spacing_; },
            [&](std::uint32_t i, SampleFields<kFields>& f) {
                const Point& p = point_[i];
                f[kVx] = p.velocity.x, f[kVy] = p.velocity.y, f[kVz] = p.velocity.z;
                f[kWeight] = p.weight, f[kExtra] = p.extra, f[kFading] = p.fading_square;
            },
            [&](const GroupLanes& group, Samples samples) {
                Lanes sums[kSums];
                forLanes(SumOuter{samples, group.place, sums});
                for (std::size_t lane = 0; lane < group.size; ++lane)
                    approach[group.row[lane]] = approachOf(sums, lane);
            });
        return approach;
    }

private:
    Approach approachOf(const Lanes (&sums)[kSums], std::size_t lane) const {
        const double distance = std::sqrt(static_cast<double>(sums[kNearest][lane]));
        const double in_reach = 1 - smoothStep((distance - rolling_) / kFadesBelow).value;
        const float weight = sums[kWeights][lane];
        if (!(in_reach > 0) || !(weight > 0)) return Approach{.distance = static_cast<float>(distance)};
        const auto vector = [&](int s) { return Vec3f(sums[s][lane], sums[s + 1][lane], sums[s + 2][lane]); };
        return {vector(kAway).normalized(),
                static_cast<float>(rolling_ - distance - sums[kExtras][lane] / static_cast<double>(weight)),
                static_cast<float>(in_reach), vector(kVelocity) / weight, static_cast<float>(distance)};
    }

    struct Point {
        Vec3f velocity;
        float weight, extra, fading_square;
    };

    double rolling_, spacing_;
    std::vector<Vec3> position_;
    std::vector<Point> point_;
    PointGroups groups_;
};

}  // namespace

void retract(const OuterSamples& samples, const SkinLengths& lengths, DeformingMesh& surface) {
    const OuterBoundary outer(samples, lengths, surface.spacing());
    std::vector<float> reach;  // of each vertex, beyond which no outer point counts; none: not known
    const auto wide = static_cast<std::size_t>(
        std::min(kMostWideSteps, std::ceil((lengths.joining - lengths.skin) / kWideStep)));
    const std::size_t count = wide + std::size(kNarrower);
    for (std::size_t s = 0; s < count; ++s) {
        const double share = s < wide ? 1 / static_cast<double>(wide - s) : 1;  // of the way that is left
        const double width = s < wide ? kWide : kNarrower[s - wide];
        if (s == wide + kRefinedAfter) {
            surface.refine(lengths.joining, lengths.coarser);
            reach.clear();
        }
        const std::vector<Approach> approach = outer.approaches(surface, reach);
        std::vector<Vec3f> step(surface.size());
        parallelFor(step.size(), 4096, [&](std::size_t v) {
            const Approach& a = approach[v];
            const double longest = kLongestStep * width;
            const double way = std::clamp(a.gap * share, -std::min(kLongestOutwards, longest), longest) * a.in_reach;
            step[v] = a.away * static_cast<float>(way);
        });
        if (s + 1 == count) {
            std::vector<Vec3f> velocity(surface.size());
            parallelFor(velocity.size(), 4096, [&](std::size_t v) {
                const Vec3f own(surface.mesh().vertex[v].velocity);
                velocity[v] = own + (approach[v].velocity - own) * approach[v].in_reach;
            });
            velocity = surface.means(width, velocity);
            surface.setVelocities(velocity);
        }
        step = surface.means(width, step);
        surface.move(step);
        reach.resize(surface.size());
        parallelFor(reach.size(), 8192,
                    [&](std::size_t v) { reach[v] = approach[v].distance + step[v].length() + kSlack; });
    }
    surface.measure();
}

}  // namespace betamesh
