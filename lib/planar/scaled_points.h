// Points that each have a scale, the size of the particles there, and searches whose reach is in proportion to scales.

#pragma once

#include "base/cell_grid.h"

#include <span>
#include <vector>

namespace betamesh {

/// Points whose scales are within a factor of two of each other.
struct ScaleClass {
    double largest;                  ///< scale that these may have
    std::vector<std::uint32_t> row;  ///< of the points, ascending
};

/// n points by scale, the largest first; one class of scale 1 if `scale` is empty.
std::vector<ScaleClass> scaleClasses(std::size_t n, std::span<const double> scale);

/// Points to be found from places as far away as is in proportion to the points' own scales.
class ScaledPoints {
public:
    /// in      edge: of the cells for points of scale 1. positionOf(row): position of a point. scale: one per point;
    ///         empty: all 1
    template <typename PositionOf>
    ScaledPoints(std::size_t n, double edge, const PositionOf& positionOf, std::span<const double> scale) {
        for (ScaleClass& points : scaleClasses(n, scale)) {
            CellGrid cells(points.row.size(), edge * points.largest,
                           [&](std::size_t k) { return positionOf(points.row[k]); });
            classes_.push_back({std::move(points), std::move(cells)});
        }
    }

    /// Calls visit(row) for all points within reach · (their scale) + beyond of x in the plane, and for some others.
    template <typename Visit>
    void forNear(const Vec3& x, double reach, double beyond, const Visit& visit) const {
        for (const auto& [points, cells] : classes_) {
            const double within = reach * points.largest + beyond;
            const std::vector<std::uint32_t>& row = points.row;
            cells.forRowsIn(x - Vec3(within, within, 0), x + Vec3(within, within, 0),
                            [&row, &visit](std::uint32_t k) { visit(row[k]); });
        }
    }

private:
    struct Class {
        ScaleClass points;
        CellGrid cells;
    };
    std::vector<Class> classes_;
};

/// Lengths of a search from points of scale 1; those of others are in proportion.
struct ScaledSearch {
    double reach;
    double edge;            ///< of the cells in which searching points are grouped
    double edge_of_others;  ///< of the cells in which the points to be found are sorted
};

/// Calls visit(row, rows of others) for each of n points, in parallel, with all others within reach and some beyond.
///
/// in      scale: one per searching point; empty: all 1
/// cost    O(n + others) for each factor of two between the scales, and the visits
template <typename PositionOf, typename PositionOfOther, typename Visit>
void forScaledNeighbours(const ScaledSearch& search, std::size_t n, const PositionOf& positionOf,
                         std::span<const double> scale, std::size_t others, const PositionOfOther& positionOfOther,
                         const Visit& visit) {
    for (const ScaleClass& points : scaleClasses(n, scale)) {
        const CellGrid cells(points.row.size(), search.edge * points.largest,
                             [&](std::size_t k) { return positionOf(points.row[k]); });
        const CellGrid around(others, search.edge_of_others * points.largest, positionOfOther);
        forCellsAndNeighbours(search.reach * points.largest, cells, around, positionOfOther,
                              [&](std::uint32_t cell, std::span<const std::uint32_t> near) {
                                  for (const std::uint32_t k : cells.rowsOf(cell)) visit(points.row[k], near);
                              });
    }
}

/// The same among n points, in cells whose edge is half the reach.
template <typename PositionOf, typename Visit>
void forScaledNeighbours(double reach, std::size_t n, const PositionOf& positionOf, std::span<const double> scale,
                         const Visit& visit) {
    if (!scale.empty())
        return forScaledNeighbours({reach, reach / 2, reach / 2}, n, positionOf, scale, n, positionOf, visit);
    const CellGrid cells(n, reach / 2, positionOf);
    forCellsAndNeighbours(reach, cells, cells, positionOf,
                          [&](std::uint32_t cell, std::span<const std::uint32_t> near) {
                              for (const std::uint32_t row : cells.rowsOf(cell)) visit(row, near);
                          });
}

}  // namespace betamesh
