// Positions -> calmer positions, continuously in time.

#pragma once

#include "skin/beta_mesh.h"
#include "skin/boundary_samples.h"

#include <memory>

namespace betamesh {

struct CoherentSmoothing {
    double radius = 0;  ///< of the balls, world units
    double width = 0;   ///< how far a sample reaches, world units; 2.8 radii unless there is a reason
    int passes = 1;     ///< >= 0
    double inset = 0;   ///< how far the surface is taken inwards where the liquid is thick, world units, >= 0
};

/// Moves vertices onto spheres fitted to the boundary's samples round them.
///
/// Nothing here knows which vertices or faces are neighbours. Every term is a sum over a measure that changes
/// continuously in time, weighted by smooth functions of position and direction, so the surface moves continuously
/// through every change of the boundary's connectivity. In relative positions y, directions d, weights w, where |y|²
/// and y·d are means over the piece that a sample stands for:
///
///     m = Σ w K d / Σ w K,  K = (1 - |y|²/width²)₊²               the mean direction
///     k = w K (m·d)₊² / (|m|² + 0.01) · (1 - (m·y)² / (0.5 (|m|² + 0.01) (|y|² + r²)))₊²
///
/// keeps the two sides of a sheet, and surfaces far below or above, apart; then the algebraic sphere
/// u_c + u_l·y + u_q |y|² whose gradient fits the directions best passes near x at x + τ u_l. That counts by
/// W² / (W² + 1.5²), W = Σ k in radii, about 20 on a plane surface, little round a neck that has just appeared; and by
/// |m|⁶ / (|m|⁶ + 0.15³), nearly 1 where the surface faces one way, 0 where two parts of it meet in a point: both leave
/// that point where it is, so they join there without a jump. A vertex with rim_distance above 1.4 (a drop, the tip of a
/// tendril) stays where it is, from 0.7 on it goes part of the way; and no vertex goes farther than half a radius, so
/// that no particle is ever left outside. Spheres, cylinders and planes of balls keep their size. Vertices that only
/// begin to rise from an edge or a facet are held back towards what becomes of that, or the triangles, which are plane,
/// would jump.
///
/// An inset takes vertices inwards along the fitted spheres' directions, by at most 0.45 of the liquid's thickness
/// there, whose inverse square is a sum over the samples on the other side: (m·d)₋² (m·y)₋² / (|m|⁴ (|y|² + 0.04 r²)³).
/// It vanishes at a pinch, where the directions do.
///
/// Velocities are carried through all of it.
///
/// same    bytes for any thread count and instruction set
/// cost    O(passes · vertices · samples within reach)
/// source  Guennebaud & Gross 2007, Algebraic point set surfaces
class CoherentSmoother {
public:
    CoherentSmoother(SamplesInRadii samples, const CoherentSmoothing& params);
    ~CoherentSmoother();

    /// All of a mesh, once; returns where its vertices were before.
    DualPoints smooth(BetaMesh& mesh);

private:
    class Cloud;

    bool isLast(int pass) const;
    void takeSamples(int pass);

    CoherentSmoothing params_;
    SamplesInRadii samples_;        // none in the last pass
    std::unique_ptr<Cloud> cloud_;  // of them, as sums take them
};

}  // namespace betamesh
