// The neighbours of snapped particles.

#pragma once

#include "exact/snapped_particles.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace betamesh {

/// Cells with at least this many particles are dense. With a radius of 1.5 spacings a cell has about thirty.
inline constexpr std::uint32_t kDenseCell = 64;

/// Finds the neighbours of a particle, itself excluded, in the order of SnappedParticles. Fastest when the particles of
/// one cell are queried in succession.
class NeighbourFinder {
public:
    explicit NeighbourFinder(const SnappedParticles& particles) : particles_(particles), around_(particles.cell) {}
    /// All neighbours whose balls touch that of the particle, but for those wholly inside it: with one radius, all
    /// within 2R.
    ///
    /// cost    O(particles of the cells around); with different radii in cells of the particle's size class, of all
    ///         classes of larger balls and, near the ball, of smaller ones
    void find(std::uint32_t particle, std::vector<Neighbour>& neighbours);
    /// For a particle in a dense cell all neighbours within R, about a fifth of those within 2R. Returns false, and
    /// finds nothing, for a particle in any other cell, and where balls have different radii.
    bool findInDenseCell(std::uint32_t particle, std::vector<Neighbour>& neighbours);
    /// For a particle in a dense cell with at least a thousand candidates within R: several hundred of its neighbours
    /// within R, spread over all directions. Returns false, and finds nothing, for any other particle, and where balls
    /// have different radii.
    bool findSomeInDenseCell(std::uint32_t particle, std::vector<Neighbour>& neighbours);

private:
    // Particles that may be neighbours, with positions relative to the lowest corner of the current cell.
    struct Candidates {
        std::vector<std::uint32_t> particle;
        std::vector<double> x, y, z;
        std::vector<double> radius;  // empty: all R
        Vec3 at(std::size_t k) const { return {x[k], y[k], z[k]}; }
    };
    // One cell of a size class, that of index 0 with cells of edge 2R where all radii are equal.
    struct CellOfClass {
        std::size_t size_class;
        std::size_t cell;
        friend bool operator==(const CellOfClass&, const CellOfClass&) = default;
    };
    enum Reach { some_within_radius, within_radius, within_diameter };
    // The radii of balls, from the smallest to the largest, quanta.
    struct RadiusRange {
        double smallest, largest;
    };

    void enterCellOf(std::uint32_t particle);
    void gatherCandidates();
    void gatherFromSizeClasses();
    Vec3 positionInCell(std::uint32_t particle) const { return toDouble(particles_.position[particle] - corner_); }
    bool isInDenseCell() const { return crowd_ >= kDenseCell; }
    std::span<const std::uint32_t> within(Reach reach, const Candidates& candidates, const Box& box,
                                          const RadiusRange& radii);
    std::span<const std::uint32_t> sampleOf(const Candidates& candidates);
    const Candidates& candidatesFor(const Vec3& position, Reach reach);
    void find(std::uint32_t particle, Reach reach, std::vector<Neighbour>& neighbours);
    void addSmaller(std::uint32_t particle, std::vector<Neighbour>& neighbours) const;

    const SnappedParticles& particles_;
    NeighbourCells around_;
    CellOfClass cell_{0, ~std::size_t{0}};                // the current cell
    Vec3i corner_;                                        // its lowest corner, to which candidates are relative
    double edge_ = 0;                                     // quanta
    std::size_t crowd_ = 0;                               // the number of its particles
    double largest_ = 0;                                  // the largest radius of these, quanta
    Candidates of_cell_;                                  // for all particles of the current cell
    std::array<std::array<Candidates, 8>, 3> of_octant_;  // [reach][octant of the current cell]; empty: not made yet
    std::vector<std::uint32_t> found_;                    // buffer: indices of candidates within reach
    std::vector<double> measure_;                         // buffer: how far away each candidate is
};

}  // namespace betamesh
