// The alpha mesh, read from the ball boundary.

#pragma once

#include "base/dual.h"
#include "skin/ball_boundary.h"

namespace betamesh {

/// The oriented triangles of particles whose r-ball on the side of the normal is empty: one per vertex of the boundary,
/// counter-clockwise seen from the empty ball. A thin sheet has each of its triangles twice, once for either side.
/// Particles that no triangle uses are left out.
///
/// in      a boundary, with or without arcs; its balls with their motion
/// same    bytes for any thread count and particle order
/// cost    O(triangles)
/// source  beta mesh paper, section 3.2; Edelsbrunner & Mücke 1994
Mesh alphaMesh(const BallBoundary& boundary, const std::vector<DualVec3>& balls);

/// The number of triplets whose triangle is exposed on both sides.
std::size_t doubleSidedTriangles(const BallBoundary& boundary);

}  // namespace betamesh
