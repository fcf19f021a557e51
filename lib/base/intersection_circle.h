// The circle in which two equal spheres meet, and how it moves with them.

#pragma once

#include "base/dual.h"

namespace betamesh {

/// Angles run counter-clockwise round the axis from ball a to ball b, from where begin() put their zero.
class IntersectionCircle {
public:
    /// a, b: centres of the spheres, distinct. Where the spheres barely meet, the circle grows without bound in
    /// speed: below a tenth of the spheres' radius it is followed more and more slowly.
    IntersectionCircle(const DualVec3& a, const DualVec3& b, double sphere_radius);

    /// Angle zero is towards this point, which moves; anywhere, where it lies on the axis.
    void beginTowards(const DualVec3& point);
    /// Angle zero is anywhere, and does not turn about the axis.
    void beginAnywhere();

    Dual radius() const { return radius_; }
    double sphereRadius() const { return sphere_; }
    const DualVec3& centre() const { return centre_; }
    const DualVec3& axis() const { return axis_; }
    /// From the axis to a point, across it.
    Vec3 fromAxis(const Vec3& point) const {
        const Vec3 offset = point - centre_.position;
        return offset - axis_.position * dot(offset, axis_.position);
    }
    /// The rate of change of a point's angle, whose value is known.
    Dual angleRate(const DualVec3& point, double angle) const;
    /// Unit vector from the centre.
    DualVec3 outwards(Dual angle) const;

private:
    DualVec3 across(const DualVec3& point) const;

    DualVec3 centre_, axis_, first_, second_;
    Dual radius_;
    double sphere_;
};

}  // namespace betamesh
