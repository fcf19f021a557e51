
#include "mesh/enclosure.h"

#include "base/parallel.h"
#include "exact/orientation.h"
#include "mesh/mesh_measure.h"
#include "mesh/triangle_tree.h"

#include <algorithm>

namespace betamesh {

namespace {

// +1, -1: on which side of the line from a to b, seen along z, is p, moved by an infinitesimal (ε, ε²)? 0 only
// where the line is a point.
int turnOfMoved(const Vec3& a, const Vec3& b, const Vec3& p) {
    const int turn = turnAlong(2, a, b, p);
    if (turn != 0) return turn;
    if (a.y != b.y) return a.y > b.y ? 1 : -1;
    if (a.x != b.x) return b.x > a.x ? 1 : -1;
    return 0;
}

// p is on the plane: also on the triangle, which has an area?
bool covers(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p) {
    for (int axis = 0; axis < 3; ++axis) {
        const int sense = turnAlong(axis, a, b, c);
        if (sense == 0) continue;
        return sense * turnAlong(axis, a, b, p) >= 0 && sense * turnAlong(axis, b, c, p) >= 0 &&
               sense * turnAlong(axis, c, a, p) >= 0;
    }
    return false;
}

struct Place {
    int winding = 0;
    bool on_surface = false;
};

// Counts the triangles above, each with the sign of the side from which it is seen.
Place placeOf(const TriangleTree& tree, const Vec3& p) {
    Place place;
    const auto above = [&](const Box& box) {
        return box.min.x <= p.x && p.x <= box.max.x && box.min.y <= p.y && p.y <= box.max.y && p.z <= box.max.z;
    };
    tree.forTriangles(above, [&](std::uint32_t row) {
        const Triangle& t = tree.triangles()[row];
        const Vec3 &a = tree.position()[t[0]], &b = tree.position()[t[1]], &c = tree.position()[t[2]];
        const int side = sideOfPlane(a, b, c, p);
        if (side == 0) {
            place.on_surface = covers(a, b, c, p);
            return !place.on_surface;
        }
        const int sense = turnOfMoved(a, b, p);
        if (sense != 0 && turnOfMoved(b, c, p) == sense && turnOfMoved(c, a, p) == sense && side == -sense)
            place.winding += sense;
        return true;
    });
    return place;
}

// Spheres along x, so that those which may hold a point stand together.
class SphereRow {
public:
    explicit SphereRow(const Spheres& spheres) {
        for (std::size_t i = 0; i < spheres.size(); ++i) {
            sphere_.push_back({spheres.position[i], spheres.radius[i]});
            largest_ = std::max<double>(largest_, spheres.radius[i]);
        }
        std::sort(sphere_.begin(), sphere_.end(),
                  [](const Sphere& a, const Sphere& b) { return a.centre.x < b.centre.x; });
    }
    bool holds(const Vec3& p) const {
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

std::vector<double> distancesOutside(const Mesh& mesh, const Spheres& beside, const std::vector<Vec3>& points) {
    const std::vector<Triangle> placed = placedTriangles(mesh);
    double volume = 0;
    const Vec3 origin = placed.empty() ? Vec3(0) : mesh.position[placed[0][0]];
    for (const Triangle& t : placed)
        volume += volumeBelow(mesh.position[t[0]] - origin, mesh.position[t[1]] - origin, mesh.position[t[2]] - origin);
    const int outward = volume < 0 ? -1 : 1;
    const TriangleTree tree(mesh.position, placed);
    const SphereRow spheres(beside);
    std::vector<double> distances(points.size());
    parallelFor(points.size(), 256, [&](std::size_t i) {
        const Place place = placeOf(tree, points[i]);
        const bool inside = place.on_surface || place.winding * outward > 0 || spheres.holds(points[i]);
        distances[i] = inside ? 0 : tree.distanceTo(points[i]);
    });
    return distances;
}

}  // namespace betamesh
