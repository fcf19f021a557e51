// Points in compact groups that can be moved, and the samples near each group: what sums over the skin iterate over.

#pragma once

#include "base/box.h"
#include "base/cell_grid.h"
#include "base/octaves.h"
#include "base/sample_groups.h"

#include <memory>
#include <span>
#include <vector>

namespace betamesh {

/// Compact groups of at most kLanes points. The points of group g are begin(g) … begin(g + 1) - 1, once they have been
/// brought into the order that the constructor returns. Points of different octaves of scale are in different groups,
/// so that where the points are far apart groups are wide.
class PointGroups {
public:
    PointGroups() = default;
    /// edge    edge of the cells in which points of scale 1 are grouped, a few times the intended width of groups;
    ///         world units
    /// scale   of each point; empty: all 1
    /// order   set to the required order of the points: order[i] is the row of the i-th
    ///
    /// same    groups for any thread count
    PointGroups(const std::vector<Vec3>& position, double edge, const std::vector<float>& scale,
                std::vector<std::uint32_t>& order);

    std::size_t size() const { return box_.size(); }
    std::uint32_t begin(std::size_t group) const { return begin_[group]; }
    const Box& box(std::size_t group) const { return box_[group]; }
    /// Fits the boxes to the current positions of the points. To be called after construction and after every move.
    void fitBoxes(const std::vector<Vec3>& position);

    std::uint32_t cells() const { return static_cast<std::uint32_t>(corner_.size()); }
    /// The groups of a cell are firstGroup(cell) … firstGroup(cell + 1) - 1.
    std::uint32_t firstGroup(std::uint32_t cell) const { return first_group_[cell]; }
    const Vec3& lowestCorner(std::uint32_t cell) const { return corner_[cell]; }
    /// Calls visit(group, its cell), in order, for all groups whose boxes are within reach of another box, and a few
    /// more. reachOf(largest scale in the group)
    template <typename ReachOf, typename Visit>
    void forGroupsNear(const Box& box, const ReachOf& reachOf, const Visit& visit) const {
        for (const Octave& octave : octaves_) {
            const double reach = reachOf(octave.largest);
            const Vec3 margin(reach + octave.overhang);
            octave.cells.forCellsIn(box.min - margin, box.max + margin, [&](std::uint32_t c) {
                const std::uint32_t cell = octave.first_cell + c;
                for (std::uint32_t group = firstGroup(cell); group < firstGroup(cell + 1); ++group)
                    if (squaredDistance(box, box_[group]) <= reach * reach) visit(group, cell);
            });
        }
    }

private:
    // The cells of points with scales up to `largest`.
    struct Octave {
        double largest;
        std::uint32_t first_cell;
        CellGrid cells;       // of one point of each group
        double overhang = 0;  // largest distance by which a box extends beyond its cell
    };

    void addOctave(double largest, double edge, const std::vector<Vec3>& position,
                   std::span<const std::uint32_t> points, std::vector<std::uint32_t>& order);

    std::vector<std::uint32_t> begin_{0}, first_group_{0};
    std::vector<Box> box_;
    std::vector<Vec3> corner_;  // of each cell
    std::vector<Octave> octaves_;
};

/// Samples near a group of points, as runs of consecutive elements of arrays.
template <std::size_t kFields>
class SampleRuns {
public:
    struct Run {
        const SampleFields<kFields>*begin, *end;
        Vec3f origin;  // of the samples' positions, in the frame of the points
    };

    explicit SampleRuns(std::span<const Run> runs, std::size_t step = 1) : runs_(runs), step_(step) {}
    /// These are every step()-th of the samples.
    std::size_t step() const { return step_; }
    /// Calls visit(fields, offset) for every sample; `offset` is its position relative to each point.
    template <typename Pack, typename Visit>
    __attribute__((always_inline)) void forEach(const Pack (&point)[3], const Visit& visit) const {
        for (const Run& run : runs_) {
            const Pack x = point[0] - run.origin.x, y = point[1] - run.origin.y, z = point[2] - run.origin.z;
            for (const SampleFields<kFields>* f = run.begin; f != run.end; ++f) {
                const Pack offset[3] = {(*f)[0] - x, (*f)[1] - y, (*f)[2] - z};
                visit(*f, offset);
            }
        }
    }

private:
    std::span<const Run> runs_;
    std::size_t step_;
};

/// Sets, for a sample at offset p that faces `direction`, t = (1 - |p|² / width²)₊ and c = (direction · normal)₊ in
/// lanes; normal: of the points. (A vector that is returned depends on the instruction set.)
template <typename Pack>
__attribute__((always_inline)) inline void setFacing(const Pack (&p)[3], const Pack (&normal)[3],
                                                     const float* direction, const Pack& inverse_square_width, Pack& t,
                                                     Pack& c) {
    const Pack zero{};
    t = 1.0F - (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) * inverse_square_width;
    c = direction[0] * normal[0] + direction[1] * normal[1] + direction[2] * normal[2];
    t = t > 0 ? t : zero;
    c = c > 0 ? c : zero;
}

/// Bounding boxes of runs, axis by axis, and the largest reach factor of each run, if there are any.
struct BoxColumns {
    Columns low, high;
    std::vector<float> reach_factor;

