// From the boundary of the union of balls to the skin: inwards until every vertex is deep enough.

#pragma once

#include "skin/deforming_mesh.h"
#include "skin/outer_boundary.h"

namespace betamesh {

/// The lengths that make a skin, all in particle spacings.
///
/// Balls of radius `joining` decide what belongs together. The surface lies `skin` outside the outermost particles: it
/// is what a ball of radius rolling(), rolled round balls of radius `skin`, cannot reach. As
/// outer()² = joining² + rolling()², two balls of the joining radius touch exactly when the surfaces round both meet,
/// and the hole between three closes exactly when the surface closes there.
struct SkinLengths {
    double joining = 1.5;      ///< > 0
    double skin = 0.55;        ///< > 0, < joining
    bool volume_true = false;  ///< threads and drops get a little more than `skin`, as their volume asks for
    double coarser = 1;        ///< edges may be so many times as long as by default before they are split

    double rolling() const { return (joining * joining - skin * skin) / (2 * skin); }
    double outer() const { return skin + rolling(); }
};

/// Moves the vertices of the union of balls of the joining radius to where they are rolling() deep below the boundary
/// of the union of balls of the outer radius. Each goes away from the nearest points of that boundary, softly chosen;
/// every step is a mean of such steps over what is near in space, and is short against the width of that mean: a field
/// that changes so slowly from place to place moves space without folding it. Long edges where the surface is strongly
/// curved are split on the way. Vertices that are deep enough stay. Velocities become those of the boundary's nearest
/// points, averaged alike: a surface at a fixed depth goes along its normal as fast as they do.
///
/// same    bytes for any thread count and instruction set
/// cost    O(vertices · samples within reach)
/// source  solvent-excluded surface: Connolly 1983
void retract(const OuterSamples& outer, const SkinLengths& lengths, DeformingMesh& surface);

}  // namespace betamesh
