// Measures of a mesh: components, Euler characteristic, volume, area.

#pragma once

#include "mesh/components.h"

namespace betamesh {

struct MeshMeasure {
    std::size_t components = 0;      ///< connected components
    std::int64_t euler = 0;          ///< used vertices - edges + triangles
    double volume = 0;               ///< enclosed, world units cubed; meaningful for closed meshes
    double area = 0;                 ///< world units squared
    std::size_t unpaired_edges = 0;  ///< half-edges without an opposite one; 0 when closed
};

/// same    result for any thread count
/// cost    O(triangles log triangles)
MeshMeasure measureMesh(const Mesh& mesh);

/// The triangles whose vertices exist and are within the range of the exact predicates (isInRange).
std::vector<Triangle> measurableTriangles(const Mesh& mesh);

/// Area of a triangle, world units squared.
inline double areaOf(const Vec3& a, const Vec3& b, const Vec3& c) { return cross(b - a, c - a).length() / 2; }

}  // namespace betamesh
