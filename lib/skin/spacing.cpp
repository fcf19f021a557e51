
#include "skin/spacing.h"

#include "base/box.h"
#include "base/parallel.h"
#include "base/simd.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

namespace betamesh {

namespace {

constexpr std::size_t kNearest = 6;
constexpr std::size_t kLeaf = 64;       // points, at most
constexpr double kReach = 1.4;          // squared; in the farthest of the six nearest that the leaf before has
constexpr std::size_t kMostNear = 512;  // points that are gathered; a leaf in spray may reach far into a dense liquid
constexpr std::size_t kSample = 63;     // points whose median parts the others, if that leaves
constexpr std::size_t kLeastShare = 8;  // one of so many on either side
constexpr std::size_t kBranch = 16384;  // points from which on both halves are sorted at the same time

using Points = std::vector<Vec3f>;

struct Leaf {
    std::uint32_t begin, end;  // of points
};
using Columns = std::array<std::vector<double>, 3>;  // x, y, z of points

using Nearest = std::array<double, kNearest>;  // squared distances, ascending
constexpr double kFarOff = std::numeric_limits<double>::infinity();
constexpr Nearest kNowhere{kFarOff, kFarOff, kFarOff, kFarOff, kFarOff, kFarOff};

// Keeps the least, ascending; without branches.
template <typename Number, typename Numbers>
__attribute__((always_inline)) inline void insert(Number squared, Numbers& nearest) {
    for (Number& kept : nearest) {
        const Number less = squared < kept ? squared : kept;
        squared = squared < kept ? kept : squared;
        kept = less;
    }
}

// Distinct points are never as near as nothing.
void offer(double squared, Nearest& nearest) {
    if (squared < nearest.back() && squared != 0) insert(squared, nearest);
}

// The squared distances from each point of a leaf to its six nearest of some, ascending: [which][point].
using NearestOfLeaf = std::array<std::array<double, kLeaf>, kNearest>;

struct FindNearest {
    const Columns& some;
    std::size_t size;                     // of these
    std::array<const double*, 3> points;  // of the leaf; there is room to read kLeaf
    std::size_t count;                    // of them
    NearestOfLeaf& nearest;

    // A point in each lane.
    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()() const {
        constexpr std::size_t kPoints = kWidth / 2;
        using Some = Doubles<kPoints>;
        const Some far_off = Some{} + kFarOff;
        for (std::size_t first = 0; first < count; first += kPoints) {
            Some x, y, z, kept[kNearest];
            std::memcpy(&x, points[0] + first, sizeof x);
            std::memcpy(&y, points[1] + first, sizeof y);
            std::memcpy(&z, points[2] + first, sizeof z);
            for (Some& k : kept) k = far_off;
            for (std::size_t i = 0; i < size; ++i) {
                const Some dx = x - some[0][i], dy = y - some[1][i], dz = z - some[2][i];
                Some squared = dx * dx + dy * dy + dz * dz;
                squared = squared == 0 ? far_off : squared;  // distinct points are never as near as nothing
                insert(squared, kept);
            }
            for (std::size_t k = 0; k < kNearest; ++k) std::memcpy(&nearest[k][first], &kept[k], sizeof kept[k]);
        }
    }
};

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
    void findNearest(const Columns& points, const Leaf& leaf, NearestOfLeaf& nearest) const {
        const std::array<const double*, 3> first{&points[0][leaf.begin], &points[1][leaf.begin],
                                                 &points[2][leaf.begin]};
        onThisCpu(FindNearest{near_, size_, first, leaf.end - leaf.begin, nearest});
    }

private:
    std::size_t size_ = 0;
    Columns near_;
};

// Distinct points in the leaves of a k-d tree.
class NearestFinder {
public:
    explicit NearestFinder(Points points) {
        if (!points.empty()) split(points, 0, static_cast<std::uint32_t>(points.size()), node_);
        leaf_ = indicesWhere(node_.size(), [&](std::uint32_t i) { return node_[i].isLeaf(); });
        for (std::vector<double>& column : points_) column.resize(points.size() + kLeaf);
        parallelFor(leaf_.size(), 64, [&](std::size_t l) {
            const Leaf& leaf = node_[leaf_[l]].leaf;
            for (std::uint32_t i = leaf.begin; i < leaf.end; ++i)
                for (int k = 0; k < 3; ++k) points_[static_cast<std::size_t>(k)][i] = points[i][k];
        });
    }

    std::size_t leaves() const { return leaf_.size(); }

    /// Mean distances of the points of a leaf to their six nearest others.
    void addMeanDistances(std::size_t number, Search& search, std::vector<double>& means) const {
        const auto& [box, leaf, size] = node_[leaf_[number]];
        const auto [begin, end] = leaf;
        double squared_reach = std::min(kReach * search.farthest, (box.max - box.min).length2());
        search.clear();
        gather(0, box, squared_reach, search);
        if (search.size() > kMostNear) squared_reach = 0;
        NearestOfLeaf found;
        if (squared_reach > 0) search.findNearest(points_, leaf, found);
        double farthest = 0;
        for (std::uint32_t i = begin; i < end; ++i) {
            Nearest nearest = kNowhere;
            if (squared_reach > 0 && found.back()[i - begin] < squared_reach)
                for (std::size_t k = 0; k < kNearest; ++k) nearest[k] = found[k][i - begin];
            else
                visit(0, {points_[0][i], points_[1][i], points_[2][i]}, nearest);
            farthest = std::max(farthest, nearest.back());
            double sum = 0;
            for (const double squared : nearest) sum += std::sqrt(squared);
            means.push_back(sum / kNearest);
        }
        search.farthest = farthest;
    }

private:
    struct Node {
        Box box;
        Leaf leaf{};
        std::size_t size = 1;  // nodes, itself included; those below follow it, the lower side first

