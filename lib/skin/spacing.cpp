#include "skin/spacing.h"

#include "base/box.h"
#include "base/parallel.h"
#include "base/random.h"
#include "base/simd.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <tuple>

namespace betamesh {

namespace {

constexpr std::size_t kNearest = 6;    // neighbours averaged over: as many as in a cubic lattice
constexpr std::size_t kLeafSize = 64;  // largest number of points in a leaf
constexpr double kReachGrowth = 1.4;   // squared reach of a leaf's search, in squared reaches that the last one needed
constexpr std::size_t kMostGathered = 512;    // points; in spray a leaf may reach far into dense liquid
constexpr std::size_t kSample = 63;           // points whose median splits a node, if that is balanced enough
constexpr std::size_t kLeastFraction = 8;     // balanced enough: at least one point in this many on either side
constexpr std::size_t kParallelSize = 16384;  // number of points from which on both sides are built in parallel

constexpr std::size_t kSampled = 1024;  // particles whose local spacing is sampled, about
constexpr double kFlat = 0.03;          // share of the variance below which neighbours do not extend along an axis
constexpr double kWindow = 1.284;       // local spacings within this factor, e^0.25, belong to one liquid
constexpr double kAgreement = 0.05;     // between the median of the first frame and the typical local spacing, relative
// Mean distance to the six nearest in a row, (1 + 1 + 2 + 2 + 3 + 3) / 6, in a sheet (square and hexagonal lattices:
// 1.14 and 1; measured in SPH: 1.12), and in a cubic lattice, in spacings.
constexpr double kMeanOfSix[] = {2, 1.12, 1};

using Points = std::vector<Vec3f>;

struct Leaf {
    std::uint32_t begin, end;  // of points
};
using Coordinates = std::array<std::vector<double>, 3>;  // x, y, z of points

using Nearest = std::array<double, kNearest>;  // squared distances, ascending
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr Nearest kNoneFound{kInfinity, kInfinity, kInfinity, kInfinity, kInfinity, kInfinity};

// Inserts a number into an ascending list and drops the largest; without branches.
template <typename Number, typename Numbers>
__attribute__((always_inline)) inline void insert(Number squared, Numbers& nearest) {
    for (Number& kept : nearest) {
        const Number less = squared < kept ? squared : kept;
        squared = squared < kept ? kept : squared;
        kept = less;
    }
}

// Inserts a squared distance if it is small enough; 0 is the point itself.
void offer(double squared, Nearest& nearest) {
    if (squared < nearest.back() && squared != 0) insert(squared, nearest);
}

double meanDistanceOf(const Nearest& nearest) {
    double sum = 0;
    for (const double squared : nearest) sum += std::sqrt(squared);
    return sum / kNearest;
}

// Squared distances from each point of a leaf to its six nearest neighbours, ascending: [neighbour][point].
using NearestOfLeaf = std::array<std::array<double, kLeafSize>, kNearest>;

struct FindNearest {
    const Coordinates& candidates;
    std::size_t size;                     // number of candidates
    std::array<const double*, 3> points;  // of the leaf; kLeafSize of them can be read
    std::size_t count;                    // number of points in the leaf
    NearestOfLeaf& nearest;

    // One point of the leaf per lane.
    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()() const {
        constexpr std::size_t kPoints = kWidth / 2;
        using Pack = Doubles<kPoints>;
        const Pack infinity = Pack{} + kInfinity;
        for (std::size_t first = 0; first < count; first += kPoints) {
            Pack x, y, z, kept[kNearest];
            std::memcpy(&x, points[0] + first, sizeof x);
            std::memcpy(&y, points[1] + first, sizeof y);
            std::memcpy(&z, points[2] + first, sizeof z);
            for (Pack& k : kept) k = infinity;
            for (std::size_t i = 0; i < size; ++i) {
                const Pack dx = x - candidates[0][i], dy = y - candidates[1][i], dz = z - candidates[2][i];
                Pack squared = dx * dx + dy * dy + dz * dz;
                squared = squared == 0 ? infinity : squared;  // the point itself
                insert(squared, kept);
            }
            for (std::size_t k = 0; k < kNearest; ++k) std::memcpy(&nearest[k][first], &kept[k], sizeof kept[k]);
        }
    }
};

// The points near those of a leaf: candidates for their nearest neighbours.
class NearPoints {
public:
    double farthest = kInfinity;  // squared distance of the farthest neighbour found for the last leaf

