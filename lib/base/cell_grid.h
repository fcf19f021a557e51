// A uniform grid over points: points sorted by cell, to find those in a box or near a cell.

#pragma once

#include "base/index.h"
#include "base/parallel.h"
#include "betamesh/vec3.h"

#include <algorithm>
#include <array>
#include <compare>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace betamesh {

/// Integer coordinates of a grid cell, ordered by z, then y, then x.
struct GridCell {
    std::int32_t z, y, x;
    friend auto operator<=>(const GridCell&, const GridCell&) = default;
};

/// Numbers cells 0, 1, 2 … in the order in which they are first added: a hash table with open addressing.
class CellNumbering {
public:
    CellNumbering() : slot_(std::size_t{1} << kInitialBits, kInvalidIndex) {}
    /// The number of a cell, a new one if the cell has none yet.
    std::uint32_t add(const GridCell& cell) {
        const std::size_t slot = slotOf(cell);
        if (slot_[slot] != kInvalidIndex) return slot_[slot];
        const auto number = slot_[slot] = static_cast<std::uint32_t>(cell_.size());
        cell_.push_back(cell);
        if (2 * cell_.size() > slot_.size()) grow();
        return number;
    }
    /// The number of a cell, or kInvalidIndex.
    std::uint32_t find(const GridCell& cell) const { return slot_[slotOf(cell)]; }
    /// Cells by number.
    const std::vector<GridCell>& cells() const { return cell_; }

private:
    // The slot of a cell: the first one from its hash on that is free or already holds it.
    std::size_t slotOf(const GridCell& cell) const {
        const auto [z, y, x] = cell;
        const std::uint64_t hash = static_cast<std::uint64_t>(z) * 0x9E3779B97F4A7C15 +
                                   static_cast<std::uint64_t>(y) * 0xC2B2AE3D27D4EB4F +
                                   static_cast<std::uint64_t>(x) * 0x165667B19E3779F9;
        std::size_t slot = hash >> shift_;  // the high bits of the products depend on every bit of the coordinates
        while (slot_[slot] != kInvalidIndex && cell_[slot_[slot]] != cell) slot = (slot + 1) & (slot_.size() - 1);
        return slot;
    }
    void grow() {
        slot_.assign(2 * slot_.size(), kInvalidIndex);
        --shift_;
        for (std::uint32_t number = 0; number < cell_.size(); ++number) slot_[slotOf(cell_[number])] = number;
    }

    static constexpr int kInitialBits = 6;

    std::vector<GridCell> cell_;
    std::vector<std::uint32_t> slot_;  // numbers of cells; 2^k slots, at most half of them in use
    int shift_ = 64 - kInitialBits;    // 64 - k
};

/// The rows of n points sorted by cell (z, y, x) and ascending within a cell; only occupied cells are stored.
class CellGrid {
public:
    /// in      edge: of a cell; |coordinate| / edge below 2^31. positionOf(row): position of a point
    /// same    order for any thread count
    /// cost    O(n + cells log cells)
    template <typename PositionOf>
    CellGrid(std::size_t n, double edge, const PositionOf& positionOf) : edge_(edge), row_(n) {
        std::vector<Part> parts(std::clamp<std::size_t>(n / 4096, 1, threadsHere()));
        std::vector<std::uint32_t> number(n);  // of each point's cell within its part
        parallelFor(parts.size(), 1, [&](std::size_t p) {
            Part part;  // a local variable, to avoid false sharing between threads
            for (std::size_t row = n * p / parts.size(); row < n * (p + 1) / parts.size(); ++row) {
                const Vec3 at = positionOf(row);
                number[row] = part.add({indexOf(at.z), indexOf(at.y), indexOf(at.x)});
            }
            parts[p] = std::move(part);
        });
        sortCells(parts);
        parallelFor(parts.size(), 1, [&](std::size_t p) {
            for (std::size_t row = n * p / parts.size(); row < n * (p + 1) / parts.size(); ++row)
                row_[parts[p].next[number[row]]++] = static_cast<std::uint32_t>(row);
        });
    }

    double edge() const { return edge_; }
    const std::vector<std::uint32_t>& rows() const { return row_; }

