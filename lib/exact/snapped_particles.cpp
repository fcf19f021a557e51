
#include "exact/snapped_particles.h"

#include "base/box.h"
#include "base/cell_grid.h"
#include "base/compressed_rows.h"
#include "base/parallel.h"
#include "betamesh/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <tuple>

namespace betamesh {

namespace {

constexpr double kLargestQuanta = 0x1p50;   // quanta: still exact in double precision
constexpr std::size_t kMostInCell = 50000;  // on average; usual are about thirty, thousands in clumped liquids

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

// The cells of size classes: those of edge 2R, halved along each axis as often as the largest radius of the class has
// been halved, but not so often that cells could not be numbered.
class SizeClassCells {
public:
    SizeClassCells(std::int64_t radius, int most_halvings) : radius_(radius), most_halvings_(most_halvings) {}
    /// How often these cells can be halved so that they can be numbered.
    static int mostHalvings(const std::vector<Vec3i>& cells) {
        std::int64_t farthest = 1;
        for (const Vec3i& cell : cells)
            for (int axis = 0; axis < 3; ++axis) farthest = std::max(farthest, std::abs(cell[axis]) + 2);
        int halvings = 0;
        while (farthest << (halvings + 1) < kMostCells) ++halvings;
        return halvings;
    }
    /// How often R can be halved so that it is not less than the radius.
    int halvings(std::int32_t radius) const {
        int count = 0;
        while (radius_ >> (count + 1) >= radius) ++count;
        return count;
    }
    double edge(int halvings) const {
        return std::ldexp(static_cast<double>(2 * radius_), -std::min(halvings, most_halvings_));
    }
    /// By what the particles of one cell of edge 2R are sorted: size class, then the class's cell. Less than 2^34.
    std::uint64_t orderOf(const Vec3i& cell, const Vec3i& position, std::int32_t radius) const {
        const int count = halvings(radius), halved = std::min(count, most_halvings_);
        const Vec3i from_corner = (position - cell * (2 * radius_)) * (std::int64_t{1} << halved);
        return (((static_cast<std::uint64_t>(count) << 10 | at(from_corner.z)) << 10) | at(from_corner.y)) << 10 |
               at(from_corner.x);
    }

private:
    static constexpr std::int64_t kMostCells = std::int64_t{1} << 30;
    std::uint64_t at(std::int64_t scaled) const { return static_cast<std::uint64_t>(scaled / (2 * radius_)); }

