// Points in groups that lie together, and what is near each group: what sums over a neighbourhood go through.

#pragma once

#include "base/box.h"
#include "base/cell_order.h"
#include "base/sample_groups.h"

#include <memory>
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
    Vec3 lowestCorner(std::uint32_t cell) const { return cells_->lowestCorner(cell); }
    /// Calls visit(group, its cell) for all whose boxes are within reach of another box, and a few more, in order.
    template <typename Visit>
    void forGroupsNear(const Box& box, double reach, const Visit& visit) const {
        if (!cells_) return;
        cells_->forCellsIn(box.min - Vec3(reach + strayed_), box.max + Vec3(reach + strayed_), [&](std::uint32_t cell) {
            for (const std::uint32_t group : groupsOf(cell)) visit(group, cell);
        });
    }

private:
    std::vector<std::uint32_t> begin_{0};
    std::vector<Box> box_;
    std::optional<CellOrder> cells_;  // of groups
    double strayed_ = 0;              // how far boxes stick out of their cells
};

/// Values of points in an order, or of some of them.
template <typename Value>
std::vector<Value> inOrder(const std::vector<Value>& values, const std::vector<std::uint32_t>& order) {
    std::vector<Value> sorted(order.size());
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

/// Samples near a group of points, in runs that follow one another in an array.
template <std::size_t kFields>
class SampleRuns {
public:
    struct Run {
        const SampleFields<kFields>*begin, *end;
        Vec3f origin;  // of their positions, in the frame of the points
    };

    explicit SampleRuns(std::span<const Run> runs) : runs_(runs) {}
    /// Calls visit(fields, from) for every sample, where `from` leads from the points to it.
    template <typename Some, typename Visit>
    __attribute__((always_inline)) void forEach(const Some (&point)[3], const Visit& visit) const {
        for (const Run& run : runs_) {
            const Some x = point[0] - run.origin.x, y = point[1] - run.origin.y, z = point[2] - run.origin.z;
            for (const SampleFields<kFields>* f = run.begin; f != run.end; ++f) {
                const Some from[3] = {(*f)[0] - x, (*f)[1] - y, (*f)[2] - z};
                visit(*f, from);
            }
        }
    }

private:
    std::span<const Run> runs_;
};

/// The samples that sums run over, in the order of their groups. Positions are relative to the lowest corner of the
/// group's cell, in units, so that floats are exact enough far from the origin.
template <std::size_t kFields>
class SampleTable {
public:
    /// fill(row, fields) sets a sample's fields after its position.
    template <typename Fill>
    SampleTable(const PointGroups& groups, const std::vector<Vec3>& position, double unit, const Fill& fill)
        : groups_(groups),
          scale_(1 / unit),
          field_(std::make_unique_for_overwrite<SampleFields<kFields>[]>(position.size())),
          box_(groups.size() * kRuns) {
        parallelFor(groups.cells(), 16, [&](std::size_t c) {
            const auto cell = static_cast<std::uint32_t>(c);
            const Vec3 corner = groups.lowestCorner(cell);
            for (const std::uint32_t group : groups.groupsOf(cell))
                for (std::uint32_t i = groups.begin(group), run = 0; i < groups.begin(group + 1); ++run) {
                    Boxf& box = box_[group * kRuns + run];
                    for (const std::uint32_t run_end = endOfRun(group, i); i < run_end; ++i) {
                        const Vec3f place((position[i] - corner) * scale_);
                        box.extendBy(place);
                        for (int k = 0; k < 3; ++k) field_[i][static_cast<std::size_t>(k)] = place[k];
                        fill(i, field_[i]);
                    }
                }
        });
    }

    /// Appends the runs of a group and their bounding boxes; middle: the origin of the positions asked for.
    void addRuns(std::uint32_t group, std::uint32_t cell, const Vec3& middle, BoxColumns& boxes,
                 std::vector<typename SampleRuns<kFields>::Run>& runs) const {
        const Vec3f origin((groups_.lowestCorner(cell) - middle) * scale_);
        for (std::uint32_t i = groups_.begin(group), run = 0; i < groups_.begin(group + 1); ++run) {
            const std::uint32_t run_end = endOfRun(group, i);
            runs.push_back({field_.get() + i, field_.get() + run_end, origin});
            const Boxf& box = box_[group * kRuns + run];
            boxes.add(Boxf(box.min + origin, box.max + origin));
            i = run_end;
        }
    }

private:
    static constexpr std::uint32_t kRun = kLanes / 2;  // samples at most that are accepted or rejected together
    static constexpr std::uint32_t kRuns = kLanes / kRun;  // of a group, at most

    std::uint32_t endOfRun(std::uint32_t group, std::uint32_t begin) const {
        return std::min(groups_.begin(group + 1), begin + kRun);
    }

    const PointGroups& groups_;
    double scale_;
    std::unique_ptr<SampleFields<kFields>[]> field_;
    std::vector<Boxf> box_;  // of runs, kRuns a group; positions as those of samples
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
    using Run = typename SampleRuns<kFields>::Run;
    const SampleTable<kFields> table(samples, sample, unit, fill);
    const double scale = 1 / unit;
    parallelRanges(points.cells(), 4, [&](std::size_t first, std::size_t last) {
        std::vector<Run> candidates, runs;
        std::vector<SampleFields<kFields>> thinned;
        BoxColumns boxes;  // of candidates
        std::vector<std::uint32_t> near;
        for (auto cell = static_cast<std::uint32_t>(first); cell < last; ++cell) {
            Box box;
            double farthest = 0;
            for (const std::uint32_t g : points.groupsOf(cell)) {
                box.extendBy(points.box(g));
                farthest = std::max(farthest, reachOf(g));
            }
            const Vec3 middle = box.center();
            const auto placeOf = [&](const Vec3& p) { return Vec3f((p - middle) * scale); };
            candidates.clear();
            boxes.clear();
            samples.forGroupsNear(box, farthest, [&](std::uint32_t group, std::uint32_t its_cell) {
                if (squaredDistance(box, samples.box(group)) <= farthest * farthest)
                    table.addRuns(group, its_cell, middle, boxes, candidates);
            });
            for (const std::uint32_t g : points.groupsOf(cell)) {
                const double reach = reachOf(g) * scale;
                // A hair more than the reach: what is left out is beyond it however places are rounded.
                boxes.findNear(Boxf(placeOf(points.box(g).min), placeOf(points.box(g).max)),
                               static_cast<float>(reach * reach * (1 + 1e-5)), near);
                runs.clear();
                std::size_t n = 0;
                for (const std::uint32_t i : near) {
                    const Run& run = candidates[i];
                    n += static_cast<std::size_t>(run.end - run.begin);
                    if (!runs.empty() && runs.back().end == run.begin && runs.back().origin == run.origin)
                        runs.back().end = run.end;
                    else
                        runs.push_back(run);
                }
                if (const std::size_t step = (n + most - 1) / most; step > 1) {
                    thinned.clear();
                    std::size_t count = 0;
                    for (const Run& run : runs)
                        for (const SampleFields<kFields>* f = run.begin; f != run.end; ++f) {
                            if (count++ % step != 0) continue;
                            thinned.push_back(*f);
                            for (int k = 0; k < 3; ++k) thinned.back()[static_cast<std::size_t>(k)] += run.origin[k];
                        }
                    runs.assign(1, {thinned.data(), thinned.data() + thinned.size(), Vec3f(0)});
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
