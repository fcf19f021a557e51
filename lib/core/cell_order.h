// Points sorted into cells, to find those near a place.

#pragma once

#include "core/parallel.h"
#include "core/vec3.h"

#include <algorithm>
#include <cmath>
#include <compare>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace betamesh {

/// Row numbers of n points, in an order that depends on nothing but where the points are and on their numbers.
/// Coordinates divided by the edge of a cell have to stay below 2^31.
class CellOrder {
public:
    struct Entry {
        std::int32_t z, y, x;
        std::uint32_t row;
        friend auto operator<=>(const Entry&, const Entry&) = default;
    };

    /// same    order for any thread count
    /// cost    O(n log n)
    template <typename PositionOf>
    CellOrder(std::size_t n, double edge, const PositionOf& positionOf) : edge_(edge), entry_(n) {
        parallelFor(n, 4096, [&](std::size_t row) {
            const Vec3 p = positionOf(row);
            entry_[row] = {indexOf(p.z), indexOf(p.y), indexOf(p.x), static_cast<std::uint32_t>(row)};
        });
        parallelSort(entry_, std::less<>());
        for (std::uint32_t i = 0; i < n; ++i)
            if (i == 0 || !sameCell(entry_[i], entry_[i - 1])) begin_.push_back(i);
        begin_.push_back(static_cast<std::uint32_t>(n));
    }

    double edge() const { return edge_; }
    const std::vector<Entry>& entries() const { return entry_; }
    /// The first entry of each cell that has points, and one entry past the last.
    const std::vector<std::uint32_t>& cells() const { return begin_; }
    Vec3 lowestCorner(const Entry& entry) const { return Vec3(entry.x, entry.y, entry.z) * edge_; }

    /// Calls visit(first entry, one past the last) for every cell that meets a box, in order.
    template <typename Visit>
    void forCellsIn(const Vec3& low, const Vec3& high, const Visit& visit) const {
        const std::int32_t first = indexOf(low.x), last = indexOf(high.x);
        for (std::int32_t z = indexOf(low.z); z <= indexOf(high.z); ++z)
            for (std::int32_t y = indexOf(low.y); y <= indexOf(high.y); ++y) {
                auto cell = std::lower_bound(begin_.begin(), begin_.end() - 1, Entry{z, y, first, 0},
                                             [&](std::uint32_t i, const Entry& wanted) { return entry_[i] < wanted; });
                for (; cell != begin_.end() - 1; ++cell) {
                    const Entry& at = entry_[*cell];
                    if (at.z != z || at.y != y || at.x > last) break;
                    visit(*cell, *(cell + 1));
                }
            }
    }
    /// Calls visit(row) for all points in them.
    template <typename Visit>
    void forRowsIn(const Vec3& low, const Vec3& high, const Visit& visit) const {
        forCellsIn(low, high, [&](std::uint32_t begin, std::uint32_t end) {
            for (std::uint32_t i = begin; i < end; ++i) visit(entry_[i].row);
        });
    }

private:
    static bool sameCell(const Entry& a, const Entry& b) { return a.z == b.z && a.y == b.y && a.x == b.x; }
    std::int32_t indexOf(double coordinate) const { return static_cast<std::int32_t>(std::floor(coordinate / edge_)); }

    double edge_;
    std::vector<Entry> entry_;
    std::vector<std::uint32_t> begin_;
};

/// Goes through points cell by cell: calls visit(entries of the cell, rows of `around` within reach of its box) for
/// each, on several threads.
template <typename PositionOf, typename Visit>
void forCellsWithin(double reach, const CellOrder& points, const CellOrder& around, const PositionOf& positionAround,
                    const Visit& visit) {
    parallelRanges(points.cells().size() - 1, 16, [&](std::size_t first, std::size_t last) {
        std::vector<std::uint32_t> rows;
        for (std::size_t g = first; g < last; ++g) {
            const auto cell =
                std::span(points.entries()).subspan(points.cells()[g], points.cells()[g + 1] - points.cells()[g]);
            const Vec3 low = points.lowestCorner(cell[0]), high = low + Vec3(points.edge());
            rows.clear();
            around.forRowsIn(low - Vec3(reach), high + Vec3(reach), [&](std::uint32_t row) {
                const Vec3 p = positionAround(row);
                double beyond = 0;
                for (int k = 0; k < 3; ++k) {
                    const double out = std::max({0.0, low[k] - p[k], p[k] - high[k]});
                    beyond += out * out;
                }
                if (beyond < reach * reach) rows.push_back(row);
            });
            visit(cell, std::span<const std::uint32_t>(rows));
        }
    });
}

}  // namespace betamesh
