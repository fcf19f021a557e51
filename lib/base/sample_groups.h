// Points, sixteen at a time, and the samples near them: what sums over a neighbourhood go through.

#pragma once

#include "base/cell_order.h"
#include "base/simd.h"

#include <array>
#include <cstring>
#include <memory>
#include <span>
#include <vector>

namespace betamesh {

/// A sample as sums take it; the first three fields are its position.
template <std::size_t kFields>
using SampleFields = std::array<float, kFields>;

/// Some of many samples.
template <std::size_t kFields>
class SomeSamples {
public:
    struct Iterator {
        const SampleFields<kFields>* all;
        const std::uint32_t* number;
        const SampleFields<kFields>& operator*() const { return all[*number]; }
        Iterator& operator++() { return ++number, *this; }
        bool operator!=(const Iterator& other) const { return number != other.number; }
    };

    SomeSamples(const SampleFields<kFields>* all, std::span<const std::uint32_t> numbers)
        : all_(all), numbers_(numbers) {}
    Iterator begin() const { return {all_, numbers_.data()}; }
    Iterator end() const { return {all_, numbers_.data() + numbers_.size()}; }

private:
    const SampleFields<kFields>* all_;
    std::span<const std::uint32_t> numbers_;
};

/// A point of many: its row and where it is.
struct PlacedRow {
    Vec3f place;
    std::uint32_t row;
};

/// Points that lie together, a lane each. Lanes without a point of their own repeat the first.
struct PointGroup {
    std::size_t size;
    std::uint32_t row[kLanes];
    Lanes place[3];

    explicit PointGroup(std::span<const PlacedRow> points) : size(points.size()) {
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
            const PlacedRow& point = points[lane < size ? lane : 0];
            row[lane] = point.row;
            for (int k = 0; k < 3; ++k) place[k][lane] = point.place[k];
        }
    }
};

/// The numbers of those places that are less than sqrt(square) away from the box, in order, at the front of `near`,
/// which has room for all; returns how many.
std::size_t findNear(const Boxf& box, const std::array<std::vector<float>, 3>& places, float square,
                     std::vector<std::uint32_t>& near);

Boxf boxOf(std::span<const PlacedRow> points);

/// Reorders points so that the first kLanes, the next, and so on lie together, and of these the first half, too.
void groupTogether(std::span<PlacedRow> points);

/// How near each other the points of a group are: groups that lie closely have fewer samples near them, but it takes
/// time to find them.
enum class Grouping { close, coarse };

/// Samples in an order that depends on nothing but their places and rows, to be gone through near points. Their
/// positions, from a place near them and in units of `unit`, are exact enough as floats.
template <std::size_t kFields>
class SampleCloud {
public:
    /// fieldsOf    sample's row -> its fields after the position, kFields - 3 floats
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
                const Vec3f place((sampleAt(row) - cells_.lowestCorner(cell)) * scale_);
                const std::array<float, kFields - 3> given = fieldsOf(row);
                for (std::size_t k = 0; k < 3; ++k) field_[i][k] = place[static_cast<int>(k)];
                std::copy(given.begin(), given.end(), field_[i].begin() + 3);
            }
        });
    }

    /// Calls visit(group, samples) on several threads, each point in one group, where the samples are at least all
    /// those within reach of it: what becomes of a point does not depend on other points, if samples out of its reach
    /// count for nothing. Places and positions of samples count from one place near both.
    ///
    /// cost        O(points + samples near them), and what visit does
    template <typename PointAt, typename Visit>
    void forPoints(std::size_t points, const PointAt& pointAt, Grouping grouping, const Visit& visit) const {
        // Of each cell's groups one is not full: few cells. Those of samples are smaller, for fewer beyond reach.
        const CellOrder near(points, 1.5 * reach_, pointAt);
        // A hair more than the reach: what is left out is beyond it however sums round.
        const auto square = static_cast<float>(reach_ * scale_ * reach_ * scale_ * (1 + 1e-5));
        parallelRanges(near.cells(), 4, [&](std::size_t first, std::size_t last) {
            std::vector<Fields> candidate;
            std::array<std::vector<float>, 3> place;  // of candidates
            std::vector<std::uint32_t> number;
            std::vector<PlacedRow> point;
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
                    place[k].resize(n);
                    for (std::size_t i = 0; i < n; ++i) place[k][i] = candidate[i][k];
                }
                number.resize(n);

                point.clear();
                for (const std::uint32_t row : near.rowsOf(cell))
                    point.push_back({Vec3f((pointAt(row) - middle) * scale_), row});
                if (grouping == Grouping::close) groupTogether(point);
                for (std::size_t begin = 0; begin < point.size(); begin += kLanes) {
                    const std::span together = std::span(point).subspan(begin, std::min(kLanes, point.size() - begin));
                    const PointGroup group(together);
                    const std::size_t used = findNear(boxOf(together), place, square, number);
                    visit(group, SomeSamples<kFields>(candidate.data(), std::span(number).first(used)));
                }
            }
        });
    }

private:
    using Fields = SampleFields<kFields>;

    double reach_, scale_;
    CellOrder cells_;
    std::unique_ptr<Fields[]> field_;  // in the order of cells; positions from the cell's lowest corner
};

}  // namespace betamesh
