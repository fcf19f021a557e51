
#include "skin/smooth_coherent.h"

#include "base/dual_packs.h"
#include "base/parallel.h"
#include "base/sample_groups.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <span>
#include <utility>

namespace betamesh {

namespace {

constexpr double kFarthest = 0.5;       // that a vertex goes, in radii
constexpr double kStayingBegins = 0.7;  // rim_distance up to which a vertex goes all the way
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
using Sample = SampleFields<kFields>;

// The sums over samples, each with its rate: Σk, Σk y, Σk d, Σk y·d, Σk |y|². A lane is a point.
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

// A sample as points see it: offset, its rate, |y|² with the spread, half the rate of that, and 1 - that over width²,
// zero out of reach.
template <typename Some>
struct Seen {
    Some px, py, pz, vx, vy, vz, square, approach, t;

    __attribute__((always_inline))
    Seen(const Sample& f, const Some (&x)[3], const Some (&v)[3], float inverse_square_width)
        : px(f[kX] - x[0]),
          py(f[kY] - x[1]),
          pz(f[kZ] - x[2]),
          vx(f[kVx] - v[0]),
          vy(f[kVy] - v[1]),
          vz(f[kVz] - v[2]),
          square(px * px + py * py + pz * pz + f[kQ]),
          approach(px * vx + py * vy + pz * vz + f[kS]),
          t(1.0F - square * inverse_square_width) {
        t = t > 0 ? t : Some{};
    }
};

// How a sample lies to the mean direction: d·m, y·m and their rates.
template <typename Some>
struct Facing {
    Some facing, turning, height, fading;

