// What may be exposed of each ball, in patches of directions.

#pragma once

#include "core/vec3.h"

#include <array>
#include <cstdint>
#include <vector>

namespace betamesh {

/// Patches of the unit sphere, the faces of an icosahedron whose edges are cut in four, each as its
/// midpoint and the angle within which it surely lies.
inline constexpr std::size_t kPatches = 320;
struct DirectionPatches {
    alignas(64) std::array<float, kPatches> x, y, z;
    float cos_angle, sin_angle;
    std::array<std::array<Vec3, 3>, kPatches> corners;  ///< of the faces
};
const DirectionPatches& directionPatches();

/// Bit p is set where patch p of a ball's sphere is not wholly inside one other ball.
using PatchMask = std::array<std::uint64_t, kPatches / 64>;

/// Particles that may be exposed, one row each.
struct Survivors {
    std::vector<std::uint32_t> particle;  ///< rows of SnappedParticles, ascending
    std::vector<PatchMask> uncovered;
};

}  // namespace betamesh
