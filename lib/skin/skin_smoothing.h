// The smoothing of the skin: wide sphere fits in thick liquid, and narrow smoothing that does not shrink.

#pragma once

#include "skin/deforming_mesh.h"

namespace betamesh {

/// Smooths a retracted surface. Each pass consists of:
///
/// 1. fitSpheres(): vertices move onto spheres fitted with kernels at most `widest` wide.
/// 2. kBiLaplacianSteps steps along the normals: the mean height over the tangent plane minus the mean of these heights
///    near the vertex (a bi-Laplacian), which is zero on planes, spheres and cylinders.
/// 3. returnLongWaves(): the part of long waves that the fits have removed is added again.
/// 4. DeformingMesh::relaxFolds(), as before the pass.
///
/// A coarse mesh goes without step 3, which hardly shows there, and with fewer relaxations.
///
/// With several passes, what is near a vertex that gets nearly `farthest` from its initial position stays behind with
/// it.
///
/// in      widest, farthest: particle spacings
/// same    bytes for any thread count and instruction set
/// cost    O(passes · vertices · samples within reach)
/// source  Guennebaud & Gross 2007, Algebraic point set surfaces; Vollmer et al. 1999, Improved Laplacian smoothing
void smoothSkin(DeformingMesh& surface, double widest, double farthest, int passes, bool is_coarse = false);

/// Shortens the displacements of vertices, so that none is `farthest` particle spacings or more from where it was.
/// Those up to two thirds of that hardly change.
void limitDisplacements(DeformingMesh& surface, const std::vector<Vec3>& from, double farthest);

}  // namespace betamesh
