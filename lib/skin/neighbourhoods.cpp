
#include "skin/neighbourhoods.h"

namespace betamesh {

PointGroups::PointGroups(const std::vector<Vec3>& position, double edge, std::vector<std::uint32_t>& order) {
    const CellOrder cells(position.size(), edge, [&](std::size_t i) -> const Vec3& { return position[i]; });
    order = cells.rows();
    std::vector<std::uint32_t> count(cells.cells());
    for (std::uint32_t c = 0; c < cells.cells(); ++c)
        count[c] = static_cast<std::uint32_t>((cells.rowsOf(c).size() + kLanes - 1) / kLanes);
    const std::vector<std::uint32_t> first = exclusiveScan(count);
    begin_.assign(first.back() + 1, static_cast<std::uint32_t>(position.size()));
    box_.resize(first.back());
    std::vector<Vec3> member(first.back());  // the position of one point of each group
    parallelRanges(cells.cells(), 16, [&](std::size_t from, std::size_t to) {
        std::vector<PointRow> points;
        for (auto c = static_cast<std::uint32_t>(from); c < to; ++c) {
            points.clear();
            const Vec3 corner = cells.lowestCorner(c);
            for (const std::uint32_t row : cells.rowsOf(c))
                points.push_back({Vec3f((position[row] - corner) / edge), row});
            sortIntoGroups(points);
            for (std::size_t i = 0; i < points.size(); ++i) {
                order[cells.begin(c) + i] = points[i].row;
                if (i % kLanes != 0) continue;
                begin_[first[c] + i / kLanes] = static_cast<std::uint32_t>(cells.begin(c) + i);
                member[first[c] + i / kLanes] = position[points[i].row];
            }
        }
    });
    cells_.emplace(member.size(), edge, [&](std::size_t g) -> const Vec3& { return member[g]; });
}

void PointGroups::fitBoxes(const std::vector<Vec3>& position) {
    parallelFor(size(), 256, [&](std::size_t g) {
        Vec3 low = position[begin(g)], high = low;
        for (std::uint32_t i = begin(g) + 1; i < begin(g + 1); ++i)
            for (int k = 0; k < 3; ++k) {
                low[k] = std::min(low[k], position[i][k]);
                high[k] = std::max(high[k], position[i][k]);
            }
        box_[g] = Box(low, high);
    });
    overhang_ = 0;
    for (std::uint32_t c = 0; c < cells(); ++c) {
        const Vec3 low = cells_->lowestCorner(c), high = low + Vec3(cells_->edge());
        for (const std::uint32_t g : groupsOf(c))
            for (int k = 0; k < 3; ++k)
                overhang_ = std::max({overhang_, low[k] - box_[g].min[k], box_[g].max[k] - high[k]});
    }
}

}  // namespace betamesh