        bool isLeaf() const { return size == 1; }
    };

    // The same points never come apart.
    static void split(Points& points, std::uint32_t begin, std::uint32_t end, std::vector<Node>& nodes) {
        const auto first = points.begin() + begin, last = points.begin() + end;
        const std::size_t here = nodes.size();
        nodes.emplace_back();
        for (auto p = first; p != last; ++p) nodes[here].box.extendBy(Vec3(*p));
        if (end - begin <= kLeaf) {
            const auto before = [](const Vec3f& a, const Vec3f& b) {
                return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
            };
            std::sort(first, last, before);
            nodes[here].leaf = {begin, begin + static_cast<std::uint32_t>(std::unique(first, last) - first)};
            return;
        }
        const Vec3 size = nodes[here].box.size();
        if (size == Vec3(0)) {
            nodes[here].leaf = {begin, begin + 1};
            return;
        }
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        const auto cut = static_cast<std::uint32_t>(cutAcross(axis, first, last) - points.begin());
        if (end - begin < kBranch) {
            split(points, begin, cut, nodes);
            split(points, cut, end, nodes);
        } else {
            std::vector<Node> high;
            parallelBoth([&] { split(points, begin, cut, nodes); }, [&] { split(points, cut, end, high); });
            nodes.insert(nodes.end(), high.begin(), high.end());
        }
        nodes[here].size = nodes.size() - here;
    }
    // Sorts points to both sides along an axis, about as many to each. Returns where the higher ones begin.
    static Points::iterator cutAcross(int axis, Points::iterator first, Points::iterator last) {
        const auto n = static_cast<std::size_t>(last - first);
        std::array<float, kSample> sample;
        for (std::size_t i = 0; i < kSample; ++i) sample[i] = first[static_cast<std::ptrdiff_t>(i * n / kSample)][axis];
        std::nth_element(sample.begin(), sample.begin() + kSample / 2, sample.end());
        const auto cut = partition(first, last, axis, sample[kSample / 2]);
        const auto below = static_cast<std::size_t>(cut - first);
        if (std::min(below, n - below) >= n / kLeastShare) return cut;

        const auto middle = first + static_cast<std::ptrdiff_t>(n / 2);
        std::nth_element(first, middle, last, [axis](const Vec3f& a, const Vec3f& b) { return a[axis] < b[axis]; });
        const float at = (*middle)[axis];
        const auto lower = partition(first, middle, axis, at);
        if (lower != first) return lower;
        return partition(middle, last, axis, std::nextafter(at, std::numeric_limits<float>::infinity()));
    }
    // Those below come first. Without branches, as it takes turns.
    static Points::iterator partition(Points::iterator first, Points::iterator last, int axis, float at) {
        for (auto low = first;; ++first) {
            if (first == last) return low;
            const Vec3f point = *first;
            *first = *low;
            *low = point;
            low += point[axis] < at;
        }
    }

    // Those below a node.
    std::array<std::size_t, 2> below(std::size_t node) const { return {node + 1, node + 1 + node_[node + 1].size}; }

    // Points of all leaves less far from a box than this, or more than there may be.
    void gather(std::size_t node, const Box& box, double squared_reach, Search& search) const {
        if (search.size() > kMostNear || !(squaredDistance(node_[node].box, box) < squared_reach)) return;
        if (node_[node].isLeaf()) return search.add(points_, node_[node].leaf, box, squared_reach);
        for (const std::size_t side : below(node)) gather(side, box, squared_reach, search);
    }

    // Branch and bound.
    void visit(std::size_t node, const Vec3& place, Nearest& nearest) const {
        if (node_[node].isLeaf()) {
            const auto [begin, end] = node_[node].leaf;
            for (std::uint32_t i = begin; i < end; ++i)
                offer((Vec3(points_[0][i], points_[1][i], points_[2][i]) - place).length2(), nearest);
            return;
        }
        const std::array<std::size_t, 2> side = below(node);
        const std::array<double, 2> apart{squaredDistance(node_[side[0]].box, place),
                                          squaredDistance(node_[side[1]].box, place)};
        const std::size_t nearer = apart[1] < apart[0];
        for (const std::size_t k : {nearer, 1 - nearer})
            if (apart[k] < nearest.back()) visit(side[k], place, nearest);
    }

    std::vector<Node> node_;
    std::vector<std::uint32_t> leaf_;  // nodes
    Columns points_;                   // and room for a leaf
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
    std::vector<double> mean = concatenate(of_leaves);
    if (mean.size() <= kNearest) return std::nullopt;
    const auto middle = mean.begin() + static_cast<std::ptrdiff_t>(mean.size() / 2);
    std::nth_element(mean.begin(), middle, mean.end());
    return *middle;
}

}  // namespace betamesh
