#include "skin/spacing.h"

#include "core/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace betamesh {

namespace {

constexpr std::size_t kNearest = 6;
constexpr std::size_t kLeaf = 16;

// A k-d tree over distinct positions, median splits, stored as the order of the points it sorts.
class NearestFinder {
public:
    explicit NearestFinder(std::vector<Vec3f> points) : points_(std::move(points)) { split(0, points_.size()); }

    /// Mean distance from point i to its six nearest others.
    double meanDistance(std::size_t i) const {
        Nearest nearest;
        nearest.fill(std::numeric_limits<double>::infinity());
        search(0, points_.size(), i, nearest);
        double sum = 0;
        for (const double squared : nearest) sum += std::sqrt(squared);
        return sum / kNearest;
    }

private:
    using Nearest = std::array<double, kNearest>;  // squared distances, ascending

    static int widestAxis(const Vec3f& low, const Vec3f& high) {
        const Vec3f size = high - low;
        return size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    }
    int axisOf(std::size_t begin, std::size_t end) const { return axis_[(begin + end) / 2]; }

    void split(std::size_t begin, std::size_t end) {
        if (axis_.empty()) axis_.resize(points_.size());
        if (end - begin <= kLeaf) return;
        Vec3f low = points_[begin], high = low;
        for (std::size_t i = begin; i < end; ++i)
            for (int a = 0; a < 3; ++a) {
                low[a] = std::min(low[a], points_[i][a]);
                high[a] = std::max(high[a], points_[i][a]);
            }
        const int axis = widestAxis(low, high);
        const std::size_t middle = (begin + end) / 2;
        const auto at = [&](std::size_t i) { return points_.begin() + static_cast<std::ptrdiff_t>(i); };
        std::nth_element(at(begin), at(middle), at(end),
                         [axis](const Vec3f& a, const Vec3f& b) { return a[axis] < b[axis]; });
        axis_[middle] = static_cast<std::int8_t>(axis);
        split(begin, middle);
        split(middle + 1, end);
    }

    void offer(std::size_t other, std::size_t i, Nearest& nearest) const {
        if (other == i) return;
        const Vec3 offset = Vec3(points_[other]) - Vec3(points_[i]);
        double squared = dot(offset, offset);
        for (double& kept : nearest)
            if (squared < kept) std::swap(squared, kept);
    }

    void search(std::size_t begin, std::size_t end, std::size_t i, Nearest& nearest) const {
        if (end - begin <= kLeaf) {
            for (std::size_t other = begin; other < end; ++other) offer(other, i, nearest);
            return;
        }
        const std::size_t middle = (begin + end) / 2;
        const int axis = axisOf(begin, end);
        const double beyond = double{points_[i][axis]} - double{points_[middle][axis]};
        offer(middle, i, nearest);
        const bool low_first = beyond < 0 || (beyond == 0 && i < middle);
        if (low_first)
            search(begin, middle, i, nearest);
        else
            search(middle + 1, end, i, nearest);
        if (beyond * beyond > nearest.back()) return;
        if (low_first)
            search(middle + 1, end, i, nearest);
        else
            search(begin, middle, i, nearest);
    }

    std::vector<Vec3f> points_;
    std::vector<std::int8_t> axis_;
};

}  // namespace

std::optional<double> spacing(std::vector<Vec3f> points) {
    const auto before = [](const Vec3f& a, const Vec3f& b) {
        return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
    };
    std::sort(points.begin(), points.end(), before);
    points.erase(std::unique(points.begin(), points.end()), points.end());
    if (points.size() <= kNearest) return std::nullopt;

    const std::size_t n = points.size();
    const NearestFinder finder(std::move(points));
    std::vector<double> mean(n);
    parallelFor(n, 1024, [&](std::size_t i) { mean[i] = finder.meanDistance(i); });
    const auto middle = mean.begin() + static_cast<std::ptrdiff_t>(n / 2);
    std::nth_element(mean.begin(), middle, mean.end());
    return *middle;
}

}  // namespace betamesh
