
#include "skin/limit_velocities.h"

#include "base/box.h"
#include "base/sample_groups.h"
#include "skin/constants.h"

#include <algorithm>
#include <cmath>

namespace betamesh {

namespace {

constexpr double kRounding = 3e-6;  // relative error of sums of squares in single precision

// Fields of a ball: position and velocity.
enum Field { kX, kY, kZ, kVx, kVy, kVz, kFields };

// Sums over balls: y is the position relative to a vertex in units of the reach, v the velocity relative to a reference
// velocity of the vertex, w = (1 - |y|²)⁴. Σw, Σw y, Σw v, Σw y × v, Σw of xx, yy, zz, xy, yz, zx, and Σw v·v.
enum Sum {
    kWeight,
    kOffset,
    kVelocity = kOffset + 3,
    kMoment = kVelocity + 3,
    kSquares = kMoment + 3,
    kEnergy = kSquares + 6,
    kSums
};
struct MotionSums {
    SampleSubset<kFields> samples;
    const Lanes (&point)[3], (&reference)[3];
    Lanes (&sums)[kSums];

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()(std::size_t first) const {
        using Pack = Floats<kWidth>;
        Pack x[3], u[3];
        getLanes<kWidth>(point, first, x);
        getLanes<kWidth>(reference, first, u);
        const Pack zero{}, one = zero + 1.0F;
        Pack sum[kSums] = {};
        for (const auto& f : samples) {
            const Pack y[3] = {f[kX] - x[0], f[kY] - x[1], f[kZ] - x[2]};
            const Pack v[3] = {f[kVx] - u[0], f[kVy] - u[1], f[kVz] - u[2]};
            Pack t = one - (y[0] * y[0] + y[1] * y[1] + y[2] * y[2]);
            t = t > 0 ? t : zero;
            const Pack square = t * t, w = square * square, wy[3] = {w * y[0], w * y[1], w * y[2]};
            sum[kWeight] += w;
            for (int k = 0; k < 3; ++k) {
                const int l = (k + 1) % 3, m = (k + 2) % 3;
                sum[kOffset + k] += wy[k];
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

// A smooth factor that keeps a length below a limit, both given by their squares: 1 unless the length is near the
// limit.
double limitingFactor(double square, double limit) {
    if (!(limit > 0)) return 0;
    const double ratio = square / limit, ratio4 = ratio * ratio * ratio * ratio;
    return std::pow(1 + ratio4 * ratio4, -1.0 / 16);
}

// The motion of the liquid at a vertex.
struct LiquidMotion {
    Vec3 velocity;    // of the best rigid motion
    double residual;  // root mean square of the balls' velocities relative to it

    LiquidMotion(const Lanes (&sums)[kSums], std::size_t lane, const Vec3f& reference) {
        const auto at = [&](int s) { return static_cast<double>(sums[s][lane]); };
        const auto mean = [&](int s) { return Vec3(at(s), at(s + 1), at(s + 2)) / at(kWeight); };
        const Vec3 y = mean(kOffset), v = mean(kVelocity), moment = mean(kMoment) - cross(y, v);
        const Vec3 square = mean(kSquares), product = mean(kSquares + 3);
        const double total = at(kEnergy) / at(kWeight), energy = std::max(0.0, total - dot(v, v));
        const double xx = square.x - y.x * y.x, yy = square.y - y.y * y.y, zz = square.z - y.z * y.z,
                     xy = product.x - y.x * y.y, yz = product.y - y.y * y.z, zx = product.z - y.z * y.x;
        const auto inertia = [&](double more) {
            return Mat33(yy + zz + more, -xy, -zx, -xy, zz + xx + more, -yz, -zx, -yz, xx + yy + more);
        };
        const double rotation_energy = dot(moment, moment * inertia(kMinInertia).inverse());
        const double explained = energy > 0 ? std::min(1.0, rotation_energy / energy) : 1;
        const Vec3 angular_velocity = moment * inertia(kMinInertia + kNoiseInertia * (1 - explained)).inverse();
        const double rotating = std::clamp(dot(angular_velocity, angular_velocity * inertia(0)), 0.0, energy),
                     rest = energy - 2 * dot(moment, angular_velocity) + rotating;
        residual = std::sqrt(std::clamp(rest - kRounding * total, 0.0, energy));
        const Vec3 rotated = cross(y, angular_velocity);  // velocity at the vertex: its offset from the mean is -y
        velocity = Vec3(reference) + v +
                   rotated * limitingFactor(rotated.length2(), kMaxRotationGain * kMaxRotationGain * rotating);
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
        vertices.size(), [&](std::size_t v) { return vertices[v].position; }, Grouping::unsorted,
        [&](const PointGroup& group, SampleSubset<kFields> near) {
            Lanes reference[3], sums[kSums];  // subtracted first: floats lose small differences of large velocities
            for (std::size_t lane = 0; lane < kLanes; ++lane)
                for (int k = 0; k < 3; ++k)
                    reference[k][lane] = static_cast<float>(
                        std::clamp(vertices[group.row[lane]].velocity[k], velocities.min[k], velocities.max[k]));
            forLanes(MotionSums{near, group.position, reference, sums});
            for (std::size_t lane = 0; lane < group.size; ++lane) {
                if (!(sums[kWeight][lane] > 0)) continue;
                const std::uint32_t v = group.row[lane];
                const LiquidMotion liquid(sums, lane,
                                          Vec3f(reference[0][lane], reference[1][lane], reference[2][lane]));
                const double limit = kMaxRelativeVelocity * liquid.residual;
                double relative = dot(normals[v], vertices[v].velocity - liquid.velocity);
                relative *= limitingFactor(relative * relative, limit * limit);
                vertices[v].velocity = liquid.velocity + normals[v] * relative;
            }
        });
}

}  // namespace betamesh
