#include "skin/vicinity.h"

namespace betamesh {

void fitBoxes(PointGroups& groups, const std::vector<Vec3>& position) {
    parallelFor(groups.size(), 256, [&](std::size_t g) {
        groups.box[g] = Box();
        for (const std::uint32_t row : std::as_const(groups)[g]) groups.box[g].extendBy(position[row]);
    });
}

PointGroups groupsOf(const CellOrder& order, const std::vector<Vec3>& position) {
    PointGroups groups;
    groups.row = order.rows();
    std::vector<std::uint32_t> count(order.cells());
    for (std::uint32_t c = 0; c < order.cells(); ++c)
        count[c] = static_cast<std::uint32_t>((order.rowsOf(c).size() + kLanes - 1) / kLanes);
    const std::vector<std::uint32_t> first = placesOf(count);
    groups.begin.assign(first.back() + 1, static_cast<std::uint32_t>(position.size()));
    groups.box.resize(first.back());
    groups.cell_begin = first;
    parallelRanges(order.cells(), 16, [&](std::size_t from, std::size_t to) {
        std::vector<PlacedRow> points;
        for (auto c = static_cast<std::uint32_t>(from); c < to; ++c) {
            points.clear();
            const Vec3 corner = order.lowestCorner(c);
            for (const std::uint32_t row : order.rowsOf(c))
                points.push_back({Vec3f((position[row] - corner) / order.edge()), row});
            groupTogether(points);
            for (std::size_t i = 0; i < points.size(); ++i) {
                groups.row[order.begin(c) + i] = points[i].row;
                if (i % kLanes == 0) groups.begin[first[c] + i / kLanes] = static_cast<std::uint32_t>(order.begin(c) + i);
            }
        }
    });
    fitBoxes(groups, position);
    return groups;
}

Rows nearGroups(const PointGroups& groups, const CellOrder& samples, const std::vector<Vec3>& position, double reach,
                std::size_t most) {
    constexpr std::size_t kCellsPerTask = 8;
    const std::size_t cells = groups.cell_begin.size() - 1, tasks = (cells + kCellsPerTask - 1) / kCellsPerTask;
    std::vector<std::vector<std::uint32_t>> parts(tasks);
    std::vector<std::uint32_t> count(groups.size());
    // A hair more than the reach: what is left out is beyond it however places are rounded.
    const auto square = static_cast<float>(reach * reach * (1 + 1e-5));
    std::vector<Vec3> sorted(position.size());  // cell by cell: each is looked at several times
    parallelFor(sorted.size(), 8192, [&](std::size_t i) { sorted[i] = position[samples.rows()[i]]; });
    parallelFor(tasks, 1, [&](std::size_t task) {
        std::vector<std::uint32_t>& rows = parts[task];
        std::vector<std::uint32_t> candidate, number;
        std::array<std::vector<float>, 3> place;
        for (std::size_t c = task * kCellsPerTask; c < std::min(cells, (task + 1) * kCellsPerTask); ++c) {
            const std::uint32_t begin = groups.cell_begin[c], end = groups.cell_begin[c + 1];
            Box box;
            for (std::uint32_t g = begin; g < end; ++g) box.extendBy(groups.box[g]);
            const Vec3 middle = box.center();
            candidate.clear();
            for (auto& along : place) along.clear();
            samples.forCellsIn(box.min - Vec3(reach), box.max + Vec3(reach), [&](std::uint32_t cell) {
                const std::uint32_t first = samples.begin(cell), last = samples.begin(cell + 1);
                candidate.insert(candidate.end(), samples.rows().begin() + first, samples.rows().begin() + last);
                for (std::size_t k = 0; k < 3; ++k) {
                    const std::size_t before = place[k].size();
                    place[k].resize(before + last - first);
                    const int axis = static_cast<int>(k);
                    for (std::uint32_t i = first; i < last; ++i)
                        place[k][before + i - first] = static_cast<float>(sorted[i][axis] - middle[axis]);
                }
            });
            number.resize(candidate.size());
            for (std::uint32_t g = begin; g < end; ++g) {
                const Boxf here(Vec3f(groups.box[g].min - middle), Vec3f(groups.box[g].max - middle));
                const std::size_t used = findNear(here, place, square, number);
                const std::size_t step = used > most ? (used + most - 1) / most : 1, kept = (used + step - 1) / step;
                const std::size_t before = rows.size();
                rows.resize(before + kept);
                for (std::size_t i = 0; i < kept; ++i) rows[before + i] = candidate[number[i * step]];
                count[g] = static_cast<std::uint32_t>(kept);
            }
        }
    });
    return {placesOf(count), joined(parts)};
}

}  // namespace betamesh
