
#include "render/camera.h"

#include "mesh/components.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace betamesh {
namespace {

constexpr double kRadians = std::numbers::pi / 180;
constexpr double kMinDistance = 1e-3;   // camera to the nearest ball, in diagonals of the bounding box
constexpr double kTail = 0.03;          // fraction of the area at either end of an axis that is not in the bulk
constexpr double kOutlierDistance = 1;  // from the bulk, in lengths of its longest side
constexpr std::size_t kMaxSamples = std::size_t{1} << 17;  // of the surface, to estimate its bulk

struct Axes {
    Vec3 right, up, forward;
};

Axes axesOf(const Vec3& forward, const Vec3& up) {
    Vec3 right = cross(forward, up);
    if (right.length() < 1e-9)  // viewing direction parallel to up
        right = cross(forward, std::abs(up.z) < 0.5 ? Vec3(0, 0, -1) : Vec3(0, 1, 0));
    right.normalize();
    return {right, cross(right, forward), forward};
}

/// Calls visit(v) for every finite vertex that a triangle uses.
template <typename Visit>
void visitUsedVertices(const Mesh& mesh, const Visit& visit) {
    std::vector<bool> used(mesh.position.size(), false);
    for (const Triangle& t : mesh.triangles)
        for (const std::uint32_t v : t) used[v] = true;
    for (std::size_t v = 0; v < used.size(); ++v)
        if (used[v] && isFinite(mesh.position[v])) visit(v);
}

template <typename Visit>
void visitSpheres(const Spheres& spheres, const Visit& visit) {
    for (std::size_t i = 0; i < spheres.size(); ++i)
        if (isFinite(spheres.position[i])) visit(spheres.position[i], static_cast<double>(spheres.radius[i]));
}

bool isHidden(const std::optional<CutawayPlane>& cutaway, const Vec3& p, double radius) {
    return cutaway &&
           (cutaway->below ? p[cutaway->axis] - radius > cutaway->at : p[cutaway->axis] + radius < cutaway->at);
}

/// A triangle corner with a third of the triangle's area, or a sphere.
struct AreaSample {
    Vec3 position;
    double radius, area;
};

/// At most about kMaxSamples, evenly chosen. Leaves out what is not finite or hidden by the cutaway plane.
std::vector<AreaSample> areaSamples(const Mesh& mesh, const Spheres& spheres,
                                    const std::optional<CutawayPlane>& cutaway) {
    std::vector<AreaSample> samples;
    const auto add = [&](const Vec3& p, double radius, double area) {
        if (isFinite(p) && std::isfinite(area) && !isHidden(cutaway, p, radius)) samples.push_back({p, radius, area});
    };
    const std::size_t rows = 3 * mesh.triangles.size() + spheres.size(), step = (rows + kMaxSamples - 1) / kMaxSamples;
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
    return samples;
}

/// The box of the bulk, grown by kOutlierDistance: what is outside of it is an outlier.
Bounds outlierFence(std::vector<AreaSample> samples) {
    Bounds bulk;
    const double total = std::accumulate(samples.begin(), samples.end(), 0.0,
                                         [](double sum, const AreaSample& sample) { return sum + sample.area; });
    for (int axis = 0; axis < 3 && !samples.empty(); ++axis) {
        std::sort(samples.begin(), samples.end(), [&](const AreaSample& a, const AreaSample& b) {
            return a.position[axis] != b.position[axis] ? a.position[axis] < b.position[axis] : a.radius < b.radius;
        });
        double area_before = 0;
        for (const AreaSample& sample : samples) {
            const double area_after = area_before + sample.area;
            if (area_after >= kTail * total && area_before <= (1 - kTail) * total) {
                bulk.low[axis] = std::min(bulk.low[axis], sample.position[axis] - sample.radius);
                bulk.high[axis] = std::max(bulk.high[axis], sample.position[axis] + sample.radius);
            }
            area_before = area_after;
        }
    }
    const Vec3 size = bulk.high - bulk.low;
    const double margin = kOutlierDistance * std::max({size.x, size.y, size.z});
    return {bulk.low - Vec3(margin, margin, margin), bulk.high + Vec3(margin, margin, margin)};
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
    visitUsedVertices(mesh, [&](std::size_t v) { bounds.add(mesh.position[v], 0); });
    visitSpheres(spheres, [&](const Vec3& p, double radius) { bounds.add(p, radius); });
    return bounds;
}

void visitBulk(const Mesh& mesh, const Spheres& spheres, const std::optional<CutawayPlane>& cutaway,
               const std::function<void(const Vec3& centre, double radius)>& visit) {
    std::vector<AreaSample> samples = areaSamples(mesh, spheres, cutaway);
    if (samples.empty()) return;
    const Bounds fence = outlierFence(std::move(samples));
    bool all_near = true;
    visitUsedVertices(mesh, [&](std::size_t v) { all_near = all_near && fence.contains(mesh.position[v]); });
    Components components;
    std::vector<bool> near;
    if (!all_near) {
        components = componentsOf(mesh.position.size(), mesh.triangles);
        near.resize(components.count, false);
        visitUsedVertices(mesh, [&](std::size_t v) {
            if (fence.contains(mesh.position[v]) && !isHidden(cutaway, mesh.position[v], 0))
                near[components.of_vertex[v]] = true;
        });
    }
    visitUsedVertices(mesh, [&](std::size_t v) {
        if ((all_near || near[components.of_vertex[v]]) && !isHidden(cutaway, mesh.position[v], 0))
            visit(mesh.position[v], 0);
    });
    visitSpheres(spheres, [&](const Vec3& p, double radius) {
        if (fence.contains(p) && !isHidden(cutaway, p, radius)) visit(p, radius);
    });
}

Bounds boundsOfBulk(const Mesh& mesh, const Spheres& spheres, const std::optional<CutawayPlane>& cutaway) {
    Bounds bounds;
    visitBulk(mesh, spheres, cutaway, [&](const Vec3& p, double radius) { bounds.add(p, radius); });
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

// Consider the plane of the viewing direction and one picture axis. A camera at lateral position x and distance d
// behind the origin sees a point at lateral position a and depth b if |a - x| <= slope (b + d). So every point gives a
// lower bound of x + slope d and one of slope d - x; `above` and `below` are the largest of them.
void CameraFinder::add(const Vec3& centre, double radius) {
    const Vec3 seen(dot(centre, right_), dot(centre, up_), dot(centre, forward_));
    for (std::size_t i = 0; i < 2; ++i)
        for (Edges& edges : edges_[i]) {
            const double across = seen[static_cast<int>(i)], along = edges.slope * seen.z;
            const double margin = radius * std::sqrt(1 + edges.slope * edges.slope);  // for a ball tangent to the edge
            edges.above = std::max(edges.above, across - along + margin);
            edges.below = std::max(edges.below, -across - along + margin);
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

// Lateral position of a camera at the given distance. If the distance is larger than this picture axis requires, all
// balls fit between narrower edges, and the camera is centred between the narrowest of those.
double CameraFinder::middle(const Fan& edges, double distance) {
    std::size_t k = kEdges - 1;  // narrowest edges that contain all balls at this distance
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
    if (!(size > 0)) size = bounds_.centre().length();  // a single point: a distance that rounding does not swallow
    if (!(size > 0)) size = 1;
    double distance = -bounds_.low.z + kMinDistance * size;
    for (const Fan& edges : edges_) distance = std::max(distance, edges.back().distance());
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
