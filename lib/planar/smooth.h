// Smoothing of curves on the boundary of discs: the paper's averages, and fits that are continuous in time.

#pragma once

#include "planar/boundary_curves.h"
#include "skin/boundary_samples.h"

namespace betamesh {

/// The paper's smoothing of paperCurve(), `passes` times: every pure beta vertex moves to the mean of the midpoints of
/// its two faces, weighted by the distance between the faces' ends; then every alphabeta vertex moves to the midpoint
/// of its face. Curves have no rims, so thin features need no exception. Velocities are carried through.
///
/// cost    O(passes · vertices)
/// source  beta mesh paper, Algorithm 4 and Figure 8 (b)
void smoothAsInPaper(BetaCurve& curve, int passes);

/// Step 4 of the paper, for paperCurve(). A pure beta vertex behind its alpha segment moves onto the segment's line;
/// then an alphabeta vertex whose particle is to the right of either of its edges moves to the particle.
///
/// cost    O(vertices)
/// source  beta mesh paper, section 3.4.2, step 4, and Figure 8 (d); the first half is an addition, for smoothing
///         stronger than the paper's
void resolveIntersections(const DiscBoundary& boundary, const std::vector<DualVec3>& discs, BetaCurve& curve);

struct CurveSmoothing {
    double radius = 0;  ///< of the largest discs, world units
    double width = 0;   ///< radius of a sample's influence, world units; 2.8 radii unless there is a reason
    int passes = 1;     ///< >= 0
};

/// Moves every vertex onto a circle fitted to the samples of the boundary around it, without using connectivity.
///
/// Let y be the positions of samples relative to the vertex, d their directions, w their weights, and
/// K_h = (1 - |y|²/h²)₊². The mean direction is m = Σ w K d / Σ w K for h = width/2. For h = width, the weights
///
///     k = w K (m·d)₊² / (|m|² + 0.01) · (1 - (m·y)² / (0.2 (|m|² + 0.01) (|y|² + r²)))₊²
///
/// separate the two sides of thin features, and curves far below or above. The algebraic circle u_c + u_l·y + u_q |y|²
/// whose gradient fits the directions best passes near the vertex x at x + τ u_l. That displacement is multiplied
/// - by W² / (W² + 0.25²), W = Σ k in radii, about 3 on a straight boundary;
/// - by 1 / (1 + (E / 0.25)⁴), E the mean squared difference between gradient and directions: a drop near a pool fits
///   no circle with it;
/// - by M⁴ / (M⁴ + 0.2⁴), M = |m|²: in narrow gaps directions cancel, so boundaries that nearly touch do not move.
/// No vertex moves farther than half a radius, nor across the curve (moveWithoutCrossings()). The displacement is a
/// continuous function in the plane, made of a measure that changes continuously, so the curve moves continuously
/// through every event. Samples on an arc have its circle's directions, so isolated discs, rows and rings keep their
/// size. Velocities are carried through. Where discs differ in size, all lengths are those of the largest, and in
/// proportion to the scale at the vertex.
///
/// same    bytes for any thread count and instruction set
/// cost    O(passes · vertices · samples within reach)
/// source  Guennebaud & Gross 2007, Algebraic point set surfaces
void smoothCoherently(BetaCurve& curve, DiscSamples samples, const CurveSmoothing& params);

}  // namespace betamesh