    void clear() { size_ = 0; }
    std::size_t size() const { return size_; }
    void add(const Coordinates& points, const Leaf& leaf, const Box& box, double squared_reach) {
        for (std::vector<double>& column : near_)
            if (column.size() < size_ + kLeafSize) column.resize(2 * size_ + kLeafSize);
        std::array<double, kLeafSize> squared;
        const std::size_t count = leaf.end - leaf.begin;
        squaredDistances(box, &points[0][leaf.begin], &points[1][leaf.begin], &points[2][leaf.begin], count,
                         squared.data());
        for (std::size_t i = 0; i < count; ++i) {
            for (std::size_t k = 0; k < 3; ++k) near_[k][size_] = points[k][leaf.begin + i];
            size_ += squared[i] < squared_reach;
        }
    }
    void findNearest(const Coordinates& points, const Leaf& leaf, NearestOfLeaf& nearest) const {
        const std::array<const double*, 3> first{&points[0][leaf.begin], &points[1][leaf.begin],
                                                 &points[2][leaf.begin]};
        onThisCpu(FindNearest{near_, size_, first, leaf.end - leaf.begin, nearest});
    }

private:
    std::size_t size_ = 0;
    Coordinates near_;
};

// A k-d tree of points. Duplicates are dropped within leaves.
class NearestFinder {
public:
    explicit NearestFinder(Points points) {
        if (!points.empty()) split(points, 0, static_cast<std::uint32_t>(points.size()), node_);
        leaf_ = indicesWhere(node_.size(), [&](std::uint32_t i) { return node_[i].isLeaf(); });
        for (std::vector<double>& column : points_) column.resize(points.size() + kLeafSize);
        parallelFor(leaf_.size(), 64, [&](std::size_t l) {
            const Leaf& leaf = node_[leaf_[l]].leaf;
            for (std::uint32_t i = leaf.begin; i < leaf.end; ++i)
                for (int k = 0; k < 3; ++k) points_[static_cast<std::size_t>(k)][i] = points[i][k];
        });
    }

    std::size_t leaves() const { return leaf_.size(); }

    /// Number of distinct points.
    std::size_t size() const {
        std::size_t n = 0;
        for (const std::uint32_t l : leaf_) n += node_[l].leaf.end - node_[l].leaf.begin;
        return n;
    }

    /// Calls visit(point) for the distinct points of a leaf.
    template <typename Visit>
    void forEachPoint(std::size_t number, const Visit& visit) const {
        const Leaf& leaf = node_[leaf_[number]].leaf;
        for (std::uint32_t i = leaf.begin; i < leaf.end; ++i) visit(Vec3(points_[0][i], points_[1][i], points_[2][i]));
    }

    /// The mean distance from a point of the tree to its six nearest neighbours; infinite if there are fewer.
    double meanDistance(const Vec3& point) const {
        Nearest nearest = kNoneFound;
        visit(0, point, nearest);
        return meanDistanceOf(nearest);
    }

    /// Calls visit(offset) for the points at an offset shorter than `reach` from a point, among them offset 0.
    template <typename Visit>
    void forEachWithin(const Vec3& point, double reach, const Visit& visit, std::size_t node = 0) const {
        if (!(squaredDistance(node_[node].box, point) < reach * reach)) return;
        if (!node_[node].isLeaf()) {
            for (const std::size_t side : children(node)) forEachWithin(point, reach, visit, side);
            return;
        }
        const auto [begin, end] = node_[node].leaf;
        for (std::uint32_t i = begin; i < end; ++i) {
            const Vec3 offset = Vec3(points_[0][i], points_[1][i], points_[2][i]) - point;
            if (offset.length2() < reach * reach) visit(offset);
        }
    }

