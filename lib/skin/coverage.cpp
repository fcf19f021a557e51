#include "skin/coverage.h"

#include "base/cell_grid.h"
#include "base/compressed_rows.h"
#include "base/parallel.h"
#include "base/simd.h"
#include "exact/neighbour_finder.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <span>
#include <utility>

namespace betamesh {

namespace {

constexpr int kVoxels = 8;        // voxels along the edge of a cell (2R)
constexpr int kRadius = 4;        // R, in voxels
constexpr int kStencilReach = 5;  // voxels from a particle's own voxel to the farthest one its sphere may touch
constexpr int kSubsteps = kStepsPerCell / kVoxels;  // sub-voxel positions with a table each, along each axis
constexpr double kSlack = 1e-4;                     // voxels, far above the rounding of a particle's position
constexpr int kSlices = 2 * kStencilReach + 1;
constexpr std::size_t kRows = 16;  // rows of a slice, padded to a register
constexpr int kCellsAround = 27;
constexpr std::size_t kCellsPerListTask = 256;

using SliceRows = std::uint16_t __attribute__((vector_size(kRows * 2)));
using WindowRows = std::uint32_t __attribute__((vector_size(kRows * 4), aligned(4)));
using BrickRows = std::uint8_t __attribute__((vector_size(8)));
using WindowWords = std::uint32_t __attribute__((vector_size(32), aligned(4)));

// Voxels round a particle's own voxel as bits: [z][y], bit x, each starting at -kStencilReach.
using Stencil = std::array<SliceRows, kSlices>;

// For each sub-voxel position of a particle: the voxels wholly inside its ball, and those its sphere passes through.
// For balls of several radii, the voxels wholly inside the smallest, and all that the sphere of any passes through.
// Aligned for the widest registers, whatever the processor that this file is compiled for.
struct alignas(64) Stencils {
    std::array<Stencil, kSubsteps * kSubsteps * kSubsteps> inside, sphere;
};

// smallest, largest: radii of the balls, in R.
Stencils computedStencils(double smallest, double largest) {
    // Least and greatest squared distance along one axis between a point of a voxel and one of a sub-voxel interval.
    struct SquaredDistances {
        double least, greatest;
    };
    std::array<std::array<SquaredDistances, kSlices>, kSubsteps> along{};
    for (int step = 0; step < kSubsteps; ++step)
        for (int voxel = -kStencilReach; voxel <= kStencilReach; ++voxel) {
            const double low = step / double{kSubsteps}, high = low + 1.0 / kSubsteps;
            const double least = std::max({0.0, voxel - high, low - (voxel + 1)});
            const double greatest = std::max(voxel + 1 - low, high - voxel);
            along[static_cast<std::size_t>(step)][static_cast<std::size_t>(voxel + kStencilReach)] = {
                least * least, greatest * greatest};
        }
    const double inside_squared = (kRadius * smallest - kSlack) * (kRadius * smallest - kSlack);
    const double outside_squared = (kRadius * largest + kSlack) * (kRadius * largest + kSlack);
    Stencils stencils{};
    for (std::size_t position = 0; position < stencils.inside.size(); ++position) {
        const auto& along_x = along[position % kSubsteps];
        const auto& along_y = along[position / kSubsteps % kSubsteps];
        const auto& along_z = along[position / (kSubsteps * kSubsteps)];
        for (std::size_t z = 0; z < kSlices; ++z)
            for (std::size_t y = 0; y < kSlices; ++y)
                for (std::size_t x = 0; x < kSlices; ++x) {
                    const auto bit = static_cast<std::uint16_t>(1U << x);
                    if (along_x[x].greatest + along_y[y].greatest + along_z[z].greatest < inside_squared)
                        stencils.inside[position][z][y] |= bit;
                    else if (along_x[x].least + along_y[y].least + along_z[z].least < outside_squared)
                        stencils.sphere[position][z][y] |= bit;
                }
    }
    return stencils;
}

// The voxels of a cell and the 26 round it: rows of bits along x, [z][y]. The last rows are padding for whole reads.
struct Window {
    alignas(64) std::uint32_t row[3 * kVoxels][3 * kVoxels + kRows];
};

// Position of a particle's stencil in the window of its cell, and which table it uses.
struct StencilPosition {
    std::uint32_t x, y, z;  // first voxel
    std::size_t table;
};

StencilPosition stencilPosition(CellOffset offset) {
    constexpr std::uint32_t kFirstVoxel = kVoxels - kStencilReach;
    const std::uint32_t x = offset % kStepsPerCell, y = offset / kStepsPerCell % kStepsPerCell,
                        z = offset / (kStepsPerCell * kStepsPerCell);
    return {x / kSubsteps + kFirstVoxel, y / kSubsteps + kFirstVoxel, z / kSubsteps + kFirstVoxel,
            x % kSubsteps + kSubsteps * (y % kSubsteps + kSubsteps * (z % kSubsteps))};
}

// Sets the voxels wholly inside the ball of a particle.
BETAMESH_EVERY_CPU
void setInside(Window& window, const StencilPosition& position, const Stencil& inside) {
    for (std::size_t s = 0; s < kSlices; ++s) {
        auto& rows = reinterpret_cast<WindowRows&>(window.row[position.z + s][position.y]);
        rows |= __builtin_convertvector(inside[s], WindowRows) << position.x;
    }
}

// Are all voxels that the sphere of a particle passes through set?
BETAMESH_EVERY_CPU
bool coversAll(const Window& window, const StencilPosition& position, const Stencil& sphere) {
    WindowRows open{};
    for (std::size_t s = 0; s < kSlices; ++s)
        open |= (__builtin_convertvector(sphere[s], WindowRows) << position.x) &
                ~reinterpret_cast<const WindowRows&>(window.row[position.z + s][position.y]);
    std::uint32_t any = 0;
    for (std::size_t l = 0; l < kRows; ++l) any |= open[l];
    return any == 0;
}

// The voxels of one cell: a slice is a word, a row a byte. Several threads may set voxels of one brick at once.
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

std::array<std::size_t, 3> asIndices(const Vec3i& v) {
    return {static_cast<std::size_t>(v.x), static_cast<std::size_t>(v.y), static_cast<std::size_t>(v.z)};
}

// Sets the voxels of a brick that are set in its part of the window; where: the brick's cell, 0 to 2 along each axis.
BETAMESH_EVERY_CPU
void addToBrick(Brick& brick, const Window& window, const Vec3i& where) {
    const auto [x, y, z] = asIndices(where);
    for (std::size_t s = 0; s < kVoxels; ++s) {
        const auto& rows = reinterpret_cast<const WindowWords&>(window.row[z * kVoxels + s][y * kVoxels]);
        const BrickRows bytes = __builtin_convertvector(rows >> static_cast<std::uint32_t>(x * kVoxels), BrickRows);
        brick.set(s, reinterpret_cast<const std::uint64_t&>(bytes));
    }
}

// Copies a brick into its part of the window.
BETAMESH_EVERY_CPU
void addToWindow(const Brick& brick, Window& window, const Vec3i& where) {
    const auto [x, y, z] = asIndices(where);
    for (std::size_t s = 0; s < kVoxels; ++s) {
        const auto& bytes = reinterpret_cast<const BrickRows&>(brick.slice[s]);
        auto& rows = reinterpret_cast<WindowWords&>(window.row[z * kVoxels + s][y * kVoxels]);
        rows |= __builtin_convertvector(bytes, WindowWords) << static_cast<std::uint32_t>(x * kVoxels);
    }
}

// Empty cells beside dense ones, in order. Balls reach into them, so they need bricks for those balls to be found
// covered. Beside cells that are not dense, empty cells could outnumber the particles.
std::vector<Vec3i> emptyBesideDenseCells(const std::vector<Vec3i>& cell, const std::vector<std::uint32_t>& cell_begin) {
    std::vector<std::vector<Vec3i>> parts((cell.size() + kCellsPerListTask - 1) / kCellsPerListTask);
    parallelFor(parts.size(), 1, [&](std::size_t part) {
        NeighbourCells around(cell);
        for (std::size_t c = part * kCellsPerListTask; c < std::min(cell.size(), (part + 1) * kCellsPerListTask); ++c) {
            if (cell_begin[c + 1] - cell_begin[c] < kDenseCell) continue;
            std::uint32_t occupied = 0;  // one bit for each of the 27 cells
            around.forEach(c, [&](const Vec3i& where, std::size_t) {
                occupied |= std::uint32_t{1} << (where.x + 3 * where.y + 9 * where.z);
            });
            for (std::int64_t k = 0; k < kCellsAround; ++k)
                if (!(occupied >> k & 1)) parts[part].push_back(cell[c] + Vec3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1));
        }
    });
    std::vector<Vec3i> empty = concatenate(parts);
    std::sort(empty.begin(), empty.end(), cellBefore);
    empty.erase(std::unique(empty.begin(), empty.end()), empty.end());
    return empty;
}

// As coveredParticles(), for a list of cells that may include empty ones. stencilsOf(i): those for a ball's radius.
template <typename StencilsOf>
std::vector<std::uint8_t> coveredInCells(const std::vector<Vec3i>& cell, const std::vector<std::uint32_t>& cell_begin,
                                         const std::vector<CellOffset>& offset, const StencilsOf& stencilsOf) {
    constexpr std::size_t kCellsPerTask = 16;
    std::vector<Brick> bricks(cell.size(), Brick{});
    parallelRanges(bricks.size(), kCellsPerTask, [&](std::size_t first, std::size_t last) {
        NeighbourCells around(cell);
        for (std::size_t c = first; c < last; ++c) {
            Window window{};
            for (std::uint32_t i = cell_begin[c]; i < cell_begin[c + 1]; ++i) {
                const StencilPosition p = stencilPosition(offset[i]);
                setInside(window, p, stencilsOf(i).inside[p.table]);
            }
            around.forEach(c, [&](const Vec3i& where, std::size_t other) {
                if (!bricks[other].isFull()) addToBrick(bricks[other], window, where);
            });
        }
    });

    std::vector<std::uint8_t> is_full(bricks.size()), is_covered(offset.size(), 1);
    parallelFor(bricks.size(), 1024, [&](std::size_t c) { is_full[c] = bricks[c].isFull(); });
    parallelRanges(bricks.size(), kCellsPerTask, [&](std::size_t first, std::size_t last) {
        NeighbourCells around(cell);
        for (std::size_t c = first; c < last; ++c) {
            int full = 0;
            around.forEach(c, [&](const Vec3i&, std::size_t other) { full += is_full[other]; });
            if (full == kCellsAround) continue;  // deep inside the liquid every ball is covered
            Window window{};
            around.forEach(c,
                           [&](const Vec3i& where, std::size_t other) { addToWindow(bricks[other], window, where); });
            for (std::uint32_t i = cell_begin[c]; i < cell_begin[c + 1]; ++i) {
                const StencilPosition p = stencilPosition(offset[i]);
                is_covered[i] = coversAll(window, p, stencilsOf(i).sphere[p.table]);
            }
        }
    });
    return is_covered;
}

// As coveredParticles(), for occupied cells.
template <typename StencilsOf>
std::vector<std::uint8_t> coveredBy(const std::vector<Vec3i>& cell, const std::vector<std::uint32_t>& cell_begin,
                                    const std::vector<CellOffset>& offset, const StencilsOf& stencilsOf) {
    const std::vector<Vec3i> empty = emptyBesideDenseCells(cell, cell_begin);
    if (empty.empty())
        return coveredInCells(cell, cell_begin, offset, stencilsOf);  // the usual case, without a copy of the cells
    std::vector<Vec3i> all(cell.size() + empty.size());
    std::merge(cell.begin(), cell.end(), empty.begin(), empty.end(), all.begin(), cellBefore);
    std::vector<std::uint32_t> begin;
    std::size_t passed = 0;  // occupied cells so far
    for (const Vec3i& here : all) {
        begin.push_back(cell_begin[passed]);
        passed += passed < cell.size() && cell[passed] == here;
    }
    begin.push_back(cell_begin.back());
    return coveredInCells(all, begin, offset, stencilsOf);
}

// Balls of which the largest is at most about twice as large as the smallest, by cells as wide as the largest.
struct AlikeBalls {
    std::span<const std::uint32_t> ball;  // the larger ranges first
    std::vector<std::uint32_t> begin;     // first row of `ball` of each range of nearly the same radius, and the end
    std::int64_t largest;                 // radius, quanta
    CellGrid grid;                        // rows of `ball`
};

// Of each row of alike.ball, 1 where the others cover it. radiusOf, positionOf: of a ball.
template <typename PositionOf, typename RadiusOf>
std::vector<std::uint8_t> coveredByAlike(const AlikeBalls& alike, const PositionOf& positionOf,
                                         const RadiusOf& radiusOf) {
    std::vector<Stencils> stencils(alike.begin.size() - 1);
    std::vector<std::uint8_t> range_of(alike.ball.size());  // of each row
    for (std::size_t range = 0; range < stencils.size(); ++range) {
        const std::uint32_t first = alike.begin[range], last = alike.begin[range + 1];
        if (first == last) continue;
        const auto balls = alike.ball.subspan(first, last - first);
        const auto [least, most] = std::ranges::minmax_element(balls, {}, radiusOf);
        const auto scale = static_cast<double>(alike.largest);
        stencils[range] = computedStencils(static_cast<double>(radiusOf(*least)) / scale,
                                           static_cast<double>(radiusOf(*most)) / scale);
        std::fill(range_of.begin() + first, range_of.begin() + last, static_cast<std::uint8_t>(range));
    }
    const CellGrid& grid = alike.grid;
    std::vector<Vec3i> cell(grid.cells());
    std::vector<std::uint32_t> cell_begin(grid.cells() + 1, 0);
    std::vector<CellOffset> offset(alike.ball.size());
    parallelFor(cell.size(), 64, [&](std::size_t i) {
        const auto c = static_cast<std::uint32_t>(i);
        cell[c] = Vec3i(grid.cell(c).x, grid.cell(c).y, grid.cell(c).z);
        cell_begin[c + 1] = grid.begin(c + 1);
        for (std::uint32_t at = grid.begin(c); at < grid.begin(c + 1); ++at) {
            const Vec3i corner = cell[c] * (2 * alike.largest);
            offset[at] = cellOffset(positionOf(alike.ball[grid.rows()[at]]) - corner, alike.largest);
        }
    });
    const std::vector<std::uint8_t> covered = coveredBy(
        cell, cell_begin, offset, [&](std::size_t i) -> const Stencils& { return stencils[range_of[grid.rows()[i]]]; });
    std::vector<std::uint8_t> is_covered(covered.size());
    for (std::size_t i = 0; i < covered.size(); ++i) is_covered[grid.rows()[i]] = covered[i];
    return is_covered;
}

constexpr std::size_t kRangesPerFactorOfTwo = 4, kRangesAlike = 2;

// Numbers a ball's range of radii: 4k + b is for those up to (8 - b) / 8 of the largest / 2^k.
std::size_t rangeOf(std::int64_t radius, std::int64_t largest) {
    constexpr std::int64_t kEighths = 2 * kRangesPerFactorOfTwo;
    std::size_t range = 0;
    for (; radius <= largest / 2; largest /= 2) range += kRangesPerFactorOfTwo;
    for (std::int64_t eighths = kEighths - 1; radius <= largest * eighths / kEighths; --eighths) ++range;
    return range;
}

}  // namespace

