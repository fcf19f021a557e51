
#include "skin/velocity.h"

#include "base/index.h"
#include "base/parallel.h"
#include "base/rigid_motion.h"
#include "exact/neighbour_finder.h"
#include "skin/constants.h"

#include <algorithm>
#include <array>
#include <utility>

namespace betamesh {

namespace {

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

// The three equations of a vertex: unit directions q from the balls to it, and the velocities of the balls.
struct SphereEquations {
    Vec3 q[3];
    Vec3 velocity[3];
    double growth[3];  // rates of the radii
    double determinant;

    SphereEquations(const Vec3& vertex, const DualVec3& a, const DualVec3& b, const DualVec3& c,
                    const std::array<double, 3>& rates)
        : q{(vertex - a.position).normalized(), (vertex - b.position).normalized(), (vertex - c.position).normalized()},
          velocity{a.velocity, b.velocity, c.velocity},
          growth{rates[0], rates[1], rates[2]},
          determinant(dot(q[0], cross(q[1], q[2]))) {}

    // 1 where the equations are singular, 0 and below where they are well-conditioned.
    double illConditioning() const { return 1 - std::abs(determinant) / kWellConditioned; }
    // The right-hand sides q_m·(v_m - base) + ṙ_m: speeds along q relative to a base velocity.
    void relativeSpeeds(const Vec3& base, double speed[3]) const {
        for (int m = 0; m < 3; ++m) speed[m] = dot(q[m], velocity[m] - base) + growth[m];
    }
    Vec3 solved() const {
        const Vec3 mean = (velocity[0] + velocity[1] + velocity[2]) / 3;
        double speed[3];
        relativeSpeeds(mean, speed);
        return mean + (cross(q[1], q[2]) * speed[0] + cross(q[2], q[0]) * speed[1] + cross(q[0], q[1]) * speed[2]) /
                          determinant;
    }
    // The solution damped towards a base velocity.
    Vec3 damped(const Vec3& base) const {
        double speed[3];
        relativeSpeeds(base, speed);
        return base + dampedSolution(q, speed, kRigidMotionDamping * illConditioning() * illConditioning());
    }
};

// Rigid motion of the particles near one, as a function of the offset from it in quanta.
RigidMotionFit rigidMotion(const Particles& particles, const SnappedParticles& snapped, std::uint32_t around,
                           NeighbourFinder& finder, std::vector<Neighbour>& neighbours) {
    const auto own = static_cast<std::int32_t>(snapped.radiusOf(around));
    finder.find(around, neighbours);
    neighbours.push_back({Vec3(0, 0, 0), 0, around, own});
    RigidMotionFit fit;
    if (particles.velocity.empty()) return fit;
    for (const Neighbour& n : neighbours) {
        const double reach = static_cast<double>(own) + n.radius,
                     w = 1 - n.squaredDistance() / (1.0001 * (reach * reach));
        fit.add(n.offset, Vec3(particles.velocity[snapped.row[n.particle]]), w * w);
    }
    return fit;
}

}  // namespace

std::vector<DualVec3> ballCentres(const BallBoundary& boundary, const Particles& particles) {
    std::vector<DualVec3> balls;
    firstTouchResize(balls, boundary.position.size());
    parallelFor(balls.size(), 4096, [&](std::size_t b) {
        balls[b].position = boundary.centre(b);
        if (!particles.velocity.empty()) balls[b].velocity = Vec3(particles.velocity[boundary.row[b]]);
    });
    return balls;
}

std::vector<DualVec3> boundaryVertices(const Particles& particles, const SnappedParticles& snapped,
                                       const BallBoundary& boundary, const std::vector<DualVec3>& balls) {
    std::vector<DualVec3> vertices;
    firstTouchResize(vertices, boundary.vertex.size());
    parallelRanges(vertices.size(), 1024, [&](std::size_t begin, std::size_t end) {
        NeighbourFinder finder(snapped);
        std::vector<Neighbour> neighbours;
        RigidMotionFit motion;
        std::uint32_t fitted = kInvalidIndex;  // ball of the last fit: neighbouring vertices share it
        for (std::size_t v = begin; v < end; ++v) {
            vertices[v].position = boundary.vertex[v];
            if (particles.velocity.empty() && boundary.radius_rate.empty()) continue;
            const Triangle& t = boundary.triangle[v];
            const auto rate = [&](std::size_t m) { return boundary.worldRadiusOf(t[m]).rate; };
            const SphereEquations spheres(boundary.vertex[v], balls[t[0]], balls[t[1]], balls[t[2]],
                                          {rate(0), rate(1), rate(2)});
            if (spheres.illConditioning() <= 0) {
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

}  // namespace betamesh
