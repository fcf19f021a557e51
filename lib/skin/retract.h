// The boundary of the union of balls -> the skin: vertices move inwards until each has the depth of the skin.

#pragma once

#include "skin/deforming_mesh.h"
#include "skin/outer_boundary.h"

namespace betamesh {

/// The lengths that define a skin, all in particle spacings.
///
/// Balls of radius `joining` decide which particles are connected. The skin is the boundary of the region that a ball
/// of radius rolling() cannot enter when it rolls over balls of radius `skin`; it is `skin` away from the outermost
/// particles. Since outer()² = joining² + rolling()², two balls of the joining radius touch exactly when the skins
/// around both meet, and the hole between three balls closes exactly when the skin closes there.
struct SkinLengths {
    double joining = 1.5;      ///< > 0
    double skin = 0.55;        ///< > 0, < joining
    bool volume_true = false;  ///< threads and drops are a little thicker than `skin`, which makes their volume true
    double edge_factor = 1;    ///< >= 1: scales the edge lengths at which the mesh is refined

    double rolling() const { return (joining * joining - skin * skin) / (2 * skin); }
    double outer() const { return skin + rolling(); }
};

/// Moves the vertices of the union of balls of the joining radius to depth rolling() below the boundary of the union of
/// balls of the outer radius. Each vertex moves away from the nearest samples of that boundary, chosen by a smooth
/// weight. Every step is a kernel mean of such displacements over space and is short compared with the kernel's width:
/// so smooth a displacement field cannot fold the mesh. Long edges in strongly curved parts are split on the way.
/// Vertices that are deep enough stay. Velocities become kernel means of those of the nearest samples: along its
/// normal, a surface at constant depth moves as fast as they do.
///
/// same    bytes for any thread count and instruction set
/// cost    O(vertices · samples within reach)
/// source  solvent-excluded surface: Connolly 1983
void retract(const OuterSamples& outer, const SkinLengths& lengths, DeformingMesh& surface);

}  // namespace betamesh
