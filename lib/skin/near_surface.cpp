
#include "skin/near_surface.h"

#include "base/cell_order.h"
#include "base/parallel.h"
#include "betamesh/error.h"
#include "skin/covered.h"

#include <algorithm>
#include <atomic>
#include <bitset>
#include <cmath>
#include <mutex>
#include <utility>

namespace betamesh {

namespace {

constexpr std::size_t kRowsPerPiece = std::size_t{1} << 14;
constexpr std::size_t kCellsPerTask = 64;
constexpr std::size_t kMostParticles = 0xFFFFFFFE;

// So many rows, one after another.
struct Piece {
    std::size_t first_row = 0;
    std::vector<std::uint32_t> cell;  // its number
    std::vector<PlaceInCell> place;   // in it, and then
    std::vector<std::uint32_t> slot;  // among all particles, cell by cell
};

// Tells which particles of a cell share a place with others.
class SharedPlaces {
public:
    // Returns whether any does.
    bool find(std::span<const PlaceInCell> places, std::span<std::uint8_t> is_shared) {
        bool any = false;
        for (const PlaceInCell place : places) {
            any |= taken_[place];
            taken_.set(place);
        }
        for (const PlaceInCell place : places) taken_.reset(place);
        if (!any) return false;
        sorted_.assign(places.begin(), places.end());
        std::sort(sorted_.begin(), sorted_.end());
        for (std::size_t i = 0; i < places.size(); ++i) {
            const auto [first, last] = std::equal_range(sorted_.begin(), sorted_.end(), places[i]);
            is_shared[i] = last - first > 1;
        }
        return true;
    }

private:
    std::bitset<kPlacesInCell> taken_;
    std::vector<PlaceInCell> sorted_;
};

// For each cell how many cells it is to the nearest one with balls that may be exposed, at most `far`.
std::vector<int> distancesToExposed(const std::vector<Vec3i>& cells, const std::vector<std::uint32_t>& cell_begin,
                                    const std::vector<std::uint8_t>& is_buried, int far) {
    std::vector<int> distance(cells.size(), far);
    parallelFor(cells.size(), kCellsPerTask, [&](std::size_t c) {
        const auto begin = is_buried.begin() + cell_begin[c], end = is_buried.begin() + cell_begin[c + 1];
        if (std::find(begin, end, 0) != end) distance[c] = 0;
    });
    for (int step = 1; step < far; ++step) {
        std::vector<std::uint8_t> reached(cells.size());
        parallelRanges(cells.size(), kCellsPerTask, [&](std::size_t first, std::size_t last) {
            CellsAround around(cells);
            for (std::size_t c = first; c < last; ++c)
                if (distance[c] == far)
                    around.forEach(c, [&](const Vec3i&, std::size_t other) { reached[c] |= distance[other] < far; });
        });
        for (std::size_t c = 0; c < cells.size(); ++c)
            if (reached[c]) distance[c] = step;
    }
    return distance;
}

// How many cells, two radii wide, round those with exposed balls matter. A skin is as deep below the union of larger
// balls as the ball that rolls over it is large; what is exposed of these is decided by their neighbours.
int marginOf(const SkinParams& params) {
    const Features& features = params.features;
    int margin = 1;
    if (const double skin = leastSkin(params); skin > 0) {
        const double rolling = (params.radius * params.radius - skin * skin) / (2 * skin);
        const double farthest = params.radius + 2 * rolling + skin + particleSpacing(params);
        margin = static_cast<int>(std::ceil(farthest / (2 * params.radius)));
    }
    if (features.droplets != Droplets::mesh)
        for (double side = -1; side * side * side < features.droplet_particles; side += 2) ++margin;
    return margin;
}

}  // namespace

struct NearSurfaceFinder::State {
    SnapGrid grid;
    int margin;
    bool all;
    std::size_t particles = 0;
    std::vector<Piece> pieces{};
    std::mutex mutex{};  // guards numbers
    CellNumbers numbers{};

