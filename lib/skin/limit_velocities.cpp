
#include "skin/limit_velocities.h"

#include "base/box.h"
#include "base/octaves.h"
#include "base/sample_groups.h"
#include "skin/constants.h"

#include <algorithm>
#include <cmath>

namespace betamesh {

namespace {

constexpr double kRounding = 3e-6;  // relative error of sums of squares in single precision

// Fields of a ball: position, velocity, change of its radius and share.
enum Field { kX, kY, kZ, kVx, kVy, kVz, kGrowth, kShare, kFields };

// Sums over balls: y is the position relative to a vertex in units of the vertex's reach, v the velocity relative to a
// reference velocity of the vertex, w = share · (1 - |y|²)⁴. Σw, Σw y, Σw v, Σw y × v, Σw of xx, yy, zz, xy, yz, zx,
// Σw v·v, and Σw of
// the squared change of the radius.
enum Sum {
    kWeight,
    kOffset,
    kVelocity = kOffset + 3,
    kMoment = kVelocity + 3,
    kSquares = kMoment + 3,
    kEnergy = kSquares + 6,
    kSquaredGrowth,
    kSums
};
// Positions of samples and points are in units of the group's reach, of which the vertices have these shares.
template <bool kGrowing>
struct MotionSums {
    SampleSubset<kFields> samples;
    const Lanes (&point)[3], (&reference)[3];
    const Lanes& inverse_share;
    Lanes (&sums)[kSums];

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()(std::size_t first) const {
        using Pack = Floats<kWidth>;
        Pack x[3], u[3];
        getLanes<kWidth>(point, first, x);
        getLanes<kWidth>(reference, first, u);
        Pack scale;
        getLanes<kWidth>(inverse_share, first, scale);
        const Pack zero{}, one = zero + 1.0F;
        Pack sum[kSums] = {};
        for (const auto& f : samples) {
            const Pack y[3] = {(f[kX] - x[0]) * scale, (f[kY] - x[1]) * scale, (f[kZ] - x[2]) * scale};
            const Pack v[3] = {f[kVx] - u[0], f[kVy] - u[1], f[kVz] - u[2]};
            Pack t = one - (y[0] * y[0] + y[1] * y[1] + y[2] * y[2]);
            t = t > 0 ? t : zero;
            const Pack square = t * t, w = f[kShare] * (square * square), wy[3] = {w * y[0], w * y[1], w * y[2]};
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
            if constexpr (kGrowing) sum[kSquaredGrowth] += w * f[kGrowth] * f[kGrowth];
        }
        setLanes<kWidth>(sums, first, sum);
    }
};

// The motion of the liquid at a vertex.
struct LiquidMotion {
    Vec3 velocity;    // of the best rigid motion
    double residual;  // root mean square of the balls' velocities relative to it and of the changes of their radii

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
        residual = std::sqrt(std::clamp(rest - kRounding * total, 0.0, energy) + at(kSquaredGrowth) / at(kWeight));
        const Vec3 rotated = cross(y, angular_velocity);  // velocity at the vertex: its offset from the mean is -y
        velocity = Vec3(reference) + v +
                   rotated * limitingFactor(rotated.length2(), kMaxRotationGain * kMaxRotationGain * rotating);
    }
};

}  // namespace

double limitingFactor(double square, double limit) {
    if (!(limit > 0)) return 0;
    const double ratio = square / limit, ratio4 = ratio * ratio * ratio * ratio;
    double root = 1 + ratio4 * ratio4;
    for (int i = 0; i < 4; ++i) root = std::sqrt(root);  // not std::pow(), whose bits depend on the instruction set
    return 1 / root;
}

void limitVelocities(const BallBoundary& boundary, const std::vector<DualVec3>& balls, double reach,
                     const std::vector<Vec3>& normals, BetaMesh& mesh) {
    if (balls.empty()) return;
    Box velocities;
    for (const DualVec3& ball : balls) velocities.extendBy(ball.velocity);
    std::vector<DualVec3>& vertices = mesh.vertex;
    const std::vector<std::vector<std::uint32_t>> octaves = byOctave(allRows(vertices.size()), mesh.scale);
    for (std::size_t octave = 0; octave < octaves.size(); ++octave) {
        const std::vector<std::uint32_t>& rows = octaves[octave];
        if (rows.empty()) continue;
        const double largest = largestOfOctave(octave), longest = reach * largest;
        const SampleCloud<kFields> cloud(
            balls.size(), [&](std::size_t b) { return balls[b].position; },
            [&](std::size_t b) {
                const Vec3f v(balls[b].velocity);
                const double scale = boundary.scaleOf(b);
                const double growth = boundary.worldRadiusOf(b).rate;
                return std::array{v.x, v.y, v.z, static_cast<float>(growth), static_cast<float>(scale * scale)};
            },
            longest, longest);
        cloud.forPoints(
            rows.size(), [&](std::size_t i) { return vertices[rows[i]].position; }, Grouping::unsorted,
            [&](const PointGroup& group, SampleSubset<kFields> near) {
                std::uint32_t row[kLanes];
                Lanes reference[3], inverse_share, sums[kSums];
                for (std::size_t lane = 0; lane < kLanes; ++lane) {
                    row[lane] = rows[group.row[lane]];
                    inverse_share[lane] = mesh.scale.empty() ? 1 : static_cast<float>(largest) / mesh.scale[row[lane]];
                    for (int k = 0; k < 3; ++k)  // subtracted first: floats lose small differences of large velocities
                        reference[k][lane] = static_cast<float>(
                            std::clamp(vertices[row[lane]].velocity[k], velocities.min[k], velocities.max[k]));
                }
                if (boundary.radius_rate.empty())
                    forLanes(MotionSums<false>{near, group.position, reference, inverse_share, sums});
                else
                    forLanes(MotionSums<true>{near, group.position, reference, inverse_share, sums});
                for (std::size_t lane = 0; lane < group.size; ++lane) {
                    if (!(sums[kWeight][lane] > 0)) continue;
                    DualVec3& vertex = vertices[row[lane]];
                    const Vec3& normal = normals[row[lane]];
                    const LiquidMotion liquid(sums, lane,
                                              Vec3f(reference[0][lane], reference[1][lane], reference[2][lane]));
                    const double limit = kMaxRelativeVelocity * liquid.residual;
                    double relative = dot(normal, vertex.velocity - liquid.velocity);
                    relative *= limitingFactor(relative * relative, limit * limit);
                    vertex.velocity = liquid.velocity + normal * relative;
                }
            });
    }
}

}  // namespace betamesh
