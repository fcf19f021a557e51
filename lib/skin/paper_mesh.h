// The ball boundary -> the beta mesh before smoothing.

#pragma once

#include "skin/ball_boundary.h"
#include "skin/beta_mesh.h"

namespace betamesh {

/// The paper's tessellation. Each cycle of the boundary is cut into fans where it rolls over a rim; the
/// alphabeta vertex of a fan starts at the projection of its particle onto the fan's plane. For a closed fan
/// that plane is normal to the length-weighted sum of the sphere's normals along the fan's edges, which puts
/// the vertex at the weighted mean of the edges' midpoints; for an open fan it is normal to its alpha
/// triangles, which keeps the vertex above the particle, at the rim of the sheet. Rims of
/// thin sheets are closed as in the paper's Figure 6; where more than two sheets meet in one particle, the
/// polygon that is left between their rims is closed too, which the paper leaves open.
///
/// in      a boundary; its balls and vertices with their motion
/// out     a closed oriented mesh (edges in opposite pairs); full circles and bare spheres have no part in it
/// same    result for any thread count
/// cost    O(boundary)
/// source  beta mesh paper, section 3.4.2, steps 1 and 2
PaperMesh paperTessellation(const BallBoundary& boundary, const std::vector<DualVec3>& balls,
                            const std::vector<DualVec3>& vertices);

/// What has no part in the beta mesh: isolated particles and both ends of degenerate edges, each once, as
/// spheres of the particles' radius.
Spheres externalSpheres(const BallBoundary& boundary, const Particles& particles);

}  // namespace betamesh