    std::int64_t radius_;
    int most_halvings_;
};

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

// Sorts the particles of each cell by size class, the class's cell and position, and keeps one of those that coincide.
// positionAt and rowAt take an item of cells.particles; such items are what the result has in `row`.
template <typename PositionAt, typename RowAt>
SnappedParticles sortedWithinCells(ParticlesByCell&& cells, const PositionAt& positionAt, const RowAt& rowAt,
                                   const Particles& particles, std::int64_t radius, const Radii& radii = {}) {
    const std::vector<std::uint32_t>& item = cells.particles.item;
    const std::size_t n = item.size();
    SnappedParticles snapped;
    snapped.cell = std::move(cells.cell);
    snapped.cell_begin = std::move(cells.particles.begin);
    snapped.radius = radius;
    snapped.most_halvings = SizeClassCells::mostHalvings(snapped.cell);
    const SizeClassCells class_cells(radius, snapped.most_halvings);

    snapped.position.resize(n);
    snapped.row.resize(n);
    std::vector<std::uint32_t> kept(snapped.cell.size());  // distinct particles of each cell
    parallelRanges(kept.size(), 64, [&](std::size_t first, std::size_t last) {
        std::vector<std::pair<Vec3i, std::uint32_t>> cell;
        std::vector<std::uint64_t> order;
        // Sorted as they are, but by size class first.
        const auto sortBySizeClass = [&](const Vec3i& here) {
            constexpr int kIndexBits = 30;
            order.clear();
            for (const auto& [position, item_here] : cell)
                order.push_back(class_cells.orderOf(here, position, radii[rowAt(item_here)]) << kIndexBits |
                                order.size());
            if (std::ranges::is_sorted(order)) return;
            std::ranges::sort(order);
            const auto before = cell;
            for (std::size_t k = 0; k < order.size(); ++k)
                cell[k] = before[order[k] & ((std::uint64_t{1} << kIndexBits) - 1)];
        };
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
            if (!radii.empty()) sortBySizeClass(snapped.cell[c]);
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

// Throws Error where so many balls meet that the radius must be in another unit than the positions. Small balls count
// by their volume.
void requireSuitable(const SnappedParticles& snapped) {
    double balls = 0;  // as large as the largest
    for (std::size_t i = 0; i < snapped.size(); ++i) {
        const double scale = static_cast<double>(snapped.radiusOf(i)) / static_cast<double>(snapped.radius);
        balls += scale * scale * scale;
    }
    if (balls <= static_cast<double>(kMostInCell * snapped.cell.size())) return;
    throw Error(std::to_string(snapped.size()) + " particles fit into " + std::to_string(snapped.cell.size()) +
                " cubes of the balls' diameter; expected at most " + std::to_string(kMostInCell) +
                " particles per cube. The radius, " +
                std::to_string(static_cast<double>(snapped.radius) * snapped.quantum) +
                ", is probably not in the unit of the particles' positions.");
}

// row[i]: the row in `particles` of item i in cells; empty where the two are the same.
SnappedParticles snapInCells(ParticlesByCell&& cells, std::span<const std::uint32_t> row, const Particles& particles,
                             const SnapGrid& grid, std::span<const std::uint8_t> is_covered = {},
                             const Radii& radii = {}) {
    const auto rowAt = [&](std::uint32_t i) { return row.empty() ? i : row[i]; };
    SnappedParticles snapped = sortedWithinCells(
        std::move(cells), [&](std::uint32_t i) { return grid.at(particles.position[rowAt(i)]); }, rowAt, particles,
        grid.radius(), radii);
    snapped.is_covered.resize(is_covered.empty() ? 0 : snapped.size());
    parallelFor(snapped.size(), 4096, [&](std::size_t i) {
        if (!is_covered.empty()) snapped.is_covered[i] = is_covered[snapped.row[i]];
        snapped.row[i] = rowAt(snapped.row[i]);
    });
    if (!radii.empty())
        for (const std::uint32_t particle : snapped.row) snapped.radius_of.push_back(radii[particle]);
    snapped.quantum = 1 / grid.perUnit();
    listSizeClasses(snapped);
    requireSuitable(snapped);
    return snapped;
}

}  // namespace

void listSizeClasses(SnappedParticles& particles) {
    particles.size_classes = nullptr;
    if (particles.radius_of.empty()) return;
    const SizeClassCells class_cells(particles.radius, particles.most_halvings);
    auto classes = std::make_shared<std::vector<SizeClass>>();
    for (int halvings = 0; particles.radius >> halvings > 0; ++halvings) {
        std::vector<std::uint32_t> particle = indicesWhere(particles.size(), [&](std::uint32_t i) {
            return class_cells.halvings(particles.radius_of[i]) == halvings;
        });
        if (particle.empty()) continue;
        CellGrid cells(particle.size(), class_cells.edge(halvings),
                       [&](std::size_t i) { return toDouble(particles.position[particle[i]]); });
        std::vector<SizeClass::Ball> balls;
        balls.reserve(particle.size());
        for (const std::uint32_t row : cells.rows()) {
            const std::uint32_t i = particle[row];
            balls.push_back({particles.position[i], particles.radius_of[i], i});
        }
        classes->push_back({particles.radius >> halvings, std::move(cells), std::move(balls)});
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
    const double reach = kLargestQuanta / per_unit_;
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
    throw ParticleError(first_row + i, "at (" + text(p.x) + ", " + text(p.y) + ", " + text(p.z) +
                                           ") is too far from the origin for a radius of " +
                                           text(static_cast<double>(radius_) / per_unit_) +
                                           "; expected coordinates of at most " + text(reach));
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
        [&](std::size_t i) { return original.row[i]; }, particles, grid.radius());
    for (std::uint32_t& row : snapped.row) row = original.row[row];
    snapped.quantum = original.quantum;
    return snapped;
}

void requireSimilar(std::span<const double> radii, double largest, std::size_t first_row) {
    constexpr double kLeastShare = 0x1p-10;
    const std::size_t bad =
        firstIndexWhere(radii.size(), [&](std::size_t i) { return !(radii[i] >= kLeastShare * largest); });
    if (bad < radii.size())
        throw ParticleError(first_row + bad, "has a ball of radius " + std::to_string(radii[bad]) +
                                                 ", but the largest has " + std::to_string(largest) +
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

}  // namespace betamesh
