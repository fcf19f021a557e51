#include "skin/keep_apart.h"

#include "core/box.h"
#include "core/cell_order.h"
#include "core/icosphere.h"
#include "core/parallel.h"
#include "exact/orientation.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>
#include <span>

namespace betamesh {

namespace {

constexpr std::size_t kRun = 16;       // consecutive triangles that make a patch, if they face the same way
constexpr double kRunCosine = 0.8;     // to their mean normal: else they are parted by octants
constexpr double kSameSide = .35;      // cosine of the angle within which normals face the same way
constexpr double kNearTurned = 0.3;    // of a triangle turned over, radii
constexpr std::size_t kTasks = 512;    // at least, where there is that much to do
constexpr int kRounds = 24;            // after which what still crosses goes back all the way
constexpr int kHalvings = 32;          // of the way, to find where two triangles meet
constexpr double kShortOf = 0.999;     // of the way to there
constexpr double kMeanWidth = 0.5;     // of the kernel of mean ways, radii
constexpr double kStepOfTime = 1e-4;   // in which nothing moves further, in radii: to see how the place changes
constexpr double kFarthestOff = 0.05;  // that it may change in this step, as a share of the way
constexpr double kFastest = 2;         // that this may move vertices, in largest speeds of the two triangles

using Pair = std::array<std::uint32_t, 2>;  // of triangles

// Does the segment go from one side of the triangle to the other, through its inside or its edges?
bool pierces(const Vec3& p, const Vec3& q, const std::array<Vec3, 3>& t) {
    const int from = sideOfPlane(t[0], t[1], t[2], p);
    if (from == 0 || sideOfPlane(t[0], t[1], t[2], q) != -from) return false;
    const int a = sideOfPlane(p, q, t[0], t[1]), b = sideOfPlane(p, q, t[1], t[2]);
    if (a * b < 0) return false;
    const int c = sideOfPlane(p, q, t[2], t[0]);
    return a * c >= 0 && b * c >= 0;
}

// Passes an edge of one through the other? Edges at a common vertex touch.
template <typename PositionOf>
bool cross(const Triangle& s, const Triangle& t, const PositionOf& positionOf) {
    std::array<Vec3, 3> at_s, at_t;
    for (std::size_t m = 0; m < 3; ++m) {
        at_s[m] = positionOf(s[m]);
        at_t[m] = positionOf(t[m]);
    }
    const auto piercesOther = [](const Triangle& one, const std::array<Vec3, 3>& at, const Triangle& other,
                                 const std::array<Vec3, 3>& other_at) {
        const auto isCommon = [&](std::uint32_t v) { return v == other[0] || v == other[1] || v == other[2]; };
        for (std::size_t m = 0; m < 3; ++m) {
            const std::size_t next = (m + 1) % 3;
            if (!isCommon(one[m]) && !isCommon(one[next]) && pierces(at[m], at[next], other_at)) return true;
        }
        return false;
    };
    return piercesOther(s, at_s, t, at_t) || piercesOther(t, at_t, s, at_s);
}

// Patches of triangles in a binary tree. Each node knows which directions all of its triangles face: two nodes with
// a common one are parts of a surface over a plane, which cannot cross. Layers that face the same way have others
// between them, which would cross first.
class PatchTree {
public:
    // Awake are the patches that have moved since; all are, near triangles that have turned over.
    PatchTree(const BetaMesh& mesh, const std::vector<Moving>& since, double radius)
        : mesh_(mesh), direction_(icosphere(2).position) {
        makePatches();
        std::vector<std::uint8_t> turned(patch_.size(), 0);
        parallelFor(patch_.size(), 64, [&](std::size_t p) {
            for (const std::uint32_t t : trianglesOf(patch_[p])) {
                const auto& [a, b, c] = mesh.triangles[t];
                const Vec3 &from_a = since[a].position, &from_b = since[b].position, &from_c = since[c].position;
                if (at(a) == from_a && at(b) == from_b && at(c) == from_c) continue;
                awake_[first_leaf_ + p] = 1;
                turned[p] |= dot(betamesh::cross(from_b - from_a, from_c - from_a), normalOf(t)) <= 0;
            }
        });
        for (std::size_t i = first_leaf_ - 1; i > 0; --i) awake_[i] = awake_[2 * i] | awake_[2 * i + 1];
        for (std::size_t p = 0; p < patch_.size(); ++p)
            if (turned[p]) wake(patch_[p].box, kNearTurned * radius);
    }

