#include "exact/snapped_particles.h"

#include "core/error.h"
#include "core/parallel.h"

#include <algorithm>
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
    Vec3i cell, position;
    std::uint32_t row;
};

// Sorts, and keeps one of all that coincide.
void sortIntoCells(std::vector<Placed>& placed, std::int64_t edge, const Particles& particles) {
    parallelFor(placed.size(), 4096, [&](std::size_t i) {
        const Vec3i& p = placed[i].position;
        placed[i].cell = {floorDivide(p.x, edge), floorDivide(p.y, edge), floorDivide(p.z, edge)};
    });
    parallelSort(placed, [&](const Placed& a, const Placed& b) {
        if (a.cell != b.cell) return scanOrder(a.cell) < scanOrder(b.cell);
        if (a.position != b.position) return before(a.position, b.position);
        return preferred(particles, a.row, b.row);
    });
    placed.erase(std::unique(placed.begin(), placed.end(),
                             [](const Placed& a, const Placed& b) { return a.position == b.position; }),
                 placed.end());
}

}  // namespace

SnappedParticles snapParticles(const Particles& particles, double radius, const Jitter& jitter) {
    if (!(std::isnormal(radius) && radius > 0))
        throw Error("the radius is " + std::to_string(radius) + ", expected a positive number");
    int exponent = 0;
    const double mantissa = std::frexp(radius, &exponent);  // radius = mantissa · 2^exponent, mantissa in [1/2, 1)
    exponent -= mantissa > 0.5 ? 20 : 21;

    SnappedParticles snapped;
    snapped.quantum = std::ldexp(1.0, exponent);
    snapped.radius = std::llround(std::ldexp(radius, -exponent));

    std::vector<Placed> placed(particles.size());
    const auto quanta = [&](float x) { return std::ldexp(static_cast<double>(x), -exponent); };
    for (std::size_t i = 0; i < particles.size(); ++i) {
        const Vec3f& p = particles.position[i];
        const Vec3 scaled(quanta(p.x), quanta(p.y), quanta(p.z));
        if (!(std::max({std::abs(scaled.x), std::abs(scaled.y), std::abs(scaled.z)}) <= kLargestCoordinate))
            throw Error("particle " + std::to_string(i) + " at (" + std::to_string(p.x) + ", " + std::to_string(p.y) +
                        ", " + std::to_string(p.z) + ") is too far from the origin for a radius of " +
                        std::to_string(radius) + ", expected coordinates within " +
                        std::to_string(std::ldexp(kLargestCoordinate, exponent)));
        placed[i] = {{},
                     {std::llround(scaled.x), std::llround(scaled.y), std::llround(scaled.z)},
                     static_cast<std::uint32_t>(i)};
    }

    const std::int64_t edge = 2 * snapped.radius;
    sortIntoCells(placed, edge, particles);
    if (jitter.attempt > 0) {
        for (Placed& p : placed) {
            const std::uint64_t key = particles.id.empty() ? positionKey(p.position) : mix(particles.id[p.row]);
            p.position = jittered(p.position, key, jitter, snapped.radius);
        }
        sortIntoCells(placed, edge, particles);
    }

    snapped.position.reserve(placed.size());
    snapped.row.reserve(placed.size());
    for (const Placed& p : placed) {
        if (snapped.cell.empty() || snapped.cell.back() != p.cell) {
            snapped.cell.push_back(p.cell);
            snapped.cell_begin.push_back(static_cast<std::uint32_t>(snapped.position.size()));
        }
        snapped.position.push_back(p.position);
        snapped.row.push_back(p.row);
    }
    snapped.cell_begin.push_back(static_cast<std::uint32_t>(placed.size()));
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

void NeighbourFinder::find(std::uint32_t particle, std::vector<Neighbour>& neighbours) {
    const auto above = std::upper_bound(particles_.cell_begin.begin(), particles_.cell_begin.end(), particle);
    const auto cell = static_cast<std::size_t>(above - particles_.cell_begin.begin()) - 1;
    if (cell != cell_) {
        cell_ = cell;
        ranges_ = rangesAround(particles_, cell, buffer_);
    }
    const Vec3i origin = particles_.position[particle];
    const std::int64_t reach = 4 * particles_.radius * particles_.radius;
    neighbours.clear();
    for (const CellRange range : ranges_)
        for (std::uint32_t k = range.begin; k < range.end; ++k) {
            const Vec3i offset = particles_.position[k] - origin;
            const std::int64_t squared = offset.x * offset.x + offset.y * offset.y + offset.z * offset.z;
            if (squared <= reach && k != particle)
                neighbours.push_back({toDouble(offset), static_cast<double>(squared), k});
        }
}

}  // namespace betamesh
