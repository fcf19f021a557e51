#include "skin/velocity.h"

#include "core/box.h"
#include "core/cell_order.h"
#include "core/parallel.h"
#include "core/rigid_motion.h"
#include "core/sample_groups.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

namespace betamesh {

namespace {

constexpr double kWellConditioned = 0.01;  // of |q1·(q2 × q3)| / r³; 99.9% of vertices lie above
constexpr double kDamping = 0.25;          // weight of the field against the three equations at condition zero

// Of the rigid motion near a vertex, in squares of its reach: what is added to the inertia, so that a line of balls has
// one, and how much more where balls do not move as a rigid body: threads would spin at the slightest provocation.
constexpr double kLeastInertia = 1e-7, kCalmedInertia = 0.03;
constexpr double kFastestTurned = 8;  // a vertex, in root mean squares of what balls do by turning: pairs may be close
constexpr double kRounding = 3e-6;  // of sums of squares
constexpr double kMostBeyond = 0.7;  // of what balls do beyond the rigid motion, that a vertex does along its normal

// The ċ that minimises Σ (q_m·ċ - q_m·v_m)² + damping² |ċ|², q_m of unit length.
Vec3 dampedSolution(const Vec3 q[3], const double speed[3], double damping) {
    Mat33 normal;
    Vec3 right(0, 0, 0);
    for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) {
            normal[a][b] = a == b ? damping * damping : 0;
            for (int m = 0; m < 3; ++m) normal[a][b] += q[m][a] * q[m][b];
        }
    for (int m = 0; m < 3; ++m) right += q[m] * speed[m];
    return right * normal.inverse();
}

// The three equations of a vertex, as unit directions and the balls' speeds along them.
struct SphereEquations {
    Vec3 q[3];
    Vec3 velocity[3];
    double determinant;

    SphereEquations(const Vec3& vertex, const Moving& a, const Moving& b, const Moving& c)
        : q{(vertex - a.position).normalized(), (vertex - b.position).normalized(), (vertex - c.position).normalized()},
          velocity{a.velocity, b.velocity, c.velocity},
          determinant(dot(q[0], cross(q[1], q[2]))) {}

    double shortfall() const { return 1 - std::abs(determinant) / kWellConditioned; }
    // What the spheres ask for beyond a given velocity.
    void speedsBeyond(const Vec3& field, double speed[3]) const {
        for (int m = 0; m < 3; ++m) speed[m] = dot(q[m], velocity[m] - field);
    }
    Vec3 solved() const {
        const Vec3 mean = (velocity[0] + velocity[1] + velocity[2]) / 3;
        double speed[3];
        speedsBeyond(mean, speed);
        return mean + (cross(q[1], q[2]) * speed[0] + cross(q[2], q[0]) * speed[1] + cross(q[0], q[1]) * speed[2]) /
                          determinant;
    }
    Vec3 damped(const Vec3& field) const {
        double speed[3];
        speedsBeyond(field, speed);
        return field + dampedSolution(q, speed, kDamping * shortfall() * shortfall());
    }
};

// The rigid motion of the particles round one, by offsets from it (in quanta).
RigidMotionFit rigidMotion(const Particles& particles, const SnappedParticles& snapped, std::uint32_t around,
                           NeighbourFinder& finder, std::vector<Neighbour>& neighbours) {
    const auto reach = 4 * static_cast<double>(snapped.radius) * static_cast<double>(snapped.radius);
    finder.find(around, neighbours);
    neighbours.push_back({Vec3(0, 0, 0), 0, around});
    RigidMotionFit fit;
    for (const Neighbour& n : neighbours) {
        const double w = 1 - n.squared / (1.0001 * reach);
        fit.add(n.offset, Vec3(particles.velocity[snapped.row[n.particle]]), w * w);
    }
    return fit;
}

}  // namespace

std::vector<Moving> movingBalls(const BallBoundary& boundary, const Particles& particles) {
    std::vector<Moving> balls;
    resizeOnAll(balls, boundary.position.size());
    parallelFor(balls.size(), 4096, [&](std::size_t b) {
        balls[b].position = boundary.centre(b);
        if (!particles.velocity.empty()) balls[b].velocity = Vec3(particles.velocity[boundary.row[b]]);
    });
    return balls;
}

