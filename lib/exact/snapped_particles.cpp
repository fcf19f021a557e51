
#include "exact/snapped_particles.h"

#include "base/box.h"
#include "base/cell_grid.h"
#include "base/compressed_rows.h"
#include "base/icosphere.h"
#include "base/parallel.h"
#include "base/simd.h"
#include "betamesh/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <tuple>

namespace betamesh {

namespace {

constexpr double kLargestCoordinate = 0x1p50;     // quanta: still exact in double precision
constexpr std::size_t kSampledCandidates = 1024;  // candidates of an octant from which on a sample replaces them
constexpr std::size_t kSampleSize = 512;          // evenly chosen candidates of a sample
constexpr std::size_t kMostInCell = 50000;        // on average; usual are about thirty, thousands in clumped liquids

std::uint64_t mix(std::uint64_t x) {  // the finaliser of splitmix64
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

Vec3i jittered(const Vec3i& position, std::uint64_t key, const Jitter& jitter, std::int64_t radius) {
    const auto reach = std::max<std::int64_t>(1, std::llround(jitter.tolerance * static_cast<double>(radius)));
    Vec3i moved = position;
    for (int axis = 0; axis < 3; ++axis) {
        key = mix(key + 0x9e3779b97f4a7c15u * static_cast<std::uint64_t>(jitter.attempt));
        moved[axis] += static_cast<std::int64_t>(key % static_cast<std::uint64_t>(2 * reach + 1)) - reach;
    }
    return moved;
}

std::uint64_t positionKey(const Vec3i& p) {
    return mix(static_cast<std::uint64_t>(p.x) +
               mix(static_cast<std::uint64_t>(p.y) + mix(static_cast<std::uint64_t>(p.z))));
}

template <typename T>
int compareBytes(const std::vector<T>& column, std::size_t per_row, std::uint32_t a, std::uint32_t b) {
    if (column.empty()) return 0;
    return std::memcmp(&column[a * per_row], &column[b * per_row], per_row * sizeof(T));
}

// Radii of the input's particles in quanta; empty: all the same.
using Radii = std::vector<std::int32_t>;

// Is the first of two coincident particles kept? A total order on all their data, so it does not depend on row order.
bool preferred(const Particles& particles, const Radii& radii, std::uint32_t a, std::uint32_t b) {
    if (!radii.empty() && radii[a] != radii[b]) return radii[a] > radii[b];
    if (!particles.id.empty() && particles.id[a] != particles.id[b]) return particles.id[a] < particles.id[b];
    if (const int order = compareBytes(particles.velocity, 1, a, b)) return order < 0;
    for (const Attribute& attribute : particles.attributes) {
        if (const int order = compareBytes(attribute.real, attribute.components, a, b)) return order < 0;
        if (const int order = compareBytes(attribute.integer, attribute.components, a, b)) return order < 0;
    }
    return a < b;
}

// Particles grouped by cell; cells are sorted by cellBefore().
struct ParticlesByCell {
    std::vector<Vec3i> cell;
    IndexRows particles;
};

template <typename PositionAt>
ParticlesByCell groupedByCell(std::size_t n, const PositionAt& positionAt, std::int64_t radius) {
    const CellGrid grid(n, static_cast<double>(2 * radius), [&](std::size_t i) { return toDouble(positionAt(i)); });
    ParticlesByCell grouped;
    for (std::uint32_t c = 0; c < grid.cells(); ++c) {
        const auto [z, y, x] = grid.cell(c);
        grouped.cell.emplace_back(x, y, z);
        grouped.particles.begin.push_back(grid.begin(c + 1));
    }
    grouped.particles.item = grid.rows();
    return grouped;
}

// Sorts the particles of each cell by position and keeps one of those that coincide. positionAt and rowAt take an item
// of cells.particles; such items are what the result has in `row`.
template <typename PositionAt, typename RowAt>
SnappedParticles sortedWithinCells(ParticlesByCell&& cells, const PositionAt& positionAt, const RowAt& rowAt,
                                   const Particles& particles, const Radii& radii = {}) {
    const std::vector<std::uint32_t>& item = cells.particles.item;
    const std::size_t n = item.size();
    SnappedParticles snapped;
    snapped.cell = std::move(cells.cell);
    snapped.cell_begin = std::move(cells.particles.begin);

    snapped.position.resize(n);
    snapped.row.resize(n);
    std::vector<std::uint32_t> kept(snapped.cell.size());  // distinct particles of each cell
    parallelRanges(kept.size(), 64, [&](std::size_t first, std::size_t last) {
        std::vector<std::pair<Vec3i, std::uint32_t>> cell;
        for (std::size_t c = first; c < last; ++c) {
            cell.clear();
            const std::uint32_t begin = snapped.cell_begin[c];
            for (std::uint32_t i = begin; i < snapped.cell_begin[c + 1]; ++i)
                cell.emplace_back(positionAt(item[i]), item[i]);
            std::sort(cell.begin(), cell.end(), [&](const auto& a, const auto& b) {
                return a.first != b.first ? before(a.first, b.first)
                                          : preferred(particles, radii, rowAt(a.second), rowAt(b.second));
            });
            cell.erase(
                std::unique(cell.begin(), cell.end(), [](const auto& a, const auto& b) { return a.first == b.first; }),
                cell.end());
            kept[c] = static_cast<std::uint32_t>(cell.size());
            for (std::uint32_t k = 0; k < kept[c]; ++k)
                std::tie(snapped.position[begin + k], snapped.row[begin + k]) = cell[k];
        }
    });
    const std::vector<std::uint32_t> begin = exclusiveScan(kept);
    if (begin.back() == n) return snapped;
    for (std::size_t c = 0; c < kept.size(); ++c)
        for (std::uint32_t k = 0; k < kept[c]; ++k) {
            snapped.position[begin[c] + k] = snapped.position[snapped.cell_begin[c] + k];
            snapped.row[begin[c] + k] = snapped.row[snapped.cell_begin[c] + k];
        }
    snapped.cell_begin = begin;
    snapped.position.resize(begin.back());
    snapped.row.resize(begin.back());
    return snapped;
}

// row[i]: the row in `particles` of item i in cells; empty where the two are the same.
SnappedParticles snapInCells(ParticlesByCell&& cells, std::span<const std::uint32_t> row, const Particles& particles,
                             const SnapGrid& grid, std::span<const std::uint8_t> is_covered = {},
                             const Radii& radii = {}) {
    const auto rowAt = [&](std::uint32_t i) { return row.empty() ? i : row[i]; };
    SnappedParticles snapped = sortedWithinCells(
        std::move(cells), [&](std::uint32_t i) { return grid.at(particles.position[rowAt(i)]); }, rowAt, particles,
        radii);
    snapped.is_covered.resize(is_covered.empty() ? 0 : snapped.size());
    parallelFor(snapped.size(), 4096, [&](std::size_t i) {
        if (!is_covered.empty()) snapped.is_covered[i] = is_covered[snapped.row[i]];
        snapped.row[i] = rowAt(snapped.row[i]);
    });
    if (!radii.empty())
        for (const std::uint32_t particle : snapped.row) snapped.radius_of.push_back(radii[particle]);
    snapped.quantum = 1 / grid.perUnit();
    snapped.radius = grid.radius();
    listSizeClasses(snapped);
    if (snapped.size() > kMostInCell * snapped.cell.size())
        throw Error(std::to_string(snapped.size()) + " particles fit into " + std::to_string(snapped.cell.size()) +
                    " cubes of the balls' diameter; expected at most " + std::to_string(kMostInCell) +
                    " particles per cube. The radius, " +
                    std::to_string(static_cast<double>(grid.radius()) / grid.perUnit()) +
                    ", is probably not in the unit of the particles' positions.");
    return snapped;
}

}  // namespace

void listSizeClasses(SnappedParticles& particles) {
    particles.size_classes = nullptr;
    if (particles.radius_of.empty()) return;
    auto classes = std::make_shared<std::vector<SizeClass>>();
    for (std::int64_t largest = particles.radius; largest > 0; largest /= 2) {
        std::vector<std::uint32_t> particle = indicesWhere(particles.size(), [&](std::uint32_t i) {
            return particles.radius_of[i] <= largest && particles.radius_of[i] > largest / 2;
        });
        if (particle.empty()) continue;
        CellGrid cells(particle.size(), 2 * static_cast<double>(largest),
                       [&](std::size_t i) { return toDouble(particles.position[particle[i]]); });
        std::vector<SizeClass::Ball> balls;
        balls.reserve(particle.size());
        for (const std::uint32_t row : cells.rows()) {
            const std::uint32_t i = particle[row];
            balls.push_back({particles.position[i], particles.radius_of[i], i});
        }
        classes->push_back({largest, std::move(cells), std::move(balls)});
    }
    particles.size_classes = std::move(classes);
}

SnapGrid::SnapGrid(double world_radius) {
    constexpr double kSmallest = 0x1p-900, kLargest = 0x1p900;
    if (!(world_radius > kSmallest && world_radius < kLargest))
        throw Error("the radius is " + std::to_string(world_radius) + "; expected a positive number");
    int exponent = 0;
    const double mantissa = std::frexp(world_radius, &exponent);  // in [1/2, 1)
    exponent -= mantissa > 0.5 ? 20 : 21;
    per_unit_ = std::ldexp(1.0, -exponent);
    radius_ = std::llround(world_radius * per_unit_);
    per_quantum_ = 0.5 / static_cast<double>(radius_);
}

void SnapGrid::requireWithin(std::span<const Vec3f> positions, std::size_t first_row) const {
    const double reach = kLargestCoordinate / per_unit_;
    const std::size_t i = firstIndexWhere(positions.size(), [&](std::size_t row) {
        const Vec3f& p = positions[row];
        return !((std::abs(p.x) <= reach) & (std::abs(p.y) <= reach) & (std::abs(p.z) <= reach));
    });
    if (i == positions.size()) return;
    const Vec3f& p = positions[i];
    const auto text = [](double number) {
        std::array<char, 32> buffer{};
        std::snprintf(buffer.data(), buffer.size(), "%.6g", number);
        return std::string(buffer.data());
    };
    throw Error("particle " + std::to_string(first_row + i) + " at (" + text(p.x) + ", " + text(p.y) + ", " +
                text(p.z) + ") is too far from the origin for a radius of " +
                text(static_cast<double>(radius_) / per_unit_) + "; expected coordinates of at most " + text(reach));
}

SnappedParticles snapParticles(const Particles& particles, double radius, const Jitter& jitter) {
    const SnapGrid grid(radius);
    grid.requireWithin(particles.position, 0);
    const auto snappedAt = [&](std::size_t i) { return grid.at(particles.position[i]); };
    SnappedParticles snapped =
        snapInCells(groupedByCell(particles.size(), snappedAt, grid.radius()), {}, particles, grid);
    if (jitter.attempt == 0) return snapped;
    const SnappedParticles original = std::move(snapped);
    const auto jitteredAt = [&](std::size_t i) {
        const Vec3i& p = original.position[i];
        const std::uint64_t key = particles.id.empty() ? positionKey(p) : mix(particles.id[original.row[i]]);
        return jittered(p, key, jitter, grid.radius());
    };
    snapped = sortedWithinCells(
        groupedByCell(original.size(), jitteredAt, grid.radius()), jitteredAt,
        [&](std::size_t i) { return original.row[i]; }, particles);
    for (std::uint32_t& row : snapped.row) row = original.row[row];
    snapped.quantum = original.quantum;
    snapped.radius = original.radius;
    return snapped;
}

void requireSimilar(std::span<const double> radii, double largest, std::size_t first_row) {
    constexpr double kLeastShare = 0x1p-10;
    const std::size_t bad =
        firstIndexWhere(radii.size(), [&](std::size_t i) { return !(radii[i] >= kLeastShare * largest); });
    if (bad < radii.size())
        throw Error("particle " + std::to_string(first_row + bad) + " has a ball of radius " +
                    std::to_string(radii[bad]) + ", but the largest has " + std::to_string(largest) +
                    "; expected at least a thousandth of it");
}

namespace {

Radii inQuanta(std::span<const double> radii, const SnapGrid& grid) {
    Radii in_quanta(radii.size());
    for (std::size_t i = 0; i < radii.size(); ++i)
        in_quanta[i] = static_cast<std::int32_t>(std::llround(radii[i] * grid.perUnit()));
    return in_quanta;
}

SnappedParticles snapUnequal(const Particles& particles, const Radii& in_quanta, const SnapGrid& grid) {
    grid.requireWithin(particles.position, 0);
    const auto snappedAt = [&](std::size_t i) { return grid.at(particles.position[i]); };
    return snapInCells(groupedByCell(particles.size(), snappedAt, grid.radius()), {}, particles, grid, {}, in_quanta);
}

// The selected particles. radii: empty if all are alike.
SnappedParticles snapNear(const Particles& particles, const NearSurface& near, const SnapGrid& grid,
                          const Radii& radii = {}) {
    ParticlesByCell cells{near.cell, sortedIntoRows<std::uint32_t>(
                                         near.cell.size(), near.row.size(), [&](std::size_t i, const auto& visit) {
                                             visit(near.cell_of[i], static_cast<std::uint32_t>(i));
                                         })};
    const bool selected = particles.size() == near.row.size();
    const std::span<const std::uint32_t> row(near.row);
    SnappedParticles snapped =
        snapInCells(std::move(cells), selected ? row.first(0) : row, particles, grid, near.is_covered, radii);
    snapped.is_incomplete = near.is_incomplete;
    return snapped;
}

}  // namespace

SnappedParticles snapParticles(const Particles& particles, std::span<const double> radii) {
    if (radii.empty()) return {};
    const double largest = *std::max_element(radii.begin(), radii.end());
    const SnapGrid grid(largest);
    requireSimilar(radii, largest, 0);
    const Radii in_quanta = inQuanta(radii, grid);
    const bool all_equal = std::all_of(in_quanta.begin(), in_quanta.end(), [&](auto r) { return r == in_quanta[0]; });
    return snapUnequal(particles, all_equal ? Radii() : in_quanta, grid);
}

SnappedParticles snapParticles(const Particles& particles, std::span<const double> radii, double largest) {
    const SnapGrid grid(largest);
    return snapUnequal(particles, inQuanta(radii, grid), grid);
}

SnappedParticles snapParticles(const Particles& particles, double radius, const NearSurface& near) {
    return near.all ? snapParticles(particles, radius) : snapNear(particles, near, SnapGrid(radius));
}

SnappedParticles snapParticles(const Particles& particles, std::span<const double> radii, const NearSurface& near) {
    if (near.all || radii.empty()) return snapParticles(particles, radii);
    const SnapGrid grid(near.largest);
    return snapNear(particles, near, grid, near.is_unequal ? inQuanta(radii, grid) : Radii());
}

void NeighbourFinder::gatherCandidates(std::size_t cell) {
    cell_ = cell;
    const Vec3i corner = particles_.cell[cell] * (2 * particles_.radius);
    Candidates& candidates = of_cell_;
    std::size_t n = 0;
    around_.forEach(cell, [&](const Vec3i&, std::size_t other) {
        const std::uint32_t begin = particles_.cell_begin[other], end = particles_.cell_begin[other + 1];
        const std::size_t all = n + (end - begin);
        candidates.particle.resize(all), candidates.x.resize(all), candidates.y.resize(all), candidates.z.resize(all);
        for (std::uint32_t k = begin; k < end; ++k, ++n) {
            const Vec3 position = toDouble(particles_.position[k] - corner);
            candidates.particle[n] = k, candidates.x[n] = position.x, candidates.y[n] = position.y,
            candidates.z[n] = position.z;
        }
    });
    squared_.resize(candidates.particle.size());
    found_.resize(candidates.particle.size() + 1);
    for (auto& octants : of_octant_)
        for (Candidates& octant : octants) octant.particle.clear();
}

// Indices of the candidates within reach of a box.
std::span<const std::uint32_t> NeighbourFinder::within(Reach reach, const Candidates& candidates, const Box& box) {
    const auto& [particle, x, y, z] = candidates;
    squaredDistances(box, x.data(), y.data(), z.data(), particle.size(), squared_.data());  // integers, hence exact
    const std::int64_t farthest = (reach == within_diameter ? 2 : 1) * particles_.radius;
    const auto square = static_cast<double>(farthest * farthest);
    std::size_t found = 0;
    for (std::uint32_t k = 0; k < particle.size(); ++k) {
        found_[found] = k;
        found += squared_[k] <= square;
    }
    return std::span(found_).first(found);
}

Vec3 NeighbourFinder::positionInCell(std::uint32_t particle) const {
    return toDouble(particles_.position[particle] - particles_.cell[cell_] * (2 * particles_.radius));
}

bool NeighbourFinder::isInDenseCell() const {
    return particles_.cell_begin[cell_ + 1] - particles_.cell_begin[cell_] >= kDenseCell;
}

// Indices of evenly chosen candidates and of the extreme ones in fixed directions; balls of these cover most others.
std::span<const std::uint32_t> NeighbourFinder::sampleOf(const Candidates& candidates) {
    static const std::vector<Vec3> directions = icosphere(1).position;
    const std::size_t n = candidates.particle.size();
    std::size_t found = 0;
    while (found < kSampleSize) {
        found_[found] = static_cast<std::uint32_t>(found * n / kSampleSize);
        ++found;
    }
    for (const Vec3& direction : directions) {
        double farthest = -std::numeric_limits<double>::infinity();
        for (std::uint32_t k = 0; k < n; ++k)
            if (const double extent = dot(candidates.at(k), direction); extent > farthest)
                farthest = extent, found_[found] = k;
        ++found;
    }
    return std::span(found_).first(found);
}

// In a dense cell the candidates are narrowed to those within reach of one octant: two in five, or one in eight. The
// many particles of the octant share the list.
const NeighbourFinder::Candidates& NeighbourFinder::candidatesFor(const Vec3& position, Reach reach) {
    if (!isInDenseCell()) return of_cell_;
    const auto radius = static_cast<double>(particles_.radius);
    const bool upper_x = position.x >= radius, upper_y = position.y >= radius, upper_z = position.z >= radius;
    Candidates& selected = of_octant_[reach][(upper_x ? 1 : 0) + (upper_y ? 2 : 0) + (upper_z ? 4 : 0)];
    if (!selected.particle.empty()) return selected;
    const auto select = [&](const Candidates& from, std::span<const std::uint32_t> indices) {
        const auto copySelected = [&](const auto& all, auto& to) {
            to.resize(indices.size());
            for (std::size_t k = 0; k < indices.size(); ++k) to[k] = all[indices[k]];
        };
        copySelected(from.particle, selected.particle);
        copySelected(from.x, selected.x);
        copySelected(from.y, selected.y);
        copySelected(from.z, selected.z);
    };
    if (reach == some_within_radius) {
        const Candidates& all = candidatesFor(position, within_radius);
        select(all, sampleOf(all));
    } else {
        const Vec3 low(upper_x ? radius : 0, upper_y ? radius : 0, upper_z ? radius : 0);
        select(of_cell_, within(reach, of_cell_, {low, low + Vec3(radius)}));
    }
    return selected;
}

void NeighbourFinder::enterCellOf(std::uint32_t particle) {
    const std::vector<std::uint32_t>& begin = particles_.cell_begin;
    if (cell_ != ~std::size_t{0} && particle >= begin[cell_] && particle < begin[cell_ + 1]) return;
    const auto next = std::upper_bound(begin.begin(), begin.end(), particle);
    gatherCandidates(static_cast<std::size_t>(next - begin.begin()) - 1);
}

void NeighbourFinder::find(std::uint32_t particle, Reach reach, std::vector<Neighbour>& neighbours) {
    const Vec3 position = positionInCell(particle);
    const Candidates& candidates = candidatesFor(position, reach);
    const auto near = within(reach, candidates, Box(position));
    neighbours.resize(near.size());
    std::size_t found = 0;  // the particle itself, the only one at distance zero, is excluded
    const auto radius = static_cast<std::int32_t>(particles_.radius);
    for (const std::uint32_t k : near) {
        neighbours[found] = {candidates.at(k) - position, squared_[k], candidates.particle[k], radius};
        found += squared_[k] > 0;
    }
    neighbours.resize(found);
}

void NeighbourFinder::findInSizeClasses(std::uint32_t particle, std::vector<Neighbour>& neighbours) const {
    neighbours.clear();
    const Vec3i here = particles_.position[particle];
    const Vec3 position = toDouble(here);
    const double own = particles_.radius_of[particle];
    for (const SizeClass& size_class : *particles_.size_classes) {
        const Vec3 reach(own + static_cast<double>(size_class.largest));
        size_class.cells.forCellsIn(position - reach, position + reach, [&](std::uint32_t cell) {
            const std::uint32_t begin = size_class.cells.begin(cell), end = size_class.cells.begin(cell + 1);
            for (const SizeClass::Ball& ball : std::span(size_class.ball).subspan(begin, end - begin)) {
                const Vec3 offset = toDouble(ball.position - here);
                const double squared = dot(offset, offset), sum = own + ball.radius, difference = own - ball.radius;
                if (squared > sum * sum) continue;
                const bool is_inside = difference > 0 && squared < difference * difference;
                if (!is_inside && ball.particle != particle)
                    neighbours.push_back({offset, squared + sum * difference, ball.particle, ball.radius});
            }
        });
    }
    std::sort(neighbours.begin(), neighbours.end(),
              [](const Neighbour& a, const Neighbour& b) { return a.particle < b.particle; });
}

void NeighbourFinder::find(std::uint32_t particle, std::vector<Neighbour>& neighbours) {
    if (particles_.size_classes) return findInSizeClasses(particle, neighbours);
    enterCellOf(particle);
    find(particle, within_diameter, neighbours);
}

bool NeighbourFinder::findInDenseCell(std::uint32_t particle, std::vector<Neighbour>& neighbours) {
    if (particles_.size_classes) return false;
    enterCellOf(particle);
    if (!isInDenseCell()) return false;
    find(particle, within_radius, neighbours);
    return true;
}

bool NeighbourFinder::findSomeInDenseCell(std::uint32_t particle, std::vector<Neighbour>& neighbours) {
    if (particles_.size_classes) return false;
    enterCellOf(particle);
    if (!isInDenseCell()) return false;
    if (candidatesFor(positionInCell(particle), within_radius).particle.size() < kSampledCandidates) return false;
    find(particle, some_within_radius, neighbours);
    return true;
}

}  // namespace betamesh