std::vector<std::uint8_t> coveredParticles(const std::vector<Vec3i>& cell, const std::vector<std::uint32_t>& cell_begin,
                                           const std::vector<CellOffset>& offset) {
    static const Stencils stencils = computedStencils(1, 1);
    return coveredBy(cell, cell_begin, offset, [](std::size_t) -> const Stencils& { return stencils; });
}

std::vector<std::uint8_t> coveredUnequal(std::size_t n, std::int64_t largest,
                                         const std::function<Vec3i(std::uint32_t)>& positionOf,
                                         const std::function<std::int64_t(std::uint32_t)>& radiusOf) {
    const std::size_t ranges = (rangeOf(1, largest) / kRangesAlike + 1) * kRangesAlike;
    const IndexRows balls_in = sortedIntoRows<std::uint32_t>(ranges, n, [&](std::size_t i, const auto& visit) {
        const auto ball = static_cast<std::uint32_t>(i);
        visit(rangeOf(radiusOf(ball), largest), ball);
    });
    // The balls of several ranges in succession.
    const auto alikeIn = [&](std::size_t first, std::size_t last) {
        const std::uint32_t begin = balls_in.begin[first];
        const auto balls = std::span(balls_in.item).subspan(begin, balls_in.begin[last] - begin);
        std::vector<std::uint32_t> begin_of;
        for (std::size_t range = first; range <= last; ++range) begin_of.push_back(balls_in.begin[range] - begin);
        const std::int64_t most = radiusOf(*std::ranges::max_element(balls, {}, radiusOf));
        CellGrid grid(balls.size(), static_cast<double>(2 * most),
                      [&](std::size_t i) { return toDouble(positionOf(balls[i])); });
        return AlikeBalls{balls, std::move(begin_of), most, std::move(grid)};
    };
    const auto isInsideOneOf = [&](const AlikeBalls& others, const Vec3i& position, std::int64_t radius) {
        const Vec3 reach(static_cast<double>(others.largest - radius)), at = toDouble(position);
        bool is_inside = false;
        others.grid.forRowsIn(at - reach, at + reach, [&](std::uint32_t row) {
            const std::int64_t margin = radiusOf(others.ball[row]) - radius;
            is_inside = is_inside || (positionOf(others.ball[row]) - position).length2() < margin * margin;
        });
        return is_inside;
    };
    std::vector<std::uint8_t> is_covered(n, 0);
    std::vector<AlikeBalls> larger;   // the largest first
    std::vector<std::size_t> firsts;  // the first range of each
    for (std::size_t first = 0; first < ranges; first += kRangesAlike) {
        if (balls_in.begin[first] == balls_in.begin[first + kRangesAlike]) continue;
        firsts.push_back(first);
        larger.push_back(alikeIn(first, first + kRangesAlike));
        const std::span<const std::uint32_t> balls = larger.back().ball;
        const std::vector<std::uint8_t> by_alike = coveredByAlike(larger.back(), positionOf, radiusOf);
        parallelFor(balls.size(), 256, [&](std::size_t i) {
            std::uint8_t& covered = is_covered[balls[i]];
            if (by_alike[i]) covered = kCoveredByAlike;
            const std::int64_t radius = radiusOf(balls[i]);
            for (const AlikeBalls& others : larger) {
                if (covered || others.largest < 2 * radius) break;
                covered = isInsideOneOf(others, positionOf(balls[i]), radius);
            }
        });
    }
    // Together, all that are at most twice as large as each other cover more, but small ones are resolved less finely.
    for (std::size_t k = 0; k + 1 < firsts.size(); ++k) {
        if (firsts[k + 1] >= firsts[k] + kRangesPerFactorOfTwo) continue;
        const AlikeBalls alike = alikeIn(firsts[k], firsts[k] + kRangesPerFactorOfTwo);
        const std::vector<std::uint8_t> by_alike = coveredByAlike(alike, positionOf, radiusOf);
        for (std::size_t i = 0; i < by_alike.size(); ++i)
            is_covered[alike.ball[i]] = std::max(is_covered[alike.ball[i]], by_alike[i]);
    }
    return is_covered;
}

