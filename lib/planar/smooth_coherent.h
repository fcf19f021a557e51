// Positions -> calmer positions, continuously in time.

#pragma once

#include "planar/beta_curve.h"
#include "skin/boundary_samples.h"

namespace betamesh {

struct CurveSmoothing {
    double radius = 0;  ///< of the discs, world units
    double width = 0;   ///< how far a sample reaches, world units; 2.8 radii unless there is a reason
    int passes = 1;     ///< >= 0
};

/// Moves every vertex onto a circle fitted to the boundary's samples round it.
///
/// Nothing here knows who is whose neighbour. With relative positions y, directions d, weights w and
/// K_h = (1 - |y|²/h²)₊², m = Σ w K d / Σ w K for h = width/2 is the mean direction, and for h = width
///
///     k = w K (m·d)₊² / (|m|² + 0.01) · (1 - (m·y)² / (0.2 (|m|² + 0.01) (|y|² + r²)))₊²
///
/// keeps the two sides of what is thin, and curves far below or above, apart; then the algebraic circle
/// u_c + u_l·y + u_q |y|² whose gradient fits the directions best passes near x at x + τ u_l. That counts by
/// W² / (W² + 0.25²), W = Σ k in radii, about 3 on a straight boundary, by 1 / (1 + (E / 0.25)⁴), E the mean square by
/// which the gradient misses the directions, and by M⁴ / (M⁴ + 0.2⁴), M = |m|²: a drop near a pool fits no circle with
/// it, in the gap directions cancel, and what nearly touches stays as it is. No vertex goes farther than half a radius.
/// What is smoothed is a continuous map of the plane, made of a measure that changes continuously, so the curve moves
/// continuously through every event. Arcs hold their own circle's directions: lone discs, rows and rings keep their
/// size.
///
/// Velocities are carried through all of it.
///
/// same    bytes for any thread count and instruction set
/// cost    O(passes · vertices · samples within reach)
/// source  Guennebaud & Gross 2007, Algebraic point set surfaces
void smoothCoherently(BetaCurve& curve, BoundarySamples samples, const CurveSmoothing& params);

}  // namespace betamesh
