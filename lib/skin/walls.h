// Lays the surface flat against plane walls.

#pragma once

#include "betamesh/skin_params.h"
#include "skin/ball_boundary.h"
#include "skin/beta_mesh.h"

namespace betamesh {

/// A point after its distance s from the wall has been replaced by a smooth, increasing function of s. Within 0.5
/// spacings of the wall, on either side, 0.01 s remains; from 1.25 spacings on s itself. Since the function increases,
/// space is compressed and never folded.
DualVec3 laidAgainst(const Wall& wall, double spacing, const DualVec3& point);

/// Lays the surface against walls, one after the other, and removes the self-intersections that this causes where
/// triangles are large for its curvature. A vertex that fades in takes the displacement of its supports. The
/// spacing at a vertex is BetaMesh::scale times that of the frame.
///
/// in      a mesh without self-intersections; spacing: of the particles, of the largest if their sizes differ, world
///         units
/// out     positions and velocities; rounded positions and a number of crossings, as resolveSelfIntersections()
/// same    bytes for any thread count
/// cost    O(vertices · walls), plus that of resolveSelfIntersections()
std::size_t layAgainstWalls(const std::vector<Wall>& walls, double spacing, const BallBoundary& boundary,
                            BetaMesh& mesh);

}  // namespace betamesh
