// The paper's tessellation: from the ball boundary to the beta mesh before smoothing.

#pragma once

#include "skin/ball_boundary.h"
#include "skin/beta_mesh.h"

namespace betamesh {

/// The paper's tessellation. Each cycle of the boundary is cut into fans where it goes round a rim. The alphabeta
/// vertex of a fan is the projection of its particle onto the fan's plane. For a closed fan that plane is normal to the
/// length-weighted sum of the sphere's normals along the fan's edges, which puts the vertex at the weighted mean of the
/// edges' midpoints; for an open fan it is normal to the fan's alpha triangles, which keeps the vertex above the
/// particle, at the rim of the sheet. Rims of thin sheets are closed as in the paper's Figure 6. Where more than two
/// sheets meet in one particle, the polygon between their rims is closed as well, which the paper leaves open.
///
/// in      a boundary; its balls and vertices with their motion
/// out     a closed oriented mesh (edges in opposite pairs), without full circles and isolated spheres
/// same    result for any thread count
/// cost    O(boundary)
/// source  beta mesh paper, section 3.4.2, steps 1 and 2
PaperMesh paperTessellation(const BallBoundary& boundary, const std::vector<DualVec3>& balls,
                            const std::vector<DualVec3>& vertices);

/// What the paper's beta mesh leaves out, each particle once, as spheres of the particles' radius: isolated particles
/// and both ends of degenerate edges.
Spheres externalSpheres(const BallBoundary& boundary, const Particles& particles);

}  // namespace betamesh
