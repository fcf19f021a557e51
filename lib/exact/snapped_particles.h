// Particles snapped to an integer grid and sorted by cell, in an order that depends only on their positions.

#pragma once

#include "base/box.h"
#include "base/cell_grid.h"
#include "betamesh/particles.h"
#include "exact/predicates.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <span>
#include <tuple>

namespace betamesh {

/// The paper's perturbation: every particle is displaced by at most `tolerance` radii along each axis. The displacement
/// is a hash of its id (without ids: of its position) and of `attempt`. Attempt 0 moves nothing.
struct Jitter {
    double tolerance = 0;
    int attempt = 0;
};

/// The integer grid for balls of one radius.
class SnapGrid {
public:
    /// errors  a radius that is not a normal number
    explicit SnapGrid(double world_radius);

    /// Quanta per world unit, a power of two.
    double perUnit() const { return per_unit_; }
    /// The ball radius R in quanta, in (2^19, 2^20].
    std::int64_t radius() const { return radius_; }
    /// The nearest grid point; halves round away from zero. Coordinates have 24 bits, so adding half a quantum is
    /// exact.
    Vec3i at(const Vec3f& position) const {
        const auto nearest = [&](double x) { return static_cast<std::int64_t>(x + std::copysign(0.5, x)); };
        return {nearest(position.x * per_unit_), nearest(position.y * per_unit_), nearest(position.z * per_unit_)};
    }
    /// The cell that contains a grid point; cells have edge 2R.
    Vec3i cellOf(const Vec3i& position) const { return {cell(position.x), cell(position.y), cell(position.z)}; }
    /// Throws Error for the first position with a coordinate beyond 2^50 quanta. first_row: row number of positions[0]
    /// for the message.
    void requireWithin(std::span<const Vec3f> positions, std::size_t first_row) const;

private:
    // The rounded quotient is off by at most one, which the remainder shows.
    std::int64_t cell(std::int64_t x) const {
        const std::int64_t edge = 2 * radius_;
        const auto quotient = static_cast<std::int64_t>(static_cast<double>(x) * per_quantum_);
        const std::int64_t remainder = x - quotient * edge;
        return quotient - (remainder < 0) + (remainder >= edge);
    }

    double per_unit_ = 1, per_quantum_ = 1;  // quanta per world unit, cells per quantum
    std::int64_t radius_ = 0;
};

/// Which of n particles can influence the surface; made by NearSurfaceFinder in skin/near_surface.h.
struct NearSurface {
    std::size_t particles = 0;             ///< n
    double largest = 0;                    ///< radius of the largest of all n balls, world units; 0: none was given
    bool is_unequal = false;               ///< the n balls have different radii, in quanta of the largest
    bool all = true;                       ///< no selection was made: all particles are used, and the arrays are empty
    std::vector<std::uint32_t> row;        ///< selected particles, ascending
    std::vector<std::uint32_t> cell_of;    ///< cell of each selected particle, an index into cell
    std::vector<std::uint8_t> is_covered;  ///< of each selected particle: not 0 where its ball is known to be covered
    std::vector<Vec3i> cell;               ///< occupied cells, sorted by cellBefore()
    std::vector<std::uint8_t>
        is_incomplete;  ///< of each cell: 1 where particles of it or of an adjacent cell are left out

    std::size_t omitted() const { return all ? 0 : particles - row.size(); }
};

/// Particles whose balls are less than twice as large as each other, in cells of their own. These cells divide those of
/// SnappedParticles and contain consecutive particles.
struct SizeClass {
    struct Ball {
        Vec3i position;  ///< quanta
        std::int32_t radius;
        std::uint32_t particle;  ///< row of SnappedParticles
    };
    std::int64_t largest;    ///< radius up to which these are, quanta
    CellGrid cells;          ///< of their positions; the edge is at least 2 largest
    std::vector<Ball> ball;  ///< in the order of the cells
};

/// Distinct particles, sorted by cell of edge 2R (z, then y, then x) and within a cell by size class, its cells and
/// position.
/// World position = quantum · position. position, row and is_covered have one row per distinct particle.
struct SnappedParticles {
    double quantum = 1;                   ///< a power of two, world units
    std::int64_t radius = 0;              ///< radius R of the largest ball in quanta, in (2^19, 2^20]
    std::vector<std::int32_t> radius_of;  ///< of each ball, in quanta; empty: all R
    std::shared_ptr<const std::vector<SizeClass>> size_classes;  ///< the largest balls first; null: all R
    int most_halvings = 0;                 ///< cells of size classes are those of edge 2R halved at most so often
    std::vector<Vec3i> position;           ///< in quanta
    std::vector<std::uint32_t> row;        ///< row of the particle in the input
    std::vector<std::uint8_t> is_covered;  ///< not 0 where the ball is known to be covered; empty: not known