    // Of crossing triangles, the smaller row first, ascending; each in a patch that is awake, or both.
    std::vector<Pair> crossings() const {
        std::vector<Pair> tasks = {{1, 1}};  // of nodes
        for (bool coarse = true; coarse && tasks.size() < kTasks;) {
            std::vector<Pair> finer;
            coarse = false;
            for (const Pair& task : tasks) {
                if (areLeaves(task)) {
                    finer.push_back(task);
                } else {
                    descend(task, finer);
                    coarse = true;
                }
            }
            tasks = std::move(finer);
        }
        std::vector<std::vector<Pair>> found(tasks.size());
        parallelFor(tasks.size(), 1, [&](std::size_t i) {
            std::vector<Pair> waiting = {tasks[i]};
            while (!waiting.empty()) {
                const Pair task = waiting.back();
                waiting.pop_back();
                if (areLeaves(task))
                    addCrossings(task, found[i]);
                else
                    descend(task, waiting);
            }
        });
        std::vector<Pair> all;
        for (const std::vector<Pair>& some : found) all.insert(all.end(), some.begin(), some.end());
        std::sort(all.begin(), all.end());
        return all;
    }

    void sleep() { std::fill(awake_.begin(), awake_.end(), std::uint8_t{0}); }
    // Patches that are no farther from the box than this. From now on they are compared with all others, whichever
    // way they face.
    void wake(Box box, double distance) {
        box.low -= Vec3(distance);
        box.high += Vec3(distance);
        std::vector<std::size_t> waiting = {1};
        while (!waiting.empty()) {
            const std::size_t i = waiting.back();
            waiting.pop_back();
            if (!box_[i].meets(box)) continue;
            awake_[i] = 1;
            facing_[i] = 0;
            if (i < first_leaf_) waiting.insert(waiting.end(), {2 * i, 2 * i + 1});
        }
    }
    // Patches without a triangle that moves(t) fall asleep.
    template <typename Moves>
    void sleepUnless(const Moves& moves) {
        for (std::size_t p = 0; p < patch_.size(); ++p) {
            std::uint8_t& awake = awake_[first_leaf_ + p];
            const auto triangles = trianglesOf(patch_[p]);
            awake = awake && std::any_of(triangles.begin(), triangles.end(),
                                         [&](std::uint32_t t) { return moves(mesh_.triangles[t]); });
        }
        for (std::size_t i = first_leaf_ - 1; i > 0; --i) awake_[i] = awake_[2 * i] | awake_[2 * i + 1];
    }
    // After vertices of patches that are awake have moved.
    void refit() {
        parallelFor(patch_.size(), 64, [&](std::size_t p) {
            if (awake_[first_leaf_ + p]) box_[first_leaf_ + p] = boxOf(patch_[p]);
        });
        for (std::size_t i = first_leaf_ - 1; i > 0; --i) {
            box_[i] = box_[2 * i];
            box_[i].extend(box_[2 * i + 1]);
        }
    }
    // Calls visit(triangle) for those in patches that are awake.
    template <typename Visit>
    void forTrianglesAwake(const Visit& visit) const {
        for (std::size_t p = 0; p < patch_.size(); ++p)
            if (awake_[first_leaf_ + p])
                for (const std::uint32_t t : trianglesOf(patch_[p])) visit(mesh_.triangles[t]);
    }

private:
    struct Patch {
        std::uint32_t begin, end;  // of triangle_
        Box box;
        std::uint64_t facing;
        std::uint64_t place = 0;  // on a curve through all
    };

