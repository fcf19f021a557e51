// Fewer triangles for the same surface.

#pragma once

#include "betamesh/mesh.h"

namespace betamesh {

/// Removes vertices where the surface is flat. The others keep their position, velocity and attributes bit for bit.
///
/// Every point of one surface is within the tolerance of the other one. No triangles cross that did not before, every
/// component keeps its topology, and no triangle is inclined by more than 20° to the surface that was at its corners.
/// Vertices at borders, at edges of more than two triangles and where another part of the surface is close stay.
///
/// in      tolerance: world units, > 0
/// out     rows in their order; unused vertices are left out
/// same    bytes for any thread count
/// cost    O(triangles) times some 30 rounds; about 100 bytes a triangle
/// errors  a tolerance that is not a positive number; triangles whose vertices do not exist or are not finite
Mesh simplified(const Mesh& mesh, double tolerance);

}  // namespace betamesh
