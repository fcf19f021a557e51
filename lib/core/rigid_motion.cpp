#include "core/rigid_motion.h"

#include "core/simd.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace betamesh {

namespace {

typedef double Eight __attribute__((vector_size(MovingColumns::kAtOnce * sizeof(double))));

// Σw, Σw x, Σw v, Σw x × v, Σw v·v, Σw of xx, yy, zz, xy, yz, zx.
using Sums = std::array<double, 17>;

BETAMESH_EVERY_CPU
void sumNear(const MovingColumns& points, const Moving& centre, double reach, Sums& sums) {
    const double cx = centre.position.x, cy = centre.position.y, cz = centre.position.z;
    const double cu = centre.velocity.x, cv = centre.velocity.y, cw = centre.velocity.z;
    const double inverse_square = 1 / (reach * reach);
    const auto at = [](const std::vector<double>& column, std::size_t i, Eight& some) {
        std::memcpy(&some, &column[i], sizeof some);
    };
    Eight sum[17] = {};
    for (std::size_t i = 0; i < points.x.size(); i += MovingColumns::kAtOnce) {
        Eight x, y, z, u, v, w;
        at(points.x, i, x), at(points.y, i, y), at(points.z, i, z);
        at(points.vx, i, u), at(points.vy, i, v), at(points.vz, i, w);
        x -= cx, y -= cy, z -= cz, u -= cu, v -= cv, w -= cw;
        Eight near = 1 - (x * x + y * y + z * z) * inverse_square;
        near = near > 0 ? near : Eight{};
        const Eight weight = near * near, wx = weight * x, wy = weight * y, wz = weight * z;
        sum[0] += weight;
        sum[1] += wx, sum[2] += wy, sum[3] += wz;
        sum[4] += weight * u, sum[5] += weight * v, sum[6] += weight * w;
        sum[7] += wy * w - wz * v, sum[8] += wz * u - wx * w, sum[9] += wx * v - wy * u;
        sum[10] += weight * (u * u + v * v + w * w);
        sum[11] += wx * x, sum[12] += wy * y, sum[13] += wz * z;
        sum[14] += wx * y, sum[15] += wy * z, sum[16] += wz * x;
    }
    for (std::size_t k = 0; k < sums.size(); ++k) {
        sums[k] = 0;
        for (std::size_t lane = 0; lane < MovingColumns::kAtOnce; ++lane) sums[k] += sum[k][lane];
    }
}

}  // namespace

RigidMotionFit::RigidMotionFit(const MovingColumns& points, const Moving& centre, double reach) {
    Sums sums;
    sumNear(points, centre, reach, sums);
    drift_ = centre.velocity;
    weight_ = sums[0];
    position_ = Vec3(sums[1], sums[2], sums[3]);
    velocity_ = Vec3(sums[4], sums[5], sums[6]);
    moment_ = Vec3(sums[7], sums[8], sums[9]);
    energy_ = sums[10];
    std::copy(sums.begin() + 11, sums.end(), squares_);
}

Vec3 RigidMotionFit::spin() const {
    if (!(weight_ > 0)) return Vec3(0);
    const Vec3 centre = position_ / weight_, moment = moment_ - cross(centre, velocity_);
    const double xx = squares_[0] - weight_ * centre.x * centre.x, yy = squares_[1] - weight_ * centre.y * centre.y,
                 zz = squares_[2] - weight_ * centre.z * centre.z, xy = squares_[3] - weight_ * centre.x * centre.y,
                 yz = squares_[4] - weight_ * centre.y * centre.z, zx = squares_[5] - weight_ * centre.z * centre.x;
    const double trace = xx + yy + zz;
    if (!(trace > 0)) return Vec3(0);
    const double floor = 1e-9 * trace;  // far below what any three points off a line have
    const Mat33 inertia(yy + zz + floor, -xy, -zx, -xy, zz + xx + floor, -yz, -zx, -yz, xx + yy + floor);
    return moment * inertia.inverse();
}

Vec3 RigidMotionFit::velocityAt(const Vec3& position) const {
    if (!(weight_ > 0)) return Vec3(0);
    return drift_ + velocity_ / weight_ + cross(spin(), position - origin_ - position_ / weight_);
}

double RigidMotionFit::rigidity(const Vec3& spin) const {
    const double all = weight_ > 0 ? energy_ - dot(velocity_, velocity_) / weight_ : 0;
    if (!(all > 0)) return 1;
    return std::clamp(dot(spin, moment_ - cross(position_ / weight_, velocity_)) / all, 0.0, 1.0);
}

}  // namespace betamesh
