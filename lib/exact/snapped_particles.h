// Particles on an integer grid, in an order that depends on nothing but where they are.

#pragma once

#include "base/box.h"
#include "betamesh/particles.h"
#include "exact/predicates.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <tuple>

namespace betamesh {

/// The paper's perturbation: every particle moves by up to `tolerance` radii along each axis, by a hash of
/// its id (of its position, without ids) and of `attempt`. Attempt 0 moves nothing.
struct Jitter {
    double tolerance = 0;
    int attempt = 0;
};

/// The integer grid for balls of one radius.
class SnapGrid {
public:
    /// errors  a radius that is not a normal number
    explicit SnapGrid(double world_radius);

    /// Quanta in a world unit, a power of two.
    double perUnit() const { return per_unit_; }
    /// R, in quanta, in (2^19, 2^20].
    std::int64_t radius() const { return radius_; }
    /// The nearest place, halves away from zero: coordinates have 24 bits, so that half a quantum more is exact.
    Vec3i at(const Vec3f& position) const {
        const auto nearest = [&](double x) { return static_cast<std::int64_t>(x + std::copysign(0.5, x)); };
        return {nearest(position.x * per_unit_), nearest(position.y * per_unit_), nearest(position.z * per_unit_)};
    }
    /// Of edge 2R.
    Vec3i cellOf(const Vec3i& position) const { return {cell(position.x), cell(position.y), cell(position.z)}; }
    /// Throws Error for the first position farther from the origin than 2^50 quanta; first_row: its number, for
    /// messages.
    void requireWithin(std::span<const Vec3f> positions, std::size_t first_row) const;

private:
    // The quotient is one off at most, which the rest tells.
    std::int64_t cell(std::int64_t x) const {
        const std::int64_t edge = 2 * radius_, near = static_cast<std::int64_t>(static_cast<double>(x) * per_quantum_);
        const std::int64_t rest = x - near * edge;
        return near - (rest < 0) + (rest >= edge);
    }

    double per_unit_ = 1, per_quantum_ = 1;  // quanta in a world unit, cells in a quantum
    std::int64_t radius_ = 0;
};

/// Which of n particles matter to the surface: see exact/near_surface.h.
struct NearSurface {
    std::size_t particles = 0;            ///< n
    bool all = true;                      ///< they all do, and nothing is known of them; the arrays are empty
    std::vector<std::uint32_t> row;       ///< theirs, ascending
    std::vector<std::uint32_t> cell_of;   ///< for each row which of the cells it lies in
    std::vector<std::uint8_t> is_buried;  ///< for each row whether the ball surely is
    std::vector<Vec3i> cell;              ///< theirs, in order
    std::vector<std::uint8_t> is_rim;     ///< of each cell: particles of it or of a cell beside it were left out

    std::size_t leftOut() const { return all ? 0 : particles - row.size(); }
};

/// Distinct particles, sorted by cell (z, y, x, the edge of a cell is 2R) and inside a cell by position.
/// World position = quantum · position. Every array but the cells' has one row per distinct particle.
struct SnappedParticles {
    double quantum = 1;       ///< a power of two, world units
    std::int64_t radius = 0;  ///< R, in quanta, in (2^19, 2^20]
    std::vector<Vec3i> position;
    std::vector<std::uint32_t> row;       ///< of the particle as it was given
    std::vector<std::uint8_t> is_buried;  ///< whether the ball surely is; empty: not known

    std::vector<Vec3i> cell;                ///< occupied cells, in order
    std::vector<std::uint32_t> cell_begin;  ///< first particle of each cell, and one entry past the last
    std::vector<std::uint8_t> is_rim;       ///< of each cell, as NearSurface::is_rim; empty: none is

