
#include "render/camera.h"

#include "mesh/components.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace betamesh {
namespace {

constexpr double kRadians = std::numbers::pi / 180;
constexpr double kLeastDistance = 1e-3;  // of the size of what is seen: how near the camera comes to it
constexpr double kTail = 0.03;            // of the surface at either end of an axis that is not its bulk
constexpr double kOutlying = 1;           // of the longest side of the bulk: how far from it outliers begin
constexpr std::size_t kMostParts = std::size_t{1} << 17;  // of the surface that are looked at to find its bulk

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

/// Calls visit(v) for every finite vertex that a triangle uses.
template <typename Visit>
void forVertices(const Mesh& mesh, const Visit& visit) {
    std::vector<bool> used(mesh.position.size(), false);
    for (const Triangle& t : mesh.triangles)
        for (const std::uint32_t v : t) used[v] = true;
    for (std::size_t v = 0; v < used.size(); ++v)
        if (used[v] && isFinite(mesh.position[v])) visit(v);
}

template <typename Visit>
void forSpheres(const Spheres& spheres, const Visit& visit) {
    for (std::size_t i = 0; i < spheres.size(); ++i)
        if (isFinite(spheres.position[i])) visit(spheres.position[i], static_cast<double>(spheres.radius[i]));
}

bool isCutAway(const std::optional<Cut>& cut, const Vec3& p, double radius) {
    return cut && (cut->below ? p[cut->axis] - radius > cut->at : p[cut->axis] + radius < cut->at);
}

/// A piece of the surface: a corner of a triangle, or a sphere.
struct SurfacePart {
    Vec3 position;
    double radius, area;
};

/// Evenly chosen ones, finite and not cut away.
std::vector<SurfacePart> surfaceParts(const Mesh& mesh, const Spheres& spheres, const std::optional<Cut>& cut) {
    std::vector<SurfacePart> parts;
    const auto add = [&](const Vec3& p, double radius, double area) {
        if (isFinite(p) && std::isfinite(area) && !isCutAway(cut, p, radius)) parts.push_back({p, radius, area});
    };
    const std::size_t rows = 3 * mesh.triangles.size() + spheres.size(), step = (rows + kMostParts - 1) / kMostParts;
    for (std::size_t i = 0; i < mesh.triangles.size(); i += step) {
        const Vec3 a = mesh.position[mesh.triangles[i][0]], b = mesh.position[mesh.triangles[i][1]],
                   c = mesh.position[mesh.triangles[i][2]];
        const double area = cross(b - a, c - a).length() / 6;
        for (const Vec3& corner : {a, b, c}) add(corner, 0, area);
    }
    for (std::size_t i = 0; i < spheres.size(); i += step) {
        const auto radius = static_cast<double>(spheres.radius[i]);
        add(spheres.position[i], radius, 4 * std::numbers::pi * radius * radius);
    }
    return parts;
}

/// Beyond this box are outliers.
Bounds fenceOf(std::vector<SurfacePart> parts) {
    Bounds bulk;
    const double total = std::accumulate(parts.begin(), parts.end(), 0.0,
                                         [](double sum, const SurfacePart& part) { return sum + part.area; });
    for (int axis = 0; axis < 3 && !parts.empty(); ++axis) {
        std::sort(parts.begin(), parts.end(), [&](const SurfacePart& a, const SurfacePart& b) {
            return a.position[axis] != b.position[axis] ? a.position[axis] < b.position[axis] : a.radius < b.radius;
        });
        double before = 0;
        for (const SurfacePart& part : parts) {
            const double after = before + part.area;
            if (after >= kTail * total && before <= (1 - kTail) * total) {
                bulk.low[axis] = std::min(bulk.low[axis], part.position[axis] - part.radius);
                bulk.high[axis] = std::max(bulk.high[axis], part.position[axis] + part.radius);
            }
            before = after;
        }
    }
    const Vec3 size = bulk.high - bulk.low;
    const double room = kOutlying * std::max({size.x, size.y, size.z});
    return {bulk.low - Vec3(room, room, room), bulk.high + Vec3(room, room, room)};
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
    forVertices(mesh, [&](std::size_t v) { bounds.add(mesh.position[v], 0); });
    forSpheres(spheres, [&](const Vec3& p, double radius) { bounds.add(p, radius); });
    return bounds;
}

void forBulk(const Mesh& mesh, const Spheres& spheres, const std::optional<Cut>& cut,
             const std::function<void(const Vec3& centre, double radius)>& visit) {
    std::vector<SurfacePart> parts = surfaceParts(mesh, spheres, cut);
    if (parts.empty()) return;
    const Bounds fence = fenceOf(std::move(parts));
    bool all_near = true;
    forVertices(mesh, [&](std::size_t v) { all_near = all_near && fence.holds(mesh.position[v]); });
    Components pieces;
    std::vector<bool> near;
    if (!all_near) {
        pieces = componentsOf(mesh.position.size(), mesh.triangles);
        near.resize(pieces.count, false);
        forVertices(mesh, [&](std::size_t v) {
            if (fence.holds(mesh.position[v]) && !isCutAway(cut, mesh.position[v], 0)) near[pieces.of_vertex[v]] = true;
        });
    }
    forVertices(mesh, [&](std::size_t v) {
        if ((all_near || near[pieces.of_vertex[v]]) && !isCutAway(cut, mesh.position[v], 0))
            visit(mesh.position[v], 0);
    });
    forSpheres(spheres, [&](const Vec3& p, double radius) {
        if (fence.holds(p) && !isCutAway(cut, p, radius)) visit(p, radius);
    });
}

Bounds boundsOfBulk(const Mesh& mesh, const Spheres& spheres, const std::optional<Cut>& cut) {
    Bounds bounds;
    forBulk(mesh, spheres, cut, [&](const Vec3& p, double radius) { bounds.add(p, radius); });
    return bounds;
}

CameraFinder::CameraFinder(const Framing& framing, double aspect) : framing_(framing) {
    const double azimuth = framing.azimuth * kRadians, elevation = framing.elevation * kRadians;
    const Vec3 back = framing.up.z > 0.5 ? Vec3(0, -1, 0) : Vec3(0, 0, 1), side = cross(framing.up, back);
    const Vec3 horizontal = back * std::cos(azimuth) + side * std::sin(azimuth);
    const Axes axes = axesOf(-(horizontal * std::cos(elevation) + framing.up * std::sin(elevation)), framing.up);
    right_ = axes.right, up_ = axes.up, forward_ = axes.forward;
    const double slope = std::tan(framing.fov * kRadians / 2) * (1 - 2 * framing.margin);
    for (std::size_t k = 0; k < kEdges; ++k) {
        const double share = static_cast<double>(k + 1) / kEdges;
        edges_[0][k].slope = slope * aspect * share;
        edges_[1][k].slope = slope * share;
    }
}

// A camera at x across and d behind the origin has a point at (a across, b along) in the picture where
// |a - x| <= slope (b + d). Every point bounds x + slope d and slope d - x from below.
void CameraFinder::add(const Vec3& centre, double radius) {
    const Vec3 seen(dot(centre, right_), dot(centre, up_), dot(centre, forward_));
    for (std::size_t i = 0; i < 2; ++i)
        for (Edges& edges : edges_[i]) {
            const double across = seen[static_cast<int>(i)], along = edges.slope * seen.z;
            const double round = radius * std::sqrt(1 + edges.slope * edges.slope);  // balls touch edges sideways
            edges.above = std::max(edges.above, across - along + round);
            edges.below = std::max(edges.below, -across - along + round);
        }
    bounds_.add(seen, radius);
}

void CameraFinder::add(const CameraFinder& other) {
    for (std::size_t i = 0; i < 2; ++i)
        for (std::size_t k = 0; k < kEdges; ++k) {
            edges_[i][k].above = std::max(edges_[i][k].above, other.edges_[i][k].above);
            edges_[i][k].below = std::max(edges_[i][k].below, other.edges_[i][k].below);
        }
    bounds_.add(other.bounds_);
}

// A camera farther away than its width needs has all between narrower edges: where these stand is the middle.
double CameraFinder::middle(const Side& edges, double distance) {
    std::size_t k = kEdges - 1;  // the narrowest that distance is enough for
    while (k > 0 && edges[k - 1].distance() <= distance) --k;
    double middle = edges[k].middle();
    if (k > 0 && edges[k].distance() < edges[k - 1].distance()) {
        const double share =
            std::clamp((distance - edges[k].distance()) / (edges[k - 1].distance() - edges[k].distance()), 0.0, 1.0);
        middle += share * (edges[k - 1].middle() - middle);
    }
    const Edges& widest = edges.back();
    const double reach = widest.slope * distance;
    return std::max(std::min(middle, reach - widest.below), widest.above - reach);
}

Camera CameraFinder::camera() const {
    if (bounds_.empty()) return {-forward_, {0, 0, 0}, framing_.up, framing_.fov};
    double size = bounds_.diagonal();
    if (!(size > 0)) size = bounds_.centre().length();  // a single point: any distance that is not lost beside it
    if (!(size > 0)) size = 1;
    double distance = -bounds_.low.z + kLeastDistance * size;
    for (const Side& edges : edges_) distance = std::max(distance, edges.back().distance());
    const Vec3 position =
        right_ * middle(edges_[0], distance) + up_ * middle(edges_[1], distance) - forward_ * distance;
    return {position, position + forward_ * (bounds_.centre().z + distance), framing_.up, framing_.fov};
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
