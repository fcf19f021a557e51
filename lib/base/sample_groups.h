// Points in groups of one SIMD register, and the samples near each group: what neighbourhood sums iterate over.

#pragma once

#include "base/cell_grid.h"
#include "base/simd.h"

#include <array>
#include <cstring>
#include <memory>
#include <span>
#include <vector>

namespace betamesh {

/// A sample as sums read it; the first three fields are its position.
template <std::size_t kFields>
using SampleFields = std::array<float, kFields>;

/// Samples given by their indices in an array.
template <std::size_t kFields>
class SampleSubset {
public:
    struct Iterator {
        const SampleFields<kFields>* all;
        const std::uint32_t* index;
        const SampleFields<kFields>& operator*() const { return all[*index]; }
        Iterator& operator++() { return ++index, *this; }
        bool operator!=(const Iterator& other) const { return index != other.index; }
    };

    SampleSubset(const SampleFields<kFields>* all, std::span<const std::uint32_t> indices)
        : all_(all), indices_(indices) {}
    Iterator begin() const { return {all_, indices_.data()}; }
    Iterator end() const { return {all_, indices_.data() + indices_.size()}; }

private:
    const SampleFields<kFields>* all_;
    std::span<const std::uint32_t> indices_;
};

/// A point and its row in the arrays of all points.
struct PointRow {
    Vec3f position;
    std::uint32_t row;
};

/// Up to kLanes nearby points, one per lane. Unused lanes repeat the first point.
struct PointGroup {
    std::size_t size;
    std::uint32_t row[kLanes];
    Lanes position[3];

    /// pointAt(i): the PointRow of point i < points.
    template <typename PointAt>
    PointGroup(std::size_t points, const PointAt& pointAt) : size(points) {
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
            const PointRow point = pointAt(lane < size ? lane : 0);
            row[lane] = point.row;
            for (int k = 0; k < 3; ++k) position[k][lane] = point.position[k];
        }
    }

    struct Vectors {
        Lanes lanes[3];
    };
    /// Vectors of the points, from an array with a row per point.
    Vectors gather(const std::vector<Vec3f>& vectors) const {
        Vectors gathered;
        for (std::size_t lane = 0; lane < kLanes; ++lane)
            for (int k = 0; k < 3; ++k) gathered.lanes[k][lane] = vectors[row[lane]][k];
        return gathered;
    }
};

/// Coordinates of many points, axis by axis.
using Columns = std::array<std::vector<float>, 3>;

/// Writes the ascending indices of all boxes low[i], high[i] nearer than sqrt(squared_distance) to `box` to the front
/// of `near`, which grows as needed, and returns their number. For points low and high are the same.
std::size_t findNear(const Boxf& box, const Columns& low, const Columns& high, float squared_distance,
                     std::vector<std::uint32_t>& near);

Boxf boundsOf(std::span<const PointRow> points);

/// Reorders points so that each run of kLanes points is compact in space, and so is the first half of each run.
void sortIntoGroups(std::span<PointRow> points);

/// Compact groups have fewer samples near them, but sorting points into them takes time.
enum class Grouping { compact, unsorted };

