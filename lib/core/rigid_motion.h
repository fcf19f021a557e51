// The rigid motion that explains the velocities of some points best.

#pragma once

#include "core/moving.h"

#include <vector>

namespace betamesh {

/// Points that move, by column, filled up to whole registers.
struct MovingColumns {
    static constexpr std::size_t kAtOnce = 8;
    std::vector<double> x, y, z, vx, vy, vz;

    void clear() {
        for (std::vector<double>* column : {&x, &y, &z, &vx, &vy, &vz}) column->clear();
    }
    void add(const Moving& point) {
        x.push_back(point.position.x), y.push_back(point.position.y), z.push_back(point.position.z);
        vx.push_back(point.velocity.x), vy.push_back(point.velocity.y), vz.push_back(point.velocity.z);
    }
    /// far: out of everyone's reach.
    void fillUp(const Vec3& far) {
        while (x.size() % kAtOnce != 0) add({far, Vec3(0)});
    }
};

/// Weighted least squares over points added one by one; their order does not matter but for rounding. Everything is
/// counted from the first point, so that a single one determines its velocity and no rotation.
/// Where the points leave a rotation undetermined (one point, a line) it is the smallest one.
class RigidMotionFit {
public:
    RigidMotionFit() = default;
    /// Of all points within reach of one, with weights (1 - (distance / reach)²)². Counts positions from there and
    /// velocities as they are; its own velocity is taken for the drift.
    RigidMotionFit(const MovingColumns& points, const Moving& centre, double reach);
    /// weight >= 0.
    void add(const Vec3& position, const Vec3& velocity, double weight) {
        if (weight_ == 0) origin_ = position, drift_ = velocity;
        const Vec3 x = position - origin_, v = velocity - drift_;
        weight_ += weight;
        position_ += x * weight;
        velocity_ += v * weight;
        moment_ += cross(x, v) * weight;
        energy_ += dot(v, v) * weight;
        const double squares[6] = {x.x * x.x, x.y * x.y, x.z * x.z, x.x * x.y, x.y * x.z, x.z * x.x};
        for (int k = 0; k < 6; ++k) squares_[k] += weight * squares[k];
    }
    /// The velocity of the fitted motion at a point; zero when nothing was added.
    Vec3 velocityAt(const Vec3& position) const;
    /// Its angular velocity, radians per second.
    Vec3 spin() const;
    /// How much of the motion relative to their centre this angular velocity explains, which is theirs: from 0 to 1,
    /// where the points move as a rigid body.
    double rigidity(const Vec3& spin) const;

private:
    double weight_ = 0;
    Vec3 origin_{0, 0, 0}, drift_{0, 0, 0};                         // the first position and velocity
    Vec3 position_{0, 0, 0}, velocity_{0, 0, 0}, moment_{0, 0, 0};  // Σw x, Σw v, Σw x × v
    double energy_ = 0;                                             // Σw v·v
    double squares_[6] = {};                                        // Σw of xx, yy, zz, xy, yz, zx
};

}  // namespace betamesh
