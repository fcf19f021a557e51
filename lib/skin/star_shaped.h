// Surfaces that one point sees all of.

#pragma once

#include "betamesh/vec3.h"

#include <array>
#include <span>

namespace betamesh {

/// Is every direction from the centre covered by one triangle of a closed surface, from inside, and by no other? Then
/// it does not cross or touch itself. Exact signs; also false where the one direction that is counted runs along an
/// edge.
///
/// in      all triangles of a closed surface, counter-clockwise seen from outside; coordinates as in
///         exact/orientation.h
/// cost    O(triangles), some 40 ns each
/// source  triangles that all turn the same way cover every direction equally often, as crossing an edge leaves one
///         and enters another
bool isStarShaped(const Vec3& centre, std::span<const std::array<Vec3, 3>> triangles);

}  // namespace betamesh
