
#include "base/rigid_motion.h"

namespace betamesh {

Vec3 RigidMotionFit::angularVelocity() const {
    if (!(weight_ > 0)) return Vec3(0);
    const Vec3 centre = position_ / weight_, moment = moment_ - cross(centre, velocity_);
    const double xx = squares_[0] - weight_ * centre.x * centre.x, yy = squares_[1] - weight_ * centre.y * centre.y,
                 zz = squares_[2] - weight_ * centre.z * centre.z, xy = squares_[3] - weight_ * centre.x * centre.y,
                 yz = squares_[4] - weight_ * centre.y * centre.z, zx = squares_[5] - weight_ * centre.z * centre.x;
    const double trace = xx + yy + zz;
    if (!(trace > 0)) return Vec3(0);
    const double floor = 1e-9 * trace;  // keeps lines invertible; far below the moments of points off a line
    const Mat33 inertia(yy + zz + floor, -xy, -zx, -xy, zz + xx + floor, -yz, -zx, -yz, xx + yy + floor);
    return moment * inertia.inverse();
}

Vec3 RigidMotionFit::velocityAt(const Vec3& position) const {
    if (!(weight_ > 0)) return Vec3(0);
    return origin_velocity_ + velocity_ / weight_ + cross(angularVelocity(), position - origin_ - position_ / weight_);
}

}  // namespace betamesh
