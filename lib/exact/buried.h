// Which balls are surely buried: most of a liquid's are, and leave before anything is measured.

#pragma once

#include "exact/snapped_particles.h"

namespace betamesh {

/// Where a particle lies in its cell, along each axis in 32nds of the cell's edge: all that is asked of it here.
using CellPlace = std::uint16_t;
inline constexpr std::uint32_t kPlacesAlongCell = 32;

/// from_corner: from the cell's lowest corner, in quanta.
CellPlace placeInCell(const Vec3i& from_corner, std::int64_t radius);

/// Finds particles whose whole sphere surely lies inside other balls, without looking at neighbours: in a grid of bits
/// every ball sets the voxels (edge R/4) that lie wholly inside it, and a particle is buried where its sphere passes
/// through set voxels only. Which voxels these are is read from tables made for a particle anywhere in a quarter of a
/// voxel, so the answer is never wrong, only conservative; cells without particles count as not covered. What decides
/// about a particle lies in its cell and the 26 round it.
///
/// in      cells in order and the first of the particles of each, as in SnappedParticles, and where these lie; asked:
///         which cells are to be looked at (0: not); empty: all
/// out     for every particle whether it is buried; 1 in cells that were not asked for
/// same    result for any thread count, instruction set and order of particles in a cell
/// cost    O(n), some 50 ns a particle; 64 bytes a cell
std::vector<std::uint8_t> buried(const std::vector<Vec3i>& cell, const std::vector<std::uint32_t>& cell_begin,
                                 const std::vector<CellPlace>& place, const std::vector<std::uint8_t>& asked);

}  // namespace betamesh