    std::span<const std::uint32_t> trianglesOf(const Patch& patch) const {
        return std::span(triangle_).subspan(patch.begin, patch.end - patch.begin);
    }

    const Vec3& at(std::uint32_t v) const { return mesh_.vertex[v].position; }
    Vec3 normalOf(std::uint32_t t) const {
        const auto& [a, b, c] = mesh_.triangles[t];
        return betamesh::cross(at(b) - at(a), at(c) - at(a));
    }
    Box boxOf(std::uint32_t t) const {
        Box box;
        for (const std::uint32_t v : mesh_.triangles[t]) box.extend(at(v));
        return box;
    }
    Box boxOf(const Patch& patch) const {
        Box box;
        for (const std::uint32_t t : trianglesOf(patch)) box.extend(boxOf(t));
        return box;
    }
    static double leastCosine(std::span<const Vec3> normals, const Vec3& axis) {
        double least = 1;
        for (const Vec3& n : normals)
            if (n != Vec3(0)) least = std::min(least, dot(n, axis));
        return least;
    }

    // Runs of triangles are near each other, as the mesh is made ball by ball.
    void makePatches() {
        const std::size_t n = mesh_.triangles.size(), runs = (n + kRun - 1) / kRun;
        triangle_.resize(n);
        std::vector<std::vector<Patch>> patches_of(runs);
        parallelFor(runs, 64, [&](std::size_t run) {
            const auto begin = static_cast<std::uint32_t>(run * kRun);
            const auto size = static_cast<std::uint32_t>(std::min(n - begin, kRun));
            std::array<Vec3, kRun> normal;
            std::array<std::uint32_t, kRun> octant;
            Vec3 sum(0);
            for (std::uint32_t k = 0; k < size; ++k) {
                const Vec3& v = normal[k] = normalOf(begin + k).normalized();
                octant[k] = (v.x > 0) + 2U * (v.y > 0) + 4U * (v.z > 0);
                sum += v;
            }
            if (leastCosine(std::span(normal).first(size), sum.normalized()) >= kRunCosine)
                std::fill_n(octant.begin(), size, 0U);
            std::uint32_t placed = 0;
            for (std::uint32_t wanted = 0; wanted < 8; ++wanted) {
                const std::uint32_t first = placed;
                for (std::uint32_t k = 0; k < size; ++k)
                    if (octant[k] == wanted) triangle_[begin + placed++] = begin + k;
                if (placed > first) patches_of[run].push_back(lookAt(begin + first, begin + placed));
            }
        });
        for (const std::vector<Patch>& some : patches_of) patch_.insert(patch_.end(), some.begin(), some.end());

        Box whole;
        for (const Patch& patch : patch_) whole.extend(patch.box);
        for (Patch& patch : patch_) patch.place = placeOnCurve(patch.box, whole);
        parallelSort(patch_, [](const Patch& a, const Patch& b) {
            return a.place != b.place ? a.place < b.place : a.begin < b.begin;
        });
        first_leaf_ = std::bit_ceil(std::max<std::size_t>(patch_.size(), 1));
        box_.resize(2 * first_leaf_);
        facing_.assign(2 * first_leaf_, ~std::uint64_t{0});
        awake_.assign(2 * first_leaf_, 0);
        for (std::size_t p = 0; p < patch_.size(); ++p) {
            box_[first_leaf_ + p] = patch_[p].box;
            facing_[first_leaf_ + p] = patch_[p].facing;
        }
        for (std::size_t i = first_leaf_ - 1; i > 0; --i) {
            box_[i] = box_[2 * i];
            box_[i].extend(box_[2 * i + 1]);
            facing_[i] = facing_[2 * i] & facing_[2 * i + 1];
        }
    }
    Patch lookAt(std::uint32_t begin, std::uint32_t end) const {
        Patch patch{begin, end, {}, 0};
        std::array<Vec3, kRun> normal;
        Vec3 sum(0);
        std::size_t n = 0;
        for (std::uint32_t i = begin; i < end; ++i) {
            patch.box.extend(boxOf(triangle_[i]));
            normal[n] = normalOf(triangle_[i]).normalized();
            sum += normal[n++];
        }
        const Vec3 axis = sum.normalized();
        const double cosine = leastCosine(std::span(normal).first(n), axis);
        if (cosine <= kSameSide) return patch;
        // the cosine of what is left of the angle between an axis and a direction
        const double left =
            kSameSide * cosine + std::sqrt((1 - kSameSide * kSameSide) * std::max(0.0, 1 - cosine * cosine));
        for (std::size_t d = 0; d < direction_.size(); ++d)
            patch.facing |= std::uint64_t{dot(axis, direction_[d]) >= left} << d;
        return patch;
    }
    bool areLeaves(const Pair& nodes) const { return nodes[0] >= first_leaf_ && nodes[1] >= first_leaf_; }
    // Adds what is to be looked at instead of these two nodes.
    void descend(const Pair& nodes, std::vector<Pair>& into) const {
        const auto [i, j] = nodes;
        const auto add = [&](std::uint32_t a, std::uint32_t b) {
            if ((awake_[a] || awake_[b]) && (facing_[a] & facing_[b]) == 0 && box_[a].meets(box_[b]))
                into.push_back({a, b});
        };
        if (i == j) {
            add(2 * i, 2 * i);
            add(2 * i + 1, 2 * i + 1);
            add(2 * i, 2 * i + 1);
        } else if (j < i || i >= first_leaf_) {  // the larger number is nowhere higher
            add(i, 2 * j);
            add(i, 2 * j + 1);
        } else {
            add(2 * i, j);
            add(2 * i + 1, j);
        }
    }
    void addCrossings(const Pair& leaves, std::vector<Pair>& out) const {
        const auto [i, j] = leaves;
        const std::span<const std::uint32_t> one = trianglesOf(patch_[i - first_leaf_]),
                                             other = trianglesOf(patch_[j - first_leaf_]);
        // Only those near the other patch.
        struct Near {
            std::uint32_t triangle;
            Box box;
        };
        const auto nearOnes = [&](std::span<const std::uint32_t> triangles, const Box& box, std::span<Near> near) {
            std::size_t n = 0;
            for (const std::uint32_t t : triangles)
                if (const Box own = boxOf(t); own.meets(box)) near[n++] = {t, own};
            return near.first(n);
        };
        std::array<Near, kRun> one_near, other_near;
        const std::span<const Near> ones = nearOnes(one, box_[j], one_near),
                                    others = nearOnes(other, box_[i], other_near);
        const auto positionOf = [&](std::uint32_t v) { return at(v); };
        for (std::size_t m = 0; m < ones.size(); ++m)
            for (std::size_t k = i == j ? m + 1 : 0; k < others.size(); ++k) {
                const std::uint32_t s = ones[m].triangle, t = others[k].triangle;
                if (ones[m].box.meets(others[k].box) && cross(mesh_.triangles[s], mesh_.triangles[t], positionOf))
                    out.push_back({std::min(s, t), std::max(s, t)});
            }
    }

