#include "mesh/enclosure.h"

#include "base/parallel.h"
#include "exact/orientation.h"
#include "mesh/mesh_measure.h"

#include <algorithm>

namespace betamesh {

namespace {

// orientationAlong z with p displaced by an infinitesimal (ε, ε²), which breaks ties: 0 only where a and b project to
// one point.
int turnOfPerturbed(const Vec3& a, const Vec3& b, const Vec3& p) {
    const int turn = orientationAlong(2, a, b, p);
    if (turn != 0) return turn;
    if (a.y != b.y) return a.y > b.y ? 1 : -1;
    if (a.x != b.x) return b.x > a.x ? 1 : -1;
    return 0;
}

// Is p, which is in the plane of a non-degenerate triangle, on the triangle?
bool covers(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p) {
    for (int axis = 0; axis < 3; ++axis) {
        const int sense = orientationAlong(axis, a, b, c);
        if (sense == 0) continue;
        return sense * orientationAlong(axis, a, b, p) >= 0 && sense * orientationAlong(axis, b, c, p) >= 0 &&
               sense * orientationAlong(axis, c, a, p) >= 0;
    }
    return false;
}

struct PointLocation {
    int winding = 0;
    bool on_surface = false;
};

// The winding number: the number of triangles above the point, each with the sign of the side that faces it.
PointLocation locate(const TriangleTree& tree, const Vec3& p) {
    PointLocation location;
    const auto above = [&](const Box& box) {
        return box.min.x <= p.x && p.x <= box.max.x && box.min.y <= p.y && p.y <= box.max.y && p.z <= box.max.z;
    };
    tree.forTriangles(above, [&](std::uint32_t row) {
        const Triangle& t = tree.triangles()[row];
        const Vec3 &a = tree.position()[t[0]], &b = tree.position()[t[1]], &c = tree.position()[t[2]];
        const int side = sideOfPlane(a, b, c, p);
        if (side == 0) {
            location.on_surface = covers(a, b, c, p);
            return !location.on_surface;
        }
        const int sense = turnOfPerturbed(a, b, p);
        if (sense != 0 && turnOfPerturbed(b, c, p) == sense && turnOfPerturbed(c, a, p) == sense && side == -sense)
            location.winding += sense;
        return true;
    });
    return location;
}

// Spheres sorted by x, so that those that may contain a point are consecutive.
class SortedSpheres {
public:
    explicit SortedSpheres(const Spheres& spheres) {
        for (std::size_t i = 0; i < spheres.size(); ++i) {
            sphere_.push_back({spheres.position[i], spheres.radius[i]});
            largest_ = std::max<double>(largest_, spheres.radius[i]);
        }
        std::sort(sphere_.begin(), sphere_.end(),
                  [](const Sphere& a, const Sphere& b) { return a.centre.x < b.centre.x; });
    }
    bool contain(const Vec3& p) const {
        auto next = std::lower_bound(sphere_.begin(), sphere_.end(), p.x - largest_,
                                     [](const Sphere& sphere, double x) { return sphere.centre.x < x; });
        for (; next != sphere_.end() && next->centre.x <= p.x + largest_; ++next)
            if ((p - next->centre).length2() <= next->radius * next->radius) return true;
        return false;
    }

private:
    struct Sphere {
        Vec3 centre;
        double radius;
    };
    std::vector<Sphere> sphere_;
    double largest_ = 0;
};

}  // namespace

bool isEnclosed(const TriangleTree& tree, const Vec3& point) {
    const PointLocation location = locate(tree, point);
    return location.on_surface || location.winding > 0;
}

std::vector<double> distancesOutside(const Mesh& mesh, const Spheres& beside, const std::vector<Vec3>& points) {
    const std::vector<Triangle> triangles = measurableTriangles(mesh);
    double volume = 0;
    const Vec3 origin = triangles.empty() ? Vec3(0) : mesh.position[triangles[0][0]];
    for (const Triangle& t : triangles)
        volume +=
            signedVolume(mesh.position[t[0]] - origin, mesh.position[t[1]] - origin, mesh.position[t[2]] - origin);
    const int outward = volume < 0 ? -1 : 1;
    const TriangleTree tree(mesh.position, triangles);
    const SortedSpheres spheres(beside);
    std::vector<double> distances(points.size());
    parallelFor(points.size(), 256, [&](std::size_t i) {
        const PointLocation location = locate(tree, points[i]);
        const bool inside = location.on_surface || location.winding * outward > 0 || spheres.contain(points[i]);
        distances[i] = inside ? 0 : tree.distanceTo(points[i]);
    });
    return distances;
}

EnclosedRegion::EnclosedRegion(const std::vector<Vec3>& position, const std::vector<Edge>& edges)
    : position_(position) {
    double lowest = std::numeric_limits<double>::infinity(), highest = -lowest, heights = 0;
    for (const Edge& edge : edges) {
        const auto [low, high] = std::minmax(position[edge[0]].y, position[edge[1]].y);
        lowest = std::min(lowest, low);
        highest = std::max(highest, high);
        heights += high - low;
    }
    const auto n = static_cast<double>(edges.size());
    if (heights > 0) {  // strips as high as the mean edge, but no more than edges
        lowest_ = lowest;
        strips_per_unit_ = n / std::max(heights, highest - lowest);
    }
    strip_.resize(edges.empty() ? 1 : stripOf(highest) + 1);
    for (const Edge& edge : edges) {
        const auto [low, high] = std::minmax(position[edge[0]].y, position[edge[1]].y);
        for (std::size_t s = stripOf(low); s <= stripOf(high); ++s) strip_[s].push_back(edge);
    }
}

std::size_t EnclosedRegion::stripOf(double y) const {
    const double strip = std::max(0.0, (y - lowest_) * strips_per_unit_);  // 0 also if y is not a number
    const auto last = static_cast<double>(std::max(strip_.size(), std::size_t{1}) - 1);
    return static_cast<std::size_t>(strip_.empty() ? strip : std::min(strip, last));
}

bool EnclosedRegion::contains(const Vec3& p) const {
    int winding = 0;
    for (const Edge& edge : strip_[stripOf(p.y)]) {
        const Vec3 &a = position_[edge[0]], &b = position_[edge[1]];
        if ((a.y <= p.y) == (b.y <= p.y)) continue;  // the horizontal line through p does not cross the edge
        const int side = orientationAlong(2, a, b, p);
        if (side == 0) return true;
        if (side == (b.y > a.y ? 1 : -1)) winding += side;
    }
    return winding > 0;
}

std::vector<double> distancesOutside(const Curves& curves, const Spheres& beside, const std::vector<Vec3>& points) {
    std::vector<double> distances(points.size());
    const EnclosedRegion region(curves.position, curves.edges);
    parallelFor(points.size(), 64, [&](std::size_t i) {
        const Vec3 p(points[i].x, points[i].y, 0);
        for (std::size_t s = 0; s < beside.size(); ++s)
            if (std::hypot(beside.position[s].x - p.x, beside.position[s].y - p.y) <=
                static_cast<double>(beside.radius[s]))
                return;
        if (region.contains(p)) return;
        double nearest = std::numeric_limits<double>::infinity();
        for (const Edge& edge : curves.edges) {
            Vec3 a = curves.position[edge[0]], b = curves.position[edge[1]];
            a.z = b.z = 0;
            const Vec3 along = b - a;
            const double t = along.length2() > 0 ? std::clamp(dot(p - a, along) / along.length2(), 0.0, 1.0) : 0;
            nearest = std::min(nearest, (a + along * t - p).length2());
        }
        distances[i] = std::sqrt(nearest);
    });
    return distances;
}

}  // namespace betamesh
