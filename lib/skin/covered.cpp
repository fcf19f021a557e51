
#include "skin/covered.h"

#include "base/parallel.h"
#include "base/simd.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

namespace betamesh {

namespace {

constexpr int kVoxels = 8;  // per edge of a cell, which is 2R
constexpr int kRadius = 4;  // R, in voxels
constexpr int kReach = 5;   // voxels from a particle's own to the farthest that its sphere may touch
constexpr int kQuarters = kPlacesAlongCell / kVoxels;  // places in a voxel told apart along each axis
constexpr double kSlack = 1e-4;                        // voxels: far above the rounding of a particle's place
constexpr int kSlices = 2 * kReach + 1;
constexpr std::size_t kRows = 16;  // of a slice, the last ones empty
constexpr int kCellsAround = 27;
constexpr std::size_t kCellsPerPart = 256;

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
    // Squares of the least and greatest distances along one axis between a voxel and a place.
    struct Distances {
        double least, greatest;
    };
    std::array<std::array<Distances, kSlices>, kQuarters> along{};
    for (int quarter = 0; quarter < kQuarters; ++quarter)
        for (int voxel = -kReach; voxel <= kReach; ++voxel) {
            const double low = quarter / double{kQuarters}, high = low + 1.0 / kQuarters;
            const double least = std::max({0.0, voxel - high, low - (voxel + 1)});
            const double greatest = std::max(voxel + 1 - low, high - voxel);
            along[static_cast<std::size_t>(quarter)][static_cast<std::size_t>(voxel + kReach)] = {least * least,
                                                                                                  greatest * greatest};
        }
    constexpr double kInside = (kRadius - kSlack) * (kRadius - kSlack),
                     kOutside = (kRadius + kSlack) * (kRadius + kSlack);
    Stencils stencils{};
    for (std::size_t place = 0; place < stencils.inside.size(); ++place) {
        const auto& along_x = along[place % kQuarters];
        const auto& along_y = along[place / kQuarters % kQuarters];
        const auto& along_z = along[place / (kQuarters * kQuarters)];
        for (std::size_t z = 0; z < kSlices; ++z)
            for (std::size_t y = 0; y < kSlices; ++y)
                for (std::size_t x = 0; x < kSlices; ++x) {
                    const auto bit = static_cast<std::uint16_t>(1U << x);
                    if (along_x[x].greatest + along_y[y].greatest + along_z[z].greatest < kInside)
                        stencils.inside[place][z][y] |= bit;
                    else if (along_x[x].least + along_y[y].least + along_z[z].least < kOutside)
                        stencils.sphere[place][z][y] |= bit;
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

// Where a particle's stencil lies.
struct Place {
    std::uint32_t x, y, z;  // first voxel of the stencil, in the window
    std::size_t quarter;
};

Place placeOf(PlaceInCell in_cell) {
    constexpr std::uint32_t kFirst = kVoxels - kReach;
    const std::uint32_t x = in_cell % kPlacesAlongCell, y = in_cell / kPlacesAlongCell % kPlacesAlongCell,
                        z = in_cell / (kPlacesAlongCell * kPlacesAlongCell);
    return {x / kQuarters + kFirst, y / kQuarters + kFirst, z / kQuarters + kFirst,
            x % kQuarters + kQuarters * (y % kQuarters + kQuarters * (z % kQuarters))};
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

// The voxels of one cell: a slice is a word, a row a byte. Several threads set voxels of it at once.
struct alignas(64) Brick {
    std::uint64_t slice[kVoxels];

    void set(std::size_t s, std::uint64_t voxels) {
        const std::atomic_ref word(slice[s]);
        if (voxels & ~word.load(std::memory_order_relaxed)) word.fetch_or(voxels, std::memory_order_relaxed);
    }
    bool isFull() {
        std::uint64_t common = ~std::uint64_t{0};
        for (std::uint64_t& word : slice) common &= std::atomic_ref(word).load(std::memory_order_relaxed);
        return common == ~std::uint64_t{0};
    }
};

std::array<std::size_t, 3> indicesOf(const Vec3i& v) {
    return {static_cast<std::size_t>(v.x), static_cast<std::size_t>(v.y), static_cast<std::size_t>(v.z)};
}

BETAMESH_EVERY_CPU
void addTo(Brick& brick, const Window& window, const Vec3i& where) {
    const auto [x, y, z] = indicesOf(where);
    for (std::size_t s = 0; s < kVoxels; ++s) {
        const auto& rows = reinterpret_cast<const Words&>(window.row[z * kVoxels + s][y * kVoxels]);
        const Bytes bytes = __builtin_convertvector(rows >> static_cast<std::uint32_t>(x * kVoxels), Bytes);
        brick.set(s, reinterpret_cast<const std::uint64_t&>(bytes));
    }
}

BETAMESH_EVERY_CPU
void readFrom(const Brick& brick, Window& window, const Vec3i& where) {
    const auto [x, y, z] = indicesOf(where);
    for (std::size_t s = 0; s < kVoxels; ++s) {
        const auto& bytes = reinterpret_cast<const Bytes&>(brick.slice[s]);
        auto& rows = reinterpret_cast<Words&>(window.row[z * kVoxels + s][y * kVoxels]);
        rows |= __builtin_convertvector(bytes, Words) << static_cast<std::uint32_t>(x * kVoxels);
    }
}

// Cells without particles beside crowds, in order: balls reach into these, and so does whoever hides them there. Beside
// cells with fewer there may be more of them than particles.
std::vector<Vec3i> emptyBesideDenseCells(const std::vector<Vec3i>& cell, const std::vector<std::uint32_t>& cell_begin) {
    std::vector<std::vector<Vec3i>> parts((cell.size() + kCellsPerPart - 1) / kCellsPerPart);
    parallelFor(parts.size(), 1, [&](std::size_t part) {
        CellsAround around(cell);
        for (std::size_t c = part * kCellsPerPart; c < std::min(cell.size(), (part + 1) * kCellsPerPart); ++c) {
            if (cell_begin[c + 1] - cell_begin[c] < kDenseCell) continue;
            std::uint32_t there = 0;  // a bit for each of the 27
            around.forEach(c, [&](const Vec3i& where, std::size_t) {
                there |= std::uint32_t{1} << (where.x + 3 * where.y + 9 * where.z);
            });
            for (std::int64_t k = 0; k < kCellsAround; ++k)
                if (!(there >> k & 1)) parts[part].push_back(cell[c] + Vec3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1));
        }
    });
    std::vector<Vec3i> empty = concatenate(parts);
    std::sort(empty.begin(), empty.end(), cellBefore);
    empty.erase(std::unique(empty.begin(), empty.end()), empty.end());
    return empty;
}

// As coveredParticles(), where cells without particles are cells as any other.
std::vector<std::uint8_t> coveredAmong(const std::vector<Vec3i>& cell, const std::vector<std::uint32_t>& cell_begin,
                                      const std::vector<PlaceInCell>& place) {
    constexpr std::size_t kCellsPerTask = 16;
    std::vector<Brick> bricks(cell.size(), Brick{});
    parallelRanges(bricks.size(), kCellsPerTask, [&](std::size_t first, std::size_t last) {
        CellsAround around(cell);
        for (std::size_t c = first; c < last; ++c) {
            Window window{};
            for (std::uint32_t i = cell_begin[c]; i < cell_begin[c + 1]; ++i) {
                const Place p = placeOf(place[i]);
                setInside(window, p, stencils().inside[p.quarter]);
            }
            around.forEach(c, [&](const Vec3i& where, std::size_t other) {
                if (!bricks[other].isFull()) addTo(bricks[other], window, where);
            });
        }
    });

    std::vector<std::uint8_t> is_full(bricks.size()), is_buried(place.size(), 1);
    parallelFor(bricks.size(), 1024, [&](std::size_t c) { is_full[c] = bricks[c].isFull(); });
    parallelRanges(bricks.size(), kCellsPerTask, [&](std::size_t first, std::size_t last) {
        CellsAround around(cell);
        for (std::size_t c = first; c < last; ++c) {
            int full = 0;
            around.forEach(c, [&](const Vec3i&, std::size_t other) { full += is_full[other]; });
            if (full == kCellsAround) continue;  // deep inside all are buried
            Window window{};
            around.forEach(c, [&](const Vec3i& where, std::size_t other) { readFrom(bricks[other], window, where); });
            for (std::uint32_t i = cell_begin[c]; i < cell_begin[c + 1]; ++i) {
                const Place p = placeOf(place[i]);
                is_buried[i] = allSet(window, p, stencils().sphere[p.quarter]);
            }
        }
    });
    return is_buried;
}

}  // namespace

std::vector<std::uint8_t> coveredParticles(const std::vector<Vec3i>& cell, const std::vector<std::uint32_t>& cell_begin,
                                 const std::vector<PlaceInCell>& place) {
    const std::vector<Vec3i> empty = emptyBesideDenseCells(cell, cell_begin);
    if (empty.empty()) return coveredAmong(cell, cell_begin, place);  // as a rule: no copy of them all
    std::vector<Vec3i> all(cell.size() + empty.size());
    std::merge(cell.begin(), cell.end(), empty.begin(), empty.end(), all.begin(), cellBefore);
    std::vector<std::uint32_t> begin;
    std::size_t passed = 0;  // of those with particles
    for (const Vec3i& here : all) {
        begin.push_back(cell_begin[passed]);
        passed += passed < cell.size() && cell[passed] == here;
    }
    begin.push_back(cell_begin.back());
    return coveredAmong(all, begin, place);
}

}  // namespace betamesh
