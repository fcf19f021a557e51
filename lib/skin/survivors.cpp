#include "skin/survivors.h"

#include "core/parallel.h"
#include "core/simd.h"

#include <algorithm>
#include <atomic>
#include <cmath>

namespace betamesh {

namespace {

constexpr int kVoxels = 8;       // per edge of a cell, which is 2R
constexpr int kRadius = 4;       // R, in voxels
constexpr int kReach = 5;        // voxels from a particle's own to the farthest that its sphere may touch
constexpr int kQuarters = 4;     // places in a voxel told apart along each axis
constexpr double kSlack = 1e-4;  // voxels: far above the rounding of a particle's place
constexpr int kSlices = 2 * kReach + 1;
constexpr std::size_t kRows = 16;  // of a slice, the last ones empty

using Rows16 = std::uint16_t __attribute__((vector_size(kRows * 2)));
using Rows32 = std::uint32_t __attribute__((vector_size(kRows * 4), aligned(4)));
using Bytes = std::uint8_t __attribute__((vector_size(8)));
using Words = std::uint32_t __attribute__((vector_size(32), aligned(4)));

// Voxels round a particle's own one as bits: [z][y], bit x, each from -kReach on.
using Stencil = std::array<Rows16, kSlices>;

// For each place in a voxel: the voxels wholly inside a ball, and those that its sphere passes through.
struct Stencils {
    std::array<Stencil, kQuarters * kQuarters * kQuarters> inside, sphere;
};

Stencils makeStencils() {
    Stencils stencils{};
    for (int place = 0; place < kQuarters * kQuarters * kQuarters; ++place) {
        const std::array<int, 3> quarter{place % kQuarters, place / kQuarters % kQuarters,
                                         place / (kQuarters * kQuarters)};
        // Least and greatest distances along one axis between a voxel and a place.
        const auto least = [&](int axis, int voxel) {
            const double low = quarter[static_cast<std::size_t>(axis)] / double{kQuarters},
                         high = low + 1.0 / kQuarters;
            return std::max({0.0, voxel - high, low - (voxel + 1)});
        };
        const auto greatest = [&](int axis, int voxel) {
            const double low = quarter[static_cast<std::size_t>(axis)] / double{kQuarters},
                         high = low + 1.0 / kQuarters;
            return std::max(voxel + 1 - low, high - voxel);
        };
        for (int z = -kReach; z <= kReach; ++z)
            for (int y = -kReach; y <= kReach; ++y)
                for (int x = -kReach; x <= kReach; ++x) {
                    const double near = std::hypot(least(0, x), least(1, y), least(2, z));
                    const double far = std::hypot(greatest(0, x), greatest(1, y), greatest(2, z));
                    const auto bit = static_cast<std::uint16_t>(1U << (x + kReach));
                    const auto p = static_cast<std::size_t>(place), slice = static_cast<std::size_t>(z + kReach);
                    const auto row = static_cast<std::size_t>(y + kReach);
                    if (far < kRadius - kSlack)
                        stencils.inside[p][slice][row] |= bit;
                    else if (near < kRadius + kSlack)
                        stencils.sphere[p][slice][row] |= bit;
                }
    }
    return stencils;
}

const Stencils& stencils() {
    static const Stencils made = makeStencils();
    return made;
}

// The voxels of a cell and of those round it: rows of bits along x, [z][y]; the last rows are only room to read.
struct Window {
    alignas(64) std::uint32_t row[3 * kVoxels][3 * kVoxels + kRows];
};

// Where a particle lies in its cell.
struct Place {
    std::uint32_t x, y, z;  // first voxel of the stencil, in the window
    std::size_t quarter;
};

Place placeOf(const Vec3i& in_cell, float quarters_per_quantum) {
    std::array<std::uint32_t, 3> q;
    for (int k = 0; k < 3; ++k)
        q[static_cast<std::size_t>(k)] =
            std::min(static_cast<std::uint32_t>(static_cast<float>(in_cell[k]) * quarters_per_quantum),
                     std::uint32_t{kVoxels * kQuarters - 1});
    constexpr std::uint32_t kFirst = kVoxels - kReach;
    return {q[0] / kQuarters + kFirst, q[1] / kQuarters + kFirst, q[2] / kQuarters + kFirst,
            q[0] % kQuarters + kQuarters * (q[1] % kQuarters + kQuarters * (q[2] % kQuarters))};
}

BETAMESH_EVERY_CPU
void setInside(Window& window, const Place& place, const Stencil& inside) {
    for (std::size_t s = 0; s < kSlices; ++s) {
        auto& rows = reinterpret_cast<Rows32&>(window.row[place.z + s][place.y]);
        rows |= __builtin_convertvector(inside[s], Rows32) << place.x;
    }
}

BETAMESH_EVERY_CPU
bool allSet(const Window& window, const Place& place, const Stencil& sphere) {
    Rows32 open{};
    for (std::size_t s = 0; s < kSlices; ++s)
        open |= (__builtin_convertvector(sphere[s], Rows32) << place.x) &
                ~reinterpret_cast<const Rows32&>(window.row[place.z + s][place.y]);
    std::uint32_t any = 0;
    for (std::size_t l = 0; l < kRows; ++l) any |= open[l];
    return any == 0;
}

// The voxels of one cell: a slice is a word, a row a byte.
struct alignas(64) Brick {
    std::uint64_t slice[kVoxels];
};

BETAMESH_EVERY_CPU
void addTo(Brick& brick, const Window& window, std::size_t x, std::size_t y, std::size_t z) {
    for (std::size_t s = 0; s < kVoxels; ++s) {
        const auto& rows = reinterpret_cast<const Words&>(window.row[z * kVoxels + s][y * kVoxels]);
        const Bytes bytes = __builtin_convertvector(rows >> static_cast<std::uint32_t>(x * kVoxels), Bytes);
        const auto word = reinterpret_cast<const std::uint64_t&>(bytes);
        if (word) std::atomic_ref(brick.slice[s]).fetch_or(word, std::memory_order_relaxed);
    }
}

BETAMESH_EVERY_CPU
void readFrom(const Brick& brick, Window& window, std::size_t x, std::size_t y, std::size_t z) {
    for (std::size_t s = 0; s < kVoxels; ++s) {
        const auto& bytes = reinterpret_cast<const Bytes&>(brick.slice[s]);
        auto& rows = reinterpret_cast<Words&>(window.row[z * kVoxels + s][y * kVoxels]);
        rows |= __builtin_convertvector(bytes, Words) << static_cast<std::uint32_t>(x * kVoxels);
    }
}

}  // namespace

std::vector<std::uint32_t> survivors(const SnappedParticles& particles) {
    constexpr std::size_t kCellsPerTask = 16;
    const std::size_t cells = particles.cell.size();
    const std::int64_t edge = 2 * particles.radius;
    const float quarters_per_quantum = static_cast<float>(kRadius * kQuarters) / static_cast<float>(particles.radius);
    std::vector<Brick> bricks(cells, Brick{});
    const auto forParticles = [&](std::size_t cell, const auto& visit) {
        const Vec3i corner = particles.cell[cell] * edge;
        for (std::uint32_t i = particles.cell_begin[cell]; i < particles.cell_begin[cell + 1]; ++i)
            visit(i, placeOf(particles.position[i] - corner, quarters_per_quantum));
    };

    parallelFor(cells, kCellsPerTask, [&](std::size_t cell) {
        Window window{};
        forParticles(cell, [&](std::uint32_t, const Place& place) {
            setInside(window, place, stencils().inside[place.quarter]);
        });
        forCellsAround(particles, cell, [&](const Vec3i& at, std::size_t other) {
            addTo(bricks[other], window, static_cast<std::size_t>(at.x), static_cast<std::size_t>(at.y),
                  static_cast<std::size_t>(at.z));
        });
    });

    std::vector<std::uint8_t> buried(particles.size());
    parallelFor(cells, kCellsPerTask, [&](std::size_t cell) {
        Window window{};
        forCellsAround(particles, cell, [&](const Vec3i& at, std::size_t other) {
            readFrom(bricks[other], window, static_cast<std::size_t>(at.x), static_cast<std::size_t>(at.y),
                     static_cast<std::size_t>(at.z));
        });
        forParticles(cell, [&](std::uint32_t i, const Place& place) {
            buried[i] = allSet(window, place, stencils().sphere[place.quarter]);
        });
    });
    std::vector<std::uint32_t> left;
    for (std::uint32_t i = 0; i < buried.size(); ++i)
        if (!buried[i]) left.push_back(i);
    return left;
}

}  // namespace betamesh
