// Particles on an integer grid, in an order that depends on nothing but where they are.

#pragma once

#include "core/particles.h"
#include "exact/predicates.h"

#include <algorithm>
#include <tuple>

namespace betamesh {

/// The paper's perturbation: every particle moves by up to `tolerance` radii along each axis, by a hash of
/// its id (of its position, without ids) and of `attempt`. Attempt 0 moves nothing.
struct Jitter {
    double tolerance = 0;
    int attempt = 0;
};

/// Distinct particles, sorted by cell (z, y, x, the edge of a cell is 2R) and inside a cell by position.
/// World position = quantum · position. Every array but the cells' has one row per distinct particle.
struct SnappedParticles {
    double quantum = 1;       ///< a power of two, world units
    std::int64_t radius = 0;  ///< R, in quanta, in (2^19, 2^20]
    std::vector<Vec3i> position;
    std::vector<std::uint32_t> row;  ///< of the particle as it was given

    std::vector<Vec3i> cell;                ///< occupied cells, in order
    std::vector<std::uint32_t> cell_begin;  ///< first particle of each cell, and one entry past the last

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

/// The order of cells: by z, then y, then x.
inline bool cellBefore(const Vec3i& a, const Vec3i& b) { return std::tuple(a.z, a.y, a.x) < std::tuple(b.z, b.y, b.x); }

/// Calls visit(place from (0, 0, 0) to (2, 2, 2), number of the cell there) for those of the 27 cells round one that
/// have particles, in order. Everything within 2R of a particle in the middle one is among theirs.
template <typename Visit>
void forCellsAround(const SnappedParticles& particles, std::size_t cell, const Visit& visit) {
    const std::vector<Vec3i>& cells = particles.cell;
    const Vec3i centre = cells[cell];
    for (std::int64_t dz = -1; dz <= 1; ++dz)
        for (std::int64_t dy = -1; dy <= 1; ++dy) {
            auto at = std::lower_bound(cells.begin(), cells.end(), centre + Vec3i(-1, dy, dz), cellBefore);
            for (; at != cells.end() && !cellBefore(centre + Vec3i(1, dy, dz), *at); ++at)
                visit(Vec3i(at->x - centre.x + 1, dy + 1, dz + 1), static_cast<std::size_t>(at - cells.begin()));
        }
}

/// Another particle seen from one: offset and its squared length in quanta, whole numbers.
struct Neighbour {
    Vec3 offset;
    double squared;
    std::uint32_t particle;
};

/// Finds all particles within 2R of one, itself left out, in the order of SnappedParticles. Quickest when
/// asked for one particle of a cell after another.
class NeighbourFinder {
public:
    explicit NeighbourFinder(const SnappedParticles& particles) : particles_(particles) {}
    void find(std::uint32_t particle, std::vector<Neighbour>& neighbours);

private:
    void gather(std::size_t cell);

    const SnappedParticles& particles_;
    std::size_t cell_ = ~std::size_t{0};
    std::vector<std::uint32_t> candidate_;     // all that may be near a particle of the cell
    std::vector<double> x_, y_, z_, squared_;  // where they are, from the cell's corner; distances to the one asked for
};

}  // namespace betamesh