    /// Number of occupied cells.
    std::uint32_t cells() const { return static_cast<std::uint32_t>(cell_.size()); }
    const GridCell& cell(std::uint32_t index) const { return cell_[index]; }
    Vec3 lowestCorner(std::uint32_t cell) const { return Vec3(cell_[cell].x, cell_[cell].y, cell_[cell].z) * edge_; }
    /// Position of the cell's first point in rows(); n for cell == cells().
    std::uint32_t begin(std::uint32_t cell) const { return begin_[cell]; }
    std::span<const std::uint32_t> rowsOf(std::uint32_t cell) const {
        return std::span(row_).subspan(begin_[cell], begin_[cell + 1] - begin_[cell]);
    }

    /// Calls visit(cell) for every occupied cell that overlaps a box, in order.
    template <typename Visit>
    void forCellsIn(const Vec3& low, const Vec3& high, const Visit& visit) const {
        const std::int32_t first = indexOf(low.x), last = indexOf(high.x);
        for (std::int32_t z = indexOf(low.z); z <= indexOf(high.z); ++z)
            for (std::int32_t y = indexOf(low.y); y <= indexOf(high.y); ++y) {
                const std::uint32_t line = lines_.find({z, y, 0});
                if (line == kInvalidIndex) continue;
                const auto end = cell_.begin() + line_begin_[line + 1];
                for (auto at = std::lower_bound(cell_.begin() + line_begin_[line], end, GridCell{z, y, first});
                     at != end && at->x <= last; ++at)
                    visit(static_cast<std::uint32_t>(at - cell_.begin()));
            }
    }
    /// Calls visit(row) for all points of the cells that overlap a box: those in the box and some beside it.
    template <typename Visit>
    void forRowsIn(const Vec3& low, const Vec3& high, const Visit& visit) const {
        forCellsIn(low, high, [&](std::uint32_t cell) {
            for (const std::uint32_t row : rowsOf(cell)) visit(row);
        });
    }

private:
    // A range of consecutive points, counted and then placed by one thread.
    struct Part {
        CellNumbering numbers;
        std::vector<std::uint32_t> count;  // points of each cell
        std::vector<std::uint32_t> next;   // position in row_ at which the cell's next point is written
        GridCell last_cell{};
        std::uint32_t last = kInvalidIndex;

        std::uint32_t add(const GridCell& cell) {
            if (last == kInvalidIndex || cell != last_cell) {
                last = numbers.add(last_cell = cell);
                if (last == count.size()) count.push_back(0);
            }
            ++count[last];
            return last;
        }
    };

    void sortCells(std::vector<Part>& parts);
    std::int32_t indexOf(double coordinate) const {
        const double cells = coordinate / edge_;
        const auto towards_zero = static_cast<std::int32_t>(cells);
        return towards_zero - (cells < towards_zero);
    }

    double edge_;
    std::vector<std::uint32_t> row_, begin_;
    std::vector<GridCell> cell_;
    CellNumbering lines_;                    // lines of cells with the same z and y
    std::vector<std::uint32_t> line_begin_;  // first cell of each line, and one entry past the last
};

/// Calls visit(cell, rows of `around` within reach of the cell's box) for each cell of `points`, in parallel. Every
/// thread calls its own copy of `visit`, which may therefore keep buffers from cell to cell.
template <typename PositionOf, typename Visit>
void forCellsAndNeighbours(double reach, const CellGrid& points, const CellGrid& around,
                           const PositionOf& positionAround, const Visit& visit) {
    parallelRanges(points.cells(), 16, [&](std::size_t first, std::size_t last) {
        Visit own(visit);
        std::vector<std::uint32_t> rows;
        for (auto cell = static_cast<std::uint32_t>(first); cell < last; ++cell) {
            const Vec3 low = points.lowestCorner(cell), high = low + Vec3(points.edge());
            rows.clear();
            around.forRowsIn(low - Vec3(reach), high + Vec3(reach), [&](std::uint32_t row) {
                const Vec3 p = positionAround(row);
                double squared = 0;
                for (int k = 0; k < 3; ++k) {
                    const double outside = std::max({0.0, low[k] - p[k], p[k] - high[k]});
                    squared += outside * outside;
                }
                if (squared < reach * reach) rows.push_back(row);
            });
            own(cell, std::span<const std::uint32_t>(rows));
        }
    });
}

}  // namespace betamesh
