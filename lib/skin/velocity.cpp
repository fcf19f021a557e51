#include "skin/velocity.h"

#include "core/parallel.h"

#include <Imath/ImathMatrix.h>

#include <algorithm>

namespace betamesh {

namespace {

constexpr double kWellConditioned = 0.05;  // of |q1·(q2 × q3)| / r³; 99.9% of vertices lie above
constexpr double kDamping = 0.25;          // of the squared residuals' weight where the condition is zero

// The ċ that minimises Σ (q_m·ċ - q_m·v_m)² + damping² |ċ|², q_m of unit length.
Vec3 dampedSolution(const Vec3 q[3], const double speed[3], double damping) {
    Imath::M33d normal;
    Vec3 right(0, 0, 0);
    for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) {
            normal[a][b] = a == b ? damping * damping : 0;
            for (int m = 0; m < 3; ++m) normal[a][b] += q[m][a] * q[m][b];
        }
    for (int m = 0; m < 3; ++m) right += q[m] * speed[m];
    return right * normal.inverse();
}

Vec3 vertexVelocity(const Vec3& vertex, const Moving ball[3]) {
    const Vec3 mean = (ball[0].velocity + ball[1].velocity + ball[2].velocity) / 3;
    Vec3 q[3];
    double speed[3];  // along q, relative to the mean
    for (int m = 0; m < 3; ++m) {
        q[m] = (vertex - ball[m].position).normalized();
        speed[m] = dot(q[m], ball[m].velocity - mean);
    }
    const double determinant = dot(q[0], cross(q[1], q[2]));
    const double shortfall = 1 - std::abs(determinant) / kWellConditioned;
    if (shortfall > 0) return mean + dampedSolution(q, speed, kDamping * shortfall * shortfall);
    return mean +
           (cross(q[1], q[2]) * speed[0] + cross(q[2], q[0]) * speed[1] + cross(q[0], q[1]) * speed[2]) / determinant;
}

}  // namespace

std::vector<Moving> movingBalls(const BallBoundary& boundary, const Particles& particles) {
    std::vector<Moving> balls(boundary.position.size());
    parallelFor(balls.size(), 4096, [&](std::size_t b) {
        balls[b].position = boundary.centre(b);
        if (!particles.velocity.empty()) balls[b].velocity = Vec3(particles.velocity[boundary.row[b]]);
    });
    return balls;
}

std::vector<Moving> movingVertices(const BallBoundary& boundary, const std::vector<Moving>& balls) {
    std::vector<Moving> vertices(boundary.vertex.size());
    parallelFor(vertices.size(), 1024, [&](std::size_t v) {
        const Triangle& t = boundary.triangle[v];
        const Moving corners[3] = {balls[t[0]], balls[t[1]], balls[t[2]]};
        vertices[v] = {boundary.vertex[v], vertexVelocity(boundary.vertex[v], corners)};
    });
    return vertices;
}

}  // namespace betamesh
