// What makes the skin calm: one wide fit where the liquid is wide, and narrow smoothing that shrinks nothing.

#pragma once

#include "skin/deforming_mesh.h"

namespace betamesh {

/// Smooths a retracted surface. In each pass:
///
/// 1. A sphere is fitted to what is near each vertex and faces its way, as far as the surface does not turn sideways
///    but at most `widest` away; the vertex goes onto it. Where that is near, as on threads, this fades out. Edges of
///    what is thick are rounded all the same.
/// 2. Narrow steps along the normal: the height of what is near over the tangent plane, less the mean of these heights
///    round it (a bi-Laplacian), which is zero on planes, spheres and cylinders.
/// 3. What was taken from long waves returns: the mean of what was lost, over what is near and faces the same way.
/// 4. Vertices at folds are drawn together, and triangles that lie upside down turned.
///
/// In the end no vertex is `farthest` from where it was, however many passes there are.
///
/// in      widest, farthest: particle spacings
/// same    bytes for any thread count and instruction set
/// cost    O(passes · vertices · samples within reach)
/// source  Guennebaud & Gross 2007, Algebraic point set surfaces; Vollmer et al. 1999, Improved Laplacian smoothing
void smoothSkin(DeformingMesh& surface, double widest, double farthest, int passes);

/// Of a fit, in particle spacings.
inline constexpr double kWidestFit = 5.8;

}  // namespace betamesh
