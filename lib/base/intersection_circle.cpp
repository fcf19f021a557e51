
#include "base/intersection_circle.h"

#include "base/angles.h"

#include <algorithm>
#include <cmath>

namespace betamesh {

namespace {

// Radii of the smaller sphere. Derivatives divide by at least this radius, so those of smaller circles are damped.
constexpr double kLeastRadius = 0.1;

}  // namespace

IntersectionCircle::IntersectionCircle(const DualVec3& a, Dual radius_a, const DualVec3& b, Dual radius_b)
    : centre_((a + b) * 0.5), sphere_(radius_a.value < radius_b.value ? radius_a : radius_b) {
    const DualVec3 span = b - a;
    const Dual distance = length(span);
    axis_ = normalized(span);
    const Dual off_middle = (radius_a * radius_a - radius_b * radius_b) / (distance * 2);
    centre_ = centre_ + axis_ * off_middle;
    const Dual from_a = distance / 2 + off_middle;
    radius_.value = std::sqrt(std::max(0.0, (radius_a.value - from_a.value) * (radius_a.value + from_a.value)));
    radius_.rate = (radius_a.value * radius_a.rate - from_a.value * from_a.rate) /
                   std::max(radius_.value, kLeastRadius * sphere_.value);
}

DualVec3 IntersectionCircle::rejection(const DualVec3& point) const {
    const DualVec3 offset = point - centre_;
    return offset - axis_ * dot(offset, axis_);
}

void IntersectionCircle::setZeroTowards(const DualVec3& point) {
    const DualVec3 offset = rejection(point);
    if (!(offset.position.length2() > 0)) return setZeroAnywhere();
    first_ = normalized(offset);
    const double distance = offset.position.length();
    if (const double least = kLeastRadius * sphere_.value; distance < least) first_.velocity *= distance / least;
    second_ = cross(axis_, first_);
}

void IntersectionCircle::setZeroAnywhere() {
    const Vec3 other = std::abs(axis_.position.x) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
    first_.position = cross(axis_.position, other).normalized();
    first_.velocity = axis_.position * -dot(axis_.velocity, first_.position);
    second_ = cross(axis_, first_);
}

Dual IntersectionCircle::angleOfPoint(const DualVec3& point, double angle) const {
    const DualVec3 offset = rejection(point);
    const Dual x = dot(offset, first_), y = dot(offset, second_);
    const double least = kLeastRadius * sphere_.value;
    return {angle,
            (x.value * y.rate - y.value * x.rate) / std::max(x.value * x.value + y.value * y.value, least * least)};
}

DualVec3 IntersectionCircle::outwards(Dual angle) const {
    const auto [s, c] = sineCosine(angle.value);
    return first_ * Dual{c, -s * angle.rate} + second_ * Dual{s, c * angle.rate};
}

}  // namespace betamesh
