// Smoothing of the skin's curves without shrinking them.

#pragma once

#include "planar/boundary_curves.h"

namespace betamesh {

struct SkinSmoothing {
    double spacing = 0;  ///< of the particles of scale 1, world units; as all lengths, elsewhere in proportion to scale
    double widest = 0;   ///< radius of the widest fit, world units
    int passes = 1;      ///< of wide fits, >= 1
};

/// Moves vertices along the normals of the curve, in this order:
///
/// 1. Narrow bi-Laplacian steps: a vertex moves by the difference between its own depth below the curve nearby and the
///    mean depth of the vertices nearby. The step is zero on lines and circles.
/// 2. Wide fits: a vertex moves onto a circle fitted to the part of the curve around it that faces its direction. Fits
/// are
///    wide on thick liquid and on both sides of sheets; drops and round ends are not moved, because a fit ends where
///    the curve turns sideways.
/// 3. Narrow bi-Laplacian steps again.
/// 4. The mean displacement of steps 1 to 3 is undone, which restores long waves.
///
/// Means use only edges that face the vertex's direction, so the two sides of a sheet do not influence each other. All
/// displacements are continuous functions in the plane, made of a measure that changes continuously. Velocities are
/// carried through. No edges cross afterwards that did not cross before.
///
/// same    bytes for any thread count
/// cost    O(passes · vertices · edges within reach)
/// source  Taubin 1995; Guennebaud & Gross 2007, Algebraic point set surfaces
void smoothSkin(BetaCurve& curve, const SkinSmoothing& params);

}  // namespace betamesh