    std::size_t size() const { return position.size(); }
};

/// Snaps once: the same way in every frame and for every order of the particles; a coordinate moves by at
/// most half a quantum, less than 1e-6 radii. Exact duplicates collapse onto the smallest id (without ids:
/// onto the smallest bytes of velocity, then of the attributes).
///
/// in      n >= 0 valid particles, radius > 0 in world units
/// cost    O(n log n)
/// errors  a particle farther from the origin than 2^50 quanta; a radius that is not a normal number, or so large that
///         there are more than 50,000 distinct particles for each cell
SnappedParticles snapParticles(const Particles& particles, double radius, const Jitter& jitter = {});

/// The same of those near the surface alone. particles: all, or where near.row is empty, only those.
SnappedParticles snapParticles(const Particles& particles, double radius, const NearSurface& near);

/// The order of cells: by z, then y, then x.
inline bool cellBefore(const Vec3i& a, const Vec3i& b) { return std::tuple(a.z, a.y, a.x) < std::tuple(b.z, b.y, b.x); }

/// Finds the cells round one among cells in order; quickest when asked for one after another.
class CellsAround {
public:
    explicit CellsAround(const std::vector<Vec3i>& cells) : cells_(cells) {}

    /// Calls visit(place from (0, 0, 0) to (2, 2, 2), number of the cell there) for those of the 27 cells round one
    /// that have particles, in order. Everything within 2R of a particle in the middle one is among theirs.
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
    /// The first that does not come before a place; it is not far from the one it was last.
    std::size_t firstFrom(std::size_t last, const Vec3i& place) const {
        std::size_t low = last, high = cells_.size();
        for (std::size_t step = 1; low + step < high; step *= 2) {
            if (!cellBefore(cells_[low + step], place))
                high = low + step;
            else
                low += step;
        }
        if (low > 0 && !cellBefore(cells_[low - 1], place)) low = 0;
        const auto begin = cells_.begin();
        return static_cast<std::size_t>(std::lower_bound(begin + static_cast<std::ptrdiff_t>(low),
                                                         begin + static_cast<std::ptrdiff_t>(high), place, cellBefore) -
                                        begin);
    }

    const std::vector<Vec3i>& cells_;
    std::array<std::size_t, 9> first_{};  // of each row of three, where it was last
};

/// Another particle seen from one: offset and its squared length in quanta, whole numbers.
struct Neighbour {
    Vec3 offset;
    double squared;
    std::uint32_t particle;
};

/// A cell with so many particles is a crowd; the radius of 1.5 spacings leaves some thirty in one.
inline constexpr std::uint32_t kDenseCell = 64;

/// Finds particles near one, itself left out, in the order of SnappedParticles. Quickest when asked for one particle of
/// a cell after another.
class NeighbourFinder {
public:
    explicit NeighbourFinder(const SnappedParticles& particles) : particles_(particles), around_(particles.cell) {}
    /// All within 2R.
    void find(std::uint32_t particle, std::vector<Neighbour>& neighbours);
    /// Of a particle in a crowd all within R, a fifth of them; false where it is in none.
    bool findInDenseCell(std::uint32_t particle, std::vector<Neighbour>& neighbours);
    /// Likewise some hundreds of those, from all over, where there are a thousand and more; false where there are not.
    bool findSomeInDenseCell(std::uint32_t particle, std::vector<Neighbour>& neighbours);

private:
    struct Candidates {
        std::vector<std::uint32_t> particle;
        std::vector<double> x, y, z;  // from the cell's corner
        Vec3 at(std::size_t k) const { return {x[k], y[k], z[k]}; }
    };
    enum Reach { some_within_radius, within_radius, within_diameter };

    void goTo(std::uint32_t particle);
    void gather(std::size_t cell);
    Vec3 placeInCell(std::uint32_t particle) const;
    bool isInDenseCell() const;
    void find(std::uint32_t particle, Reach reach, std::vector<Neighbour>& neighbours);
    std::span<const std::uint32_t> within(Reach reach, const Candidates& candidates, const Box& box);
    std::span<const std::uint32_t> someOf(const Candidates& candidates);
    const Candidates& candidatesFor(const Vec3& place, Reach reach);

    const SnappedParticles& particles_;
    CellsAround around_;
    std::size_t cell_ = ~std::size_t{0};
    Candidates of_cell_;                                  // all that may be near a particle of the cell
    std::array<std::array<Candidates, 8>, 3> of_eighth_;  // those in reach of a part of it; empty: not made yet
    std::vector<std::uint32_t> found_;                    // of candidates, those that are near
    std::vector<double> squared_;                         // distances of all of them
};

}  // namespace betamesh