    const BetaMesh& mesh_;
    std::vector<Vec3> direction_;          // at most 64
    std::vector<std::uint32_t> triangle_;  // patch by patch
    std::vector<Patch> patch_;             // in the order of leaves
    std::size_t first_leaf_ = 1;           // a power of two; node 1 is the root, those below i are 2i and 2i + 1
    std::vector<Box> box_;
    std::vector<std::uint64_t> facing_;
    std::vector<std::uint8_t> awake_;
};

// The share of the ways of six vertices up to which their triangles do not cross; none where they do from the start.
std::optional<Rate> freeShare(const Triangle& s, const Triangle& t, const std::vector<Moving>& from,
                              const std::vector<Moving>& to, double radius) {
    const auto crossAt = [&](double share, double time) {
        return cross(s, t, [&](std::uint32_t v) {
            const Moving way = to[v] - from[v];
            const Moving there = from[v] + way * share;
            return there.position + there.velocity * time;
        });
    };
    const auto lastFree = [&](double free, double crossing, double time) {
        for (int i = 0; i < kHalvings; ++i) {
            const double middle = (free + crossing) / 2;
            (crossAt(middle, time) ? crossing : free) = middle;
        }
        return free;
    };
    if (crossAt(0, 0)) return std::nullopt;
    const double share = lastFree(0, 1, 0);
    double speed = 0, farthest = 0;
    for (const Triangle& triangle : {s, t})
        for (const std::uint32_t v : triangle) {
            speed = std::max({speed, from[v].velocity.length(), to[v].velocity.length()});
            farthest = std::max(farthest, (to[v].position - from[v].position).length());
        }
    if (speed == 0) return share * kShortOf;
    const double step = kStepOfTime * radius / speed, low = share - kFarthestOff, high = share + kFarthestOff;
    if (crossAt(low, step) || !crossAt(high, step)) return share * kShortOf;
    const double rate = (lastFree(low, high, step) - share) / step, largest = kFastest * speed / farthest;
    return Rate(share, std::clamp(rate, -largest, largest)) * kShortOf;
}

// Where vertices go: past the mean way of all that is near them, which parts nobody, a share of what remains.
class Ways {
public:
    Ways(const std::vector<Moving>& from, double radius, const BetaMesh& mesh)
        : from_(from),
          radius_(radius),
          rising_(mesh.rising),
          base_(from),
          to_(mesh.vertex),
          rising_of_(from.size(), kNone),
          share_(from.size(), Rate(1)),
          based_(from.size(), 0) {
        for (std::uint32_t i = 0; i < rising_.size(); ++i) rising_of_[rising_[i].vertex] = i;
    }

