// From the boundary of discs to the skin: vertices move inwards to the depth of the skin.

#pragma once

#include "planar/boundary_curves.h"
#include "planar/scaled_points.h"
#include "skin/boundary_samples.h"
#include "skin/skin_lengths.h"

#include <functional>

namespace betamesh {

/// The lengths that define a skin, world units; 0 < skin < joining.
///
/// Discs of radius `joining` determine which particles are connected. The skin is `skin` outside the outermost
/// particles: it is the boundary of what a disc of radius rolling() cannot reach when it rolls around discs of radius
/// `skin`. The centre of the rolling disc follows the boundary of discs of radius outer(). As outer² = joining² +
/// rolling², the two positions of the rolling disc beside a pair of particles coincide exactly where discs of radius
/// `joining` touch.
struct CurveSkin {
    double joining = 0, skin = 0;
    double spacing = 0;  ///< particle spacing: the unit of widths and steps

    double rolling() const { return rollingRadius(joining, skin); }
    double outer() const { return skin + rolling(); }
    double reach() const;  ///< distance from the curve within which the outer boundary influences it
};

/// A point in a gap that is too narrow for the rolling disc, where a smaller one rolls.
struct GapPoint {
    DualVec3 position;
    Dual weight;          ///< world units of length
    Dual squared_offset;  ///< added to square distances from it, which are divided by the square of the scale there
    Dual scale;           ///< radius of the disc it belongs to, in radii of the largest
};

/// The boundary of discs of the outer radius, from which depth is measured.
struct OuterBoundary {
    BoundarySamples samples;        ///< a tenth of a spacing apart
    std::vector<DualVec3> corners;  ///< intersections of two circles
    std::vector<Dual> scale;        ///< of the samples and then of the corners: radius of the disc there, in radii of
                                    ///< the largest; empty: all 1
    std::vector<Dual> squared_offset;  ///< of these, as in GapPoint
    std::vector<GapPoint> gaps;        ///< points where smaller discs roll
};

/// Moves vertices from the boundary of discs of radius `joining` inwards until they are rolling() - extra_skin(x) deep
/// below the outer boundary. Where discs differ in size, all lengths are those of the largest discs; depths below a
/// point of the outer boundary, and distances from it, are in proportion to the scale there, and widths and steps to
/// that of the curve. Every step is directed away from the nearest points of the outer boundary, with soft
/// weights, and is smoothed along the curve, so displacements vary slowly and fold nothing. Vertices that are deep
/// enough stay. Velocities are carried through.
///
/// in      extra_skin(x): additional distance between the curve and the particles at a point, world units
/// same    bytes for any thread count
/// cost    O(vertices · samples within reach)
/// source  solvent-excluded surface: Connolly 1983
void retract(const OuterBoundary& outer, const CurveSkin& skin,
             const std::function<Dual(const DualVec3& x)>& extra_skin, BetaCurve& curve);

/// How isolated the particles near a point are.
class IsolationField {
public:
    /// particles: all of them. A particle's isolation is 1 if discs of the larger radius, wide_radius, do not intersect
    /// its own, and 0 if discs of the other radius do; it varies smoothly between. scale: of each particle, in
    /// proportion to which both radii are; empty: all 1.
    IsolationField(const std::vector<DualVec3>& particles, double radius, double wide_radius,
                   std::vector<double> scale);

    /// Weighted mean of the isolation of particles near x, in [0, 1]; 0 if there are none. Continuous.
    Dual at(const DualVec3& x) const;

private:
    double scaleOf(std::size_t i) const { return scale_.empty() ? 1 : scale_[i]; }

    std::vector<DualVec3> particles_;
    std::vector<double> scale_;
    double reach_;
    ScaledPoints cells_;
    std::vector<Dual> isolation_;
};

}  // namespace betamesh
