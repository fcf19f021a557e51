// Turns triangles the right way up that lie upside down between their neighbours.

#pragma once

#include "skin/beta_mesh.h"

#include <vector>

namespace betamesh {

/// Where vertices have moved past each other within the surface, a triangle lies upside down between two layers of
/// others. On a calm surface it is a black speck. This replaces edges of such triangles by the other diagonals of their
/// quads until, where that is possible, all triangles face outwards. No vertex moves.
///
/// in      normal: of the surface at each vertex, roughly; spacing: of the particles, world units; farthest: distance
///         between two diagonals up to which one may replace the other, particle spacings. No two triangles cross
/// out     other triangles; again no two cross
/// same    triangles for any thread count
/// cost    O(triangles)
void unfold(const std::vector<Vec3f>& normal, double spacing, double farthest, BetaMesh& mesh);

}  // namespace betamesh
