#include "preview/camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace betamesh {
namespace {

constexpr double kRadians = std::numbers::pi / 180;
constexpr double kLeastDistance = 1e-6;  // from a single point, world units

struct Axes {
    Vec3 right, up, forward;
};

Axes axesOf(const Vec3& forward, const Vec3& up) {
    Vec3 right = cross(forward, up);
    if (right.length() < 1e-9)  // straight up or down
        right = cross(forward, std::abs(up.z) < 0.5 ? Vec3(0, 0, -1) : Vec3(0, 1, 0));
    right.normalize();
    return {right, cross(right, forward), forward};
}

}  // namespace

void Bounds::add(const Vec3& point, double radius) {
    for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], point[axis] - radius);
        high[axis] = std::max(high[axis], point[axis] + radius);
    }
}

void Bounds::add(const Bounds& other) {
    for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], other.low[axis]);
        high[axis] = std::max(high[axis], other.high[axis]);
    }
}

Bounds boundsOf(const Mesh& mesh, const Spheres& spheres) {
    Bounds bounds;
    forPoints(mesh, spheres, [&](const Vec3& p, double radius) { bounds.add(p, radius); });
    return bounds;
}

CameraFinder::CameraFinder(const Framing& framing, double aspect) : framing_(framing) {
    const double azimuth = framing.azimuth * kRadians, elevation = framing.elevation * kRadians;
    const Vec3 back = framing.up.z > 0.5 ? Vec3(0, -1, 0) : Vec3(0, 0, 1), side = cross(framing.up, back);
    const Vec3 horizontal = back * std::cos(azimuth) + side * std::sin(azimuth);
    const Axes axes = axesOf(-(horizontal * std::cos(elevation) + framing.up * std::sin(elevation)), framing.up);
    right_ = axes.right, up_ = axes.up, forward_ = axes.forward;
    const double slope = std::tan(framing.fov * kRadians / 2) * (1 - 2 * framing.margin);
    slope_ = {slope * aspect, slope};
    above_.fill(-Bounds::kNone);
    below_.fill(-Bounds::kNone);
}

// A camera at x across and d behind the origin has a point at (a across, b along) in the picture where
// |a - x| <= slope (b + d). Every point bounds x + slope d and slope d - x from below.
void CameraFinder::add(const Vec3& centre, double radius) {
    const double along = dot(centre, forward_), across[] = {dot(centre, right_), dot(centre, up_)};
    for (std::size_t i = 0; i < 2; ++i) {
        const double round = radius * std::sqrt(1 + slope_[i] * slope_[i]);  // a ball touches the edge with its side
        above_[i] = std::max(above_[i], across[i] - slope_[i] * along + round);
        below_[i] = std::max(below_[i], -across[i] - slope_[i] * along + round);
    }
    nearest_ = std::min(nearest_, along - radius);
}

void CameraFinder::add(const CameraFinder& other) {
    for (std::size_t i = 0; i < 2; ++i) {
        above_[i] = std::max(above_[i], other.above_[i]);
        below_[i] = std::max(below_[i], other.below_[i]);
    }
    nearest_ = std::min(nearest_, other.nearest_);
}

Camera CameraFinder::camera() const {
    if (nearest_ == Bounds::kNone) return {-forward_, {0, 0, 0}, framing_.up, framing_.fov};
    double distance = -nearest_;
    for (std::size_t i = 0; i < 2; ++i) distance = std::max(distance, (above_[i] + below_[i]) / (2 * slope_[i]));
    distance += kLeastDistance;
    const Vec3 position =
        right_ * ((above_[0] - below_[0]) / 2) + up_ * ((above_[1] - below_[1]) / 2) - forward_ * distance;
    return {position, position + forward_ * (nearest_ + distance), framing_.up, framing_.fov};
}

View::View(const Camera& camera, int width, int height)
    : position_(camera.position),
      half_width_(width / 2.0),
      half_height_(height / 2.0),
      pixel_(2 * std::tan(camera.fov * kRadians / 2) / height) {
    const Axes axes = axesOf((camera.look_at - camera.position).normalized(), camera.up);
    right_ = axes.right;
    up_ = axes.up;
    forward_ = axes.forward;
}

}  // namespace betamesh
