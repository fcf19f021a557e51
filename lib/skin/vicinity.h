// Points in groups that lie together, and what is near each group: what sums over a neighbourhood go through.

#pragma once

#include "core/box.h"
#include "core/cell_order.h"
#include "core/sample_groups.h"

#include <optional>
#include <span>
#include <vector>

namespace betamesh {

/// Groups of kLanes or fewer points that lie together, in space and in their arrays: group g has the points
/// begin(g) … begin(g + 1) - 1.
class PointGroups {
public:
    PointGroups() = default;
    /// edge    of the cells in which points are grouped: a few times as wide as groups are to be
    /// order   set to the order into which the points have to be brought: the rows as they were
    ///
    /// same    groups for any thread count
    PointGroups(const std::vector<Vec3>& position, double edge, std::vector<std::uint32_t>& order);

    std::size_t size() const { return box_.size(); }
    std::uint32_t begin(std::size_t group) const { return begin_[group]; }
    const Box& box(std::size_t group) const { return box_[group]; }
    /// Fits boxes to the points where these are now.
    void fitBoxes(const std::vector<Vec3>& position);

    std::uint32_t cells() const { return cells_ ? cells_->cells() : 0; }
    /// The groups of a cell, which follow one another.
    std::span<const std::uint32_t> groupsOf(std::uint32_t cell) const { return cells_->rowsOf(cell); }
    /// Calls visit(group) for all whose boxes are within reach of another box, and a few more, in order.
    template <typename Visit>
    void forGroupsNear(const Box& box, double reach, const Visit& visit) const {
        if (cells_) cells_->forRowsIn(box.min - Vec3(reach + strayed_), box.max + Vec3(reach + strayed_), visit);
    }

private:
    std::vector<std::uint32_t> begin_{0};
    std::vector<Box> box_;
    std::optional<CellOrder> cells_;  // of groups
    double strayed_ = 0;              // how far boxes stick out of their cells
};

/// Brings values of points into an order.
template <typename Value>
std::vector<Value> inOrder(const std::vector<Value>& values, const std::vector<std::uint32_t>& order) {
    std::vector<Value> sorted(values.size());
    parallelFor(sorted.size(), 8192, [&](std::size_t i) { sorted[i] = values[order[i]]; });
    return sorted;
}

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

/// Boxes, coordinate by coordinate.
class BoxColumns {
public:
    void clear() {
        for (auto& column : low_) column.clear();
        for (auto& column : high_) column.clear();
    }
    void add(const Boxf& box) {
        for (int k = 0; k < 3; ++k) {
            low_[k].push_back(box.min[k]);
            high_[k].push_back(box.max[k]);
        }
    }
    /// Sets `near` to the numbers of those less than sqrt(square) away from a box, in order.
    void findNear(const Boxf& box, float square, std::vector<std::uint32_t>& near) const;

private:
    std::vector<float> low_[3], high_[3];
};

/// Samples in runs that follow one another in an array.
template <std::size_t kFields>
class SampleRuns {
public:
    struct Run {
        const SampleFields<kFields>*begin, *end;  // not empty
    };
    struct Iterator {
        const SampleFields<kFields>*at, *end;
        const Run *run, *last;
        const SampleFields<kFields>& operator*() const { return *at; }
        Iterator& operator++() {
            if (++at == end && ++run != last) at = run->begin, end = run->end;
            return *this;
        }
        bool operator!=(const Iterator& other) const { return run != other.run; }
    };

