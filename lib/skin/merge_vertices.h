// Vertices at the same position.

#pragma once

#include "skin/beta_mesh.h"

namespace betamesh {

/// Merges vertices at the same position that an edge connects, where this keeps the topology: the surface stays as it
/// is, without triangles of no area. Where four or more balls meet in exactly one point, as on regular grids, every arc
/// between their vertices has no length. The vertex with the lower number stays. Rows of vertices do not change; those
/// that have been merged are not used any more.
///
/// cost    O(triangles)
void mergeCoincidentVertices(BetaMesh& mesh);

}  // namespace betamesh
