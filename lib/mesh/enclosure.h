// Point-in-mesh queries: which points a mesh or curves enclose, and how far outside the others are.

#pragma once

#include "betamesh/curves.h"
#include "betamesh/mesh.h"
#include "mesh/triangle_tree.h"

namespace betamesh {

/// Is the winding number of the tree's triangles, which face outwards, positive at a point, or the point on one of
/// them?
///
/// cost    O(triangles above + log triangles)
bool isEnclosed(const TriangleTree& tree, const Vec3& point);

/// Distance of each point to the enclosed region: 0 where the mesh encloses the point, on the surface, or inside one of
/// the spheres `beside`; else the distance to the nearest triangle, infinite without triangles. Enclosed means a
/// positive winding number (negative for meshes of negative volume), which is decided exactly.
///
/// in      any mesh; triangles with missing vertices or non-finite positions are ignored. points: finite
/// same    result for any thread count
/// cost    O(triangles above + log triangles) per point, more for points far outside
std::vector<double> distancesOutside(const Mesh& mesh, const Spheres& beside, const std::vector<Vec3>& points);

/// The region of a plane in which the winding number of curves is positive, and the curves themselves; z is ignored.
class EnclosedRegion {
public:
    /// The positions are referred to.
    ///
    /// cost    O(edges)
    EnclosedRegion(const std::vector<Vec3>& position, const std::vector<Edge>& edges);

    /// Decided exactly.
    ///
    /// cost    O(edges at this height), of long closed curves about the square root of all
    bool contains(const Vec3& point) const;

private:
    std::size_t stripOf(double y) const;

    const std::vector<Vec3>& position_;
    double lowest_ = 0, strips_per_unit_ = 0;
    std::vector<std::vector<Edge>> strip_;  // of the plane, each with the edges that may cross it
};

/// Distance of each point to the enclosed region: 0 where the winding number of the curves is positive, on a curve, or
/// inside one of the circles `beside`; else the distance to the nearest edge, infinite without edges. Inside and
/// outside are decided exactly; z is ignored.
///
/// in      curves with finite positions
/// cost    O(points · edges at their heights + points outside · edges)
std::vector<double> distancesOutside(const Curves& curves, const Spheres& beside, const std::vector<Vec3>& points);

}  // namespace betamesh
