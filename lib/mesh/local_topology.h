// The topology of a mesh near some points: Euler characteristic, connected patches, rims.

#pragma once

#include "mesh/components.h"
#include "mesh/triangle_tree.h"

namespace betamesh {

/// Topology of the part of a mesh within a distance: the vertices within it, and the edges and triangles between them.
/// This is the topology of the sublevel set if the distance is interpolated linearly along edges.
struct LocalTopology {
    std::int64_t euler = 0;           ///< vertices - edges + triangles
    std::int64_t patches = 0;         ///< connected components of the part
    std::int64_t rims = 0;            ///< closed curves along which the part is cut out
    std::int64_t outer_surfaces = 0;  ///< components of the whole mesh with a vertex in the part and positive volume
    std::int64_t voids = 0;           ///< the same with negative volume
    bool closed = true;               ///< every edge with a vertex in the part has two triangles
};

/// Answers LocalTopology queries for one mesh, which it refers to. Triangles with missing vertices or non-finite
/// positions are ignored.
class LocalTopologyQuery {
public:
    /// cost    O(triangles log triangles)
    explicit LocalTopologyQuery(const Mesh& mesh);

    /// One result per distance: the topology of the part within that distance of the nearest point. World units.
    ///
    /// cost    O(triangles in the bounding box · (distances + log points))
    std::vector<LocalTopology> near(std::span<const Vec3> points, std::span<const double> distances) const;

private:
    std::span<const Vec3> position_;
    std::vector<Triangle> triangles_;
    TriangleTree tree_;
    Components components_;
    std::vector<double> volume_;  // of each component
};

}  // namespace betamesh
