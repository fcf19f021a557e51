
#include "skin/neighbourhoods.h"

namespace betamesh {

PointGroups::PointGroups(const std::vector<Vec3>& position, double edge, const std::vector<float>& scale,
                         std::vector<std::uint32_t>& order) {
    order.clear();
    const auto points_of = byOctave(allRows(position.size()), scale);
    for (std::size_t octave = 0; octave < points_of.size(); ++octave)
        if (!points_of[octave].empty())
            addOctave(largestOfOctave(octave), edge * largestOfOctave(octave), position, points_of[octave], order);
    box_.resize(begin_.size() - 1);
}

void PointGroups::addOctave(double largest, double edge, const std::vector<Vec3>& position,
                            std::span<const std::uint32_t> points, std::vector<std::uint32_t>& order) {
    const CellGrid cells(points.size(), edge, [&](std::size_t i) -> const Vec3& { return position[points[i]]; });
    const auto first_cell = this->cells(), first_group = first_group_.back(),
               first_point = static_cast<std::uint32_t>(order.size());
    for (std::uint32_t c = 0; c < cells.cells(); ++c) {
        const std::size_t groups = (cells.rowsOf(c).size() + kLanes - 1) / kLanes;
        first_group_.push_back(first_group_.back() + static_cast<std::uint32_t>(groups));
        corner_.push_back(cells.lowestCorner(c));
    }
    order.resize(first_point + points.size());
    begin_.resize(first_group_.back() + 1, static_cast<std::uint32_t>(order.size()));
    std::vector<Vec3> member(first_group_.back() - first_group);  // the position of one point of each group
    parallelRanges(cells.cells(), 16, [&](std::size_t from, std::size_t to) {
        std::vector<PointRow> in_cell;
        for (auto c = static_cast<std::uint32_t>(from); c < to; ++c) {
            in_cell.clear();
            for (const std::uint32_t i : cells.rowsOf(c))
                in_cell.push_back({Vec3f((position[points[i]] - cells.lowestCorner(c)) / edge), points[i]});
            sortIntoGroups(in_cell);
            for (std::uint32_t i = 0; i < in_cell.size(); ++i) {
                const std::uint32_t at = first_point + cells.begin(c) + i;
                order[at] = in_cell[i].row;
                if (i % kLanes != 0) continue;
                const std::uint32_t group = firstGroup(first_cell + c) + i / static_cast<std::uint32_t>(kLanes);
                begin_[group] = at;
                member[group - first_group] = position[in_cell[i].row];
            }
        }
    });
    begin_.back() = static_cast<std::uint32_t>(order.size());
    octaves_.push_back(
        {largest, first_cell, CellGrid(member.size(), edge, [&](std::size_t g) -> const Vec3& { return member[g]; })});
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
    for (Octave& octave : octaves_) {
        octave.overhang = 0;
        for (std::uint32_t c = 0; c < octave.cells.cells(); ++c) {
            const Vec3 low = lowestCorner(octave.first_cell + c), high = low + Vec3(octave.cells.edge());
            for (std::uint32_t g = firstGroup(octave.first_cell + c); g < firstGroup(octave.first_cell + c + 1); ++g)
                for (int k = 0; k < 3; ++k)
                    octave.overhang = std::max({octave.overhang, low[k] - box_[g].min[k], box_[g].max[k] - high[k]});
        }
    }
}

}  // namespace betamesh