    /// Appends the mean distance of each point of a leaf to its six nearest neighbours.
    void addMeanDistances(std::size_t number, NearPoints& search, std::vector<double>& means) const {
        const auto& [box, leaf, size] = node_[leaf_[number]];
        const auto [begin, end] = leaf;
        double squared_reach = std::min(kReachGrowth * search.farthest, (box.max - box.min).length2());
        search.clear();
        gather(0, box, squared_reach, search);
        if (search.size() > kMostGathered) squared_reach = 0;
        NearestOfLeaf found;
        if (squared_reach > 0) search.findNearest(points_, leaf, found);
        double farthest = 0;
        for (std::uint32_t i = begin; i < end; ++i) {
            Nearest nearest = kNoneFound;
            if (squared_reach > 0 && found.back()[i - begin] < squared_reach)
                for (std::size_t k = 0; k < kNearest; ++k) nearest[k] = found[k][i - begin];
            else
                visit(0, {points_[0][i], points_[1][i], points_[2][i]}, nearest);
            farthest = std::max(farthest, nearest.back());
            means.push_back(meanDistanceOf(nearest));
        }
        search.farthest = farthest;
    }

private:
    struct Node {
        Box box;
        Leaf leaf{};
        std::size_t size = 1;  // nodes of the subtree, which follow this one, the lower side first

        bool isLeaf() const { return size == 1; }
    };

    // Appends the tree of points begin to end, which it sorts. Duplicates stay together.
    static void split(Points& points, std::uint32_t begin, std::uint32_t end, std::vector<Node>& nodes) {
        const auto first = points.begin() + begin, last = points.begin() + end;
        const std::size_t here = nodes.size();
        nodes.emplace_back();
        for (auto p = first; p != last; ++p) nodes[here].box.extendBy(Vec3(*p));
        if (end - begin <= kLeafSize) {
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
        const auto cut = static_cast<std::uint32_t>(splitAlong(axis, first, last) - points.begin());
        if (end - begin < kParallelSize) {
            split(points, begin, cut, nodes);
            split(points, cut, end, nodes);
        } else {
            std::vector<Node> high;
            parallelBoth([&] { split(points, begin, cut, nodes); }, [&] { split(points, cut, end, high); });
            nodes.insert(nodes.end(), high.begin(), high.end());
        }
        nodes[here].size = nodes.size() - here;
    }
    // Partitions points along an axis into two sides of about equal size. Returns where the higher side begins.
    static Points::iterator splitAlong(int axis, Points::iterator first, Points::iterator last) {
        const auto n = static_cast<std::size_t>(last - first);
        std::array<float, kSample> sample;
        for (std::size_t i = 0; i < kSample; ++i) sample[i] = first[static_cast<std::ptrdiff_t>(i * n / kSample)][axis];
        std::nth_element(sample.begin(), sample.begin() + kSample / 2, sample.end());
        const auto cut = partition(first, last, axis, sample[kSample / 2]);
        const auto below = static_cast<std::size_t>(cut - first);
        if (std::min(below, n - below) >= n / kLeastFraction) return cut;

        const auto middle = first + static_cast<std::ptrdiff_t>(n / 2);
        std::nth_element(first, middle, last, [axis](const Vec3f& a, const Vec3f& b) { return a[axis] < b[axis]; });
        const float at = (*middle)[axis];
        const auto lower = partition(first, middle, axis, at);
        if (lower != first) return lower;
        return partition(middle, last, axis, std::nextafter(at, std::numeric_limits<float>::infinity()));
    }
    // Moves points below `at` to the front, without branches. Returns where the others begin.
    static Points::iterator partition(Points::iterator first, Points::iterator last, int axis, float at) {
        for (auto low = first;; ++first) {
            if (first == last) return low;
            const Vec3f point = *first;
            *first = *low;
            *low = point;
            low += point[axis] < at;
        }
    }

    // The two children of a node.
    std::array<std::size_t, 2> children(std::size_t node) const { return {node + 1, node + 1 + node_[node + 1].size}; }

    // Gathers the points closer to a box than this; stops once there are more than kMostGathered.
    void gather(std::size_t node, const Box& box, double squared_reach, NearPoints& search) const {
        if (search.size() > kMostGathered || !(squaredDistance(node_[node].box, box) < squared_reach)) return;
        if (node_[node].isLeaf()) return search.add(points_, node_[node].leaf, box, squared_reach);
        for (const std::size_t side : children(node)) gather(side, box, squared_reach, search);
    }

    // Finds the nearest neighbours of one point by branch and bound.
    void visit(std::size_t node, const Vec3& position, Nearest& nearest) const {
        if (node_[node].isLeaf()) {
            const auto [begin, end] = node_[node].leaf;
            for (std::uint32_t i = begin; i < end; ++i)
                offer((Vec3(points_[0][i], points_[1][i], points_[2][i]) - position).length2(), nearest);
            return;
        }
        const std::array<std::size_t, 2> side = children(node);
        const std::array<double, 2> distance{squaredDistance(node_[side[0]].box, position),
                                             squaredDistance(node_[side[1]].box, position)};
        const std::size_t nearer = distance[1] < distance[0];
        for (const std::size_t k : {nearer, 1 - nearer})
            if (distance[k] < nearest.back()) visit(side[k], position, nearest);
    }

    std::vector<Node> node_;
    std::vector<std::uint32_t> leaf_;  // the nodes that are leaves
    Coordinates points_;               // padded by one leaf
};

// Second moments of the offsets of a point's neighbours about their mean.
struct Scatter {
    double count = 0;
    Vec3 sum{0, 0, 0};
    double xx = 0, yy = 0, zz = 0, xy = 0, yz = 0, zx = 0;

