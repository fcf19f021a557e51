// Where a picture is taken from.

#pragma once

#include "core/mesh.h"

#include <array>
#include <limits>

namespace betamesh {

/// The box round points; low > high where there are none.
struct Bounds {
    Vec3 low{kNone, kNone, kNone}, high{-kNone, -kNone, -kNone};

    static constexpr double kNone = std::numeric_limits<double>::max();
    bool empty() const { return !(low.x <= high.x); }
    Vec3 centre() const { return empty() ? Vec3(0, 0, 0) : (low + high) / 2; }
    double diagonal() const { return empty() ? 0 : (high - low).length(); }
    void add(const Vec3& point, double radius);
    void add(const Bounds& other);
};

/// Calls visit(centre, radius) for every finite vertex that a triangle uses, once or more, and every sphere.
template <typename Visit>
void forPoints(const Mesh& mesh, const Spheres& spheres, const Visit& visit) {
    const auto ifFinite = [&](const Vec3& p, double radius) {
        if (isFinite(p)) visit(p, radius);
    };
    for (const Triangle& t : mesh.triangles)
        for (const std::uint32_t corner : t) ifFinite(mesh.position[corner], 0.0);
    for (std::size_t i = 0; i < spheres.size(); ++i)
        ifFinite(spheres.position[i], static_cast<double>(spheres.radius[i]));
}

Bounds boundsOf(const Mesh& mesh, const Spheres& spheres);

/// A pinhole.
struct Camera {
    Vec3 position{0, 0, 1};
    Vec3 look_at{0, 0, 0};
    Vec3 up{0, 1, 0};
    double fov = 30;  ///< degrees, across the height of the picture, (0, 180)
};

/// How a camera that finds its own place looks at things.
struct Framing {
    Vec3 up{0, 1, 0};  ///< an axis
    double azimuth =
        30;  ///< degrees round `up`, counter-clockwise seen from above; 0: from +z, or from -y where z is up
    double elevation = 20;  ///< degrees above the horizon, (-90, 90)
    double fov = 30;        ///< as Camera::fov
    double margin = 0.06;   ///< of the picture that stays free on each side, [0, 0.5)
};

/// Finds the nearest camera that has all of many balls in the picture, one by one in any order.
class CameraFinder {
public:
    /// aspect: width / height.
    CameraFinder(const Framing& framing, double aspect);

    void add(const Vec3& centre, double radius);
    /// other: of the same framing.
    void add(const CameraFinder& other);
    /// Of nothing: one that looks at the origin.
    Camera camera() const;

private:
    Framing framing_;
    Vec3 right_, up_, forward_;
    std::array<double, 2> slope_;          // of the edges of what may be filled, across and up
    std::array<double, 2> above_, below_;  // how far the edges must reach, from a camera at the origin
    double nearest_ = Bounds::kNone;       // along forward
};

/// Pixels and directions of a camera. Pixel (x, y) covers [x, x + 1) × [y, y + 1) from the top left.
class View {
public:
    View(const Camera& camera, int width, int height);

    const Vec3& position() const { return position_; }
    const Vec3& right() const { return right_; }
    const Vec3& up() const { return up_; }
    const Vec3& forward() const { return forward_; }
    /// The size of a pixel at a distance of one along the axis.
    double pixel() const { return pixel_; }

    /// As long as its way along the axis is one.
    Vec3 direction(double x, double y) const {
        return forward_ + right_ * ((x - half_width_) * pixel_) + up_ * ((half_height_ - y) * pixel_);
    }
    double depth(const Vec3& point) const { return dot(point - position_, forward_); }
    /// Where a point in front of the camera is seen: x, y.
    std::array<double, 2> seen(const Vec3& point) const {
        const Vec3 way = point - position_;
        const double scale = 1 / (dot(way, forward_) * pixel_);
        return {half_width_ + dot(way, right_) * scale, half_height_ - dot(way, up_) * scale};
    }

private:
    Vec3 position_, right_, up_, forward_;
    double half_width_, half_height_, pixel_;
};

}  // namespace betamesh
