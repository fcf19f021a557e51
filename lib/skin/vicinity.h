// Points in groups that lie together, and what is near each group: what sums over a neighbourhood go through.

#pragma once

#include "core/cell_order.h"
#include "core/graph.h"
#include "core/sample_groups.h"

#include <array>
#include <span>
#include <vector>

namespace betamesh {

/// Points sorted into groups of kLanes or fewer that lie together.
struct PointGroups {
    std::vector<std::uint32_t> row;       ///< of the points, group by group
    std::vector<std::uint32_t> begin{0};  ///< the first of each group, and one past the last
    std::vector<Box> box;                 ///< of each group
    std::vector<std::uint32_t> cell_begin{0};  ///< the first group of each cell, and one past the last

    std::size_t size() const { return box.size(); }
    std::span<const std::uint32_t> operator[](std::size_t group) const {
        return std::span(row).subspan(begin[group], begin[group + 1] - begin[group]);
    }
};

/// Boxes of the groups' points where these are now.
void fitBoxes(PointGroups& groups, const std::vector<Vec3>& position);

/// order: of the points, in cells a few times as wide as groups are to be.
PointGroups groupsOf(const CellOrder& order, const std::vector<Vec3>& position);

/// The rows of samples within reach of the box of each group, in an order that does not depend on the groups: what lies
/// out of a point's own reach has to count for nothing in sums, and their results then depend on nothing but the
/// samples.
///
/// most    so many at most for each group: of more, every second or third … stands for all
Rows nearGroups(const PointGroups& groups, const CellOrder& samples, const std::vector<Vec3>& position, double reach,
                std::size_t most = ~std::size_t{0});

/// The points of a group, a lane each, from a place near them. Lanes without a point of their own repeat the first.
struct GroupLanes {
    std::size_t size;
    std::uint32_t row[kLanes];
    Lanes place[3];

    /// Vectors of the points, a lane each.
    struct Vectors {
        Lanes lanes[3];
    };
    Vectors of(const std::vector<Vec3f>& vectors) const {
        Vectors some;
        for (std::size_t lane = 0; lane < kLanes; ++lane)
            for (int k = 0; k < 3; ++k) some.lanes[k][lane] = vectors[row[lane]][k];
        return some;
    }
};

/// Calls visit(GroupLanes, samples near) for every group on several threads; fill(row, fields) sets a sample's fields
/// after its position. Places and positions of samples count from the middle of the group, in units.
template <std::size_t kFields, typename Fill, typename Visit>
void forGroups(const PointGroups& groups, const std::vector<Vec3>& point, const Rows& near,
               const std::vector<Vec3>& sample, double unit, const Fill& fill, const Visit& visit) {
    const double scale = 1 / unit;
    parallelRanges(groups.size(), 16, [&](std::size_t first, std::size_t last) {
        std::vector<SampleFields<kFields>> fields;
        for (std::size_t g = first; g < last; ++g) {
            const std::span<const std::uint32_t> rows = near[g], points = groups[g];
            const Vec3 middle = groups.box[g].center();
            if (fields.size() < rows.size()) fields.resize(rows.size());
            for (std::size_t i = 0; i < rows.size(); ++i) {
                const Vec3 place = (sample[rows[i]] - middle) * scale;
                SampleFields<kFields>& f = fields[i];
                for (std::size_t k = 0; k < 3; ++k) f[k] = static_cast<float>(place[static_cast<int>(k)]);
                fill(rows[i], f);
            }
            GroupLanes lanes;
            lanes.size = points.size();
            for (std::size_t lane = 0; lane < kLanes; ++lane) {
                lanes.row[lane] = points[lane < lanes.size ? lane : 0];
                const Vec3 place = (point[lanes.row[lane]] - middle) * scale;
                for (int k = 0; k < 3; ++k) lanes.place[k][lane] = static_cast<float>(place[k]);
            }
            visit(lanes, std::span<const SampleFields<kFields>>(fields).first(rows.size()));
        }
    });
}

}  // namespace betamesh
