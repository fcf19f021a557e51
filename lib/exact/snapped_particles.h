// Particles on an integer grid, in an order that depends on nothing but where they are.

#pragma once

#include "core/particles.h"
#include "exact/predicates.h"

#include <array>
#include <span>

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
/// errors  a particle farther from the origin than 2^50 quanta; a radius that is not a normal number
SnappedParticles snapParticles(const Particles& particles, double radius, const Jitter& jitter = {});

/// The particles in the 27 cells round cell c, as ranges of the sorted arrays: up to nine {begin, end}.
/// Everything within 2R of a particle in cell c is among them.
struct CellRange {
    std::uint32_t begin, end;
};
std::span<const CellRange> rangesAround(const SnappedParticles& particles, std::size_t c,
                                        std::span<CellRange, 9> buffer);

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
