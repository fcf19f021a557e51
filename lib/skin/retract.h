// The boundary of the union of balls -> the skin: vertices move inwards until each has the depth of the skin.

#pragma once

#include "skin/deforming_mesh.h"
#include "skin/outer_boundary.h"
#include "skin/skin_lengths.h"

namespace betamesh {

/// Moves the vertices of the union of balls of the joining radius to depth rolling() below the boundary of the union of
/// balls of the outer radius. Each vertex moves away from the nearest samples of that boundary, chosen by a smooth
/// weight. Every step is a kernel mean of such displacements over space and is short compared with the kernel's width:
/// so smooth a displacement field cannot fold the mesh. Vertices that are still far from their depth then, as at the
/// rims of holes, take further steps. Long edges in strongly curved parts are split on the way.
/// Vertices that are deep enough stay. Velocities become kernel means of those of the nearest samples: along its
/// normal, a surface at constant depth moves as fast as they do.
///
/// same    bytes for any thread count and instruction set
/// cost    O(vertices · samples within reach)
/// source  solvent-excluded surface: Connolly 1983
void retract(const OuterSamples& outer, const SkinLengths& lengths, DeformingMesh& surface);

}  // namespace betamesh
