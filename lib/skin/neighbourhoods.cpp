
#include "skin/neighbourhoods.h"

namespace betamesh {

namespace {

BETAMESH_EVERY_CPU
void markNear(const float* const (&low)[3], const float* const (&high)[3], std::size_t n, const Vec3f& from,
              const Vec3f& to, float square, std::uint32_t* is_near) {
    for (std::size_t i = 0; i < n; ++i) {
        float sum = 0;
        for (int k = 0; k < 3; ++k) {
            const float under = low[k][i] - to[k], over = from[k] - high[k][i];
            float apart = under > over ? under : over;
            apart = apart > 0 ? apart : 0;
            sum += apart * apart;
        }
        is_near[i] = sum < square ? 1 : 0;
    }
}

}  // namespace

void BoxColumns::findNear(const Boxf& box, float square, std::vector<std::uint32_t>& near) const {
    const std::size_t n = low_[0].size();
    near.resize(n);
    const float* const low[3] = {low_[0].data(), low_[1].data(), low_[2].data()};
    const float* const high[3] = {high_[0].data(), high_[1].data(), high_[2].data()};
    markNear(low, high, n, box.min, box.max, square, near.data());
    std::size_t used = 0;
    for (std::uint32_t i = 0; i < n; ++i) {
        const std::uint32_t is_near = near[i];
        near[used] = i;
        used += is_near;
    }
    near.resize(used);
}

PointGroups::PointGroups(const std::vector<Vec3>& position, double edge, std::vector<std::uint32_t>& order) {
    const CellOrder cells(position.size(), edge, [&](std::size_t i) -> const Vec3& { return position[i]; });
    order = cells.rows();
    std::vector<std::uint32_t> count(cells.cells());
    for (std::uint32_t c = 0; c < cells.cells(); ++c)
        count[c] = static_cast<std::uint32_t>((cells.rowsOf(c).size() + kLanes - 1) / kLanes);
    const std::vector<std::uint32_t> first = exclusiveScan(count);
    begin_.assign(first.back() + 1, static_cast<std::uint32_t>(position.size()));
    box_.resize(first.back());
    std::vector<Vec3> place(first.back());  // of a point of each group
    parallelRanges(cells.cells(), 16, [&](std::size_t from, std::size_t to) {
        std::vector<PlacedRow> points;
        for (auto c = static_cast<std::uint32_t>(from); c < to; ++c) {
            points.clear();
            const Vec3 corner = cells.lowestCorner(c);
            for (const std::uint32_t row : cells.rowsOf(c))
                points.push_back({Vec3f((position[row] - corner) / edge), row});
            groupTogether(points);
            for (std::size_t i = 0; i < points.size(); ++i) {
                order[cells.begin(c) + i] = points[i].row;
                if (i % kLanes != 0) continue;
                begin_[first[c] + i / kLanes] = static_cast<std::uint32_t>(cells.begin(c) + i);
                place[first[c] + i / kLanes] = position[points[i].row];
            }
        }
    });
    cells_.emplace(place.size(), edge, [&](std::size_t g) -> const Vec3& { return place[g]; });
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
    strayed_ = 0;
    for (std::uint32_t c = 0; c < cells(); ++c) {
        const Vec3 low = cells_->lowestCorner(c), high = low + Vec3(cells_->edge());
        for (const std::uint32_t g : groupsOf(c))
            for (int k = 0; k < 3; ++k)
                strayed_ = std::max({strayed_, low[k] - box_[g].min[k], box_[g].max[k] - high[k]});
    }
}

}  // namespace betamesh