    __attribute__((always_inline)) Facing(const Sample& f, const Seen<Some>& y, const Some (&m)[3], const Some (&mr)[3])
        : facing(f[kDx] * m[0] + f[kDy] * m[1] + f[kDz] * m[2]),
          turning(f[kDx] * mr[0] + f[kDy] * mr[1] + f[kDz] * mr[2] + f[kEx] * m[0] + f[kEy] * m[1] + f[kEz] * m[2]),
          height(y.px * m[0] + y.py * m[1] + y.pz * m[2]),
          fading(y.vx * m[0] + y.vy * m[1] + y.vz * m[2] + y.px * mr[0] + y.py * mr[1] + y.pz * mr[2]) {}
};

// Is any of these above zero? None is below it.
template <std::size_t kWidth>
__attribute__((always_inline)) inline bool anyAbove(const Floats<kWidth>& values) {
    typename VectorOf<std::uint64_t, kWidth / 2>::Type bits;
    std::memcpy(&bits, &values, sizeof bits);
    std::uint64_t any = 0;
    for (std::size_t i = 0; i < kWidth / 2; ++i) any |= bits[i];
    return any != 0;
}

// 1 / (|mean|² + kLeastMean), and minus its rate by itself.
template <typename Some>
__attribute__((always_inline)) inline void invert(const Some (&mean)[3], const Some (&rate)[3], Some& inverse,
                                                  Some& growth) {
    inverse = 1.0F / (mean[0] * mean[0] + mean[1] * mean[1] + mean[2] * mean[2] + kLeastMean);
    growth = 2 * (mean[0] * rate[0] + mean[1] * rate[1] + mean[2] * rate[2]) * inverse;
}

// All lengths here are in radii. x, v: the points and their velocities. All sums go through the samples in order, and
// what is out of reach or faces away adds zero, so every instruction set and every company of points gives the same
// bytes.
struct SumUp {
    SomeSamples<kFields> samples;
    float inverse_square_width;
    const Lanes (&point)[3], (&velocity)[3];
    Sums& sums;

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()(std::size_t first) const {
        using Some = Floats<kWidth>;
        Some x[3], v[3];
        getLanes<kWidth>(point, first, x);
        getLanes<kWidth>(velocity, first, v);
        const Some zero{}, one = zero + 1.0F;
        const float narrow = 4 * inverse_square_width;

        Some mean[4] = {}, mean_rate[4] = {};
        for (const Sample& f : samples) {
            const Seen<Some> y(f, x, v, inverse_square_width);
            const Some k = f[kW] * y.t * y.t;
            const Some kr = f[kU] * y.t * y.t - f[kW] * y.t * y.approach * narrow;
            mean[0] += k * f[kDx];
            mean[1] += k * f[kDy];
            mean[2] += k * f[kDz];
            mean[3] += k;
            mean_rate[0] += kr * f[kDx] + k * f[kEx];
            mean_rate[1] += kr * f[kDy] + k * f[kEy];
            mean_rate[2] += kr * f[kDz] + k * f[kEz];
            mean_rate[3] += kr;
        }
        const Some weight = mean[3] > 0 ? mean[3] : one;  // without any all of them are zero
        Some m[3], mr[3];
        for (int k = 0; k < 3; ++k) {
            m[k] = mean[k] / weight;
            mr[k] = (mean_rate[k] - m[k] * mean_rate[3]) / weight;
        }
        Some inverse_mean, growth;
        invert(m, mr, inverse_mean, growth);

        Some value[kSums] = {}, rate[kSums] = {};
        for (const Sample& f : samples) {
            const Seen<Some> y(f, x, v, inverse_square_width);
            const Facing<Some> n(f, y, m, mr);
            const Some facing = n.facing > 0 ? n.facing : zero;
            if (!anyAbove<kWidth>(facing * y.t)) continue;  // would add zero
            const Some distance = one / (y.square + 1.0F);
            const Some steepness = n.height * distance * (inverse_mean / kSteepest);
            Some level = one - n.height * steepness;
            level = level > 0 ? level : zero;
            const Some levelling =
                steepness * (n.height * (growth + (y.approach + y.approach) * distance) - n.fading - n.fading);
            // k = w · facing² · level² · t² · inverse_mean
            const Some root = facing * level * y.t, gate = root * root * inverse_mean, k = f[kW] * gate;
            const Some pull =
                root * ((n.turning * level + facing * levelling) * y.t * 2.0F - facing * level * y.approach * narrow) *
                    inverse_mean -
                gate * growth;
            const Some kr = f[kU] * gate + f[kW] * pull;
            const float dx = f[kDx], dy = f[kDy], dz = f[kDz], ex = f[kEx], ey = f[kEy], ez = f[kEz];
            const Some along = y.px * dx + y.py * dy + y.pz * dz + f[kB];
            value[kWeight] += k;
            rate[kWeight] += kr;
            value[kOffset] += k * y.px;
            value[kOffset + 1] += k * y.py;
            value[kOffset + 2] += k * y.pz;
            rate[kOffset] += kr * y.px + k * y.vx;
            rate[kOffset + 1] += kr * y.py + k * y.vy;
            rate[kOffset + 2] += kr * y.pz + k * y.vz;
            value[kDirection] += k * dx;
            value[kDirection + 1] += k * dy;
            value[kDirection + 2] += k * dz;
            rate[kDirection] += kr * dx + k * ex;
            rate[kDirection + 1] += kr * dy + k * ey;
            rate[kDirection + 2] += kr * dz + k * ez;
            value[kAlong] += k * along;
            rate[kAlong] +=
                kr * along + k * (y.vx * dx + y.vy * dy + y.vz * dz + y.px * ex + y.py * ey + y.pz * ez + f[kC]);
            value[kSquare] += k * y.square;
            rate[kSquare] += kr * y.square + k * (y.approach + y.approach);
        }
        setLanes<kWidth>(sums.value, first, value);
        setLanes<kWidth>(sums.rate, first, rate);
        setLanes<kWidth>(sums.mean, first, m);
        setLanes<kWidth>(sums.mean_rate, first, mr);
    }
};

// How near the other side of the liquid is: Σ w (m·d)₋² (m·y)₋² / (|y|² + s)³ over samples that lie behind and face
// away, m of unit length; sums has been filled at the same points.
struct SumOpposite {
    SomeSamples<kFields> samples;
    float inverse_square_width;
    const Lanes (&point)[3], (&velocity)[3];
    const Sums& sums;
    Lanes (&opposite)[2];  // and its rate

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()(std::size_t first) const {
        using Some = Floats<kWidth>;
        Some x[3], v[3], m[3], mr[3], inverse_mean, growth;
        getLanes<kWidth>(point, first, x);
        getLanes<kWidth>(velocity, first, v);
        getLanes<kWidth>(sums.mean, first, m);
        getLanes<kWidth>(sums.mean_rate, first, mr);
        invert(m, mr, inverse_mean, growth);
        const Some zero{}, one = zero + 1.0F;
        const float soft = kSoft;
        Some sum[2] = {};
        for (const Sample& f : samples) {
            const Seen<Some> y(f, x, v, inverse_square_width);
            const Facing<Some> n(f, y, m, mr);
            const Some facing = n.facing < 0 ? n.facing : zero, height = n.height < 0 ? n.height : zero;
            const Some distance = one / (y.square + soft), cube = distance * distance * distance;
            const Some root = facing * height * y.t * inverse_mean, term = root * root * cube;
            sum[0] += f[kW] * term;
            sum[1] += f[kU] * term + f[kW] * (root * cube * inverse_mean * 2.0F *
                                                  ((n.turning * height + facing * n.fading) * y.t -
                                                   facing * height * y.approach * (2 * inverse_square_width)) -
                                              term * (2 * growth + y.approach * distance * 6.0F));
        }
        setLanes<kWidth>(opposite, first, sum);
    }
};

// From points onto the spheres fitted round them, and the directions of the spheres there.
struct Fits {
    DualVec3Pack step, direction;
    DualPack trust;  // towards 1 with many samples that agree, 0 without or where they face all ways
    DualVec3Pack inset;
};

// Inwards, by `depth` at most, less where the liquid is thin, by nothing at a pinch.
DualVec3 insetFrom(const DualVec3& direction, Dual trust, Dual opposite, double depth) {
    const DualVec3 outwards = direction / squareRoot(dot(direction, direction) + kLeastMean);
    const Dual inverse_square_thickness = opposite / kSheet;  // thickness^-2
    const Dual share = inverse_square_thickness * (depth * depth / (kShareOfThickness * kShareOfThickness));
    return outwards * trust * (Dual(-depth) / squareRoot(squareRoot(1 + share * share)));
}

BETAMESH_EVERY_CPU
void fitSpheres(const Sums& sums, Fits& fits) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const bool any = sums.value[kWeight][lane] > 0;  // without, all sums are zero
        const Dual weight = any ? sums.number(kWeight, lane) : Dual(1);
        const DualVec3 a = sums.vector(kOffset, lane) / weight, b = sums.vector(kDirection, lane) / weight;
        const Dual c = sums.number(kAlong, lane) / weight, e = sums.number(kSquare, lane) / weight;
        const Dual variance = e - dot(a, a) + kRound;
        const Dual uq = (c - dot(a, b)) / (variance * 2);
        const DualVec3 ul = b - a * (uq * 2);
        const Dual minus_uc = dot(ul, a) + uq * e, slope = dot(ul, ul) + 1e-6;
        const Dual root = squareRoot(slope * slope + uq * minus_uc * slope * 4);
        const Dual squared = weight * weight, agreement = sums.squareOfMean(lane) / kAgreement,
                   cubed = agreement * agreement * agreement;
        const Dual trust = squared / (squared + kOwnWeight * kOwnWeight) * (cubed / (cubed + 1));
        fits.step.set(lane, ul * (minus_uc * 2 / (slope + root)));
        fits.direction.set(lane, ul);
        fits.trust.set(lane, any ? trust : Dual(0));
    }
}

