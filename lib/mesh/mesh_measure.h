// What a mesh is, in numbers.

#pragma once

#include "mesh/components.h"

namespace betamesh {

struct MeshMeasure {
    std::size_t components = 0;      ///< pieces that share no vertex
    std::int64_t euler = 0;          ///< used vertices - edges + triangles
    double volume = 0;               ///< enclosed, world units cubed; meaningful for closed meshes
    double area = 0;                 ///< world units squared
    std::size_t unpaired_edges = 0;  ///< directed edges used more often than their opposites; 0 when closed
};

/// same    result for any thread count
/// cost    O(triangles log triangles)
MeshMeasure measureMesh(const Mesh& mesh);

/// Those whose corners exist and are no farther out than exact signs reach: the ones that can be measured.
std::vector<Triangle> placedTriangles(const Mesh& mesh);

/// World units squared.
inline double areaOf(const Vec3& a, const Vec3& b, const Vec3& c) { return cross(b - a, c - a).length() / 2; }

}  // namespace betamesh