    void clear() {
        reach_factor.clear();
        for (auto& column : low) column.clear();
        for (auto& column : high) column.clear();
    }
    void add(const Boxf& box) {
        for (std::size_t k = 0; k < 3; ++k) {
            low[k].push_back(box.min[static_cast<int>(k)]);
            high[k].push_back(box.max[static_cast<int>(k)]);
        }
    }
    float squaredDistance(std::uint32_t run, const Boxf& box) const {
        float sum = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const int axis = static_cast<int>(k);
            const float gap = std::max({0.0F, low[k][run] - box.max[axis], box.min[axis] - high[k][run]});
            sum += gap * gap;
        }
        return sum;
    }
};

/// The samples of sums, in the order of their groups, which are referenced and must outlive the table. Positions are
/// relative to the lowest corner of the group's cell and in units, so that single precision suffices far from the
/// origin.
template <std::size_t kFields>
class SampleTable {
public:
    /// fill(row, fields) sets a sample's fields after its position.
    /// reach_factor: of each sample, which is visited within this times the reach of a group of points; the scales by
    /// which the samples were grouped, or empty: all 1
    template <typename Fill>
    SampleTable(const PointGroups& groups, const std::vector<Vec3>& position, double unit, const Fill& fill,
                const std::vector<float>& reach_factor = {})
        : groups_(groups),
          unit_(unit),
          scale_(1 / unit),
          field_(std::make_unique_for_overwrite<SampleFields<kFields>[]>(position.size())),
          box_(groups.size() * kRuns),
          reach_factor_(reach_factor.empty() ? 0 : box_.size()) {
        parallelFor(groups.cells(), 16, [&](std::size_t c) {
            const auto cell = static_cast<std::uint32_t>(c);
            const Vec3 corner = groups.lowestCorner(cell);
            for (std::uint32_t group = groups.firstGroup(cell); group < groups.firstGroup(cell + 1); ++group)
                for (std::uint32_t i = groups.begin(group), run = 0; i < groups.begin(group + 1); ++run) {
                    Boxf& box = box_[group * kRuns + run];
                    for (const std::uint32_t run_end = endOfRun(group, i); i < run_end; ++i) {
                        if (!reach_factor.empty()) {
                            float& largest = reach_factor_[group * kRuns + run];
                            largest = std::max(largest, reach_factor[i]);
                        }
                        const Vec3f local((position[i] - corner) * scale_);
                        box.extendBy(local);
                        for (int k = 0; k < 3; ++k) field_[i][static_cast<std::size_t>(k)] = local[k];
                        fill(i, field_[i]);
                    }
                }
        });
    }

    const PointGroups& groups() const { return groups_; }
    double unit() const { return unit_; }  ///< world units
    bool haveReachFactors() const { return !reach_factor_.empty(); }

    /// Appends the runs of a group and their bounding boxes, relative to `frame`, world units.
    void addRuns(std::uint32_t group, std::uint32_t cell, const Vec3& frame, BoxColumns& boxes,
                 std::vector<typename SampleRuns<kFields>::Run>& runs) const {
        const Vec3f origin((groups_.lowestCorner(cell) - frame) * scale_);
        for (std::uint32_t i = groups_.begin(group), run = 0; i < groups_.begin(group + 1); ++run) {
            const std::uint32_t run_end = endOfRun(group, i);
            runs.push_back({field_.get() + i, field_.get() + run_end, origin});
            const Boxf& box = box_[group * kRuns + run];
            boxes.add(Boxf(box.min + origin, box.max + origin));
            if (!reach_factor_.empty()) boxes.reach_factor.push_back(reach_factor_[group * kRuns + run]);
            i = run_end;
        }
    }

private:
    static constexpr std::uint32_t kRun = kLanes / 2;      // most samples that are accepted or rejected together
    static constexpr std::uint32_t kRuns = kLanes / kRun;  // most runs of a group

    std::uint32_t endOfRun(std::uint32_t group, std::uint32_t begin) const {
        return std::min(groups_.begin(group + 1), begin + kRun);
    }

    const PointGroups& groups_;
    double unit_, scale_;
    std::unique_ptr<SampleFields<kFields>[]> field_;
    std::vector<Boxf> box_;            // of runs, kRuns per group, in the coordinates of the samples
    std::vector<float> reach_factor_;  // the largest of each run; empty: all 1
};