    std::vector<Vec3i> cell;                  ///< occupied cells, sorted by cellBefore()
    std::vector<std::uint32_t> cell_begin;    ///< first particle of each cell, and one entry past the last
    std::vector<std::uint8_t> is_incomplete;  ///< of each cell, as NearSurface::is_incomplete; empty: all 0

    std::size_t size() const { return position.size(); }
    std::int64_t radiusOf(std::size_t particle) const { return radius_of.empty() ? radius : radius_of[particle]; }
};

/// Snaps particles to the grid, in the same way in every frame and for every order of the particles. A coordinate moves
/// by at most half a quantum, which is less than 1e-6 radii. Of particles at one grid point the one with the smallest
/// id is kept (without ids: the one with the smallest bytes of velocity, then of the attributes).
///
/// in      n >= 0 valid particles, radius > 0 in world units
/// cost    O(n log n)
/// errors  a particle with a coordinate beyond 2^50 quanta; a radius that is not a normal number, or so large that
///         cells have more than 50,000 distinct particles on average, of which small ones count by their volume
SnappedParticles snapParticles(const Particles& particles, double radius, const Jitter& jitter = {});

/// The same for balls of different radii, one per particle, world units. The grid is that of the largest; of particles
/// at one grid point the one with the largest ball is kept. Where all radii are equal, the result is that for this
/// radius.
///
/// errors  those above, and a radius that is not positive or less than 2^-10 of the largest
SnappedParticles snapParticles(const Particles& particles, std::span<const double> radii);

/// The same for some of the balls only, the largest of which may not be among them: the grid is that of the radius
/// `largest`, and balls that all have one radius are treated like balls of different ones.
SnappedParticles snapParticles(const Particles& particles, std::span<const double> radii, double largest);

/// The same for the particles near the surface only. particles, radii: all of them, or only the selected ones in the
/// order of near.row.
SnappedParticles snapParticles(const Particles& particles, double radius, const NearSurface& near);
SnappedParticles snapParticles(const Particles& particles, std::span<const double> radii, const NearSurface& near);

/// Throws Error for the first ball whose radius is not positive or less than 2^-10 of the largest. first_row: row
/// number of radii[0] for the message.
void requireSimilar(std::span<const double> radii, double largest, std::size_t first_row);

/// Sets size_classes from radius_of; null where all radii are equal.
void listSizeClasses(SnappedParticles& particles);

/// The order of cells: by z, then y, then x.
inline bool cellBefore(const Vec3i& a, const Vec3i& b) { return std::tuple(a.z, a.y, a.x) < std::tuple(b.z, b.y, b.x); }

/// Finds the occupied cells among the 27 around a cell. Fastest when cells are queried in ascending order.
class NeighbourCells {
public:
    /// cells: sorted by cellBefore(); referred to.
    explicit NeighbourCells(const std::vector<Vec3i>& cells) : cells_(cells) {}

    /// Calls visit(offset from (0, 0, 0) to (2, 2, 2), index of the cell) for the occupied ones of the 27 cells, in
    /// order; the centre cell has offset (1, 1, 1). They contain every particle within 2R of one in the centre cell.
    template <typename Visit>
    void forEach(std::size_t cell, const Visit& visit) {
        const Vec3i centre = cells_[cell];
        for (std::size_t row = 0; row < first_.size(); ++row) {
            const auto dy = static_cast<std::int64_t>(row % 3) - 1, dz = static_cast<std::int64_t>(row / 3) - 1;
            first_[row] = firstFrom(first_[row], centre + Vec3i(-1, dy, dz));
            for (std::size_t at = first_[row]; at < cells_.size(); ++at) {
                if (cellBefore(centre + Vec3i(1, dy, dz), cells_[at])) break;
                visit(Vec3i(cells_[at].x - centre.x + 1, dy + 1, dz + 1), at);
            }
        }
    }

private:
    /// Index of the first cell that is not before `cell`: a galloping search from the previous result.
    std::size_t firstFrom(std::size_t previous, const Vec3i& cell) const {
        std::size_t low = previous, high = cells_.size();
        for (std::size_t step = 1; low + step < high; step *= 2) {
            if (!cellBefore(cells_[low + step], cell))
                high = low + step;
            else
                low += step;
        }
        if (low > 0 && !cellBefore(cells_[low - 1], cell)) low = 0;
        const auto begin = cells_.begin();
        return static_cast<std::size_t>(std::lower_bound(begin + static_cast<std::ptrdiff_t>(low),
                                                         begin + static_cast<std::ptrdiff_t>(high), cell, cellBefore) -
                                        begin);
    }

    const std::vector<Vec3i>& cells_;
    std::array<std::size_t, 9> first_{};  // previous result for each of the nine lines of cells along x
};

}  // namespace betamesh
