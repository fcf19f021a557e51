// Star-shaped surfaces: those that are visible as a whole from one point.

#pragma once

#include "betamesh/vec3.h"

#include <array>
#include <span>

namespace betamesh {

/// Is a closed surface star-shaped about the centre: is every direction from it covered by exactly one triangle, from
/// inside? Then the surface does not cross or touch itself. Uses exact signs. Also false if the one ray that is counted
/// meets an edge.
///
/// in      all triangles of a closed surface, counter-clockwise seen from outside; coordinates as in
///         exact/orientation.h
/// cost    O(triangles), about 40 ns each
/// source  if all triangles face away from the centre, every direction is covered equally often, as crossing an edge
///         leaves one triangle and enters another: counting on one ray is enough
bool isStarShaped(const Vec3& centre, std::span<const std::array<Vec3, 3>> triangles);

}  // namespace betamesh