/// The chosen runs, in which those that follow one another are joined. Returns how many samples they have.
template <std::size_t kFields>
std::size_t joinRuns(const std::vector<typename SampleRuns<kFields>::Run>& all, std::span<const std::uint32_t> chosen,
                     std::vector<typename SampleRuns<kFields>::Run>& runs) {
    runs.clear();
    std::size_t samples = 0;
    for (const std::uint32_t i : chosen) {
        const auto& run = all[i];
        samples += static_cast<std::size_t>(run.end - run.begin);
        if (!runs.empty() && runs.back().end == run.begin && runs.back().origin == run.origin)
            runs.back().end = run.end;
        else
            runs.push_back(run);
    }
    return samples;
}

/// Replaces runs by one run of every step-th of their samples, which `kept` holds.
template <std::size_t kFields>
void keepEvery(std::size_t step, std::vector<typename SampleRuns<kFields>::Run>& runs,
               std::vector<SampleFields<kFields>>& kept) {
    kept.clear();
    std::size_t count = 0;
    for (const auto& run : runs)
        for (const SampleFields<kFields>* f = run.begin; f != run.end; ++f) {
            if (count++ % step != 0) continue;
            kept.push_back(*f);
            for (int k = 0; k < 3; ++k) kept.back()[static_cast<std::size_t>(k)] += run.origin[k];
        }
    runs.assign(1, {kept.data(), kept.data() + kept.size(), Vec3f(0)});
}

/// Calls visit(PointGroup, SampleRuns) for every group of points on several threads. The samples contain at least all
/// those within reachOf(group) of each of its points, in an order that does not depend on the groups: if samples beyond
/// a point's own reach contribute zero, its sums depend on the samples alone. Positions of points and samples are in
/// units and have a common origin near the group.
///
/// max_samples  largest number of samples per group: of more, every second (third, …) one is visited
/// reachOf      of a group of points, world units; groups for which it is negative are left out
template <std::size_t kFields, typename ReachOf, typename Visit>
void forGroups(const PointGroups& points, const std::vector<Vec3>& point, const SampleTable<kFields>& samples,
               std::size_t max_samples, const ReachOf& reachOf, const Visit& visit) {
    using Run = typename SampleRuns<kFields>::Run;
    const double scale = 1 / samples.unit();
    parallelRanges(points.cells(), 4, [&](std::size_t first, std::size_t last) {
        std::vector<Run> candidates, runs;
        std::vector<SampleFields<kFields>> thinned;
        BoxColumns boxes;  // of candidates
        std::vector<std::uint32_t> near;
        for (auto cell = static_cast<std::uint32_t>(first); cell < last; ++cell) {
            Box box;
            double largest_reach = -1;
            const std::uint32_t first_group = points.firstGroup(cell), end_group = points.firstGroup(cell + 1);
            for (std::uint32_t g = first_group; g < end_group; ++g) {
                const double reach = reachOf(g);
                if (reach < 0) continue;
                box.extendBy(points.box(g));
                largest_reach = std::max(largest_reach, reach);
            }
            if (largest_reach < 0) continue;
            const Vec3 frame = box.center();
            const auto localOf = [&](const Vec3& p) { return Vec3f((p - frame) * scale); };
            candidates.clear();
            boxes.clear();
            samples.groups().forGroupsNear(
                box, [&](double factor) { return samples.haveReachFactors() ? largest_reach * factor : largest_reach; },
                [&](std::uint32_t group, std::uint32_t its_cell) {
                    samples.addRuns(group, its_cell, frame, boxes, candidates);
                });
            for (std::uint32_t g = first_group; g < end_group; ++g) {
                const double reach = reachOf(g) * scale;
                if (reach < 0) continue;
                // Slightly more than the reach, so that rounding never excludes a sample within reach.
                const auto squared_reach = static_cast<float>(reach * reach * (1 + 1e-5));
                const Boxf local(localOf(points.box(g).min), localOf(points.box(g).max));
                std::size_t found = findNear(local, boxes.low, boxes.high, squared_reach, near);
                if (!boxes.reach_factor.empty()) {
                    const auto isTooFar = [&](std::uint32_t run) {
                        const float factor = boxes.reach_factor[run];
                        return boxes.squaredDistance(run, local) > squared_reach * factor * factor;
                    };
                    const auto end = near.begin() + static_cast<std::ptrdiff_t>(found);
                    found = static_cast<std::size_t>(std::remove_if(near.begin(), end, isTooFar) - near.begin());
                }
                const std::size_t n = joinRuns<kFields>(candidates, std::span(near).first(found), runs);
                const std::size_t step = std::max<std::size_t>((n + max_samples - 1) / max_samples, 1);
                if (step > 1) keepEvery<kFields>(step, runs, thinned);
                const std::uint32_t begin = points.begin(g);
                visit(PointGroup(points.begin(g + 1) - begin,
                                 [&](std::size_t i) {
                                     const std::uint32_t row = begin + static_cast<std::uint32_t>(i);
                                     return PointRow{localOf(point[row]), row};
                                 }),
                      SampleRuns<kFields>(runs, step));
            }
        }
    });
}

}  // namespace betamesh
