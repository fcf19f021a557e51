// Returns the long waves of the surface that smoothing has flattened.

#pragma once

#include "skin/kernel_shapes.h"

namespace betamesh {

/// Moves vertices along their normals by the kernel mean of the height lost since `before`, over what faces the same
/// way, then by the mean of what is still missing, and so on, kWaveReturns times. The iteration runs on elements of the
/// surface; vertices move once, by the sum.
///
/// in      normal: of the vertices; before: their positions before smoothing; kernels: of their sphere fits; widest:
///         of these, particle spacings
/// cost    O(vertices · elements within reach)
/// source  Vollmer et al. 1999, Improved Laplacian smoothing
void returnLongWaves(DeformingMesh& surface, const Normals& normal, const std::vector<Vec3>& before,
                     const KernelShapes& kernels, double widest);

}  // namespace betamesh
