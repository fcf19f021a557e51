// What a mesh is like near some points: in how many pieces, with how many handles.

#pragma once

#include "mesh/components.h"
#include "mesh/triangle_tree.h"

namespace betamesh {

/// Of the corners within a distance, and what the mesh spans between them. That has the topology of what a surface
/// cuts out on which the distance changes evenly along edges.
struct LocalTopology {
    std::int64_t euler = 0;              ///< vertices - edges + triangles
    std::int64_t parts = 0;              ///< connected there
    std::int64_t rims = 0;               ///< closed curves along which it is cut out
    std::int64_t pieces = 0, voids = 0;  ///< of the whole mesh, that have a corner there: of positive, negative volume
    bool closed = true;                  ///< two triangles at every edge there
};

/// A mesh, made ready to be looked at here and there. Refers to the mesh; triangles with missing vertices or positions
/// that are not finite are left out.
class MeshParts {
public:
    /// cost    O(triangles log triangles)
    explicit MeshParts(const Mesh& mesh);

    /// Near the points, within each of the distances: to the nearest of the points, world units.
    ///
    /// cost    O((triangles in the box round all that) × (distances + log points))
    std::vector<LocalTopology> near(std::span<const Vec3> points, std::span<const double> distances) const;

private:
    std::span<const Vec3> position_;
    std::vector<Triangle> triangles_;
    TriangleTree tree_;
    Components pieces_;
    std::vector<double> volume_;  // of each
};

}  // namespace betamesh
