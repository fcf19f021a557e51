// Smoothing of the union of balls that is continuous in time.

#pragma once

#include "skin/beta_mesh.h"
#include "skin/boundary_samples.h"
#include "skin/scale_means.h"

#include <optional>
#include <vector>

namespace betamesh {

struct CoherentSmoothing {
    double radius = 0;  ///< of the largest balls, world units
    double width = 0;   ///< kernel width beside them, world units; by default 2.8 radii
    int passes = 1;     ///< >= 0
};

/// Moves vertices onto spheres fitted to the samples of the boundary near them.
///
/// The connectivity of vertices and faces is not used. Every term is a sum over a measure that changes continuously in
/// time, weighted by smooth functions of position and direction; the surface therefore moves continuously through every
/// change of the boundary's connectivity. With positions y relative to the vertex x, directions d and weights w of the
/// samples, where |y|² and y·d are means over the piece that a sample represents, and lengths in radii:
///
///     m = Σ w K d / Σ w K,  K = (1 - |y|²/width²)₊²                                 mean direction
///     k = w K (m·d)₊² / (|m|² + ε) · (1 - (m·y)² / (s (|m|² + ε) (|y|² + 1)))₊²     weight of a sample
///
/// ε = kMinSquaredMean, s = kMaxSquaredSlope. The weights k separate the two sides of a sheet, and surfaces far above
/// or below. The algebraic sphere u_c + u_l·y + u_q |y|² whose gradient fits the directions best passes near x at
/// x + τ u_l. That step is multiplied by two trust factors. With W = Σ k, about 20 on a plane surface and small at a
/// neck that has just appeared, the first is W² / (W² + kHalfTrustWeight²). The second, |m|⁶ / (|m|⁶ +
/// kHalfTrustDirection³), is near 1 where the surface faces one way and 0 where two parts of it meet in a point. Both
/// leave such a point where it is, so parts join without a jump. Vertices with a rim_distance above kStayFull (drops,
/// tips of tendrils) stay, from kStayBegins on they take part of the step, and no vertex moves farther than
/// kMaxSmoothingStep, so that no particle is left outside. Spheres, cylinders and planes of balls keep their size.
/// Vertices that fade in are blended with the smoothed positions of their supports; otherwise the
/// triangles there would jump.
///
/// Among balls of different radii all lengths at a vertex, with ε for W, are those for balls as large as the mean of
/// the samples' scales near it, over widths that begin with BetaMesh::scale; how far it may move depends on the
/// smallest of them.
///
/// Velocities are differentiated through all of it.
///
/// same    bytes for any thread count and instruction set
/// cost    O(passes · vertices · samples within reach)
/// source  Guennebaud & Gross 2007, Algebraic point set surfaces
class CoherentSmoother {
public:
    CoherentSmoother(SamplesInRadii samples, const CoherentSmoothing& params);
    CoherentSmoother(CoherentSmoother&&) noexcept;
    ~CoherentSmoother();

    /// Smooths a mesh and returns the previous positions of its vertices. To be called once.
    DualPoints smooth(BetaMesh& mesh);

private:
    class Cloud;
    using Octaves = std::vector<std::vector<std::uint32_t>>;  // rows of each octave

    bool isLast(int pass) const;
    void buildClouds(int pass);
    void moveVertices(int pass, const Octaves& vertices, const ScaleMeans::Scales& scales,
                      const std::vector<DualVec3>& begin, BetaMesh& mesh) const;
    void smoothSamples(bool have_scales);

    CoherentSmoothing params_;
    std::size_t octaves_ = 1;                // that the balls and, hence, the vertices are in
    SamplesInRadii samples_;                 // released in the last pass
    std::optional<ScaleMeans> scale_means_;  // of the samples; none where all balls are equal
    std::vector<Cloud> clouds_;              // the samples, arranged for sums at the vertices of each octave
};

}  // namespace betamesh