std::vector<std::uint32_t> allRows(std::size_t n) {
    std::vector<std::uint32_t> rows(n);
    std::iota(rows.begin(), rows.end(), 0U);
    return rows;
}

std::array<float, kFields - 3> fieldsOf(const SampleInRadii& s) {
    return {s.velocity.x,  s.velocity.y, s.velocity.z,       s.direction.x, s.direction.y,
            s.direction.z, s.turning.x,  s.turning.y,        s.turning.z,   s.weight,
            s.weight_rate, s.spread,     s.half_spread_rate, s.bulge,       s.bulge_rate};
}

// Calls take(their rows, the fits at their pointAt(row)) for sixteen rows or fewer at a time, on several threads, until
// all were taken, and expect(row) some time before; lengths in radii.
template <typename PointAt, typename Expect, typename Take>
void fitAll(const std::vector<std::uint32_t>& rows, const PointAt& pointAt, const SampleCloud<kFields>& cloud,
            const CoherentSmoothing& params, const Expect& expect, const Take& take) {
    const double scale = 1 / params.radius, width = params.width * scale;
    const auto inverse_square_width = static_cast<float>(1 / (width * width));
    cloud.forPoints(
        rows.size(), [&](std::size_t i) { return pointAt(rows[i]).position; }, Grouping::close,
        [&](const PointGroup& group, SomeSamples<kFields> near) {
            std::uint32_t row[kLanes];
            Lanes v[3];
            for (std::size_t lane = 0; lane < kLanes; ++lane) {
                row[lane] = rows[group.row[lane]];
                expect(row[lane]);
                const Vec3f velocity(pointAt(row[lane]).velocity * scale);
                for (int k = 0; k < 3; ++k) v[k][lane] = velocity[k];
            }
            Sums sums;
            forLanes(SumUp{near, inverse_square_width, group.place, v, sums});
            Fits fits;
            fitSpheres(sums, fits);
            if (params.inset > 0) {
                Lanes opposite[2];
                forLanes(SumOpposite{near, inverse_square_width, group.place, v, sums, opposite});
                for (std::size_t lane = 0; lane < group.size; ++lane)
                    if (fits.trust.value[lane] > 0)
                        fits.inset.set(lane, insetFrom(fits.direction[lane], fits.trust[lane],
                                                       {opposite[0][lane], opposite[1][lane]}, params.inset * scale));
            }
            take(std::span<const std::uint32_t>(row, group.size), fits);
        });
}