    // Vertices of triangles that are awake, if they have not been before.
    void takeMeanWay(const PatchTree& tree) {
        struct Piece {
            Moving middle, way;
            double area;
        };
        std::vector<Piece> piece;
        std::vector<std::uint32_t> vertices;
        tree.forTrianglesAwake([&](const Triangle& t) {
            const Moving &a = from_[t[0]], &b = from_[t[1]], &c = from_[t[2]];
            piece.push_back({(a + b + c) * (1.0 / 3), (to_[t[0]] + to_[t[1]] + to_[t[2]] - a - b - c) * (1.0 / 3),
                             betamesh::cross(b.position - a.position, c.position - a.position).length()});
            for (const std::uint32_t v : t)
                if (!based_[v]) {
                    based_[v] = 1;
                    vertices.push_back(v);
                }
        });
        const double width = kMeanWidth * radius_;
        const CellOrder order(piece.size(), width, [&](std::size_t i) { return piece[i].middle.position; });
        const double inverse_square = 1 / (width * width);
        parallelFor(vertices.size(), 64, [&](std::size_t i) {
            const Moving& at = from_[vertices[i]];
            Moving sum;
            Rate weight = 0;
            order.forRowsIn(at.position - Vec3(width), at.position + Vec3(width), [&](std::uint32_t row) {
                const Moving apart = piece[row].middle - at;
                const Rate t = 1 - dot(apart, apart) * inverse_square;
                if (t.value <= 0) return;
                const Rate w = t * t * piece[row].area;
                sum = sum + piece[row].way * w;
                weight = weight + w;
            });
            if (weight.value > 0) base_[vertices[i]] = at + sum / weight;
        });
    }
    // Of the vertices of crossing triangles, and of those that they rise from; where the mean way is no way out, from
    // where they come from. Returns whether any went back.
    bool shorten(const BetaMesh& mesh, const std::vector<Pair>& pairs, bool all_the_way) {
        std::vector<std::optional<Rate>> limits(pairs.size());
        if (!all_the_way)
            parallelFor(pairs.size(), 16, [&](std::size_t i) {
                limits[i] =
                    freeShare(mesh.triangles[pairs[i][0]], mesh.triangles[pairs[i][1]], base_, mesh.vertex, radius_);
            });
        const std::vector<Rate> before = share_;
        bool any = false;
        const auto limit = [&](std::uint32_t v, const std::optional<Rate>& by) {
            if (by || all_the_way) any |= lower(v, by ? before[v] * *by : Rate(0));
            if (by || base_[v].position == from_[v].position) return;
            base_[v] = from_[v];
            any = true;
        };
        for (std::size_t i = 0; i < pairs.size(); ++i)
            for (const std::uint32_t t : pairs[i])
                for (const std::uint32_t v : mesh.triangles[t]) {
                    limit(v, limits[i]);
                    if (rising_of_[v] != kNone)
                        for (const std::uint32_t u : rising_[rising_of_[v]].from) limit(u, limits[i]);
                }
        return any;
    }
    // Along the edges of triangles that are awake.
    void spread(const PatchTree& tree) {
        for (bool more = true; more;) {
            more = false;
            tree.forTrianglesAwake([&](const Triangle& t) {
                for (std::size_t m = 0; m < 3; ++m) {
                    const std::uint32_t u = t[m], v = t[(m + 1) % 3];
                    if (share_[u].value >= 1 && share_[v].value >= 1) continue;
                    const Rate apart = length(from_[u] - from_[v]) / Rate(radius_);
                    more |= lower(u, share_[v] + apart);
                    more |= lower(v, share_[u] + apart);
                }
            });
        }
    }
    Moving placeOf(std::uint32_t v) const {
        const Moving way = to_[v] - base_[v];
        if (rising_of_[v] == kNone) return base_[v] + way * share_[v];
        const RisingVertex& rising = rising_[rising_of_[v]];
        Rate below = 0;
        for (std::size_t k = 0; k < 3; ++k) below = below + share_[rising.from[k]] * rising.weight[k];
        return base_[v] + way * (share_[v] * rising.share + below * (1 - rising.share));
    }

private:
    static constexpr std::uint32_t kNone = ~std::uint32_t{0};

