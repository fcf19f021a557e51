#include "skin/velocity.h"

#include "core/cell_order.h"
#include "core/parallel.h"
#include "core/rigid_motion.h"
#include "core/sample_groups.h"

#include <algorithm>
#include <span>
#include <utility>

namespace betamesh {

namespace {

constexpr double kWellConditioned = 0.01;  // of |q1·(q2 × q3)| / r³; 99.9% of vertices lie above
constexpr double kDamping = 0.25;          // weight of the field against the three equations at condition zero

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

Spins spinsOfBalls(const BallBoundary& boundary, const std::vector<Moving>& balls, const Particles& particles) {
    const std::vector<Vec3> none(balls.size(), Vec3(0, 0, 0));
    Spins spins{none, none};
    if (particles.velocity.empty()) return spins;
    const double reach = 2 * boundary.worldRadius();
    const auto positionOf = [&](std::size_t b) -> const Vec3& { return balls[b].position; };
    const CellOrder cells(balls.size(), reach, positionOf);
    forCellsWithin(reach, cells, cells, positionOf, [&, near = MovingColumns()](auto cell, auto around) mutable {
        near.clear();
        for (const std::uint32_t b : around) near.add(balls[b]);
        near.fillUp(cells.lowestCorner(cell) - Vec3(2 * reach));
        for (const std::uint32_t b : cells.rowsOf(cell)) {
            const RigidMotionFit fit(near, balls[b], reach);
            spins.of_liquid[b] = fit.spin();
            const double rigidity = fit.rigidity(spins.of_liquid[b]), square = rigidity * rigidity;
            spins.of_points[b] = spins.of_liquid[b] * (square * square);
        }
    });
    return spins;
}

namespace {

// A ball as sums take it: position in radii, velocity, angular velocity times the radius.
enum Field { kX, kY, kZ, kVx, kVy, kVz, kSx, kSy, kSz, kFields };
using Sample = SampleFields<kFields>;

// Σ w (v + spin × y), y from each ball to the points, w = (1 - |y|²/4)² within two radii; then Σ w.
struct SumMotion {
    SomeSamples<kFields> samples;
    const Lanes (&point)[3];
    Lanes (&sums)[4];

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()(std::size_t first) const {
        using Some = Floats<kWidth>;
        Some x[3];
        getLanes<kWidth>(point, first, x);
        const Some zero{}, one = zero + 1.0F;
        Some sum[4] = {};
        for (const Sample& f : samples) {
            const Some px = x[0] - f[kX], py = x[1] - f[kY], pz = x[2] - f[kZ];
            Some t = one - (px * px + py * py + pz * pz) * 0.25F;
            t = t > 0 ? t : zero;
            const Some w = t * t;
            sum[0] += w * (f[kVx] + f[kSy] * pz - f[kSz] * py);
            sum[1] += w * (f[kVy] + f[kSz] * px - f[kSx] * pz);
            sum[2] += w * (f[kVz] + f[kSx] * py - f[kSy] * px);
            sum[3] += w;
        }
        setLanes<kWidth>(sums, first, sum);
    }
};

}  // namespace

std::vector<Vec3> liquidVelocities(const BallBoundary& boundary, const std::vector<Moving>& balls,
                                   const std::vector<Vec3>& spins, const std::vector<Moving>& points) {
    const double radius = boundary.worldRadius();
    const auto fieldsOf = [&](std::size_t b) {
        const Vec3f v(balls[b].velocity), spin(spins[b] * radius);
        return std::array{v.x, v.y, v.z, spin.x, spin.y, spin.z};
    };
    const SampleCloud<kFields> cloud(
        balls.size(), [&](std::size_t b) { return balls[b].position; }, fieldsOf, 2 * radius, radius);
    std::vector<Vec3> liquid(points.size());
    cloud.forPoints(
        points.size(), [&](std::size_t v) { return points[v].position; }, Grouping::coarse,
        [&](const PointGroup& group, SomeSamples<kFields> near) {
            Lanes sums[4];
            forLanes(SumMotion{near, group.place, sums});
            for (std::size_t lane = 0; lane < group.size; ++lane) {
                const std::uint32_t v = group.row[lane];
                liquid[v] = sums[3][lane] > 0
                                ? Vec3(sums[0][lane], sums[1][lane], sums[2][lane]) / sums[3][lane]
                                : points[v].velocity;
            }
        });
    return liquid;
}

void slideWithParticles(const BallBoundary& boundary, const std::vector<Moving>& balls, const std::vector<Vec3>& spins,
                        BetaMesh& mesh) {
    const std::vector<Vec3> normals = vertexNormals(mesh);
    const std::vector<Vec3> liquid = liquidVelocities(boundary, balls, spins, mesh.vertex);
    parallelFor(liquid.size(), 8192, [&](std::size_t v) {
        Vec3& velocity = mesh.vertex[v].velocity;
        velocity = liquid[v] + normals[v] * dot(normals[v], velocity - liquid[v]);
    });
}

}  // namespace betamesh
