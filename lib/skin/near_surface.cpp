#include "skin/near_surface.h"

#include "base/cell_grid.h"
#include "base/parallel.h"
#include "betamesh/error.h"
#include "skin/coverage.h"
#include "skin/particle_sizes.h"
#include "skin/skin_lengths.h"

#include <algorithm>
#include <atomic>
#include <bitset>
#include <cmath>
#include <mutex>
#include <utility>

namespace betamesh {

namespace {

constexpr std::size_t kRowsPerBatch = std::size_t{1} << 14;
constexpr std::size_t kCellsPerTask = 64;
constexpr std::size_t kMostParticles = 0xFFFFFFFE;

// What is kept of consecutive particles.
struct Batch {
    std::size_t first_row = 0;
    std::vector<std::uint32_t> cell;  // number of each particle's cell
    std::vector<CellOffset> offset;   // of each particle in its cell; freed once slot is filled
    std::vector<std::uint32_t> slot;  // index of each particle among all, sorted by cell
};

// Consecutive particles of different radii, kept until the largest radius is known.
struct SizedParticles {
    std::vector<Vec3f> position;
    std::vector<double> radius;  // world units
};

// Finds particles of a cell that have the same offset as others: they may be duplicates.
class SharedOffsets {
public:
    // Returns whether there are any.
    bool find(std::span<const CellOffset> offsets, std::span<std::uint8_t> is_shared) {
        bool any = false;
        for (const CellOffset offset : offsets) {
            any |= present_[offset];
            present_.set(offset);
        }
        for (const CellOffset offset : offsets) present_.reset(offset);
        if (!any) return false;
        sorted_.assign(offsets.begin(), offsets.end());
        std::sort(sorted_.begin(), sorted_.end());
        for (std::size_t i = 0; i < offsets.size(); ++i) {
            const auto [first, last] = std::equal_range(sorted_.begin(), sorted_.end(), offsets[i]);
            is_shared[i] = last - first > 1;
        }
        return true;
    }

private:
    std::bitset<kCellOffsets> present_;
    std::vector<CellOffset> sorted_;
};

// Distance from each cell to the nearest one with exposure candidates, in cells and at most `limit`.
std::vector<int> distancesToExposed(const std::vector<Vec3i>& cells, const std::vector<std::uint32_t>& cell_begin,
                                    const std::vector<std::uint8_t>& is_covered, int limit) {
    std::vector<int> distance(cells.size(), limit);
    parallelFor(cells.size(), kCellsPerTask, [&](std::size_t c) {
        const auto begin = is_covered.begin() + cell_begin[c], end = is_covered.begin() + cell_begin[c + 1];
        if (std::find(begin, end, 0) != end) distance[c] = 0;
    });
    for (int step = 1; step < limit; ++step) {
        std::vector<std::uint8_t> reached(cells.size());
        parallelRanges(cells.size(), kCellsPerTask, [&](std::size_t first, std::size_t last) {
            NeighbourCells around(cells);
            for (std::size_t c = first; c < last; ++c)
                if (distance[c] == limit)
                    around.forEach(c, [&](const Vec3i&, std::size_t other) { reached[c] |= distance[other] < limit; });
        });
        for (std::size_t c = 0; c < cells.size(); ++c)
            if (reached[c]) distance[c] = step;
    }
    return distance;
}

// What is kept of the particles in cells.
struct KeptCells {
    std::vector<std::uint8_t> is_kept;        // of each cell: some particles are
    std::vector<std::uint8_t> is_incomplete;  // of each cell, as in NearSurface
    std::vector<std::uint8_t> is_shared;      // of each particle, sorted by cell, in cells at the limit
};

// Cells at the limit keep only particles whose offset is shared, all others keep every particle.
KeptCells keptCells(const std::vector<Vec3i>& cells, const std::vector<std::uint32_t>& cell_begin,
                    const std::vector<CellOffset>& offsets, const std::vector<int>& distance, int limit) {
    KeptCells kept{std::vector<std::uint8_t>(cells.size(), 1), std::vector<std::uint8_t>(cells.size()),
                   std::vector<std::uint8_t>(offsets.size())};
    parallelRanges(cells.size(), kCellsPerTask, [&](std::size_t first, std::size_t last) {
        NeighbourCells around(cells);
        SharedOffsets shared;
        for (std::size_t c = first; c < last; ++c) {
            int farthest = 0;
            around.forEach(c, [&](const Vec3i&, std::size_t other) { farthest = std::max(farthest, distance[other]); });
            kept.is_incomplete[c] = distance[c] > 0 && farthest == limit;
            if (distance[c] < limit) continue;
            const std::size_t begin = cell_begin[c], count = cell_begin[c + 1] - begin;
            kept.is_kept[c] =
                shared.find(std::span(offsets).subspan(begin, count), std::span(kept.is_shared).subspan(begin, count));
        }
    });
    return kept;
}

// Radius within which particles matter to an exposed ball, because of the skin. The skin lies as deep below the union
// of larger balls as the rolling ball is large, and those balls' exposed parts depend on their neighbours in turn. Of
// different radii, larger balls may be exposed whose smaller ones are not: those that reach out of the smaller ones
// beside an exposed one.
double reachOfSkin(const SkinParams& params, bool different_radii) {
    const double skin = effectiveSkinDepth(params);
    if (!(skin > 0)) return 0;
    const double rolling = rollingRadius(params.radius, skin);
    return params.radius + 2 * rolling + skin + particleSpacing(params) + (different_radii ? rolling + 2 * skin : 0);
}

// How many layers of cells (edge 2R) round cells with exposed balls are kept.
int marginCells(const SkinParams& params, bool different_radii = false) {
    const Features& features = params.features;
    int margin = 1;
    if (const double reach = reachOfSkin(params, different_radii); reach > 0)
        margin = static_cast<int>(std::ceil(reach / (2 * params.radius)));
    if (features.droplets != Droplets::mesh)
        for (double side = -1; side * side * side < features.droplet_particles; side += 2) ++margin;
    return margin;
}

}  // namespace

struct NearSurfaceFinder::State {
    SkinParams params;
    SnapGrid grid;
    int margin;
    bool all;
    std::size_t particles = 0;
    std::vector<Batch> batches{};
    std::mutex mutex{};  // guards numbers
    CellNumbering numbers{};

