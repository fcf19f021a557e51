// The paper's smoothing of its beta mesh. Connectivity does not change; velocities are carried along.

#pragma once

#include "skin/ball_boundary.h"
#include "skin/beta_mesh.h"

namespace betamesh {

/// Applies the paper's smoothing `passes` times: every pure beta vertex moves to the mean of the edge midpoints of its
/// faces, weighted by edge length; then every alphabeta vertex moves to that of its own face. Vertices on the rims of
/// thin sheets, pure and alphabeta, stay, or sheets would shrink. Velocities are differentiated through the means and
/// their weights.
///
/// same    bytes for any thread count
/// cost    O(passes · vertices)
/// source  beta mesh paper, Algorithm 4
void smoothAsInPaper(PaperMesh& mesh, int passes);

/// Step 4 of the paper. A pure beta vertex behind its alpha triangle moves onto the triangle's plane; then an alphabeta
/// vertex moves to its particle if that is outside any triangle of the fan. Afterwards no particle of a closed volume
/// is outside the mesh.
///
/// same    bytes for any thread count
/// cost    O(vertices)
/// source  beta mesh paper, section 3.4.2, step 4; the first half is added here, because more smoothing than in the
///         paper's examples pushes pure beta vertices through the alpha mesh
void resolveIntersections(const BallBoundary& boundary, const std::vector<DualVec3>& balls, PaperMesh& mesh);

}  // namespace betamesh
