
#include "planar/velocity.h"

#include "base/parallel.h"
#include "base/rigid_motion.h"
#include "planar/scaled_points.h"
#include "skin/limit_velocities.h"

#include <algorithm>
#include <cmath>

namespace betamesh {

namespace {

constexpr double kWellConditionedInPlane = 0.05;  // |q1 × q2| / r² from which on the equations are solved exactly
constexpr double kDamping = 0.25;                 // root of the weight of the rigid motion where |q1 × q2| = 0

Vec3 rotatedLeft(const Vec3& a) { return {-a.y, a.x, 0}; }

// The motion of the liquid at a point.
struct LocalMotion {
    Vec3 velocity;       // of the best rigid motion
    double mean_square;  // of the discs' velocities relative to it and of the changes of their radii
};

class LocalMotions {
public:
    LocalMotions(const DiscBoundary& boundary, const std::vector<DualVec3>& discs)
        : boundary_(boundary),
          discs_(discs),
          radius_(boundary.worldRadius()),
          scale_(boundary.scales()),
          cells_(
              discs.size(), 2 * radius_, [&](std::size_t d) { return discs[d].position; }, scale_) {}

    // scale: of the discs at the point
    LocalMotion at(const Vec3& point, double scale) const {
        const auto forDiscs = [&](const auto& visit) {  // visit(disc, offset, weight)
            cells_.forNear(point, radius_, radius_ * scale, [&](std::uint32_t d) {
                const Vec3 offset = discs_[d].position - point;
                const double reach = radius_ * ((scale_.empty() ? 1 : scale_[d]) + scale);
                const double t = 1 - offset.length2() / (reach * reach);
                if (t > 0) visit(d, offset, t * t);
            });
        };
        RigidMotionFit fit;
        forDiscs(
            [&](std::uint32_t d, const Vec3& offset, double weight) { fit.add(offset, discs_[d].velocity, weight); });
        double squares = 0, weights = 0;
        forDiscs([&](std::uint32_t d, const Vec3& offset, double weight) {
            const double growth = boundary_.worldRadiusOf(d).rate;
            squares += weight * ((discs_[d].velocity - fit.velocityAt(offset)).length2() + growth * growth);
            weights += weight;
        });
        return {fit.velocityAt(Vec3(0)), weights > 0 ? squares / weights : 0};
    }

private:
    const DiscBoundary& boundary_;
    const std::vector<DualVec3>& discs_;
    double radius_;
    std::vector<double> scale_;
    ScaledPoints cells_;
};

// A circle on which a vertex stays: the direction from its centre, the centre's velocity, the change of its radius.
struct Circle {
    Vec3 direction, velocity;
    double growth;
};

// Solves q·(ċ - v) = ṙ for two circles, regularised towards `prior` where the equations are ill-conditioned.
Vec3 vertexVelocity(const Circle& one, const Circle& other, const Vec3& prior) {
    const Vec3 &q1 = one.direction, &q2 = other.direction;
    const double determinant = crossZ(q1, q2), shortfall = 1 - std::abs(determinant) / kWellConditionedInPlane;
    const double s1 = dot(q1, one.velocity - prior) + one.growth, s2 = dot(q2, other.velocity - prior) + other.growth;
    if (shortfall <= 0) return prior + (rotatedLeft(q1) * s2 - rotatedLeft(q2) * s1) / determinant;
    // Damped least squares: the third equation, of small weight, is ċ = prior.
    const double damping = kDamping * shortfall * shortfall, weight = damping * damping;
    const double xx = q1.x * q1.x + q2.x * q2.x + weight, yy = q1.y * q1.y + q2.y * q2.y + weight,
                 xy = q1.x * q1.y + q2.x * q2.y;
    const Vec3 right_side = q1 * s1 + q2 * s2;
    return prior +
           Vec3(yy * right_side.x - xy * right_side.y, xx * right_side.y - xy * right_side.x, 0) / (xx * yy - xy * xy);
}

}  // namespace

std::vector<DualVec3> movingDiscs(const DiscBoundary& boundary, const Particles& particles) {
    std::vector<DualVec3> discs(boundary.position.size());
    for (std::size_t d = 0; d < discs.size(); ++d) {
        discs[d].position = boundary.centre(d);
        if (particles.velocity.empty()) continue;
        const Vec3f& v = particles.velocity[boundary.row[d]];
        discs[d].velocity = Vec3(v.x, v.y, 0);
    }
    return discs;
}

std::vector<DualVec3> boundaryVertices(const DiscBoundary& boundary, const std::vector<DualVec3>& discs) {
    std::vector<DualVec3> vertices(boundary.vertex.size());
    const LocalMotions motions(boundary, discs);
    parallelFor(vertices.size(), 512, [&](std::size_t v) {
        const auto [from, to] = boundary.segment[v];
        const Vec3 c = boundary.vertex[v], q1 = (c - discs[from].position).normalized(),
                   q2 = (c - discs[to].position).normalized();
        const bool ill_conditioned = std::abs(crossZ(q1, q2)) < kWellConditionedInPlane;
        const Vec3 prior = ill_conditioned ? motions.at(c, boundary.movingScaleOfVertex(v).value).velocity
                                           : (discs[from].velocity + discs[to].velocity) / 2;
        vertices[v] = {c, vertexVelocity({q1, discs[from].velocity, boundary.worldRadiusOf(from).rate},
                                         {q2, discs[to].velocity, boundary.worldRadiusOf(to).rate}, prior)};
    });
    return vertices;
}

void limitVelocities(const DiscBoundary& boundary, const std::vector<DualVec3>& discs, BetaCurve& curve) {
    const LocalMotions motions(boundary, discs);
    std::vector<Vec3> normals(curve.vertex.size());
    forEveryVertex(curve, [&](std::uint32_t before, std::uint32_t v, std::uint32_t after) {
        const Vec3 &a = curve.vertex[before].position, &b = curve.vertex[v].position, &c = curve.vertex[after].position;
        normals[v] = -rotatedLeft((b - a).normalized() + (c - b).normalized()).normalized();
    });
    parallelFor(normals.size(), 256, [&](std::size_t v) {
        DualVec3& vertex = curve.vertex[v];
        const LocalMotion liquid = motions.at(vertex.position, curve.scaleOf(v).value);
        const double relative = dot(normals[v], vertex.velocity - liquid.velocity);
        vertex.velocity =
            liquid.velocity + normals[v] * (relative * limitingFactor(relative * relative, liquid.mean_square));
    });
}

}  // namespace betamesh
