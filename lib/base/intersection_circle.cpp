
#include "base/intersection_circle.h"

#include "base/angles.h"

#include <algorithm>
#include <cmath>

namespace betamesh {

namespace {

// Sphere radii. Derivatives divide by at least this radius, so those of smaller circles are damped.
constexpr double kLeastRadius = 0.1;

}  // namespace

IntersectionCircle::IntersectionCircle(const DualVec3& a, const DualVec3& b, double sphere_radius)
    : centre_((a + b) * 0.5), sphere_(sphere_radius) {
    const DualVec3 span = b - a;
    const Dual half = length(span) / 2;
    axis_ = normalized(span);
    radius_.value = std::sqrt(std::max(0.0, (sphere_ - half.value) * (sphere_ + half.value)));
    radius_.rate = -half.value * half.rate / std::max(radius_.value, kLeastRadius * sphere_);
}

DualVec3 IntersectionCircle::rejection(const DualVec3& point) const {
    const DualVec3 offset = point - centre_;
    return offset - axis_ * dot(offset, axis_);
}

void IntersectionCircle::beginTowards(const DualVec3& point) {
    const DualVec3 offset = rejection(point);
    if (!(offset.position.length2() > 0)) return beginAnywhere();
    first_ = normalized(offset);
    const double distance = offset.position.length();
    if (distance < kLeastRadius * sphere_) first_.velocity *= distance / (kLeastRadius * sphere_);
    second_ = cross(axis_, first_);
}

void IntersectionCircle::beginAnywhere() {
    const Vec3 other = std::abs(axis_.position.x) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
    first_.position = cross(axis_.position, other).normalized();
    first_.velocity = axis_.position * -dot(axis_.velocity, first_.position);
    second_ = cross(axis_, first_);
}

Dual IntersectionCircle::angleRate(const DualVec3& point, double angle) const {
    const DualVec3 offset = rejection(point);
    const Dual x = dot(offset, first_), y = dot(offset, second_);
    const double least = kLeastRadius * sphere_;
    return {angle,
            (x.value * y.rate - y.value * x.rate) / std::max(x.value * x.value + y.value * y.value, least * least)};
}

DualVec3 IntersectionCircle::outwards(Dual angle) const {
    const auto [s, c] = sineCosine(angle.value);
    return first_ * Dual{c, -s * angle.rate} + second_ * Dual{s, c * angle.rate};
}

}  // namespace betamesh