/// Samples in an order that depends only on their positions and rows, searched by groups of points. Positions are kept
/// in single precision, in units of `unit`, relative to a point nearby.
///
/// forGroups() in skin/neighbourhoods.h does the same for points that are grouped once and then moved many times. It
/// accepts or rejects runs of samples instead of single ones: the search is cheaper, which matters for the short sums
/// of the skin, but the sums visit more samples beyond their reach. Used for coherent smoothing and limitVelocities(),
/// it made the whole program take 1.05 to 1.10 times the user time on a frame without a skin (measured), and it adds in
/// another order, so that the last bits of results change.
template <std::size_t kFields>
class SampleCloud {
public:
    /// fieldsOf    row of a sample -> its fields after the position, kFields - 3 floats
    /// cost        O(samples)
    template <typename SampleAt, typename FieldsOf>
    SampleCloud(std::size_t samples, const SampleAt& sampleAt, const FieldsOf& fieldsOf, double reach, double unit)
        : reach_(reach),
          scale_(1 / unit),
          cells_(samples, reach / 1.5, sampleAt),
          field_(std::make_unique_for_overwrite<Fields[]>(samples)) {
        parallelFor(cells_.cells(), 256, [&](std::size_t c) {
            const auto cell = static_cast<std::uint32_t>(c);
            for (std::uint32_t i = cells_.begin(cell); i < cells_.begin(cell + 1); ++i) {
                const std::uint32_t row = cells_.rows()[i];
                const Vec3f position((sampleAt(row) - cells_.lowestCorner(cell)) * scale_);
                const std::array<float, kFields - 3> given = fieldsOf(row);
                for (std::size_t k = 0; k < 3; ++k) field_[i][k] = position[static_cast<int>(k)];
                std::copy(given.begin(), given.end(), field_[i].begin() + 3);
            }
        });
    }

    /// Calls visit(group, samples) on several threads for groups that contain each point once. `samples` contains at
    /// least all samples within reach of any point of the group; if samples beyond a point's reach contribute zero, the
    /// result at a point does not depend on the other points. Positions of points and samples have a common origin
    /// near both.
    ///
    /// cost        O(points + samples near them), plus visit
    template <typename PointAt, typename Visit>
    void forPoints(std::size_t points, const PointAt& pointAt, Grouping grouping, const Visit& visit) const {
        // Cells of points are larger than those of samples: fewer groups are not full. Smaller cells of samples contain
        // fewer samples beyond reach.
        const CellGrid near(points, 1.5 * reach_, pointAt);
        // Slightly more than the reach, so that rounding never excludes a sample within reach.
        const auto square = static_cast<float>(reach_ * scale_ * reach_ * scale_ * (1 + 1e-5));
        parallelRanges(near.cells(), 4, [&](std::size_t first, std::size_t last) {
            std::vector<Fields> candidate;
            Columns position;  // of candidates
            std::vector<std::uint32_t> index;
            std::vector<PointRow> point;
            for (auto cell = static_cast<std::uint32_t>(first); cell < last; ++cell) {
                const Vec3 low = near.lowestCorner(cell), high = low + Vec3(near.edge()), middle = (low + high) / 2;
                candidate.clear();
                cells_.forCellsIn(low - Vec3(reach_), high + Vec3(reach_), [&](std::uint32_t other) {
                    const Vec3f corner((cells_.lowestCorner(other) - middle) * scale_);
                    for (std::uint32_t i = cells_.begin(other); i < cells_.begin(other + 1); ++i) {
                        candidate.push_back(field_[i]);
                        for (std::size_t k = 0; k < 3; ++k) candidate.back()[k] += corner[static_cast<int>(k)];
                    }
                });
                const std::size_t n = candidate.size();
                for (std::size_t k = 0; k < 3; ++k) {
                    position[k].resize(n);
                    for (std::size_t i = 0; i < n; ++i) position[k][i] = candidate[i][k];
                }

                point.clear();
                for (const std::uint32_t row : near.rowsOf(cell))
                    point.push_back({Vec3f((pointAt(row) - middle) * scale_), row});
                if (grouping == Grouping::compact) sortIntoGroups(point);
                for (std::size_t begin = 0; begin < point.size(); begin += kLanes) {
                    const std::span members = std::span(point).subspan(begin, std::min(kLanes, point.size() - begin));
                    const PointGroup group(members.size(), [&](std::size_t i) { return members[i]; });
                    const std::size_t used = findNear(boundsOf(members), position, position, square, index);
                    visit(group, SampleSubset<kFields>(candidate.data(), std::span(index).first(used)));
                }
            }
        });
    }

private:
    using Fields = SampleFields<kFields>;

    double reach_, scale_;
    CellGrid cells_;
    std::unique_ptr<Fields[]> field_;  // in the order of cells; positions relative to the cell's lowest corner
};

}  // namespace betamesh
