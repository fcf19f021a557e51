
#include "planar/velocity.h"

#include "base/cell_grid.h"
#include "base/parallel.h"
#include "base/rigid_motion.h"

#include <algorithm>
#include <cmath>

namespace betamesh {

namespace {

constexpr double kWellConditionedInPlane = 0.05;  // |q1 × q2| / r² from which on the equations are solved exactly
constexpr double kDamping = 0.25;                 // root of the weight of the rigid motion where |q1 × q2| = 0

Vec3 rotatedLeft(const Vec3& a) { return {-a.y, a.x, 0}; }

// The motion of the liquid near a point.
class LocalMotion {
public:
    LocalMotion(const DiscBoundary& boundary, const std::vector<DualVec3>& discs)
        : discs_(discs),
          reach_(2 * boundary.worldRadius()),
          cells_(discs.size(), reach_, [&](std::size_t d) { return discs[d].position; }) {}

    Vec3 at(const Vec3& point) const {
        RigidMotionFit fit;
        cells_.forRowsIn(point - Vec3(reach_, reach_, 0), point + Vec3(reach_, reach_, 0), [&](std::uint32_t d) {
            const Vec3 offset = discs_[d].position - point;
            const double t = 1 - offset.length2() / (reach_ * reach_);
            if (t > 0) fit.add(offset, discs_[d].velocity, t * t);
        });
        return fit.velocityAt(Vec3(0));
    }

private:
    const std::vector<DualVec3>& discs_;
    double reach_;
    CellGrid cells_;
};

// Solves q1·ċ = q1·v1 and q2·ċ = q2·v2 for ċ, regularised towards `prior` where they are ill-conditioned.
Vec3 vertexVelocity(const Vec3& q1, const Vec3& v1, const Vec3& q2, const Vec3& v2, const Vec3& prior) {
    const double determinant = crossZ(q1, q2), shortfall = 1 - std::abs(determinant) / kWellConditionedInPlane;
    const double s1 = dot(q1, v1 - prior), s2 = dot(q2, v2 - prior);
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
    const LocalMotion motion(boundary, discs);
    parallelFor(vertices.size(), 512, [&](std::size_t v) {
        const auto [from, to] = boundary.segment[v];
        const Vec3 c = boundary.vertex[v], q1 = (c - discs[from].position).normalized(),
                   q2 = (c - discs[to].position).normalized();
        const bool ill_conditioned = std::abs(crossZ(q1, q2)) < kWellConditionedInPlane;
        const Vec3 prior = ill_conditioned ? motion.at(c) : (discs[from].velocity + discs[to].velocity) / 2;
        vertices[v] = {c, vertexVelocity(q1, discs[from].velocity, q2, discs[to].velocity, prior)};
    });
    return vertices;
}

void projectTangentialVelocity(const DiscBoundary& boundary, const std::vector<DualVec3>& discs, BetaCurve& curve) {
    const LocalMotion motion(boundary, discs);
    std::vector<Vec3> normals(curve.vertex.size());
    forEveryVertex(curve, [&](std::uint32_t before, std::uint32_t v, std::uint32_t after) {
        const Vec3 &a = curve.vertex[before].position, &b = curve.vertex[v].position, &c = curve.vertex[after].position;
        normals[v] = -rotatedLeft((b - a).normalized() + (c - b).normalized()).normalized();
    });
    parallelFor(normals.size(), 256, [&](std::size_t v) {
        DualVec3& vertex = curve.vertex[v];
        const Vec3 liquid = motion.at(vertex.position);
        vertex.velocity = liquid + normals[v] * dot(normals[v], vertex.velocity - liquid);
    });
}

}  // namespace betamesh
