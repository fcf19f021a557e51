
#include "skin/limit_velocities.h"

#include "base/box.h"
#include "base/sample_groups.h"

#include <algorithm>
#include <cmath>

namespace betamesh {

namespace {

// Added to the inertia of the balls near a vertex, in squares of the reach: always, so that it can be inverted for a
// line of balls; and up to this where they do not move as a rigid body, or noise would make threads spin.
constexpr double kLeastInertia = 1e-7, kCalmedInertia = 0.03;
// Largest speed that rotation gives a vertex, over the root mean square of what it gives the balls: two balls that lie
// close together have a large angular velocity, which must not be extrapolated to the surface.
constexpr double kFastestTurned = 8;
constexpr double kRounding = 3e-6;  // relative error of sums of squares in floats
// Largest velocity of a vertex along its normal relative to the rigid motion, over the root mean square of what the
// balls do relative to it. Measured: more is farther from the surface half a frame later.
constexpr double kMostBeyond = 0.7;

// Of a ball: position and velocity.
enum Field { kX, kY, kZ, kVx, kVy, kVz, kFields };

// Over balls, y their positions from each point in units of the reach, v their velocities less the point's own drift,
// w = (1 - |y|²)⁴: Σw, Σw y, Σw v, Σw y × v, Σw of xx, yy, zz, xy, yz, zx, and Σw v·v.
enum Sum {
    kWeight,
    kPlace,
    kVelocity = kPlace + 3,
    kMoment = kVelocity + 3,
    kSquares = kMoment + 3,
    kEnergy = kSquares + 6,
    kSums
};
struct SumMotion {
    SomeSamples<kFields> samples;
    const Lanes (&point)[3], (&drift)[3];
    Lanes (&sums)[kSums];

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()(std::size_t first) const {
        using Some = Floats<kWidth>;
        Some x[3], u[3];
        getLanes<kWidth>(point, first, x);
        getLanes<kWidth>(drift, first, u);
        const Some zero{}, one = zero + 1.0F;
        Some sum[kSums] = {};
        for (const auto& f : samples) {
            const Some y[3] = {f[kX] - x[0], f[kY] - x[1], f[kZ] - x[2]};
            const Some v[3] = {f[kVx] - u[0], f[kVy] - u[1], f[kVz] - u[2]};
            Some t = one - (y[0] * y[0] + y[1] * y[1] + y[2] * y[2]);
            t = t > 0 ? t : zero;
            const Some square = t * t, w = square * square, wy[3] = {w * y[0], w * y[1], w * y[2]};
            sum[kWeight] += w;
            for (int k = 0; k < 3; ++k) {
                const int l = (k + 1) % 3, m = (k + 2) % 3;
                sum[kPlace + k] += wy[k];
                sum[kVelocity + k] += w * v[k];
                sum[kMoment + k] += wy[l] * v[m] - wy[m] * v[l];
                sum[kSquares + k] += wy[k] * y[k];
                sum[kSquares + 3 + k] += wy[k] * y[l];
            }
            sum[kEnergy] += w * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
        }
        setLanes<kWidth>(sums, first, sum);
    }
};

// The factor that keeps a length below a limit, both given by their squares: 1 until the length is close to the limit.
double shareWithin(double square, double limit) {
    if (!(limit > 0)) return 0;
    const double over = square / limit, over4 = over * over * over * over;
    return std::pow(1 + over4 * over4, -1.0 / 16);
}

// How the liquid moves at a point.
struct LiquidMotion {
    Vec3 velocity;  // of the rigid motion that fits best
    double spread;  // root mean square of the balls' velocities relative to it

    LiquidMotion(const Lanes (&sums)[kSums], std::size_t lane, const Vec3f& drift) {
        const auto at = [&](int s) { return static_cast<double>(sums[s][lane]); };
        const auto mean = [&](int s) { return Vec3(at(s), at(s + 1), at(s + 2)) / at(kWeight); };
        const Vec3 y = mean(kPlace), v = mean(kVelocity), moment = mean(kMoment) - cross(y, v);
        const Vec3 square = mean(kSquares), product = mean(kSquares + 3);
        const double whole = at(kEnergy) / at(kWeight), energy = std::max(0.0, whole - dot(v, v));
        const double xx = square.x - y.x * y.x, yy = square.y - y.y * y.y, zz = square.z - y.z * y.z,
                     xy = product.x - y.x * y.y, yz = product.y - y.y * y.z, zx = product.z - y.z * y.x;
        const auto inertia = [&](double more) {
            return Mat33(yy + zz + more, -xy, -zx, -xy, zz + xx + more, -yz, -zx, -yz, xx + yy + more);
        };
        const double turns = dot(moment, moment * inertia(kLeastInertia).inverse());
        const double explained = energy > 0 ? std::min(1.0, turns / energy) : 1;
        const Vec3 spin = moment * inertia(kLeastInertia + kCalmedInertia * (1 - explained)).inverse();
        const double turning = std::clamp(dot(spin, spin * inertia(0)), 0.0, energy),
                     beyond = energy - 2 * dot(moment, spin) + turning;
        spread = std::sqrt(std::clamp(beyond - kRounding * whole, 0.0, energy));
        const Vec3 turned = cross(y, spin);
        velocity = Vec3(drift) + v + turned * shareWithin(turned.length2(), kFastestTurned * kFastestTurned * turning);
    }
};

}  // namespace

void limitVelocities(const std::vector<DualVec3>& balls, double reach, const std::vector<Vec3>& normals,
                     std::vector<DualVec3>& vertices) {
    if (balls.empty()) return;
    Box velocities;
    for (const DualVec3& ball : balls) velocities.extendBy(ball.velocity);
    const SampleCloud<kFields> cloud(
        balls.size(), [&](std::size_t b) { return balls[b].position; },
        [&](std::size_t b) {
            const Vec3f v(balls[b].velocity);
            return std::array{v.x, v.y, v.z};
        },
        reach, reach);
    cloud.forPoints(
        vertices.size(), [&](std::size_t v) { return vertices[v].position; }, Grouping::coarse,
        [&](const PointGroup& group, SomeSamples<kFields> near) {
            Lanes drift[3], sums[kSums];  // subtracted first: floats lose small differences of large velocities
            for (std::size_t lane = 0; lane < kLanes; ++lane)
                for (int k = 0; k < 3; ++k)
                    drift[k][lane] = static_cast<float>(
                        std::clamp(vertices[group.row[lane]].velocity[k], velocities.min[k], velocities.max[k]));
            forLanes(SumMotion{near, group.place, drift, sums});
            for (std::size_t lane = 0; lane < group.size; ++lane) {
                if (!(sums[kWeight][lane] > 0)) continue;
                const std::uint32_t v = group.row[lane];
                const LiquidMotion liquid(sums, lane, Vec3f(drift[0][lane], drift[1][lane], drift[2][lane]));
                const double most = kMostBeyond * liquid.spread;
                double beyond = dot(normals[v], vertices[v].velocity - liquid.velocity);
                beyond *= shareWithin(beyond * beyond, most * most);
                vertices[v].velocity = liquid.velocity + normals[v] * beyond;
            }
        });
}

}  // namespace betamesh