    explicit SampleRuns(std::span<const Run> runs) : runs_(runs) {}
    Iterator begin() const {
        const Run *first = runs_.data(), *last = first + runs_.size();
        return runs_.empty() ? end() : Iterator{first->begin, first->end, first, last};
    }
    Iterator end() const {
        const Run* last = runs_.data() + runs_.size();
        return {nullptr, nullptr, last, last};
    }

private:
    std::span<const Run> runs_;
};

/// Calls visit(GroupLanes, SampleRuns) for every group of points on several threads, where the samples are at least all
/// those within reachOf(group) of each of its points, in an order that does not depend on the groups: what lies out of
/// a point's own reach has to count for nothing in sums, and their results then depend on nothing but the samples.
/// fill(row, fields) sets a sample's fields after its position. Places and positions of samples count from a place near
/// the group, in units.
///
/// most    so many samples at most for each group: of more, every second or third … stands for all
template <std::size_t kFields, typename ReachOf, typename Fill, typename Visit>
void forGroups(const PointGroups& points, const std::vector<Vec3>& point, const PointGroups& samples,
               const std::vector<Vec3>& sample, double unit, std::size_t most, const ReachOf& reachOf, const Fill& fill,
               const Visit& visit) {
    using Fields = SampleFields<kFields>;
    constexpr std::uint32_t kRun = kLanes / 2;
    const double scale = 1 / unit;
    parallelRanges(points.cells(), 4, [&](std::size_t first, std::size_t last) {
        std::vector<Fields> candidate, thinned;
        std::vector<std::uint32_t> begin, near;  // of runs of candidates: their first one; those within reach
        BoxColumns boxes;                        // theirs
        std::vector<typename SampleRuns<kFields>::Run> runs;
        for (auto cell = static_cast<std::uint32_t>(first); cell < last; ++cell) {
            Box box;
            double farthest = 0;
            for (const std::uint32_t g : points.groupsOf(cell)) {
                box.extendBy(points.box(g));
                farthest = std::max(farthest, reachOf(g));
            }
            const Vec3 middle = box.center();
            const auto placeOf = [&](const Vec3& p) { return Vec3f((p - middle) * scale); };
            near.clear();
            samples.forGroupsNear(box, farthest, [&](std::uint32_t other) {
                if (squaredDistance(box, samples.box(other)) <= farthest * farthest) near.push_back(other);
            });
            if (candidate.size() < near.size() * kLanes) candidate.resize(near.size() * kLanes);
            begin.clear();
            boxes.clear();
            std::uint32_t filled = 0;
            for (const std::uint32_t other : near)
                for (std::uint32_t i = samples.begin(other), end = samples.begin(other + 1); i < end;) {
                    Vec3f low = placeOf(sample[i]), high = low;
                    begin.push_back(filled);
                    for (const std::uint32_t run_end = std::min(end, i + kRun); i < run_end; ++i, ++filled) {
                        const Vec3f at = placeOf(sample[i]);
                        for (int k = 0; k < 3; ++k) {
                            candidate[filled][static_cast<std::size_t>(k)] = at[k];
                            low[k] = std::min(low[k], at[k]);
                            high[k] = std::max(high[k], at[k]);
                        }
                        fill(i, candidate[filled]);
                    }
                    boxes.add(Boxf(low, high));
                }
            begin.push_back(filled);
            for (const std::uint32_t g : points.groupsOf(cell)) {
                const double reach = reachOf(g) * scale;
                // A hair more than the reach: what is left out is beyond it however places are rounded.
                boxes.findNear(Boxf(placeOf(points.box(g).min), placeOf(points.box(g).max)),
                               static_cast<float>(reach * reach * (1 + 1e-5)), near);
                runs.clear();
                std::size_t n = 0;
                for (const std::uint32_t i : near) {
                    const Fields *from = candidate.data() + begin[i], *to = candidate.data() + begin[i + 1];
                    n += begin[i + 1] - begin[i];
                    if (!runs.empty() && runs.back().end == from)
                        runs.back().end = to;
                    else
                        runs.push_back({from, to});
                }
                if (const std::size_t step = (n + most - 1) / most; step > 1) {
                    thinned.clear();
                    std::size_t count = 0;
                    for (const Fields& f : SampleRuns<kFields>(runs))
                        if (count++ % step == 0) thinned.push_back(f);
                    runs.assign(1, {thinned.data(), thinned.data() + thinned.size()});
                }
                GroupLanes lanes;
                lanes.size = points.begin(g + 1) - points.begin(g);
                for (std::size_t lane = 0; lane < kLanes; ++lane) {
                    lanes.row[lane] = points.begin(g) + static_cast<std::uint32_t>(lane < lanes.size ? lane : 0);
                    const Vec3f at = placeOf(point[lanes.row[lane]]);
                    for (int k = 0; k < 3; ++k) lanes.place[k][lane] = at[k];
                }
                visit(lanes, SampleRuns<kFields>(runs));
            }
        }
    });
}

}  // namespace betamesh
