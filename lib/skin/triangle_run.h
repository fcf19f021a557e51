// Which ways triangles face that stand one after another in a mesh, and how they have moved: many at once.

#pragma once

#include "base/box.h"
#include "skin/beta_mesh.h"

#include <array>
#include <cmath>
#include <cstdint>

namespace betamesh {

/// Bounds of whatever was rounded to x.
inline float justBelow(float x) { return x - std::abs(x) * 0x1p-23F; }
inline float justAbove(float x) { return x + std::abs(x) * 0x1p-23F; }

inline constexpr std::size_t kRun = 16;  ///< triangles at once
/// With all directions: never had an area, as far as is known.
inline constexpr std::uint64_t kFlat = std::uint64_t{1} << 63;

bool isFlat(const std::vector<DualVec3>& vertex, const Triangle& triangle);

/// Triangle begin + i of a mesh in lane i.
struct TriangleRun {
    /// before: where vertices were. size: at most kRun; what stands in lanes from there on means nothing.
    TriangleRun(const BetaMesh& mesh, const std::vector<Vec3>& before, std::uint32_t begin, std::uint32_t size);

    /// Holds the triangle, however it is rounded.
    Boxf box(std::size_t lane) const {
        return {{low[0][lane], low[1][lane], low[2][lane]}, {high[0][lane], high[1][lane], high[2][lane]}};
    }

    /// A bit for each of 42 directions within some 70 degrees of the normal; all bits where kFlat is one.
    /// Triangles with a common one are parts of a surface over a plane, as far as they alone show it.
    std::array<std::uint64_t, kRun> facing;
    std::array<std::uint8_t, kRun> octant;          ///< of the normal
    std::array<std::uint8_t, kRun> moved;           ///< a corner of it has
    std::array<std::uint8_t, kRun> turned;          ///< over: the normal is a right angle or more from what it was
    std::array<std::array<float, kRun>, 3> normal;  ///< of unit length, zero without area; by axis, as what follows
    std::array<std::array<float, kRun>, 3> low, high;
};

}  // namespace betamesh
