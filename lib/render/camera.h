// Cameras: automatic framing of a surface, and the projection of points and pixels.

#pragma once

#include "betamesh/mesh.h"
#include "render/render_settings.h"

#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

namespace betamesh {

/// Axis-aligned bounding box. Empty as long as nothing was added: then low > high.
struct Bounds {
    Vec3 low{kLargest, kLargest, kLargest}, high{-kLargest, -kLargest, -kLargest};

    static constexpr double kLargest = std::numeric_limits<double>::max();  ///< larger than any coordinate
    bool empty() const { return !(low.x <= high.x); }
    Vec3 centre() const { return empty() ? Vec3(0, 0, 0) : (low + high) / 2; }
    double diagonal() const { return empty() ? 0 : (high - low).length(); }
    void add(const Vec3& point, double radius);
    void add(const Bounds& other);
    bool contains(const Vec3& point) const {
        return low.x <= point.x && low.y <= point.y && low.z <= point.z && point.x <= high.x && point.y <= high.y &&
               point.z <= high.z;
    }
};

/// Box around every finite vertex that a triangle uses and every sphere.
Bounds boundsOf(const Mesh& mesh, const Spheres& spheres);

/// Calls visit(centre, radius) for every sphere and every finite vertex that a triangle uses (with radius 0). Skips
/// what the cutaway plane hides, and outliers: drops so far from the bulk of the surface that framing them would make
/// everything else small in the picture.
///
/// The bulk is the box that excludes 3 % of the surface area at either end of each axis. A sphere or a connected
/// component of the mesh is an outlier if all of it is outside that box by more than the box's longest side along some
/// axis. A jet that is still connected to the liquid is therefore never an outlier.
///
/// same    for any thread count
/// cost    O(triangles + spheres); the box is estimated from at most 2^17 triangle corners and spheres, evenly chosen
void visitBulk(const Mesh& mesh, const Spheres& spheres, const std::optional<CutawayPlane>& cutaway,
               const std::function<void(const Vec3& centre, double radius)>& visit);

/// Box around what visitBulk() visits.
Bounds boundsOfBulk(const Mesh& mesh, const Spheres& spheres, const std::optional<CutawayPlane>& cutaway);

/// A pinhole camera.
struct Camera {
    Vec3 position{0, 0, 1};
    Vec3 look_at{0, 0, 0};
    Vec3 up{0, 1, 0};
    double fov = 30;  ///< vertical field of view, degrees, (0, 180)
};

/// Viewing direction, field of view and margin of an automatic camera, whose position CameraFinder computes.
struct Framing {
    Vec3 up{0, 1, 0};  ///< a coordinate axis
    /// Degrees around `up`, counter-clockwise seen from above. At 0 the camera is on the +z side (-y if z is up).
    double azimuth = 30;
    double elevation = 20;  ///< degrees above the horizon, (-90, 90)
    double fov = 30;        ///< vertical field of view, degrees, (0, 180)
    double margin = 0.06;   ///< fraction of the picture left empty on each side, [0, 0.5)
};

/// Finds the camera nearest to a set of balls that still has all of them in the picture, and centres them. Balls are
/// added one by one, in any order: those of all frames, for instance, so that the camera frames the whole sequence.
class CameraFinder {
public:
    /// aspect: width / height.
    CameraFinder(const Framing& framing, double aspect);

    void add(const Vec3& centre, double radius);
    /// Adds the balls of another finder, which must have the same framing and aspect.
    void add(const CameraFinder& other);
    /// Looks at the middle of the balls' depth range; at the origin if there are no balls.
    Camera camera() const;

private:
    Framing framing_;
    Vec3 right_, up_, forward_;
    // Two parallel lines of the given slope (tangent of half the opening angle) that bound all balls in the plane of
    // the viewing direction and one picture axis: the picture edges of a camera behind the origin.
    struct Edges {
        double slope = 0, above = -Bounds::kLargest, below = -Bounds::kLargest;  // intercepts at the origin
        /// Distance behind the origin at which a centred camera has all balls between these edges.
        double distance() const { return (above + below) / (2 * slope); }
        double middle() const { return (above - below) / 2; }
    };
    static constexpr std::size_t kEdges = 8;
    using Fan = std::array<Edges, kEdges>;  // from narrow to wide; the last one is the part of the picture to be filled
    static double middle(const Fan& edges, double distance);

    std::array<Fan, 2> edges_;  // horizontal and vertical
    Bounds bounds_;             // along right, up and forward
};

/// Maps pixels to viewing directions and points to pixels. Pixel (x, y) covers [x, x + 1) × [y, y + 1) from the top
/// left.
class View {
public:
    View(const Camera& camera, int width, int height);

    const Vec3& position() const { return position_; }
    const Vec3& right() const { return right_; }
    const Vec3& up() const { return up_; }
    const Vec3& forward() const { return forward_; }
    /// Size of a pixel at unit depth.
    double pixel() const { return pixel_; }

    /// Viewing direction through a point of the picture, scaled to unit depth.
    Vec3 direction(double x, double y) const {
        return forward_ + right_ * ((x - half_width_) * pixel_) + up_ * ((half_height_ - y) * pixel_);
    }
    /// Distance from the camera along its axis.
    double depth(const Vec3& point) const { return dot(point - position_, forward_); }
    /// Pixel coordinates x, y of a point in front of the camera.
    std::array<double, 2> projected(const Vec3& point) const {
        const Vec3 offset = point - position_;
        const double scale = 1 / (dot(offset, forward_) * pixel_);
        return {half_width_ + dot(offset, right_) * scale, half_height_ - dot(offset, up_) * scale};
    }

private:
    Vec3 position_, right_, up_, forward_;
    double half_width_, half_height_, pixel_;
};

}  // namespace betamesh