    bool lower(std::uint32_t v, Rate share) {
        if (!(share.value < share_[v].value)) return false;
        share_[v] = share;
        return true;
    }

    const std::vector<Moving>& from_;
    double radius_;
    const std::vector<RisingVertex>& rising_;
    std::vector<Moving> base_, to_;
    std::vector<std::uint32_t> rising_of_;
    std::vector<Rate> share_;  // of the way from base_ to to_
    std::vector<std::uint8_t> based_;
};

}  // namespace

void keepApart(const std::vector<Moving>& from, double radius, BetaMesh& mesh) {
    if (mesh.triangles.empty()) return;
    PatchTree tree(mesh, from, radius);
    std::vector<Pair> pairs = tree.crossings();
    if (pairs.empty()) return;
    Ways ways(from, radius, mesh);
    const auto wakeNear = [&](const Pair& pair, double distance) {
        for (const std::uint32_t t : pair) {
            Box box;
            for (const std::uint32_t v : mesh.triangles[t]) {
                box.extend(from[v].position);
                box.extend(mesh.vertex[v].position);
            }
            tree.wake(box, distance);
        }
    };
    for (int round = 0; !pairs.empty(); ++round) {
        tree.sleep();
        for (const Pair& pair : pairs) wakeNear(pair, radius);
        ways.takeMeanWay(tree);
        if (!ways.shorten(mesh, pairs, round >= kRounds) && round >= kRounds) return;
        ways.spread(tree);
        const auto moves = [&](std::uint32_t v) { return mesh.vertex[v].position != ways.placeOf(v).position; };
        if (round > 0) {
            tree.sleepUnless([&](const Triangle& t) { return moves(t[0]) || moves(t[1]) || moves(t[2]); });
            for (const Pair& pair : pairs) wakeNear(pair, 0);
        }
        tree.forTrianglesAwake([&](const Triangle& t) {
            for (const std::uint32_t v : t) mesh.vertex[v] = ways.placeOf(v);
        });
        tree.refit();
        pairs = tree.crossings();
    }
}

}  // namespace betamesh
