// Weighted least-squares fit of a rigid motion to the velocities of points.

#pragma once

#include "base/dual.h"

namespace betamesh {

/// The rigid motion that fits the velocities of weighted points best. Points are added one by one; their order matters
/// for rounding only. Positions and velocities are taken relative to the first point, so that floating-point sums stay
/// accurate far from the origin. Where the points do not determine a rotation (a single point, a line), the smallest
/// one is used.
class RigidMotionFit {
public:
    /// Adds a point; weight >= 0.
    void add(const Vec3& position, const Vec3& velocity, double weight) {
        if (weight_ == 0) origin_ = position, origin_velocity_ = velocity;
        const Vec3 x = position - origin_, v = velocity - origin_velocity_;
        weight_ += weight;
        position_ += x * weight;
        velocity_ += v * weight;
        moment_ += cross(x, v) * weight;
        const double squares[6] = {x.x * x.x, x.y * x.y, x.z * x.z, x.x * x.y, x.y * x.z, x.z * x.x};
        for (int k = 0; k < 6; ++k) squares_[k] += weight * squares[k];
    }
    /// Velocity of the fitted motion at a point; zero if no weight was added.
    Vec3 velocityAt(const Vec3& position) const;
    /// Angular velocity of the fitted motion, radians per second.
    Vec3 angularVelocity() const;

private:
    double weight_ = 0;
    Vec3 origin_{0, 0, 0}, origin_velocity_{0, 0, 0};               // of the first point
    Vec3 position_{0, 0, 0}, velocity_{0, 0, 0}, moment_{0, 0, 0};  // Σw x, Σw v, Σw x × v
    double squares_[6] = {};                                        // Σw of xx, yy, zz, xy, yz, zx
};

}  // namespace betamesh
