// Normals, boxes and movement of consecutive triangles of a mesh, computed for many at once.

#pragma once

#include "base/box.h"
#include "skin/beta_mesh.h"

#include <array>
#include <cmath>
#include <cstdint>

namespace betamesh {

/// Lower and upper bounds of any number that was rounded to x.
inline float justBelow(float x) { return x - std::abs(x) * 0x1p-23F; }
inline float justAbove(float x) { return x + std::abs(x) * 0x1p-23F; }

inline constexpr std::size_t kRun = 16;  ///< triangles processed at once
/// Set, with all directions, in the mask of a triangle that has no area and had none before.
inline constexpr std::uint64_t kFlat = std::uint64_t{1} << 63;

/// Are the three corners on one line, by exact signs?
bool isFlat(const std::vector<DualVec3>& vertex, const Triangle& triangle);

/// Consecutive triangles, triangle begin + i in lane i.
struct TriangleRun {
    /// before: positions of the vertices before the displacement. size: <= kRun; further lanes are meaningless.
    TriangleRun(const BetaMesh& mesh, const std::vector<Vec3>& before, std::uint32_t begin, std::uint32_t size);

    /// Contains the triangle, whatever the rounding.
    Boxf box(std::size_t lane) const {
        return {{low[0][lane], low[1][lane], low[2][lane]}, {high[0][lane], high[1][lane], high[2][lane]}};
    }

    /// Facing mask: a bit for each of 42 directions that is within about 70 degrees of the normal; all bits of a
    /// triangle with kFlat. Two triangles with a common bit are both over the plane across that direction.
    std::array<std::uint64_t, kRun> facing;
    std::array<std::uint8_t, kRun> octant;             ///< of the normal
    std::array<std::uint8_t, kRun> moved;              ///< a corner has moved
    std::array<std::uint8_t, kRun> turned;             ///< the normal has turned by 90 degrees or more
    std::array<std::array<float, kRun>, 3> normal;     ///< by axis; unit length, zero without area
    std::array<std::array<float, kRun>, 3> low, high;  ///< boxes, by axis
};

}  // namespace betamesh
