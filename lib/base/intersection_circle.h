// The circle in which two equal spheres meet, and how it moves with them.

#pragma once

#include "base/dual.h"

namespace betamesh {

/// Angles run counter-clockwise round the axis from ball a to ball b, from where begin() put their zero.
class MovingCircle {
public:
    /// a, b: centres of the spheres, distinct. Where the spheres barely meet, the circle grows without bound in
    /// speed: below a tenth of the spheres' radius it is followed more and more slowly.
    MovingCircle(const Moving& a, const Moving& b, double sphere_radius);

    /// Angle zero is towards this point, which moves; anywhere, where it lies on the axis.
    void beginTowards(const Moving& point);
    /// Angle zero is anywhere, and does not turn about the axis.
    void beginAnywhere();

    Rate radius() const { return radius_; }
    double sphereRadius() const { return sphere_; }
    const Moving& centre() const { return centre_; }
    const Moving& axis() const { return axis_; }
    /// From the axis to a point, across it.
    Vec3 fromAxis(const Vec3& point) const {
        const Vec3 offset = point - centre_.position;
        return offset - axis_.position * dot(offset, axis_.position);
    }
    /// The rate of change of a point's angle, whose value is known.
    Rate movingAngle(const Moving& point, double angle) const;
    /// Unit vector from the centre.
    Moving outwards(Rate angle) const;

private:
    Moving across(const Moving& point) const;

    Moving centre_, axis_, first_, second_;
    Rate radius_;
    double sphere_;
};

}  // namespace betamesh
