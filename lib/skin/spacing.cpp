#include "skin/spacing.h"

#include "core/box.h"
#include "core/parallel.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

namespace betamesh {

namespace {

constexpr std::size_t kNearest = 6;
constexpr std::size_t kLeaf = 32;       // points, at most
constexpr double kReach = 1.15;         // squared; in the farthest of the six nearest that the leaf before has
constexpr std::size_t kMostNear = 512;  // points that are gathered; a leaf in spray may reach far into a dense liquid
constexpr std::size_t kBranch = 16384;  // points from which on both halves are sorted at the same time

struct Leaf {
    std::uint32_t begin, end;  // of points
};
using Columns = std::array<std::vector<double>, 3>;  // x, y, z of points

using Nearest = std::array<double, kNearest>;  // squared distances, ascending
constexpr double kFarOff = std::numeric_limits<double>::infinity();
constexpr Nearest kNowhere{kFarOff, kFarOff, kFarOff, kFarOff, kFarOff, kFarOff};

// Distinct points are never as near as nothing.
void offer(double squared, Nearest& nearest) {
    if (!(squared < nearest.back()) || squared == 0) return;
    for (double& kept : nearest) {  // without branches
        const double less = squared < kept ? squared : kept;
        squared = squared < kept ? kept : squared;
        kept = less;
    }
}

// The points near those of a leaf.
class Search {
public:
    double farthest = kFarOff;  // of the six nearest of the leaf before, squared

    void clear() { size_ = 0; }
    std::size_t size() const { return size_; }
    void add(const Columns& points, const Leaf& leaf, const Box& box, double squared_reach) {
        for (std::vector<double>& column : near_)
            if (column.size() < size_ + kLeaf) column.resize(2 * size_ + kLeaf);
        std::array<double, kLeaf> squared;
        const std::size_t count = leaf.end - leaf.begin;
        squaredDistances(box, &points[0][leaf.begin], &points[1][leaf.begin], &points[2][leaf.begin], count,
                         squared.data());
        for (std::size_t i = 0; i < count; ++i) {
            for (std::size_t k = 0; k < 3; ++k) near_[k][size_] = points[k][leaf.begin + i];
            size_ += squared[i] < squared_reach;
        }
    }
    // Of those that are nearer than the reach.
    Nearest nearest(const Vec3& place, double squared_reach) {
        squared_.resize(size_);
        within_.resize(size_ + 1);
        squaredDistances(Box(place), near_[0].data(), near_[1].data(), near_[2].data(), size_, squared_.data());
        std::size_t found = 0;
        for (std::size_t k = 0; k < size_; ++k) {
            within_[found] = squared_[k];
            found += squared_[k] < squared_reach;
        }
        Nearest nearest = kNowhere;
        for (std::size_t k = 0; k < found; ++k) offer(within_[k], nearest);
        return nearest;
    }

private:
    std::size_t size_ = 0;
    Columns near_;
    std::vector<double> squared_, within_;
};

// Distinct points in the leaves of a k-d tree, with a binary tree of boxes over these.
class NearestFinder {
public:
    explicit NearestFinder(std::vector<Vec3f> points) {
        split(points, 0, static_cast<std::uint32_t>(points.size()), leaf_);
        first_leaf_ = std::bit_ceil(std::max<std::size_t>(leaf_.size(), 1));
        box_.resize(2 * first_leaf_);
        for (std::vector<double>& column : points_) column.resize(points.size());
        parallelFor(leaf_.size(), 64, [&](std::size_t l) {
            Box& box = box_[first_leaf_ + l];
            for (std::uint32_t i = leaf_[l].begin; i < leaf_[l].end; ++i) {
                box.extendBy(Vec3(points[i]));
                for (int k = 0; k < 3; ++k) points_[static_cast<std::size_t>(k)][i] = points[i][k];
            }
        });
        for (std::size_t i = first_leaf_ - 1; i > 0; --i) {
            box_[i] = box_[2 * i];
            box_[i].extendBy(box_[2 * i + 1]);
        }
    }

    std::size_t leaves() const { return leaf_.size(); }

