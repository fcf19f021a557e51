// Where a picture is taken from.

#pragma once

#include "betamesh/mesh.h"
#include "render/render_settings.h"

#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

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
    bool holds(const Vec3& point) const {
        return low.x <= point.x && low.y <= point.y && low.z <= point.z && point.x <= high.x && point.y <= high.y &&
               point.z <= high.z;
    }
};

/// Of every finite vertex that a triangle uses, and every sphere.
Bounds boundsOf(const Mesh& mesh, const Spheres& spheres);

/// Calls visit(centre, radius) for every finite vertex that a triangle uses, and every sphere, but not for what the cut
/// leaves away, and not for outliers: drops so far from the bulk of the surface that a few of them would make all the
/// rest small in the picture.
///
/// The bulk is the box that leaves away 3 % of the surface's area at either end of each axis. Outliers are spheres and
/// connected pieces of the mesh that are wholly farther from it, along an axis, than its longest side: a jet that is
/// still connected is none, however long.
///
/// same    for any thread count
/// cost    O(triangles + spheres); the box is that of at most 2^17 of them, evenly chosen
void forBulk(const Mesh& mesh, const Spheres& spheres, const std::optional<Cut>& cut,
             const std::function<void(const Vec3& centre, double radius)>& visit);

/// The box round what forBulk visits.
Bounds boundsOfBulk(const Mesh& mesh, const Spheres& spheres, const std::optional<Cut>& cut);

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

/// Finds the nearest camera that has all of many balls in the picture, one by one in any order, and in the middle of
/// it. It looks at the middle of their depth.
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
    // How far to either side the edges of a picture must reach, from a camera at the origin; of the whole picture that
    // may be filled, and of narrower ones that stand in its middle.
    struct Edges {
        double slope = 0, above = -Bounds::kNone, below = -Bounds::kNone;
        /// How far behind the origin a camera has all between these edges.
        double distance() const { return (above + below) / (2 * slope); }
        double middle() const { return (above - below) / 2; }
    };
    static constexpr std::size_t kEdges = 8;
    using Side = std::array<Edges, kEdges>;  // from narrow to wide
    static double middle(const Side& edges, double distance);

    std::array<Side, 2> edges_;  // across and up
    Bounds bounds_;              // across, up, along
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