    double largest = 0;                   // radius of the largest ball, world units; 0: no radii are given
    std::vector<SizedParticles> sized{};  // each of kRowsPerBatch particles, but for the last

    void count(std::size_t more);
    void process(std::span<const Vec3f> positions, Batch& batch);
    void keep(std::span<const Vec3f> positions, std::span<const double> radii);
    void processSized();
    bool isUnequal() const;
    std::vector<std::uint8_t> coveredAmongSized() const;
    std::vector<std::uint8_t> findCoveredAmongSized(bool& is_unequal);
    std::vector<Vec3i> sortedCells();
    std::vector<CellOffset> sortedOffsets(std::vector<std::uint32_t>& cell_begin);
    std::vector<std::uint8_t> sortedByCell(const std::vector<std::uint8_t>& of_row) const;
    template <typename IsKept>
    void selectRows(const IsKept& isKept, const std::vector<std::uint32_t>& number,
                    const std::vector<std::uint8_t>& is_covered, NearSurface& near) const;
};

NearSurfaceFinder::NearSurfaceFinder(const SkinParams& params)
    : state_(new State{params, SnapGrid(params.radius), marginCells(params),
                       params.predicates != PredicateKind::exact || params.features.tendrils != Tendrils::mesh}) {}
NearSurfaceFinder::~NearSurfaceFinder() = default;

// Numbers the cells of the batch first, then those numbers as shared ones: the lock is taken once per batch.
void NearSurfaceFinder::State::process(std::span<const Vec3f> positions, Batch& batch) {
    batch.cell.resize(positions.size());
    batch.offset.resize(positions.size());
    CellNumbering own;
    for (std::size_t i = 0; i < positions.size(); ++i) {
        const Vec3i position = grid.at(positions[i]), cell = grid.cellOf(position);
        batch.cell[i] = own.add({static_cast<std::int32_t>(cell.z), static_cast<std::int32_t>(cell.y),
                                 static_cast<std::int32_t>(cell.x)});  // far below 2^31: coordinates are below 2^50
        batch.offset[i] = cellOffset(position - cell * (2 * grid.radius()), grid.radius());
    }
    std::vector<std::uint32_t> shared(own.cells().size());
    {
        const std::scoped_lock lock(mutex);
        for (std::size_t c = 0; c < shared.size(); ++c) shared[c] = numbers.add(own.cells()[c]);
    }
    for (std::uint32_t& cell : batch.cell) cell = shared[cell];
}

void NearSurfaceFinder::add(std::span<const Vec3f> positions) {
    State& state = *state_;
    state.grid.requireWithin(positions, state.particles);
    const std::size_t first_row = state.particles;
    state.count(positions.size());
    if (state.all) return;
    const std::size_t before = state.batches.size(), more = (positions.size() + kRowsPerBatch - 1) / kRowsPerBatch;
    state.batches.resize(before + more);
    parallelFor(more, 1, [&](std::size_t p) {
        const std::size_t begin = p * kRowsPerBatch;
        Batch& batch = state.batches[before + p];
        batch.first_row = first_row + begin;
        state.process(positions.subspan(begin, std::min(kRowsPerBatch, positions.size() - begin)), batch);
    });
}

void NearSurfaceFinder::add(std::span<const Vec3f> positions, std::span<const double> radii) {
    if (radii.empty()) return add(positions);
    State& state = *state_;
    state.count(positions.size());
    state.largest = std::max(state.largest, *std::max_element(radii.begin(), radii.end()));
    if (!state.all) state.keep(positions, radii);
}

void NearSurfaceFinder::State::count(std::size_t more) {
    particles += more;
    if (particles > kMostParticles)
        throw Error("a frame of " + std::to_string(particles) +
                    " particles or more is too large; at most 2^32 - 2 are supported");
}

void NearSurfaceFinder::State::keep(std::span<const Vec3f> positions, std::span<const double> radii) {
    for (std::size_t i = 0; i < positions.size();) {
        if (sized.empty() || sized.back().radius.size() == kRowsPerBatch) sized.emplace_back();
        auto& [position, radius] = sized.back();
        const std::size_t count = std::min(positions.size() - i, kRowsPerBatch - radius.size());
        position.insert(position.end(), &positions[i], &positions[i] + count);
        radius.insert(radius.end(), &radii[i], &radii[i] + count);
        i += count;
    }
}

// Sorts the particles that were kept into cells, once the largest radius is known.
void NearSurfaceFinder::State::processSized() {
    grid = SnapGrid(largest);
    margin = marginCells(withRadius(params, largest), true);
    for (std::size_t p = 0; p < sized.size(); ++p) requireSimilar(sized[p].radius, largest, p * kRowsPerBatch);
    for (std::size_t p = 0; p < sized.size(); ++p) grid.requireWithin(sized[p].position, p * kRowsPerBatch);
    batches.resize(sized.size());
    parallelFor(batches.size(), 1, [&](std::size_t p) {
        batches[p].first_row = p * kRowsPerBatch;
        process(sized[p].position, batches[p]);
    });
}

// Do the balls have different radii in quanta?
bool NearSurfaceFinder::State::isUnequal() const {
    return std::any_of(sized.begin(), sized.end(), [&](const SizedParticles& some) {
        return std::any_of(some.radius.begin(), some.radius.end(),
                           [&](double radius) { return std::llround(radius * grid.perUnit()) != grid.radius(); });
    });
}

std::vector<std::uint8_t> NearSurfaceFinder::State::coveredAmongSized() const {
    return coveredUnequal(
        particles, grid.radius(),
        [&](std::uint32_t row) { return grid.at(sized[row / kRowsPerBatch].position[row % kRowsPerBatch]); },
        [&](std::uint32_t row) {
            return std::llround(sized[row / kRowsPerBatch].radius[row % kRowsPerBatch] * grid.perUnit());
        });
}

// The occupied cells in order. The cell numbers of all batches become indices into them.
std::vector<Vec3i> NearSurfaceFinder::State::sortedCells() {
    struct Numbered {
        GridCell cell;
        std::uint32_t number;
    };
    std::vector<Numbered> sorted;
    for (const GridCell& cell : numbers.cells()) sorted.push_back({cell, static_cast<std::uint32_t>(sorted.size())});
    numbers = {};
    parallelSort(sorted, [](const Numbered& a, const Numbered& b) { return a.cell < b.cell; });
    std::vector<Vec3i> cells;
    std::vector<std::uint32_t> index(sorted.size());
    for (const auto& [cell, number] : sorted) {
        index[number] = static_cast<std::uint32_t>(cells.size());
        cells.emplace_back(cell.x, cell.y, cell.z);
    }
    parallelFor(batches.size(), 1, [&](std::size_t p) {
        for (std::uint32_t& cell : batches[p].cell) cell = index[cell];
    });
    return cells;
}

// The offsets of all particles, sorted by cell; sets each batch's slots and the first particle of each cell.
std::vector<CellOffset> NearSurfaceFinder::State::sortedOffsets(std::vector<std::uint32_t>& cell_begin) {
    std::vector<std::uint32_t> next(cell_begin.size() - 1, 0);
    const auto nextSlot = [&](std::uint32_t cell) {
        return std::atomic_ref(next[cell]).fetch_add(1, std::memory_order_relaxed);
    };
    parallelFor(batches.size(), 1, [&](std::size_t p) {
        for (const std::uint32_t cell : batches[p].cell) nextSlot(cell);
    });
    cell_begin = exclusiveScan(next);
    std::copy(cell_begin.begin(), cell_begin.end() - 1, next.begin());
    std::vector<CellOffset> offsets(particles);
    parallelFor(batches.size(), 1, [&](std::size_t p) {
        Batch& batch = batches[p];
        batch.slot.resize(batch.cell.size());
        for (std::size_t i = 0; i < batch.cell.size(); ++i) {
            batch.slot[i] = nextSlot(batch.cell[i]);
            offsets[batch.slot[i]] = batch.offset[i];
        }
        batch.offset = {};
    });
    return offsets;
}

// Numbers of the particles, which have their slots, in the order of the cells.
std::vector<std::uint8_t> NearSurfaceFinder::State::sortedByCell(const std::vector<std::uint8_t>& of_row) const {
    std::vector<std::uint8_t> sorted(of_row.size());
    parallelFor(batches.size(), 1, [&](std::size_t p) {
        for (std::size_t i = 0; i < batches[p].slot.size(); ++i)
            sorted[batches[p].slot[i]] = of_row[batches[p].first_row + i];
    });
    return sorted;
}

// Lists the particles for which isKept(cell, slot), with the numbers of their cells.
template <typename IsKept>
void NearSurfaceFinder::State::selectRows(const IsKept& isKept, const std::vector<std::uint32_t>& number,
                                          const std::vector<std::uint8_t>& is_covered, NearSurface& near) const {
    struct KeptRows {
        std::vector<std::uint32_t> row, cell;
        std::vector<std::uint8_t> covered;
    };
    std::vector<KeptRows> rows(batches.size());
    parallelFor(rows.size(), 1, [&](std::size_t p) {
        const Batch& batch = batches[p];
        for (std::size_t i = 0; i < batch.cell.size(); ++i) {
            const std::uint32_t c = batch.cell[i], slot = batch.slot[i];
            if (!isKept(c, slot)) continue;
            rows[p].row.push_back(static_cast<std::uint32_t>(batch.first_row + i));
            rows[p].cell.push_back(number[c]);
            rows[p].covered.push_back(is_covered[slot]);
        }
    });
    near.row = concatenate(rows, &KeptRows::row);
    near.cell_of = concatenate(rows, &KeptRows::cell);
    near.is_covered = concatenate(rows, &KeptRows::covered);
}

// Where particles of different radii are covered, once all are known. Frees what was kept of them.
std::vector<std::uint8_t> NearSurfaceFinder::State::findCoveredAmongSized(bool& is_unequal) {
    processSized();
    is_unequal = isUnequal();
    std::vector<std::uint8_t> is_covered = coveredAmongSized();
    if (!is_unequal)
        for (std::uint8_t& covered : is_covered) covered = covered != 0;
    sized = {};
    return is_covered;
}

NearSurface NearSurfaceFinder::find() {
    State& state = *state_;
    NearSurface near;
    near.particles = state.particles;
    near.all = state.all;
    near.largest = state.largest;
    if (near.all) return near;
    const bool has_radii = state.largest > 0;
    std::vector<std::uint8_t> is_row_covered;  // of each particle in the order of the stream
    if (has_radii) is_row_covered = state.findCoveredAmongSized(near.is_unequal);

    const std::vector<Vec3i> cells = state.sortedCells();
    std::vector<std::uint32_t> cell_begin(cells.size() + 1);
    const std::vector<CellOffset> offsets = state.sortedOffsets(cell_begin);
    const std::vector<std::uint8_t> is_covered =
        has_radii ? state.sortedByCell(is_row_covered) : coveredParticles(cells, cell_begin, offsets);
    const int limit = state.margin + 1;
    const std::vector<int> distance = distancesToExposed(cells, cell_begin, is_covered, limit);
    const KeptCells kept = keptCells(cells, cell_begin, offsets, distance, limit);

    std::vector<std::uint32_t> number(cells.size());  // among kept cells
    for (std::size_t c = 0; c < cells.size(); ++c) {
        if (!kept.is_kept[c]) continue;
        number[c] = static_cast<std::uint32_t>(near.cell.size());
        near.cell.push_back(cells[c]);
        near.is_incomplete.push_back(kept.is_incomplete[c]);
    }
    const auto isKept = [&](std::uint32_t cell, std::uint32_t slot) {
        return distance[cell] < limit || kept.is_shared[slot] != 0;
    };
    state.selectRows(isKept, number, is_covered, near);
    return near;
}

}  // namespace betamesh