// 1 up to kStayingBegins, 0 from kStaysWhole on.
Dual shareOfTheWay(Dual rim_distance) {
    return 1 - smoothStep((rim_distance - kStayingBegins) / (kStaysWhole - kStayingBegins));
}

// Vertices on their way.
struct Way {
    DualVec3Pack from, to;
    DualPack rim_distance;
};

// Takes them there as far as they go: shorter than `farthest`, whatever the step; steps that are not nearly as long
// stay what they are.
BETAMESH_EVERY_CPU
void go(Way& way, double farthest) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const DualVec3 from = way.from[lane], step = (way.to[lane] - from) * shareOfTheWay(way.rim_distance[lane]);
        const Dual s2 = dot(step, step) / (farthest * farthest), s4 = s2 * s2, s8 = s4 * s4, s = 1 + s8 * s8;
        const double root = std::sqrt(std::sqrt(std::sqrt(std::sqrt(s.value))));
        way.to.set(lane, from + step / Dual(root, root * s.rate / (16 * s.value)));
    }
}

// Vertices that only begin to rise stay near the edges and facets that they rise from. Those that rise from facets
// may have each other for corners: they see one another as if they were free.
void holdBack(BetaMesh& mesh) {
    const auto heldBack = [&](const FadingVertex& fading) {
        DualVec3 from;
        for (std::size_t k = 0; k < 4; ++k) from = from + mesh.vertex[fading.from[k]] * fading.weight[k];
        return mesh.vertex[fading.vertex] * fading.share + from * (1 - fading.share);
    };
    const auto hold = [&](const std::vector<FadingVertex>& group) {
        std::vector<DualVec3> held(group.size());
        parallelFor(group.size(), 1024, [&](std::size_t i) { held[i] = heldBack(group[i]); });
        for (std::size_t i = 0; i < group.size(); ++i) mesh.vertex[group[i].vertex] = held[i];
    };
    for (const auto& group : mesh.fading) hold(group);
}

}  // namespace

class CoherentSmoother::Cloud : public SampleCloud<kFields> {
public:
    using SampleCloud::SampleCloud;
};

CoherentSmoother::CoherentSmoother(SamplesInRadii samples, const CoherentSmoothing& params)
    : params_(params), samples_(std::move(samples)) {
    takeSamples(0);
}
CoherentSmoother::~CoherentSmoother() = default;

bool CoherentSmoother::isLast(int pass) const { return pass + 1 >= params_.passes; }

void CoherentSmoother::takeSamples(int pass) {
    cloud_ = std::make_unique<Cloud>(
        samples_.size(), [&](std::size_t i) { return samples_[i].position; },
        [&](std::size_t i) { return fieldsOf(samples_[i]); }, params_.width, params_.radius);
    if (isLast(pass)) std::exchange(samples_, {});  // large, and of no more use
}