    void add(const Vec3& offset) {
        ++count;
        sum += offset;
        xx += offset.x * offset.x, yy += offset.y * offset.y, zz += offset.z * offset.z;
        xy += offset.x * offset.y, yz += offset.y * offset.z, zx += offset.z * offset.x;
    }

    // 1 along a line, 2 in a sheet, 3 in a volume: the number of principal axes whose variance is at least kFlat of the
    // whole. By Sylvester's law of inertia, each change of sign in the leading minors of (covariance - kFlat trace) is
    // a smaller eigenvalue.
    int dimension() const {
        const Vec3 mean = sum / count;
        const double cxx = xx - count * mean.x * mean.x, cyy = yy - count * mean.y * mean.y,
                     czz = zz - count * mean.z * mean.z, cxy = xy - count * mean.x * mean.y,
                     cyz = yz - count * mean.y * mean.z, czx = zx - count * mean.z * mean.x;
        const double flat = kFlat * (cxx + cyy + czz);
        const double x = cxx - flat, y = cyy - flat, z = czz - flat;
        const double second = x * y - cxy * cxy;
        const double third = x * (y * z - cyz * cyz) - cxy * (cxy * z - cyz * czx) + czx * (cxy * cyz - y * czx);
        const int thin = (x < 0) + ((second < 0) != (x < 0)) + ((third < 0) != (second < 0));
        return std::max(1, 3 - thin);
    }
};

// A pseudo-random number of a position, the same for any order of the particles.
std::uint64_t hashOf(const Vec3& p) {
    std::uint64_t bits = 0;
    for (const double coordinate : {p.x, p.y, p.z})
        bits = hash(bits, std::bit_cast<std::uint32_t>(static_cast<float>(coordinate)));
    return bits;
}

// A particle and its local spacing.
struct LocalSpacing {
    Vec3f position;
    double spacing;
    bool is_clumped;  // another particle is nearer than half the mean distance to the six nearest
};

std::vector<LocalSpacing> localSpacingsAt(const NearestFinder& finder, int dimension) {
    const auto factor = [&](int local) { return kMeanOfSix[dimension - 1] / kMeanOfSix[local - 1]; };
    const std::uint64_t every = std::max<std::uint64_t>(1, finder.size() / kSampled);
    std::vector<std::vector<LocalSpacing>> of_leaves(finder.leaves());
    parallelFor(finder.leaves(), 16, [&](std::size_t l) {
        finder.forEachPoint(l, [&](const Vec3& point) {
            if (every > 1 && hashOf(point) % every != 0) return;
            const double mean = finder.meanDistance(point);
            if (!std::isfinite(mean)) return;
            Scatter neighbours;
            bool is_clumped = false;
            finder.forEachWithin(point, 2 * mean, [&](const Vec3& offset) {
                neighbours.add(offset);
                is_clumped |= offset != Vec3(0) && offset.length2() < mean * mean / 4;
            });
            of_leaves[l].push_back({Vec3f(point), mean * factor(neighbours.dimension()), is_clumped});
        });
    });
    return concatenate(of_leaves);
}

std::vector<double> localSpacings(const NearestFinder& finder, int dimension) {
    std::vector<double> local;
    for (const LocalSpacing& at : localSpacingsAt(finder, dimension)) local.push_back(at.spacing);
    return local;
}

std::optional<double> medianSixNearest(const NearestFinder& finder) {
    std::vector<std::vector<double>> of_leaves((finder.leaves() + 31) / 32);
    parallelFor(of_leaves.size(), 1, [&](std::size_t task) {
        NearPoints search;
        for (std::size_t l = 32 * task; l < std::min(finder.leaves(), 32 * (task + 1)); ++l)
            finder.addMeanDistances(l, search, of_leaves[task]);
    });
    std::vector<double> mean = concatenate(of_leaves);
    if (mean.size() <= kNearest) return std::nullopt;
    const auto middle = mean.begin() + static_cast<std::ptrdiff_t>(mean.size() / 2);
    std::nth_element(mean.begin(), middle, mean.end());
    return *middle;
}

}  // namespace

bool SpacingEstimator::add(std::vector<Vec3f> positions) {
    const NearestFinder finder(std::move(positions));
    const std::vector<LocalSpacing> local = localSpacingsAt(finder, dimension_);
    if (!first_median_) first_median_ = medianSixNearest(finder);
    for (const LocalSpacing& at : local) {
        local_.push_back(at.spacing);
        clumped_ += at.is_clumped;
    }
    return !local.empty();
}

std::optional<SpacingEstimate> SpacingEstimator::estimate() const {
    if (local_.empty()) return std::nullopt;
    const double typical = typicalSpacing(local_);
    std::vector<double> local = local_;
    const auto percentile = [&](std::size_t percent) {
        const auto at = local.begin() + static_cast<std::ptrdiff_t>((local.size() - 1) * percent / 100);
        std::nth_element(local.begin(), at, local.end());
        return *at;
    };
    const bool agrees = first_median_ && std::abs(*first_median_ - typical) <= kAgreement * typical;
    return SpacingEstimate{agrees ? *first_median_ : typical, percentile(5), percentile(95),
                           static_cast<double>(clumped_) / static_cast<double>(local_.size())};
}

std::optional<SpacingEstimate> spacingOf(std::vector<Vec3f> positions, int dimension) {
    SpacingEstimator estimator(dimension);
    estimator.add(std::move(positions));
    return estimator.estimate();
}

std::vector<double> localSpacings(std::vector<Vec3f> positions, int dimension) {
    return localSpacings(NearestFinder(std::move(positions)), dimension);
}

std::vector<double> spacingsInSizes(const std::vector<Vec3f>& positions, const std::vector<double>& size,
                                    int dimension) {
    const auto before = [](const Vec3f& a, const Vec3f& b) {
        return std::tuple(a.x, a.y, a.z) < std::tuple(b.x, b.y, b.z);
    };
    std::vector<LocalSpacing> local = localSpacingsAt(NearestFinder(positions), dimension);
    std::sort(local.begin(), local.end(),
              [&](const LocalSpacing& a, const LocalSpacing& b) { return before(a.position, b.position); });
    std::vector<double> largest(local.size(), 0);  // of the particles at the same position
    for (std::size_t i = 0; i < positions.size(); ++i) {
        const auto at = std::lower_bound(local.begin(), local.end(), positions[i],
                                         [&](const LocalSpacing& a, const Vec3f& p) { return before(a.position, p); });
        if (at == local.end() || at->position != positions[i]) continue;
        double& found = largest[static_cast<std::size_t>(at - local.begin())];
        found = std::max(found, size[i]);
    }
    std::vector<double> relative;
    for (std::size_t i = 0; i < local.size(); ++i)
        if (largest[i] > 0) relative.push_back(local[i].spacing / largest[i]);
    return relative;
}

double typicalSpacing(std::vector<double> local) {
    std::sort(local.begin(), local.end());
    const auto upTo = [&](double length) { return std::upper_bound(local.begin(), local.end(), length); };
    const auto median = [](auto first, auto last) { return *(first + (last - first) / 2); };
    auto densest = local.begin();  // first of the most numerous values that are within a factor kWindow of each other
    for (auto first = local.begin(); first != local.end(); ++first)
        if (upTo(*first * kWindow) - first > upTo(*densest * kWindow) - densest) densest = first;
    const double centre = median(densest, upTo(*densest * kWindow));
    return median(std::lower_bound(local.begin(), local.end(), centre / kWindow), upTo(centre * kWindow));
}

std::optional<double> medianSixNearest(std::vector<Vec3f> positions) {
    return medianSixNearest(NearestFinder(std::move(positions)));
}

}  // namespace betamesh
