// Moves the vertices of the skin onto spheres fitted to what is near them.

#pragma once

#include "skin/deforming_mesh.h"

namespace betamesh {

/// Moves every vertex onto the sphere that is fitted to the surface near it that faces the same way, with a kernel as
/// wide as the surface does not turn sideways, but at most `widest`. With narrow kernels, as on threads, the step fades
/// out. Edges of thick liquid are rounded nevertheless.
///
/// in      widest: particle spacings
/// out     the kernel width at each vertex, particle spacings; areas and normals are up to date
/// cost    O(vertices · elements within reach)
/// source  Guennebaud & Gross 2007, Algebraic point set surfaces
std::vector<float> fitSpheres(DeformingMesh& surface, double widest);

/// Share of a step that a fit of a kernel width (particle spacings) gets: 0 for narrow kernels, 1 for wide ones.
double fitShare(float width);

}  // namespace betamesh
