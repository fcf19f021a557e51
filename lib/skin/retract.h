// From the boundary of the union of balls to the skin: inwards until every vertex is deep enough.

#pragma once

#include "skin/outer_boundary.h"
#include "skin/surface_measure.h"

namespace betamesh {

/// The two lengths of a skin, and the ball that rolls over it; all in particle spacings.
///
/// Balls of radius `joining` decide what belongs together. The surface lies `skin` outside the outermost particles: it
/// is what a ball of radius `rolling`, rolled round balls of radius `skin`, cannot reach. With the outer radius
/// skin + rolling, outer² = joining² + rolling²: the ball's two ways round a pair of particles meet exactly where balls
/// of radius `joining` touch.
struct SkinLengths {
    double joining = 1.5;
    double skin = 0.55;
    bool volume_true = false;  ///< threads and drops get a little more than the skin, as their volume asks for

    double rolling() const { return (joining * joining - skin * skin) / (2 * skin); }
    double outer() const { return skin + rolling(); }
};

/// Moves vertices from the boundary of the union of balls of the joining radius to where they are `rolling` deep below
/// the outer boundary. Each goes away from the outer boundary's nearest points, softly chosen, and every step is a mean
/// of such steps over the surface near: a field that changes slowly from place to place moves space without folding it.
/// Vertices that are deep enough stay. Velocities become those of the outer boundary's nearest points.
///
/// same    bytes for any thread count and instruction set
/// cost    O(vertices · samples within reach)
/// source  solvent-excluded surface: Connolly 1983
void retract(const OuterSamples& outer, const SkinLengths& lengths, MovedSurface& surface);

}  // namespace betamesh
