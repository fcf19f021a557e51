// Coverage: which balls surely lie inside the others. Most of a liquid's do, and leave before anything exact is
// computed.

#pragma once

#include "exact/snapped_particles.h"

#include <algorithm>
#include <functional>

namespace betamesh {

/// Offset of a particle from the lowest corner of its cell, packed as x + 32 (y + 32 z), each in 32nds of the cell's
/// edge (which is 2R): the resolution at which coverage is decided.
using CellOffset = std::uint16_t;
inline constexpr std::uint32_t kStepsPerCell = 32;
inline constexpr std::size_t kCellOffsets = std::size_t{kStepsPerCell} * kStepsPerCell * kStepsPerCell;

/// in      offset from the cell's lowest corner and R, both in quanta
inline CellOffset cellOffset(const Vec3i& from_corner, std::int64_t radius) {
    const float steps_per_quantum = static_cast<float>(kStepsPerCell / 2) / static_cast<float>(radius);
    const auto steps = [&](std::int64_t x) {
        return std::min(static_cast<std::uint32_t>(static_cast<float>(x) * steps_per_quantum), kStepsPerCell - 1);
    };
    return static_cast<CellOffset>(steps(from_corner.x) +
                                   kStepsPerCell * (steps(from_corner.y) + kStepsPerCell * steps(from_corner.z)));
}

/// Finds particles whose whole sphere surely lies inside other balls, without a neighbour search. Every ball sets the
/// voxels (edge R/4) of a bit grid that lie wholly inside it; a particle is covered if its sphere passes through set
/// voxels only. Both sets of voxels come from tables made for all particles of a quarter voxel, so the answer is
/// conservative: a covered particle may be missed, an exposed one is never reported. Empty cells count as not covered,
/// except beside dense cells. Only the 27 cells round a particle can cover its ball.
///
/// in      cells in order and the first particle of each, as in SnappedParticles; each particle's offset in its cell
/// out     per particle, 1 if it is covered; particles with equal offsets in a cell get equal answers
/// same    result for any thread count, instruction set and order of particles in a cell
/// cost    O(n), about 40 ns per particle; 64 bytes per cell, and per empty cell beside a dense one
std::vector<std::uint8_t> coveredParticles(const std::vector<Vec3i>& cell, const std::vector<std::uint32_t>& cell_begin,
                                           const std::vector<CellOffset>& offset);

/// Marks a ball that balls of nearly its own radius cover, where radii are different; 1 marks other covered ones.
inline constexpr std::uint8_t kCoveredByAlike = 2;

/// The same for balls of different radii: of each of n, not 0 where others cover it that are at most about twice as
/// large or as small, or where it lies inside one at least twice as large; kCoveredByAlike where those that cover it
/// are at most a third larger or a quarter smaller. Balls that only balls of more unlike radii cover together are not
/// found: the more the radii differ, the fewer are.
///
/// in      radius of the largest, positions and radii, all in quanta
/// cost    O(n), about 50 ns per ball, 300 ns where radii vary by more than a third, and 1 µs for each that is not
///         covered; 20 bytes per ball
std::vector<std::uint8_t> coveredUnequal(std::size_t n, std::int64_t largest,
                                         const std::function<Vec3i(std::uint32_t)>& positionOf,
                                         const std::function<std::int64_t(std::uint32_t)>& radiusOf);

/// Coverage of snapped particles, as SnappedParticles::is_covered: computed unless it is known already.
std::vector<std::uint8_t> coverage(const SnappedParticles& particles);

/// The particles whose balls may be exposed: all but the covered ones. Coverage is computed unless it is known already.
///
/// out     rows of every particle with an exposed point, and of a few without, ascending
/// same    result for any thread count and instruction set
/// cost    O(n), about 40 ns per particle whose coverage is not known
std::vector<std::uint32_t> exposureCandidates(const SnappedParticles& particles);

/// Particles that may be outside the skin of larger ones: all but those that balls of nearly their own radius cover.
/// Rows, ascending.
///
/// in      balls of different radii
std::vector<std::uint32_t> notAmongAlike(const SnappedParticles& particles);

}  // namespace betamesh
