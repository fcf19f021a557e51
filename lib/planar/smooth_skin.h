// The skin -> a calmer skin. Nothing shrinks.

#pragma once

#include "planar/beta_curve.h"

namespace betamesh {

struct SkinSmoothing {
    double spacing = 0;  ///< of the particles, world units
    double widest = 0;   ///< how far the widest mean reaches, world units
    int passes = 1;      ///< of wide fits, >= 1
};

/// Moves vertices along the curve's normal, in this order:
///
/// 1. Bi-Laplacian, narrow: by how much more a vertex lies below the curve near it than those do, in the mean. Zero on
///    lines and circles.
/// 2. Onto a circle fitted to the curve as far as it goes the vertex's way: widely on the banks of what is thick and on
///    both sides of sheets, not at all on drops and round ends. Where it turns sideways is where the fit ends.
/// 3. Bi-Laplacian again.
/// 4. Back by the mean of what steps 1 to 3 took: long waves return.
///
/// Means take in the edges near, those alone that face the vertex's way: the two sides of a sheet do not see each
/// other. All of it is a continuous map of the plane made of a measure that changes continuously. Velocities are
/// carried through. No edges cross afterwards that did not before.
///
/// same    bytes for any thread count
/// cost    O(passes · vertices · edges within reach)
/// source  Taubin 1995; Guennebaud & Gross 2007, Algebraic point set surfaces
void smoothSkin(BetaCurve& curve, const SkinSmoothing& params);

}  // namespace betamesh
