#include "exact/snapped_particles.h"

#include "core/error.h"
#include "core/parallel.h"
#include "core/simd.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <tuple>

namespace betamesh {

namespace {

constexpr double kLargestCoordinate = 0x1p50;  // in quanta: still exact in double precision

std::int64_t floorDivide(std::int64_t a, std::int64_t b) { return a >= 0 ? a / b : -((-a + b - 1) / b); }

std::tuple<std::int64_t, std::int64_t, std::int64_t> scanOrder(const Vec3i& cell) { return {cell.z, cell.y, cell.x}; }

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

struct Placed {
    std::int32_t z, y, x;  // of the cell
    std::uint32_t row;
    friend auto operator<=>(const Placed&, const Placed&) = default;
};

// Sorts into the cells of `position`, and keeps one of all that coincide.
SnappedParticles sortedIntoCells(const std::vector<Vec3i>& position, const std::vector<std::uint32_t>& row,
                                 std::int64_t radius, const Particles& particles) {
    std::vector<Placed> placed(position.size());
    parallelFor(placed.size(), 4096, [&](std::size_t i) {
        const auto cellOf = [&](std::int64_t x) { return static_cast<std::int32_t>(floorDivide(x, 2 * radius)); };
        placed[i] = {cellOf(position[i].z), cellOf(position[i].y), cellOf(position[i].x),
                     static_cast<std::uint32_t>(i)};
    });
    parallelSort(placed, std::less<>());
    const auto sameCell = [&](std::size_t a, std::size_t b) {
        return placed[a].x == placed[b].x && placed[a].y == placed[b].y && placed[a].z == placed[b].z;
    };
    std::vector<std::uint32_t> begin;
    for (std::uint32_t i = 0; i < placed.size(); ++i)
        if (i == 0 || !sameCell(i, i - 1)) begin.push_back(i);
    begin.push_back(static_cast<std::uint32_t>(placed.size()));

    // Inside a cell by position; the preferred one of coincident ones first, the others are left out.
    std::vector<std::uint32_t> left(begin.size() - 1);
    parallelFor(left.size(), 64, [&](std::size_t c) {
        const std::span cell(&placed[begin[c]], begin[c + 1] - begin[c]);
        std::sort(cell.begin(), cell.end(), [&](const Placed& a, const Placed& b) {
            const Vec3i &p = position[a.row], &q = position[b.row];
            return p != q ? before(p, q) : preferred(particles, row[a.row], row[b.row]);
        });
        const auto end = std::unique(cell.begin(), cell.end(), [&](const Placed& a, const Placed& b) {
            return position[a.row] == position[b.row];
        });
        left[c] = static_cast<std::uint32_t>(end - cell.begin());
    });

    SnappedParticles snapped;
    snapped.cell_begin = placesOf(left);
    snapped.cell.resize(left.size());
    snapped.position.resize(snapped.cell_begin.back());
    snapped.row.resize(snapped.cell_begin.back());
    parallelFor(left.size(), 64, [&](std::size_t c) {
        const Placed& first = placed[begin[c]];
        snapped.cell[c] = Vec3i(first.x, first.y, first.z);
        for (std::uint32_t k = 0; k < left[c]; ++k) {
            const std::uint32_t i = placed[begin[c] + k].row;
            snapped.position[snapped.cell_begin[c] + k] = position[i];
            snapped.row[snapped.cell_begin[c] + k] = row[i];
        }
    });
    return snapped;
}

// From one place to all candidates; whole numbers below 2^53, so exact.
BETAMESH_EVERY_CPU
void squaredDistances(const double* x, const double* y, const double* z, std::size_t n, const Vec3& from,
                      double* squared) {
    for (std::size_t k = 0; k < n; ++k) {
        const double dx = x[k] - from.x, dy = y[k] - from.y, dz = z[k] - from.z;
        squared[k] = dx * dx + dy * dy + dz * dz;
    }
}

}  // namespace

SnappedParticles snapParticles(const Particles& particles, double radius, const Jitter& jitter) {
    if (!(std::isnormal(radius) && radius > 0))
        throw Error("the radius is " + std::to_string(radius) + ", expected a positive number");
    int exponent = 0;
    const double mantissa = std::frexp(radius, &exponent);  // radius = mantissa · 2^exponent, mantissa in [1/2, 1)
    exponent -= mantissa > 0.5 ? 20 : 21;

    const double quantum = std::ldexp(1.0, exponent), quanta_per_unit = std::ldexp(1.0, -exponent);
    const std::int64_t whole_radius = std::llround(std::ldexp(radius, -exponent));

    std::vector<Vec3i> position(particles.size());
    std::vector<std::uint32_t> row(particles.size());
    std::atomic<std::size_t> outside = particles.size();  // the first one
    parallelFor(particles.size(), 4096, [&](std::size_t i) {
        const Vec3 scaled = Vec3(particles.position[i]) * quanta_per_unit;
        row[i] = static_cast<std::uint32_t>(i);
        if (std::max({std::abs(scaled.x), std::abs(scaled.y), std::abs(scaled.z)}) <= kLargestCoordinate) {
            position[i] = {std::llround(scaled.x), std::llround(scaled.y), std::llround(scaled.z)};
            return;
        }
        std::size_t first = outside;
        while (i < first && !outside.compare_exchange_weak(first, i)) {
        }
    });
    if (const std::size_t i = outside; i < particles.size()) {
        const Vec3f& p = particles.position[i];
        throw Error("particle " + std::to_string(i) + " at (" + std::to_string(p.x) + ", " + std::to_string(p.y) +
                    ", " + std::to_string(p.z) + ") is too far from the origin for a radius of " +
                    std::to_string(radius) + ", expected coordinates within " +
                    std::to_string(std::ldexp(kLargestCoordinate, exponent)));
    }

    SnappedParticles snapped = sortedIntoCells(position, row, whole_radius, particles);
    if (jitter.attempt > 0) {
        position = std::move(snapped.position);
        row = std::move(snapped.row);
        for (std::size_t i = 0; i < position.size(); ++i) {
            const std::uint64_t key = particles.id.empty() ? positionKey(position[i]) : mix(particles.id[row[i]]);
            position[i] = jittered(position[i], key, jitter, whole_radius);
        }
        snapped = sortedIntoCells(position, row, whole_radius, particles);
    }
    snapped.quantum = quantum;
    snapped.radius = whole_radius;
    return snapped;
}

std::span<const CellRange> rangesAround(const SnappedParticles& particles, std::size_t c,
                                        std::span<CellRange, 9> buffer) {
    const Vec3i centre = particles.cell[c];
    const auto inOrder = [](const Vec3i& a, const Vec3i& b) { return scanOrder(a) < scanOrder(b); };
    std::size_t count = 0;
    for (std::int64_t dz = -1; dz <= 1; ++dz)
        for (std::int64_t dy = -1; dy <= 1; ++dy) {
            const Vec3i first = centre + Vec3i(-1, dy, dz), last = centre + Vec3i(1, dy, dz);
            const auto begin = std::lower_bound(particles.cell.begin(), particles.cell.end(), first, inOrder);
            auto end = begin;
            while (end != particles.cell.end() && !inOrder(last, *end)) ++end;
            if (begin != end)
                buffer[count++] = {particles.cell_begin[static_cast<std::size_t>(begin - particles.cell.begin())],
                                   particles.cell_begin[static_cast<std::size_t>(end - particles.cell.begin())]};
        }
    return buffer.first(count);
}

void NeighbourFinder::gather(std::size_t cell) {
    cell_ = cell;
    candidate_.clear(), x_.clear(), y_.clear(), z_.clear();
    const Vec3i corner = particles_.cell[cell] * (2 * particles_.radius);
    std::array<CellRange, 9> buffer;
    for (const CellRange range : rangesAround(particles_, cell, buffer))
        for (std::uint32_t k = range.begin; k < range.end; ++k) {
            const Vec3 place = toDouble(particles_.position[k] - corner);
            candidate_.push_back(k), x_.push_back(place.x), y_.push_back(place.y), z_.push_back(place.z);
        }
    squared_.resize(candidate_.size());
}

void NeighbourFinder::find(std::uint32_t particle, std::vector<Neighbour>& neighbours) {
    if (cell_ == ~std::size_t{0} || particle < particles_.cell_begin[cell_] ||
        particle >= particles_.cell_begin[cell_ + 1]) {
        const auto above = std::upper_bound(particles_.cell_begin.begin(), particles_.cell_begin.end(), particle);
        gather(static_cast<std::size_t>(above - particles_.cell_begin.begin()) - 1);
    }
    const Vec3 from = toDouble(particles_.position[particle] - particles_.cell[cell_] * (2 * particles_.radius));
    squaredDistances(x_.data(), y_.data(), z_.data(), squared_.size(), from, squared_.data());
    const auto reach = static_cast<double>(4 * particles_.radius * particles_.radius);
    neighbours.clear();
    for (std::size_t k = 0; k < squared_.size(); ++k)
        if (squared_[k] <= reach && candidate_[k] != particle)
            neighbours.push_back({Vec3(x_[k], y_[k], z_[k]) - from, squared_[k], candidate_[k]});
}

}  // namespace betamesh
