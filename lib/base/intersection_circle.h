// The intersection circle of two spheres, with its derivative with respect to time.

#pragma once

#include "base/dual.h"

namespace betamesh {

/// How far the plane in which two spheres meet is from the centre of the first, in radii of that; negative on the side
/// away from the second. distance: of the centres; Number: double or Dual.
template <typename Number>
Number heightOfIntersection(const Number& distance, const Number& radius, const Number& other_radius) {
    return (distance + (radius * radius - other_radius * other_radius) / distance) / (2 * radius);
}

/// Angles are measured counter-clockwise round the axis from sphere a to sphere b. setZeroTowards() or
/// setZeroAnywhere() chooses the direction of angle zero and has to be called before angles are used.
class IntersectionCircle {
public:
    /// a, b: centres of the spheres, distinct, and their radii. Where the spheres barely touch, the radius of the
    /// circle changes arbitrarily fast; for circles smaller than a tenth of the smaller sphere's radius the derivatives
    /// are damped.
    IntersectionCircle(const DualVec3& a, Dual radius_a, const DualVec3& b, Dual radius_b);

    /// Angle zero points towards this moving point; an arbitrary direction if the point is on the axis.
    void setZeroTowards(const DualVec3& point);
    /// Angle zero is an arbitrary direction, which does not rotate about the axis.
    void setZeroAnywhere();

    Dual radius() const { return radius_; }
    /// Of the smaller sphere.
    Dual sphereRadius() const { return sphere_; }
    const DualVec3& centre() const { return centre_; }
    const DualVec3& axis() const { return axis_; }
    /// The vector from the axis to a point, perpendicular to the axis.
    Vec3 fromAxis(const Vec3& point) const {
        const Vec3 offset = point - centre_.position;
        return offset - axis_.position * dot(offset, axis_.position);
    }
    /// A point's angle with its derivative; the value of the angle is given.
    Dual angleOfPoint(const DualVec3& point, double angle) const;
    /// Unit vector from the centre of the circle in the direction of an angle.
    DualVec3 outwards(Dual angle) const;

private:
    DualVec3 rejection(const DualVec3& point) const;  // fromAxis() as a dual vector

    DualVec3 centre_, axis_, first_, second_;  // first_, second_: unit vectors of angles 0 and π/2
    Dual radius_;
    Dual sphere_;  // radius of the smaller sphere
};

}  // namespace betamesh