std::vector<Moving> movingVertices(const Particles& particles, const SnappedParticles& snapped,
                                   const BallBoundary& boundary, const std::vector<Moving>& balls) {
    std::vector<Moving> vertices;
    resizeOnAll(vertices, boundary.vertex.size());
    parallelRanges(vertices.size(), 1024, [&](std::size_t begin, std::size_t end) {
        NeighbourFinder finder(snapped);
        std::vector<Neighbour> neighbours;
        RigidMotionFit motion;
        std::uint32_t fitted = kHidden;  // the ball round which that was
        for (std::size_t v = begin; v < end; ++v) {
            vertices[v].position = boundary.vertex[v];
            if (particles.velocity.empty()) continue;
            const Triangle& t = boundary.triangle[v];
            const SphereEquations spheres(boundary.vertex[v], balls[t[0]], balls[t[1]], balls[t[2]]);
            if (spheres.shortfall() <= 0) {
                vertices[v].velocity = spheres.solved();
                continue;
            }
            if (const std::uint32_t ball = t[0]; ball != std::exchange(fitted, ball))
                motion = rigidMotion(particles, snapped, boundary.snapped_row[ball], finder, neighbours);
            const Vec3 offset = (boundary.vertex[v] - balls[t[0]].position) / boundary.quantum;
            vertices[v].velocity = spheres.damped(motion.velocityAt(offset));
        }
    });
    return vertices;
}

namespace {

// A ball as sums take it: position and velocity.
enum Field { kX, kY, kZ, kVx, kVy, kVz, kFields };

// Over balls, y their positions from each point in units of the reach, v their velocities less the point's own drift,
// w = (1 - |y|²)⁴: Σw, Σw y, Σw v, Σw y × v, Σw of xx, yy, zz, xy, yz, zx, and Σw v·v.
enum Sum { kWeight, kPlace, kVelocity = kPlace + 3, kMoment = kVelocity + 3, kSquares = kMoment + 3,
           kEnergy = kSquares + 6, kSums };
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

// The share of something that keeps it below a limit, both given by their squares: 1 until nearly there.
double shareWithin(double square, double limit) {
    if (!(limit > 0)) return 0;
    const double over = square / limit, over4 = over * over * over * over;
    return std::pow(1 + over4 * over4, -1.0 / 16);
}

// How the liquid moves at a point.
struct LiquidMotion {
    Vec3 velocity;  // of the rigid motion that fits best
    double spread;  // root mean square of what balls do beyond it

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
        const double explained = energy > 0 ? std::min(1.0, dot(moment, moment * inertia(kLeastInertia).inverse()) / energy) : 1;
        const Vec3 spin = moment * inertia(kLeastInertia + kCalmedInertia * (1 - explained)).inverse();
        const double turning = std::clamp(dot(spin, spin * inertia(0)), 0.0, energy),
                     beyond = energy - 2 * dot(moment, spin) + turning;
        spread = std::sqrt(std::clamp(beyond - kRounding * whole, 0.0, energy));
        const Vec3 turned = cross(y, spin);
        velocity = Vec3(drift) + v + turned * shareWithin(turned.length2(), kFastestTurned * kFastestTurned * turning);
    }
};

}  // namespace

void limitVelocities(const std::vector<Moving>& balls, double reach, BetaMesh& mesh) {
    if (balls.empty()) return;
    const std::vector<Vec3> normals = vertexNormals(mesh);
    Box velocities;
    for (const Moving& ball : balls) velocities.extendBy(ball.velocity);
    const SampleCloud<kFields> cloud(
        balls.size(), [&](std::size_t b) { return balls[b].position; },
        [&](std::size_t b) {
            const Vec3f v(balls[b].velocity);
            return std::array{v.x, v.y, v.z};
        },
        reach, reach);
    cloud.forPoints(
        mesh.vertex.size(), [&](std::size_t v) { return mesh.vertex[v].position; }, Grouping::coarse,
        [&](const PointGroup& group, SomeSamples<kFields> near) {
            Lanes drift[3], sums[kSums];  // fast liquid would lose what small differences there are
            for (std::size_t lane = 0; lane < kLanes; ++lane)
                for (int k = 0; k < 3; ++k)
                    drift[k][lane] = static_cast<float>(
                        std::clamp(mesh.vertex[group.row[lane]].velocity[k], velocities.min[k], velocities.max[k]));
            forLanes(SumMotion{near, group.place, drift, sums});
            for (std::size_t lane = 0; lane < group.size; ++lane) {
                if (!(sums[kWeight][lane] > 0)) continue;
                const std::uint32_t v = group.row[lane];
                const LiquidMotion liquid(sums, lane, Vec3f(drift[0][lane], drift[1][lane], drift[2][lane]));
                const double most = kMostBeyond * liquid.spread;
                double beyond = dot(normals[v], mesh.vertex[v].velocity - liquid.velocity);
                beyond *= shareWithin(beyond * beyond, most * most);
                mesh.vertex[v].velocity = liquid.velocity + normals[v] * beyond;
            }
        });
}

}  // namespace betamesh
