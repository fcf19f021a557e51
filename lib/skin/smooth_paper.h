// Positions -> calmer positions. Connectivity stays as it is, velocities follow.

#pragma once

#include "skin/ball_boundary.h"
#include "skin/beta_mesh.h"

namespace betamesh {

/// The paper's smoothing, `passes` times: every pure beta vertex moves to the mean of the edge midpoints of
/// its faces, weighted by edge length; then every alphabeta vertex to that of its own face. Vertices on the
/// rims of thin sheets, pure and alphabeta, stay where they are, or sheets would shrink.
/// Velocities are carried through the average and through its weights.
///
/// same    bytes for any thread count
/// cost    O(passes · vertices)
/// source  beta mesh paper, Algorithm 4
void smoothAsInPaper(PaperMesh& mesh, int passes);

/// Step 4 of the paper. A pure beta vertex that lies behind its alpha triangle moves onto the triangle's
/// plane; then an alphabeta vertex whose particle lies outside any triangle of its fan moves to the
/// particle. Afterwards no particle of a closed volume lies outside the mesh.
///
/// same    bytes for any thread count
/// cost    O(vertices)
/// source  beta mesh paper, section 3.4.2, step 4; the first half is ours: smoothing more than the paper's
///         examples do does push pure beta vertices through the alpha mesh
void resolveIntersections(const BallBoundary& boundary, const std::vector<DualVec3>& balls, PaperMesh& mesh);

}  // namespace betamesh
