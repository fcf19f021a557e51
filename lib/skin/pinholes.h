// Small holes in sheets: narrowed, so that they open gradually.

#pragma once

#include "skin/ball_boundary.h"
#include "skin/deforming_mesh.h"

namespace betamesh {

/// Draws the surface together around the axes of holes that have just opened, and of membranes that are about to, by
/// increasing functions of the distance from the axis, which do not fold: what would be a speck with steep walls is
/// hardly wider than a point, and a hole grows in proportion to time where its radius would grow with the root. Holes
/// are where three balls have their spheres' common points close to the plane of their centres, or would have, were
/// they a little larger, and other balls close the gaps between them, but not the middle. Continuous in time,
/// but for clumps of more balls than kMaxPinholeNeighbours.
///
/// same    for any thread count
/// cost    O(triangles + balls), and O(neighbours²) for each ball near edges that turn
void narrowPinholes(const BallBoundary& boundary, DeformingMesh& surface);

}  // namespace betamesh
