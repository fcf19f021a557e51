// Cuts a mesh off at a box.

#pragma once

#include "betamesh/mesh.h"

namespace betamesh {

/// The part of a mesh inside a box, closed by plane polygons on the faces of the box. New vertices lie exactly on the
/// faces; velocities and real attributes are interpolated along the edge that was cut (normals, `N`, are of unit
/// length), whole numbers are those of its end inside.
///
/// in      a closed, oriented mesh whose edges have two triangles each, without `component`; positions that are floats.
///         low < high in each coordinate, floats
/// out     a closed, oriented mesh with the columns of the first one. Where a face passes through vertices of the mesh,
///         vertices can coincide and triangles have no area
/// same    bytes for any thread count
/// cost    O(triangles log triangles), plus O(n²) at worst for n cut edges of a face
Mesh clippedToBox(const Mesh& mesh, const Vec3& low, const Vec3& high);

/// Removes the spheres whose centres are outside a box. Attributes are not considered.
void keepInside(const Vec3& low, const Vec3& high, Spheres& spheres);

}  // namespace betamesh
