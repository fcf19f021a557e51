// From the boundary of discs to the skin: inwards until every vertex is deep enough.

#pragma once

#include "planar/beta_curve.h"
#include "skin/boundary_samples.h"

#include <functional>

namespace betamesh {

/// The lengths of a skin, world units; 0 < skin < joining.
///
/// Discs of radius `joining` decide what belongs together. The curve lies `skin` outside the outermost particles: a
/// disc of radius rolling(), rolled round discs of radius `skin`, stays outside it. The boundary of discs of radius
/// outer() is where that disc's centre goes; outer² = joining² + rolling², so its two ways past a pair of particles
/// meet exactly where discs of radius `joining` touch.
struct CurveSkin {
    double joining = 0, skin = 0;
    double spacing = 0;  ///< of the particles: what widths and steps are measured in

    double rolling() const { return (joining * joining - skin * skin) / (2 * skin); }
    double outer() const { return skin + rolling(); }
    double reach() const;  ///< from the curve to what of the outer boundary has a say
};

/// What depth is measured from: the boundary of discs of the outer radius.
struct OuterBoundary {
    BoundarySamples samples;      ///< a tenth of a spacing apart
    std::vector<DualVec3> corners;  ///< where two circles meet
};

/// Moves vertices from the boundary of discs of the joining radius to where they are rolling() deep below the outer
/// boundary, less swelling(x). Each goes away from the outer boundary's nearest points, softly chosen, in short steps,
/// every one the mean of such steps of the vertices near: that changes slowly from place to place and folds nothing.
/// Vertices that are deep enough stay. Velocities are carried through all of it.
///
/// in      swelling: how much farther from the particles the curve is to lie at a point, world units
/// same    bytes for any thread count
/// cost    O(vertices · samples within reach)
/// source  solvent-excluded surface: Connolly 1983
void retract(const OuterBoundary& outer, const CurveSkin& skin, const std::function<Dual(const DualVec3& x)>& swelling,
             BetaCurve& curve);

}  // namespace betamesh
