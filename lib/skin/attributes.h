// What else particles carry, on the surface.

#pragma once

#include "base/dual.h"
#include "betamesh/particles.h"

#include <string>
#include <vector>

namespace betamesh {

/// The named attributes of the particles as columns for the vertices of a mesh or of curves. Real numbers are means
/// over the balls within 2r of the vertex, (1 - d²/4r²)² their weight; whole numbers are those of the ball that weighs
/// most. Where no ball is that near they are zero. Accelerations (accel, acceleration) come unasked: with them motion
/// blur is curved.
///
/// in      n positions; balls and the rows of their particles; names that the particles have, each once (without
///         particles, ones they lack are left out)
/// out     one attribute of n rows for each name, in the order of the names, then accelerations
/// same    bytes for any thread count and particle order
/// cost    O(n)
/// errors  a name that the particles do not have: the text lists those they have
std::vector<Attribute> carriedAttributes(const Particles& particles, const std::vector<std::uint32_t>& rows,
                                         const std::vector<DualVec3>& balls, double radius,
                                         const std::vector<std::string>& names, const std::vector<Vec3>& position);

}  // namespace betamesh
