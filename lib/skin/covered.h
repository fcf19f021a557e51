// Which balls are surely buried: most of a liquid's are, and leave before anything is measured.

#pragma once

#include "exact/snapped_particles.h"

#include <algorithm>

namespace betamesh {

/// Where a particle lies in its cell, along each axis in 32nds of the cell's edge: all that is asked of it here.
using PlaceInCell = std::uint16_t;
inline constexpr std::uint32_t kPlacesAlongCell = 32;
inline constexpr std::size_t kPlacesInCell = std::size_t{kPlacesAlongCell} * kPlacesAlongCell * kPlacesAlongCell;

/// from_corner: from the cell's lowest corner, in quanta.
inline PlaceInCell placeInCell(const Vec3i& from_corner, std::int64_t radius) {
    const float per_quantum = static_cast<float>(kPlacesAlongCell / 2) / static_cast<float>(radius);
    const auto along = [&](std::int64_t x) {
        return std::min(static_cast<std::uint32_t>(static_cast<float>(x) * per_quantum), kPlacesAlongCell - 1);
    };
    return static_cast<PlaceInCell>(
        along(from_corner.x) + kPlacesAlongCell * (along(from_corner.y) + kPlacesAlongCell * along(from_corner.z)));
}

/// Finds particles whose whole sphere surely lies inside other balls, without looking at neighbours: in a grid of bits
/// every ball sets the voxels (edge R/4) that lie wholly inside it, and a particle is buried where its sphere passes
/// through set voxels only. Which voxels these are is read from tables made for a particle anywhere in a quarter of a
/// voxel, so the answer is never wrong, only conservative; cells without particles count as not covered, but beside
/// crowds. What covers a particle's ball lies in its cell and the 26 round it.
///
/// in      cells in order and the first of the particles of each, as in SnappedParticles, and where these lie
/// out     for every particle whether it is buried, the same for those at the same place in a cell
/// same    result for any thread count, instruction set and order of particles in a cell
/// cost    O(n), some 40 ns a particle; 64 bytes a cell, and an empty one beside a crowd
std::vector<std::uint8_t> coveredParticles(const std::vector<Vec3i>& cell, const std::vector<std::uint32_t>& cell_begin,
                                 const std::vector<PlaceInCell>& place);

}  // namespace betamesh
