// The rigid motion that explains the velocities of some points best.

#pragma once

#include "base/dual.h"

namespace betamesh {

/// Weighted least squares over points added one by one; their order does not matter but for rounding. Everything is
/// counted from the first point, so that a single one determines its velocity and no rotation.
/// Where the points leave a rotation undetermined (one point, a line) it is the smallest one.
class RigidMotionFit {
public:
    /// weight >= 0.
    void add(const Vec3& position, const Vec3& velocity, double weight) {
        if (weight_ == 0) origin_ = position, drift_ = velocity;
        const Vec3 x = position - origin_, v = velocity - drift_;
        weight_ += weight;
        position_ += x * weight;
        velocity_ += v * weight;
        moment_ += cross(x, v) * weight;
        const double squares[6] = {x.x * x.x, x.y * x.y, x.z * x.z, x.x * x.y, x.y * x.z, x.z * x.x};
        for (int k = 0; k < 6; ++k) squares_[k] += weight * squares[k];
    }
    /// The velocity of the fitted motion at a point; zero when nothing was added.
    Vec3 velocityAt(const Vec3& position) const;
    /// Its angular velocity, radians per second.
    Vec3 spin() const;

private:
    double weight_ = 0;
    Vec3 origin_{0, 0, 0}, drift_{0, 0, 0};                         // the first position and velocity
    Vec3 position_{0, 0, 0}, velocity_{0, 0, 0}, moment_{0, 0, 0};  // Σw x, Σw v, Σw x × v
    double squares_[6] = {};                                        // Σw of xx, yy, zz, xy, yz, zx
};

}  // namespace betamesh