namespace {

// The rows whose coverage is below a value.
std::vector<std::uint32_t> rowsBelow(std::uint8_t value, const std::vector<std::uint8_t>& is_covered) {
    return indicesWhere(is_covered.size(), [&](std::uint32_t i) { return is_covered[i] < value; });
}

}  // namespace

std::vector<std::uint8_t> coverage(const SnappedParticles& particles) {
    if (!particles.is_covered.empty()) return particles.is_covered;
    if (particles.size_classes)
        return coveredUnequal(
            particles.size(), particles.radius, [&](std::uint32_t i) { return particles.position[i]; },
            [&](std::uint32_t i) { return particles.radiusOf(i); });
    std::vector<CellOffset> offset(particles.size());
    parallelFor(particles.cell.size(), 64, [&](std::size_t c) {
        const Vec3i corner = particles.cell[c] * (2 * particles.radius);
        for (std::uint32_t i = particles.cell_begin[c]; i < particles.cell_begin[c + 1]; ++i)
            offset[i] = cellOffset(particles.position[i] - corner, particles.radius);
    });
    return coveredParticles(particles.cell, particles.cell_begin, offset);
}

std::vector<std::uint32_t> exposureCandidates(const SnappedParticles& particles) {
    return rowsBelow(1, coverage(particles));
}

std::vector<std::uint32_t> notAmongAlike(const SnappedParticles& particles) {
    return rowsBelow(kCoveredByAlike, coverage(particles));
}

}  // namespace betamesh