    /// Mean distances of the points of a leaf to their six nearest others.
    void addMeanDistances(std::size_t leaf, Search& search, std::vector<double>& means) const {
        const auto [begin, end] = leaf_[leaf];
        const Box& box = box_[first_leaf_ + leaf];
        double squared_reach = std::min(kReach * search.farthest, (box.max - box.min).length2());
        search.clear();
        gather(1, box, squared_reach, search);
        if (search.size() > kMostNear) squared_reach = 0;
        double farthest = 0;
        for (std::uint32_t i = begin; i < end; ++i) {
            const Vec3 place(points_[0][i], points_[1][i], points_[2][i]);
            Nearest nearest = squared_reach > 0 ? search.nearest(place, squared_reach) : kNowhere;
            if (!(nearest.back() < squared_reach)) {
                nearest = kNowhere;
                visit(1, place, nearest);
            }
            farthest = std::max(farthest, nearest.back());
            double sum = 0;
            for (const double squared : nearest) sum += std::sqrt(squared);
            means.push_back(sum / kNearest);
        }
        search.farthest = farthest;
    }

private:
    // The same points never come apart.
    static void split(std::vector<Vec3f>& points, std::uint32_t begin, std::uint32_t end, std::vector<Leaf>& leaves) {
        if (end - begin <= kLeaf) {
            const auto before = [](const Vec3f& a, const Vec3f& b) {
                return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
            };
            const auto first = points.begin() + begin, last = points.begin() + end;
            std::sort(first, last, before);
            const auto distinct = static_cast<std::uint32_t>(std::unique(first, last) - first);
            if (distinct > 0) leaves.push_back({begin, begin + distinct});
            return;
        }
        const std::uint32_t cut = cutOf(points, begin, end);
        if (cut == end) {
            leaves.push_back({begin, begin + 1});
        } else if (end - begin < kBranch) {
            split(points, begin, cut, leaves);
            split(points, cut, end, leaves);
        } else {
            std::vector<Leaf> high;
            parallelBoth([&] { split(points, begin, cut, leaves); }, [&] { split(points, cut, end, high); });
            leaves.insert(leaves.end(), high.begin(), high.end());
        }
    }
    // Sorts points to both sides of the middle along the axis in which they are widest apart. Returns where the higher
    // ones begin; end where all are the same.
    static std::uint32_t cutOf(std::vector<Vec3f>& points, std::uint32_t begin, std::uint32_t end) {
        const auto first = points.begin() + begin, last = points.begin() + end, middle = first + (end - begin) / 2;
        Vec3f low = *first, high = low;
        for (auto p = first; p != last; ++p)
            for (int k = 0; k < 3; ++k) {
                low[k] = std::min(low[k], (*p)[k]);
                high[k] = std::max(high[k], (*p)[k]);
            }
        if (low == high) return end;
        const Vec3 size = Vec3(high) - Vec3(low);
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        std::nth_element(first, middle, last, [axis](const Vec3f& a, const Vec3f& b) { return a[axis] < b[axis]; });
        const float at = (*middle)[axis];
        auto cut = std::partition(first, middle, [&](const Vec3f& p) { return p[axis] < at; });
        if (cut == first) cut = std::partition(middle, last, [&](const Vec3f& p) { return p[axis] == at; });
        return static_cast<std::uint32_t>(cut - points.begin());
    }

    // Points of all leaves less far from a box than this, or more than there may be.
    void gather(std::size_t node, const Box& box, double squared_reach, Search& search) const {
        if (search.size() > kMostNear || !(squaredDistance(box_[node], box) < squared_reach)) return;
        if (node < first_leaf_) {
            gather(2 * node, box, squared_reach, search);
            gather(2 * node + 1, box, squared_reach, search);
        } else if (node - first_leaf_ < leaf_.size()) {
            search.add(points_, leaf_[node - first_leaf_], box, squared_reach);
        }
    }

    // Branch and bound.
    void visit(std::size_t node, const Vec3& place, Nearest& nearest) const {
        if (node >= first_leaf_) {
            if (node - first_leaf_ >= leaf_.size()) return;
            const auto [begin, end] = leaf_[node - first_leaf_];
            for (std::uint32_t i = begin; i < end; ++i)
                offer((Vec3(points_[0][i], points_[1][i], points_[2][i]) - place).length2(), nearest);
            return;
        }
        const std::array<double, 2> apart{squaredDistance(box_[2 * node], place),
                                          squaredDistance(box_[2 * node + 1], place)};
        const std::size_t nearer = apart[1] < apart[0];
        for (const std::size_t k : {nearer, 1 - nearer})
            if (apart[k] < nearest.back()) visit(2 * node + k, place, nearest);
    }

    std::vector<Leaf> leaf_;
    std::size_t first_leaf_;  // a power of two; node 1 is the root, those below i are 2i and 2i + 1
    std::vector<Box> box_;    // of nodes
    Columns points_;
};

}  // namespace

std::optional<double> spacing(std::vector<Vec3f> points) {
    const NearestFinder finder(std::move(points));
    std::vector<std::vector<double>> of_leaves((finder.leaves() + 31) / 32);
    parallelFor(of_leaves.size(), 1, [&](std::size_t task) {
        Search search;
        for (std::size_t l = 32 * task; l < std::min(finder.leaves(), 32 * (task + 1)); ++l)
            finder.addMeanDistances(l, search, of_leaves[task]);
    });
    std::vector<double> mean = joined(of_leaves);
    if (mean.size() <= kNearest) return std::nullopt;
    const auto middle = mean.begin() + static_cast<std::ptrdiff_t>(mean.size() / 2);
    std::nth_element(mean.begin(), middle, mean.end());
    return *middle;
}

}  // namespace betamesh