DualPoints CoherentSmoother::smooth(BetaMesh& mesh) {
    const CoherentSmoothing& params = params_;
    DualPoints from = copyOf(mesh.vertex);
    const std::vector<std::uint32_t> moving = indicesWhere(mesh.vertex.size(), [&](std::uint32_t v) {  // the others stay
        return params.inset > 0 || mesh.rim_distance.empty() || mesh.rim_distance[v].value < kStaysWhole;
    });
    for (const auto& group : mesh.fading)
        parallelFor(group.size(), 4096, [&](std::size_t i) { mesh.vertex[group[i].vertex] = group[i].whole; });

    const bool inwards = params.inset > 0;
    const std::vector<DualVec3> begin = params.passes > 1 ? mesh.vertex : std::vector<DualVec3>();
    const std::vector<Vec3> normals = inwards ? vertexNormals(mesh) : std::vector<Vec3>();
    std::vector<DualVec3> inset(inwards ? mesh.vertex.size() : 0);
    // Between surfaces that nearly touch, the mean direction may be that of the other one.
    const auto insetAt = [&](std::uint32_t v, const DualVec3& given) {
        const double length = given.position.length(), towards = -dot(normals[v], given.position);
        return length > 0 ? given * (smoothStep(2 * towards / length).value * params.radius) : DualVec3();
    };
    CoherentSmoothing now = params;
    for (int pass = 0; pass < std::max(params.passes, inwards ? 1 : 0); ++pass) {
        fitAll(
            moving, [&](std::uint32_t v) -> const DualVec3& { return mesh.vertex[v]; }, *cloud_, now,
            [&](std::uint32_t v) {
                if (!mesh.rim_distance.empty()) __builtin_prefetch(&mesh.rim_distance[v]);
            },
            [&](std::span<const std::uint32_t> rows, const Fits& fits) {
                Way way;
                for (std::size_t lane = 0; lane < rows.size(); ++lane) {
                    const std::uint32_t v = rows[lane];
                    const DualVec3& vertex = mesh.vertex[v];
                    way.from.set(lane, pass == 0 ? vertex : begin[v]);
                    way.to.set(
                        lane, params.passes > 0 ? vertex + fits.step[lane] * fits.trust[lane] * params.radius : vertex);
                    if (!mesh.rim_distance.empty()) way.rim_distance.set(lane, mesh.rim_distance[v]);
                    if (now.inset > 0) inset[v] = insetAt(v, fits.inset[lane]);
                }
                if (isLast(pass)) go(way, kFarthest * params.radius);
                for (std::size_t lane = 0; lane < rows.size(); ++lane) {
                    const std::uint32_t v = rows[lane];
                    mesh.vertex[v] = way.to[lane];
                    if (isLast(pass) && inwards) mesh.vertex[v] = mesh.vertex[v] + inset[v];
                }
            });
        if (isLast(pass)) break;
        now.inset = 0;
        SamplesInRadii calmer = samples_;
        const auto pointAt = [&](std::uint32_t i) -> DualVec3 {
            return {samples_[i].position, Vec3(samples_[i].velocity) * params.radius};
        };
        fitAll(
            allRows(samples_.size()), pointAt, *cloud_, now, [](std::uint32_t) {},
            [&](std::span<const std::uint32_t> rows, const Fits& fits) {
                for (std::size_t lane = 0; lane < rows.size(); ++lane) {
                    SampleInRadii& sample = calmer[rows[lane]];
                    const DualVec3 step = fits.step[lane] * fits.trust[lane];
                    sample.position += step.position * params.radius;
                    sample.velocity += Vec3f(step.velocity);
                    const DualVec3 direction{Vec3(sample.direction), Vec3(sample.turning)};
                    const DualVec3 turned = direction + (fits.direction[lane] - direction) * fits.trust[lane];
                    sample.direction = Vec3f(turned.position);
                    sample.turning = Vec3f(turned.velocity);
                }
            });
        samples_ = std::move(calmer);
        takeSamples(pass + 1);
    }
    for (const auto& [v, step] : mesh.volume_offsets) mesh.vertex[v] = mesh.vertex[v] + step;
    holdBack(mesh);
    return from;
}

}  // namespace betamesh