    void place(std::span<const Vec3f> positions, Piece& piece);
    std::vector<Vec3i> sortCells();
    std::vector<PlaceInCell> sortPlaces(std::vector<std::uint32_t>& cell_begin);
};

NearSurfaceFinder::NearSurfaceFinder(const SkinParams& params)
    : state_(new State{SnapGrid(params.radius), marginOf(params),
                       params.predicates != PredicateKind::exact || params.features.tendrils != Tendrils::mesh}) {}
NearSurfaceFinder::~NearSurfaceFinder() = default;

// Numbers of its own first, so that threads seldom wait for each other.
void NearSurfaceFinder::State::place(std::span<const Vec3f> positions, Piece& piece) {
    piece.cell.resize(positions.size());
    piece.place.resize(positions.size());
    CellNumbers own;
    for (std::size_t i = 0; i < positions.size(); ++i) {
        const Vec3i position = grid.at(positions[i]), cell = grid.cellOf(position);
        piece.cell[i] = own.add({static_cast<std::int32_t>(cell.z), static_cast<std::int32_t>(cell.y),
                                 static_cast<std::int32_t>(cell.x)});  // far below 2^31: coordinates are below 2^50
        piece.place[i] = placeInCell(position - cell * (2 * grid.radius()), grid.radius());
    }
    std::vector<std::uint32_t> shared(own.places().size());
    {
        const std::scoped_lock lock(mutex);
        for (std::size_t c = 0; c < shared.size(); ++c) shared[c] = numbers.add(own.places()[c]);
    }
    for (std::uint32_t& cell : piece.cell) cell = shared[cell];
}

void NearSurfaceFinder::add(std::span<const Vec3f> positions) {
    State& state = *state_;
    state.grid.requireWithin(positions, state.particles);
    const std::size_t first_row = std::exchange(state.particles, state.particles + positions.size());
    if (state.particles > kMostParticles)
        throw Error(std::to_string(state.particles) + " particles and more, expected less than 2^32 - 1");
    if (state.all) return;
    const std::size_t before = state.pieces.size(), more = (positions.size() + kRowsPerPiece - 1) / kRowsPerPiece;
    state.pieces.resize(before + more);
    parallelFor(more, 1, [&](std::size_t p) {
        const std::size_t begin = p * kRowsPerPiece;
        Piece& piece = state.pieces[before + p];
        piece.first_row = first_row + begin;
        state.place(positions.subspan(begin, std::min(kRowsPerPiece, positions.size() - begin)), piece);
    });
}

// Their numbers become places in this order.
std::vector<Vec3i> NearSurfaceFinder::State::sortCells() {
    struct Numbered {
        CellPlace cell;
        std::uint32_t number;
    };
    std::vector<Numbered> sorted;
    for (const CellPlace& cell : numbers.places()) sorted.push_back({cell, static_cast<std::uint32_t>(sorted.size())});
    numbers = {};
    parallelSort(sorted, [](const Numbered& a, const Numbered& b) { return a.cell < b.cell; });
    std::vector<Vec3i> cells;
    std::vector<std::uint32_t> place(sorted.size());
    for (const auto& [cell, number] : sorted) {
        place[number] = static_cast<std::uint32_t>(cells.size());
        cells.emplace_back(cell.x, cell.y, cell.z);
    }
    parallelFor(pieces.size(), 1, [&](std::size_t p) {
        for (std::uint32_t& cell : pieces[p].cell) cell = place[cell];
    });
    return cells;
}

// Of all particles, cell by cell.
std::vector<PlaceInCell> NearSurfaceFinder::State::sortPlaces(std::vector<std::uint32_t>& cell_begin) {
    std::vector<std::uint32_t> next(cell_begin.size() - 1, 0);
    const auto take = [&](std::uint32_t cell) {
        return std::atomic_ref(next[cell]).fetch_add(1, std::memory_order_relaxed);
    };
    parallelFor(pieces.size(), 1, [&](std::size_t p) {
        for (const std::uint32_t cell : pieces[p].cell) take(cell);
    });
    cell_begin = exclusiveScan(next);
    std::copy(cell_begin.begin(), cell_begin.end() - 1, next.begin());
    std::vector<PlaceInCell> places(particles);
    parallelFor(pieces.size(), 1, [&](std::size_t p) {
        Piece& piece = pieces[p];
        piece.slot.resize(piece.cell.size());
        for (std::size_t i = 0; i < piece.cell.size(); ++i) {
            piece.slot[i] = take(piece.cell[i]);
            places[piece.slot[i]] = piece.place[i];
        }
        piece.place = {};
    });
    return places;
}

NearSurface NearSurfaceFinder::find() {
    State& state = *state_;
    NearSurface near;
    near.particles = state.particles;
    near.all = state.all;
    if (near.all) return near;

    const std::vector<Vec3i> cells = state.sortCells();
    std::vector<std::uint32_t> cell_begin(cells.size() + 1);
    const std::vector<PlaceInCell> places = state.sortPlaces(cell_begin);
    const std::vector<std::uint8_t> is_buried = coveredParticles(cells, cell_begin, places);
    const int far = state.margin + 1;
    const std::vector<int> distance = distancesToExposed(cells, cell_begin, is_buried, far);

    std::vector<std::uint8_t> stays(cells.size(), 1), is_rim(cells.size());  // stays: with all of it, or what is shared
    std::vector<std::uint8_t> is_shared(places.size());
    parallelRanges(cells.size(), kCellsPerTask, [&](std::size_t first, std::size_t last) {
        CellsAround around(cells);
        SharedPlaces shared;
        for (std::size_t c = first; c < last; ++c) {
            int farthest = 0;
            around.forEach(c, [&](const Vec3i&, std::size_t other) { farthest = std::max(farthest, distance[other]); });
            is_rim[c] = distance[c] > 0 && farthest == far;
            if (distance[c] < far) continue;
            const std::size_t begin = cell_begin[c], count = cell_begin[c + 1] - begin;
            stays[c] = shared.find(std::span(places).subspan(begin, count), std::span(is_shared).subspan(begin, count));
        }
    });
    std::vector<std::uint32_t> number(cells.size());  // among those that stay
    for (std::size_t c = 0; c < cells.size(); ++c) {
        if (!stays[c]) continue;
        number[c] = static_cast<std::uint32_t>(near.cell.size());
        near.cell.push_back(cells[c]);
        near.is_rim.push_back(is_rim[c]);
    }

    struct IndexRows {
        std::vector<std::uint32_t> row, cell;
        std::vector<std::uint8_t> buried;
    };
    std::vector<IndexRows> rows(state.pieces.size());
    parallelFor(rows.size(), 1, [&](std::size_t p) {
        const Piece& piece = state.pieces[p];
        for (std::size_t i = 0; i < piece.cell.size(); ++i) {
            const std::uint32_t c = piece.cell[i], slot = piece.slot[i];
            if (distance[c] == far && !is_shared[slot]) continue;
            rows[p].row.push_back(static_cast<std::uint32_t>(piece.first_row + i));
            rows[p].cell.push_back(number[c]);
            rows[p].buried.push_back(is_buried[slot]);
        }
    });
    near.row = concatenate(rows, &IndexRows::row);
    near.cell_of = concatenate(rows, &IndexRows::cell);
    near.is_buried = concatenate(rows, &IndexRows::buried);
    return near;
}

}  // namespace betamesh
