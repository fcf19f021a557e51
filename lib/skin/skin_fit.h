// Moves the vertices of the skin onto spheres fitted to what is near them.

#pragma once

#include "skin/deforming_mesh.h"
#include "skin/kernel_shapes.h"

namespace betamesh {

/// Moves every vertex onto the sphere that is fitted to the surface near it that faces the same way, with a kernel that
/// reaches as far as the surface does not turn sideways, at most `widest`. Edges of thick liquid are rounded
/// nevertheless. Rims, edges and threads are smoothed along themselves. With narrow kernels the step fades out.
///
/// in      widest: particle spacings
/// out     the kernels of the vertices; areas and normals are up to date
/// cost    O(vertices · elements within reach)
/// source  Guennebaud & Gross 2007, Algebraic point set surfaces
KernelShapes fitSpheres(DeformingMesh& surface, double widest);

}  // namespace betamesh
