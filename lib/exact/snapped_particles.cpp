
#include "exact/snapped_particles.h"

#include "base/box.h"
#include "base/cell_order.h"
#include "base/compressed_rows.h"
#include "base/icosphere.h"
#include "base/parallel.h"
#include "base/simd.h"
#include "betamesh/error.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <tuple>

namespace betamesh {

namespace {

constexpr double kLargestCoordinate = 0x1p50;  // in quanta: still exact in double precision
constexpr std::size_t kHugeCrowd = 1024;       // in reach of an eighth of one
constexpr std::size_t kSample = 512;           // of a huge crowd
constexpr std::size_t kMostInCell = 50000;     // on average; liquids have some thirty, clumped ones some thousands

std::uint64_t mix(std::uint64_t x) {  // finaliser of splitmix64
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

// Which of two coincident particles stays: a total order on everything that could be told apart.
bool preferred(const Particles& particles, std::uint32_t a, std::uint32_t b) {
    if (!particles.id.empty() && particles.id[a] != particles.id[b]) return particles.id[a] < particles.id[b];
    if (const int order = compareBytes(particles.velocity, 1, a, b)) return order < 0;
    for (const Attribute& attribute : particles.attributes) {
        if (const int order = compareBytes(attribute.real, attribute.components, a, b)) return order < 0;
        if (const int order = compareBytes(attribute.integer, attribute.components, a, b)) return order < 0;
    }
    return a < b;
}

// Some particles, cell by cell; cells in order.
struct InCells {
    std::vector<Vec3i> cell;
    IndexRows particles;
};

template <typename PositionAt>
InCells sortedIntoCells(std::size_t n, const PositionAt& positionAt, std::int64_t radius) {
    const CellOrder order(n, static_cast<double>(2 * radius), [&](std::size_t i) { return toDouble(positionAt(i)); });
    InCells sorted;
    for (std::uint32_t c = 0; c < order.cells(); ++c) {
        const auto [z, y, x] = order.place(c);
        sorted.cell.emplace_back(x, y, z);
        sorted.particles.begin.push_back(order.begin(c + 1));
    }
    sorted.particles.item = order.rows();
    return sorted;
}

// Puts those of each cell in order, and keeps one of all that coincide. Their rows are still what they were in cells.
template <typename PositionAt, typename RowAt>
SnappedParticles sortedInside(InCells&& cells, const PositionAt& positionAt, const RowAt& rowAt,
                              const Particles& particles) {
    const std::vector<std::uint32_t>& item = cells.particles.item;
    const std::size_t n = item.size();
    SnappedParticles snapped;
    snapped.cell = std::move(cells.cell);
    snapped.cell_begin = std::move(cells.particles.begin);

    // Inside a cell by position; the preferred one of coincident ones first, the others are left out.
    snapped.position.resize(n);
    snapped.row.resize(n);
    std::vector<std::uint32_t> left(snapped.cell.size());
    parallelRanges(left.size(), 64, [&](std::size_t first, std::size_t last) {
        std::vector<std::pair<Vec3i, std::uint32_t>> cell;
        for (std::size_t c = first; c < last; ++c) {
            cell.clear();
            const std::uint32_t begin = snapped.cell_begin[c];
            for (std::uint32_t i = begin; i < snapped.cell_begin[c + 1]; ++i)
                cell.emplace_back(positionAt(item[i]), item[i]);
            std::sort(cell.begin(), cell.end(), [&](const auto& a, const auto& b) {
                return a.first != b.first ? before(a.first, b.first)
                                          : preferred(particles, rowAt(a.second), rowAt(b.second));
            });
            cell.erase(
                std::unique(cell.begin(), cell.end(), [](const auto& a, const auto& b) { return a.first == b.first; }),
                cell.end());
            left[c] = static_cast<std::uint32_t>(cell.size());
            for (std::uint32_t k = 0; k < left[c]; ++k)
                std::tie(snapped.position[begin + k], snapped.row[begin + k]) = cell[k];
        }
    });
    const std::vector<std::uint32_t> place = exclusiveScan(left);
    if (place.back() == n) return snapped;
    for (std::size_t c = 0; c < left.size(); ++c)
        for (std::uint32_t k = 0; k < left[c]; ++k) {
            snapped.position[place[c] + k] = snapped.position[snapped.cell_begin[c] + k];
            snapped.row[place[c] + k] = snapped.row[snapped.cell_begin[c] + k];
        }
    snapped.cell_begin = place;
    snapped.position.resize(place.back());
    snapped.row.resize(place.back());
    return snapped;
}

// A row of the particles for each of those in cells; none: the same.
SnappedParticles snapIn(InCells&& cells, std::span<const std::uint32_t> row, const Particles& particles,
                        const SnapGrid& grid, std::span<const std::uint8_t> is_buried = {}) {
    const auto rowAt = [&](std::uint32_t i) { return row.empty() ? i : row[i]; };
    SnappedParticles snapped = sortedInside(
        std::move(cells), [&](std::uint32_t i) { return grid.at(particles.position[rowAt(i)]); }, rowAt, particles);
    snapped.is_buried.resize(is_buried.empty() ? 0 : snapped.size());
    parallelFor(snapped.size(), 4096, [&](std::size_t i) {
        if (!is_buried.empty()) snapped.is_buried[i] = is_buried[snapped.row[i]];
        snapped.row[i] = rowAt(snapped.row[i]);
    });
    snapped.quantum = 1 / grid.perUnit();
    snapped.radius = grid.radius();
    if (snapped.size() > kMostInCell * snapped.cell.size())
        throw Error(std::to_string(snapped.size()) + " particles lie in " + std::to_string(snapped.cell.size()) +
                    " cubes as wide as a ball, whose radius is " +
                    std::to_string(static_cast<double>(grid.radius()) / grid.perUnit()) + "; expected at most " +
                    std::to_string(kMostInCell) + " in each: is the radius in the particles' unit?");
    return snapped;
}

}  // namespace

SnapGrid::SnapGrid(double world_radius) {
    constexpr double kSmallest = 0x1p-900, kLargest = 0x1p900;
    if (!(world_radius > kSmallest && world_radius < kLargest))
        throw Error("the radius is " + std::to_string(world_radius) + ", expected a positive number");
    int exponent = 0;
    const double mantissa = std::frexp(world_radius, &exponent);  // of 2^exponent, in [1/2, 1)
    exponent -= mantissa > 0.5 ? 20 : 21;
    per_unit_ = std::ldexp(1.0, -exponent);
    radius_ = std::llround(world_radius * per_unit_);
    per_quantum_ = 0.5 / static_cast<double>(radius_);
}

void SnapGrid::requireWithin(std::span<const Vec3f> positions, std::size_t first_row) const {
    const double reach = kLargestCoordinate / per_unit_;
    const std::size_t i = firstRowWhere(positions.size(), [&](std::size_t row) {
        const Vec3f& p = positions[row];
        return !((std::abs(p.x) <= reach) & (std::abs(p.y) <= reach) & (std::abs(p.z) <= reach));
    });
    if (i == positions.size()) return;
    const Vec3f& p = positions[i];
    throw Error("particle " + std::to_string(first_row + i) + " at (" + std::to_string(p.x) + ", " +
                std::to_string(p.y) + ", " + std::to_string(p.z) + ") is too far from the origin for a radius of " +
                std::to_string(static_cast<double>(radius_) / per_unit_) + ", expected coordinates within " +
                std::to_string(reach));
}

SnappedParticles snapParticles(const Particles& particles, double radius, const Jitter& jitter) {
    const SnapGrid grid(radius);
    grid.requireWithin(particles.position, 0);
    const auto snappedAt = [&](std::size_t i) { return grid.at(particles.position[i]); };
    SnappedParticles snapped = snapIn(sortedIntoCells(particles.size(), snappedAt, grid.radius()), {}, particles, grid);
    if (jitter.attempt == 0) return snapped;
    const SnappedParticles still = std::move(snapped);
    const auto jitteredAt = [&](std::size_t i) {
        const Vec3i& p = still.position[i];
        const std::uint64_t key = particles.id.empty() ? positionKey(p) : mix(particles.id[still.row[i]]);
        return jittered(p, key, jitter, grid.radius());
    };
    snapped = sortedInside(
        sortedIntoCells(still.size(), jitteredAt, grid.radius()), jitteredAt,
        [&](std::size_t i) { return still.row[i]; }, particles);
    for (std::uint32_t& row : snapped.row) row = still.row[row];
    snapped.quantum = still.quantum;
    snapped.radius = still.radius;
    return snapped;
}

SnappedParticles snapParticles(const Particles& particles, double radius, const NearSurface& near) {
    if (near.all) return snapParticles(particles, radius);
    InCells cells{near.cell, sortedIntoRows<std::uint32_t>(near.cell.size(), near.row.size(),
                                                           [&](std::size_t i, const auto& visit) {
                                                               visit(near.cell_of[i], static_cast<std::uint32_t>(i));
                                                           })};
    const bool selected = particles.size() == near.row.size();
    const std::span<const std::uint32_t> row(near.row);
    SnappedParticles snapped =
        snapIn(std::move(cells), selected ? row.first(0) : row, particles, SnapGrid(radius), near.is_buried);
    snapped.is_rim = near.is_rim;
    return snapped;
}

void NeighbourFinder::gather(std::size_t cell) {
    cell_ = cell;
    const Vec3i corner = particles_.cell[cell] * (2 * particles_.radius);
    auto& [number, x, y, z] = of_cell_;
    std::size_t n = 0;
    around_.forEach(cell, [&](const Vec3i&, std::size_t other) {
        const std::uint32_t begin = particles_.cell_begin[other], end = particles_.cell_begin[other + 1];
        const std::size_t all = n + (end - begin);
        number.resize(all), x.resize(all), y.resize(all), z.resize(all);
        for (std::uint32_t k = begin; k < end; ++k, ++n) {
            const Vec3 place = toDouble(particles_.position[k] - corner);
            number[n] = k, x[n] = place.x, y[n] = place.y, z[n] = place.z;
        }
    });
    squared_.resize(number.size());
    found_.resize(number.size() + 1);
    for (auto& of_eighth : of_eighth_)
        for (Candidates& candidates : of_eighth) candidates.particle.clear();
}

// Which candidates are in reach of a box.
std::span<const std::uint32_t> NeighbourFinder::within(Reach reach, const Candidates& candidates, const Box& box) {
    const auto& [number, x, y, z] = candidates;
    squaredDistances(box, x.data(), y.data(), z.data(), number.size(), squared_.data());  // whole numbers: exact
    const std::int64_t farthest = (reach == within_diameter ? 2 : 1) * particles_.radius;
    const auto square = static_cast<double>(farthest * farthest);
    std::size_t found = 0;
    for (std::uint32_t k = 0; k < number.size(); ++k) {
        found_[found] = k;
        found += squared_[k] <= square;
    }
    return std::span(found_).first(found);
}

Vec3 NeighbourFinder::placeInCell(std::uint32_t particle) const {
    return toDouble(particles_.position[particle] - particles_.cell[cell_] * (2 * particles_.radius));
}

bool NeighbourFinder::isInDenseCell() const {
    return particles_.cell_begin[cell_ + 1] - particles_.cell_begin[cell_] >= kDenseCell;
}

// One of so many, and the farthest each way, behind which most others are.
std::span<const std::uint32_t> NeighbourFinder::someOf(const Candidates& candidates) {
    static const std::vector<Vec3> directions = icosphere(1).position;
    const std::size_t n = candidates.particle.size();
    std::size_t found = 0;
    while (found < kSample) {
        found_[found] = static_cast<std::uint32_t>(found * n / kSample);
        ++found;
    }
    for (const Vec3& direction : directions) {
        double most = -std::numeric_limits<double>::infinity();
        for (std::uint32_t k = 0; k < n; ++k)
            if (const double here = dot(candidates.at(k), direction); here > most) most = here, found_[found] = k;
        ++found;
    }
    return std::span(found_).first(found);
}

// In a crowd those of an eighth of the cell, which are two in five, or one in eight: many particles share them.
const NeighbourFinder::Candidates& NeighbourFinder::candidatesFor(const Vec3& place, Reach reach) {
    if (!isInDenseCell()) return of_cell_;
    const auto radius = static_cast<double>(particles_.radius);
    const bool right = place.x >= radius, behind = place.y >= radius, above = place.z >= radius;
    Candidates& here = of_eighth_[reach][(right ? 1 : 0) + (behind ? 2 : 0) + (above ? 4 : 0)];
    if (!here.particle.empty()) return here;
    const auto take = [&](const Candidates& from, std::span<const std::uint32_t> rows) {
        const auto some = [&](const auto& all, auto& to) {
            to.resize(rows.size());
            for (std::size_t k = 0; k < rows.size(); ++k) to[k] = all[rows[k]];
        };
        some(from.particle, here.particle);
        some(from.x, here.x);
        some(from.y, here.y);
        some(from.z, here.z);
    };
    if (reach == some_within_radius) {
        const Candidates& all = candidatesFor(place, within_radius);
        take(all, someOf(all));
    } else {
        const Vec3 low(right ? radius : 0, behind ? radius : 0, above ? radius : 0);
        take(of_cell_, within(reach, of_cell_, {low, low + Vec3(radius)}));
    }
    return here;
}

void NeighbourFinder::goTo(std::uint32_t particle) {
    const std::vector<std::uint32_t>& begin = particles_.cell_begin;
    if (cell_ != ~std::size_t{0} && particle >= begin[cell_] && particle < begin[cell_ + 1]) return;
    gather(static_cast<std::size_t>(std::upper_bound(begin.begin(), begin.end(), particle) - begin.begin()) - 1);
}

void NeighbourFinder::find(std::uint32_t particle, Reach reach, std::vector<Neighbour>& neighbours) {
    const Vec3 from = placeInCell(particle);
    const Candidates& candidates = candidatesFor(from, reach);
    const auto near = within(reach, candidates, Box(from));
    neighbours.resize(near.size());
    std::size_t found = 0;  // all but itself, the only one at its place
    for (const std::uint32_t k : near) {
        neighbours[found] = {candidates.at(k) - from, squared_[k], candidates.particle[k]};
        found += squared_[k] > 0;
    }
    neighbours.resize(found);
}

void NeighbourFinder::find(std::uint32_t particle, std::vector<Neighbour>& neighbours) {
    goTo(particle);
    find(particle, within_diameter, neighbours);
}

bool NeighbourFinder::findInDenseCell(std::uint32_t particle, std::vector<Neighbour>& neighbours) {
    goTo(particle);
    if (!isInDenseCell()) return false;
    find(particle, within_radius, neighbours);
    return true;
}

bool NeighbourFinder::findSomeInDenseCell(std::uint32_t particle, std::vector<Neighbour>& neighbours) {
    goTo(particle);
    if (!isInDenseCell() || candidatesFor(placeInCell(particle), within_radius).particle.size() < kHugeCrowd) return false;
    find(particle, some_within_radius, neighbours);
    return true;
}

}  // namespace betamesh
