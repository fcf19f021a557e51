
#include "skin/patch_tree.h"

#include "base/compressed_rows.h"
#include "base/parallel.h"
#include "exact/orientation.h"
#include "skin/triangle_run.h"

#include <algorithm>
#include <bit>
#include <bitset>
#include <utility>

namespace betamesh {

namespace {

constexpr int kCommonDirections = 6;  // a run with fewer in common is divided by the octants of its normals
constexpr double kNearTurned = 0.3;   // radii around a triangle that has turned over within which masks are ignored
constexpr std::uint32_t kMaxPerTask = 256 * kRun;  // triangles
constexpr std::size_t kMinTasks = 512;             // of the search, where there are enough nodes

// Extends a box to a point, whatever its rounding.
void extend(Boxf& box, const Vec3& point) {
    for (int k = 0; k < 3; ++k) {
        const auto x = static_cast<float>(point[k]);
        box.min[k] = std::min(box.min[k], justBelow(x));
        box.max[k] = std::max(box.max[k], justAbove(x));
    }
}

// The sides of a triangle's plane, -1, 0 or 1, of the corners of another; 0 for common corners.
std::array<int, 3> sidesOf(const std::array<Vec3, 3>& plane, const std::array<Vec3, 3>& corner,
                           const std::array<bool, 3>& common) {
    std::array<int, 3> sides;
    for (std::size_t m = 0; m < 3; ++m) sides[m] = common[m] ? 0 : sideOfPlane(plane[0], plane[1], plane[2], corner[m]);
    return sides;
}

// Is an edge in the plane, other than one that the triangles share?
bool hasEdgeInPlane(const std::array<int, 3>& side, const std::array<bool, 3>& common) {
    int corners = 0, own = 0;
    for (std::size_t m = 0; m < 3; ++m) {
        corners += side[m] == 0;
        own += side[m] == 0 && !common[m];
    }
    return corners >= 2 && own >= 1;
}

// Does an edge pass from one side of the triangle to the other through its interior or boundary?
bool pierces(const std::array<Vec3, 3>& corner, const std::array<int, 3>& side, const std::array<Vec3, 3>& t) {
    for (std::size_t m = 0; m < 3; ++m) {
        const std::size_t next = (m + 1) % 3;
        if (side[m] * side[next] >= 0) continue;
        const Vec3 &p = corner[m], &q = corner[next];
        const int a = sideOfPlane(p, q, t[0], t[1]), b = sideOfPlane(p, q, t[1], t[2]);
        if (a * b < 0) continue;
        const int c = sideOfPlane(p, q, t[2], t[0]);
        if (a * c >= 0 && b * c >= 0) return true;
    }
    return false;
}

}  // namespace

TriangleRelation relationOf(const std::array<Vec3, 3>& s, const std::array<Vec3, 3>& t,
                            const std::array<bool, 3>& s_common, const std::array<bool, 3>& t_common) {
    const std::array<int, 3> t_side = sidesOf(s, t, t_common);
    const bool above = std::count(t_side.begin(), t_side.end(), 1) > 0,
               below = std::count(t_side.begin(), t_side.end(), -1) > 0;
    bool touching = hasEdgeInPlane(t_side, t_common);
    if (!touching && (!above || !below)) return TriangleRelation::apart;
    const std::array<int, 3> s_side = sidesOf(t, s, s_common);
    if (pierces(t, t_side, s) || pierces(s, s_side, t)) return TriangleRelation::crossing;
    touching = touching || hasEdgeInPlane(s_side, s_common);
    return touching ? TriangleRelation::undecided : TriangleRelation::apart;
}

PatchTree::PatchTree(const BetaMesh& mesh, const std::vector<Vec3>& before, double radius,
                     std::span<const ComponentPart> components)
    : mesh_(mesh) {
    const std::vector<Patch> patches = makePatches(before, components);
    std::vector<Box> folded;
    parallelFor(2, 1, [&](std::size_t task) {  // both are partly serial
        if (task == 0)
            folded = foldedOneRings(patches);
        else
            makeTree(patches);
    });
    for (const Patch& patch : patches)
        if (patch.turned) activate({Vec3(patch.node.box.min), Vec3(patch.node.box.max)}, kNearTurned * radius);
    for (const Box& vertex : folded) activate(vertex, 0);
}

void PatchTree::makeTree(const std::vector<Patch>& patches) {
    Boxf whole;
    for (const Patch& patch : patches) whole.extendBy(patch.node.box);
    struct CurvePosition {
        std::uint64_t on_curve;  // a space-filling curve through all patches
        std::uint32_t patch;
    };
    std::vector<CurvePosition> sorted;
    firstTouchResize(sorted, patches.size());
    parallelFor(patches.size(), 1024, [&](std::size_t p) {
        sorted[p] = {mortonCode(patches[p].node.box, whole), static_cast<std::uint32_t>(p)};
    });
    parallelSort(sorted, [](const CurvePosition& a, const CurvePosition& b) {
        return a.on_curve != b.on_curve ? a.on_curve < b.on_curve : a.patch < b.patch;
    });

    // Leaves of a heap one level deeper than the others are the leftmost ones.
    const std::size_t n = patches.size(), first_on_the_left = std::bit_ceil(std::max<std::size_t>(n, 1)) - n;
    first_leaf_ = std::max<std::size_t>(n, 1);
    firstTouchResize(node_, 2 * first_leaf_);
    firstTouchResize(range_, n);
    parallelFor(n, 1024, [&](std::size_t p) {
        const Patch& patch = patches[sorted[p].patch];
        const std::size_t leaf = (first_on_the_left + p) % n;
        range_[leaf] = patch.range;
        node_[first_leaf_ + leaf] = patch.node;
    });
    for (std::size_t i = first_leaf_ - 1; i > 0; --i) {
        const Node &a = node_[2 * i], &b = node_[2 * i + 1];
        node_[i].component = a.component == b.component ? a.component : 0;
    }
    gatherBoxes();
    gatherActive();
}

// Vertices whose triangles face no common direction, where two triangles that do face one cross: masks would miss that.
std::vector<Box> PatchTree::foldedOneRings(const std::vector<Patch>& patches) const {
    std::vector<std::uint64_t> facing(mesh_.vertex.size(), ~std::uint64_t{0});
    for (const Patch& patch : patches) {
        if (patch.node.component) continue;
        for (std::uint32_t i = patch.range.begin; i < patch.range.end; ++i)
            for (const std::uint32_t v : mesh_.triangles[triangle_[i]]) facing[v] &= facing_[i];
    }

    const IndexRows entries =
        sortedIntoRows<std::uint32_t>(mesh_.vertex.size(), patches.size(), [&](std::size_t p, const auto& visit) {
            const Patch& patch = patches[p];
            if (!patch.node.active || patch.node.component) return;
            for (std::uint32_t i = patch.range.begin; i < patch.range.end; ++i)
                for (const std::uint32_t v : mesh_.triangles[triangle_[i]])
                    if (facing[v] == 0) visit(v, i);
        });

    const auto positionOf = [&](std::uint32_t v) { return mesh_.vertex[v].position; };
    std::vector<std::uint8_t> folded(mesh_.vertex.size(), 0);
    parallelFor(mesh_.vertex.size(), 4096, [&](std::size_t v) {
        const std::span<const std::uint32_t> ring = entries[v];
        for (std::size_t i = 0; i < ring.size(); ++i)
            for (std::size_t j = i + 1; j < ring.size(); ++j) {
                if ((facing_[ring[i]] & facing_[ring[j]]) == 0) continue;
                const std::uint32_t one = triangle_[ring[i]], other = triangle_[ring[j]];
                if (relationOf(mesh_.triangles[one], mesh_.triangles[other], positionOf) == TriangleRelation::crossing)
                    folded[v] = 1;
            }
    });
    std::vector<Box> vertices;
    for (std::size_t v = 0; v < folded.size(); ++v)
        if (folded[v]) vertices.emplace_back(mesh_.vertex[v].position);
    return vertices;
}

// Adds the patches of a run of triangles, which are near each other because the mesh is made ball by ball.
void PatchTree::addPatches(const std::vector<Vec3>& before, std::uint32_t begin, std::uint32_t size,
                           std::vector<Patch>& into) {
    const TriangleRun run(mesh_, before, begin, size);
    std::array<std::uint8_t, kRun> octant{};
    std::uint64_t in_common = ~std::uint64_t{0};
    for (std::uint32_t i = 0; i < size; ++i) in_common &= run.facing[i];
    if (std::popcount(in_common) < kCommonDirections) octant = run.octant;
    std::uint32_t placed = 0;
    for (std::uint8_t wanted = 0; placed < size; ++wanted) {
        Patch patch{{begin + placed, 0}, {}, false};
        for (std::uint32_t k = 0; k < size; ++k) {
            if (octant[k] != wanted) continue;
            triangle_[begin + placed] = begin + k;
            facing_[begin + placed++] = run.facing[k];
            patch.node.box.extendBy(run.box(k));
            patch.node.active |= run.moved[k];
            patch.turned |= run.turned[k];
            patch.node.facing &= run.facing[k];
        }
        patch.range.end = begin + placed;
        if (patch.range.begin < patch.range.end) into.push_back(patch);
    }
}

void PatchTree::addComponentPart(const std::vector<Vec3>& before, const ComponentPart& part, std::vector<Patch>& into) {
    Patch patch{{part.begin, part.end}, {}, false};
    patch.node.component = part.component;
    patch.node.facing = 0;  // no common direction
    for (std::uint32_t t = part.begin; t < part.end; ++t) {
        triangle_[t] = t;
        facing_[t] = 0;
        patch.node.box.extendBy(boxOf(t));
        for (const std::uint32_t v : mesh_.triangles[t]) patch.node.active |= before[v] != mesh_.vertex[v].position;
    }
    into.push_back(patch);
}

// The end of a run of triangles. Runs do not continue past a ball with many triangles: the next ball faces elsewhere.
std::uint32_t PatchTree::endOfRun(std::uint32_t begin, std::uint32_t end) const {
    end = std::min(end, begin + static_cast<std::uint32_t>(kRun));
    const std::vector<std::uint32_t>& balls = mesh_.ball_begin;
    const auto next = std::upper_bound(balls.begin(), balls.end(), begin);
    const bool many = next != balls.begin() && next != balls.end() && *next - *std::prev(next) >= kRun;
    return many ? std::min(end, *next) : end;
}

std::vector<PatchTree::Patch> PatchTree::makePatches(const std::vector<Vec3>& before,
                                                     std::span<const ComponentPart> components) {
    const auto n = static_cast<std::uint32_t>(mesh_.triangles.size());
    triangle_ = std::make_unique_for_overwrite<std::uint32_t[]>(n);
    facing_ = std::make_unique_for_overwrite<std::uint64_t[]>(n);
    std::vector<ComponentPart> parts;  // and, as component 0, what is between them
    std::uint32_t done = 0;
    const auto addOthers = [&](std::uint32_t end) {
        for (; done < end; done = parts.back().end) parts.push_back({done, std::min(end, done + kMaxPerTask), 0});
    };
    for (const ComponentPart& part : components) {
        addOthers(part.begin);
        parts.push_back(part);
        done = part.end;
    }
    addOthers(n);
    std::vector<std::size_t> first_part = {0};  // of each task
    std::uint32_t first = 0;
    for (std::size_t p = 0; p < parts.size(); ++p)
        if (parts[p].end - first >= kMaxPerTask) {
            first_part.push_back(p + 1);
            first = parts[p].end;
        }
    if (first_part.back() < parts.size()) first_part.push_back(parts.size());

    std::vector<std::vector<Patch>> of_task(first_part.size() - 1);
    parallelFor(of_task.size(), 1, [&](std::size_t task) {
        for (std::size_t p = first_part[task]; p < first_part[task + 1]; ++p) {
            const auto& [begin, end, component] = parts[p];
            if (component)
                addComponentPart(before, parts[p], of_task[task]);
            else
                for (std::uint32_t run = begin, next; run < end; run = next) {
                    next = endOfRun(run, end);
                    addPatches(before, run, next - run, of_task[task]);
                }
        }
    });
    return concatenate(of_task);
}

Boxf PatchTree::boxOf(std::uint32_t triangle) const {
    const auto& [a, b, c] = mesh_.triangles[triangle];
    const Vec3 &p = mesh_.vertex[a].position, &q = mesh_.vertex[b].position, &r = mesh_.vertex[c].position;
    Boxf box;
    for (int k = 0; k < 3; ++k) {
        box.min[k] = justBelow(static_cast<float>(std::min({p[k], q[k], r[k]})));
        box.max[k] = justAbove(static_cast<float>(std::max({p[k], q[k], r[k]})));
    }
    return box;
}

void PatchTree::gatherBoxes() {
    for (std::size_t i = first_leaf_ - 1; i > 0; --i) {
        node_[i].box = node_[2 * i].box;
        node_[i].box.extendBy(node_[2 * i + 1].box);
    }
}

void PatchTree::gatherActive() {
    for (std::size_t i = first_leaf_ - 1; i > 0; --i) node_[i].active = node_[2 * i].active | node_[2 * i + 1].active;
}

void PatchTree::deactivateAll() {
    for (Node& node : node_) node.active = 0;
}

void PatchTree::activate(const Box& box, double distance) {
    Boxf around;
    extend(around, box.min - Vec3(distance));
    extend(around, box.max + Vec3(distance));
    std::vector<std::size_t> stack = {1};
    while (!stack.empty()) {
        const std::size_t i = stack.back();
        stack.pop_back();
        if (!node_[i].box.intersects(around)) continue;
        node_[i].active = 1;
        if (i < first_leaf_) stack.insert(stack.end(), {2 * i, 2 * i + 1});
        if (std::exchange(node_[i].was_activated, true)) continue;
        node_[i].facing = 0;
        node_[i].component = 0;
        if (i < first_leaf_) continue;
        for (std::uint32_t k = range_[i - first_leaf_].begin; k < range_[i - first_leaf_].end; ++k) facing_[k] &= kFlat;
    }
}

void PatchTree::refit() {
    parallelFor(patches(), 64, [&](std::size_t p) {
        Node& node = node_[first_leaf_ + p];
        if (!node.active) return;
        node.box.makeEmpty();
        for (std::uint32_t i = range_[p].begin; i < range_[p].end; ++i) {
            facing_[i] &= ~kFlat;
            node.box.extendBy(boxOf(triangle_[i]));
        }
    });
    gatherBoxes();
}

CandidatePairs PatchTree::candidatePairs() const {
    std::vector<TrianglePair> tasks = {{1, 1}};  // of nodes
    for (bool coarse = true; coarse && tasks.size() < kMinTasks;) {
        std::vector<TrianglePair> finer;
        coarse = false;
        for (const TrianglePair& task : tasks) {
            if (areLeaves(task)) {
                finer.push_back(task);
            } else {
                descend(task, finer);
                coarse = true;
            }
        }
        tasks = std::move(finer);
    }
    std::vector<CandidatePairs> found(tasks.size());
    parallelFor(tasks.size(), 1, [&](std::size_t i) {
        std::vector<TrianglePair> stack = {tasks[i]};
        while (!stack.empty()) {
            const TrianglePair task = stack.back();
            stack.pop_back();
            if (areLeaves(task))
                addPairs(task, found[i]);
            else
                descend(task, stack);
        }
    });
    CandidatePairs all{concatenate(found, &CandidatePairs::crossing), concatenate(found, &CandidatePairs::undecided)};
    std::sort(all.crossing.begin(), all.crossing.end());
    std::sort(all.undecided.begin(), all.undecided.end());
    return all;
}

// Adds the pairs of nodes to be examined instead of this one.
void PatchTree::descend(const TrianglePair& nodes, std::vector<TrianglePair>& into) const {
    const auto [i, j] = nodes;
    const auto add = [&](std::uint32_t first, std::uint32_t second) {
        const Node &a = node_[first], &b = node_[second];
        const bool in_one_component = a.component != 0 && a.component == b.component;
        if (!in_one_component && (a.active || b.active) && a.box.intersects(b.box)) into.push_back({first, second});
    };
    if (i == j) {
        add(2 * i, 2 * i);
        add(2 * i + 1, 2 * i + 1);
        add(2 * i, 2 * i + 1);
    } else if (j < i || i >= first_leaf_) {  // the node with the larger number is not above the other
        add(i, 2 * j);
        add(i, 2 * j + 1);
    } else {
        add(2 * i, j);
        add(2 * i + 1, j);
    }
}

// Do two patches have a vertex in common?
bool PatchTree::areConnected(const Range& one, const Range& other) const {
    if (one.end - one.begin > kRun || other.end - other.begin > kRun) return false;  // parts of components
    std::array<std::uint32_t, 3 * kRun> corners;
    std::bitset<256> residues;  // of the corners: most others differ in these
    std::size_t n = 0;
    for (const std::uint32_t t : trianglesOf(one))
        for (const std::uint32_t v : mesh_.triangles[t]) {
            corners[n++] = v;
            residues.set(v % residues.size());
        }
    for (const std::uint32_t t : trianglesOf(other))
        for (const std::uint32_t v : mesh_.triangles[t])
            if (residues[v % residues.size()] &&
                std::find(corners.begin(), corners.begin() + n, v) != corners.begin() + n)
                return true;
    return false;
}

// The triangles of a range whose boxes meet a box and that face none of some directions, written to `near`.
std::span<const PatchTree::Boxed> PatchTree::boxesNear(const Range& range, const Boxf& box, std::uint64_t directions,
                                                       std::span<Boxed> near) const {
    std::size_t n = 0;
    for (std::uint32_t i = range.begin; i < range.end; ++i) {
        if ((facing_[i] & (directions | kFlat)) != 0) continue;
        near[n] = {triangle_[i], facing_[i], boxOf(triangle_[i])};
        n += near[n].box.intersects(box);
    }
    return near.first(n);
}

void PatchTree::addPairs(const TrianglePair& leaves, CandidatePairs& out) const {
    const auto [i, j] = leaves;
    const auto positionOf = [&](std::uint32_t v) { return mesh_.vertex[v].position; };
    const auto flat = [&](std::uint32_t t) { return isFlat(mesh_.vertex, mesh_.triangles[t]); };
    std::array<Boxed, kRun> one_near, other_near;
    const Range first = range_[i - first_leaf_], second = range_[j - first_leaf_];
    const Node &a = node_[i], &b = node_[j];
    // Directions that two triangles must not both face: all where the patches are parts of one piece of surface.
    const std::uint64_t directions = i == j || areConnected(first, second) ? ~std::uint64_t{0} : 0;
    if ((a.facing & b.facing & directions) != 0) return;
    const auto runAt = [](const Range& range, std::uint32_t begin) {
        return Range{begin, std::min<std::uint32_t>(begin + kRun, range.end)};
    };
    for (std::uint32_t f = first.begin; f < first.end; f += kRun) {
        const std::span<const Boxed> ones = boxesNear(runAt(first, f), b.box, b.facing & directions, one_near);
        for (std::uint32_t g = i == j ? f : second.begin; g < second.end && !ones.empty(); g += kRun) {
            const std::span<const Boxed> others = boxesNear(runAt(second, g), a.box, a.facing & directions, other_near);
            for (std::size_t m = 0; m < ones.size(); ++m)
                for (std::size_t k = i == j && f == g ? m + 1 : 0; k < others.size(); ++k) {
                    const Boxed &one = ones[m], &other = others[k];
                    if ((one.facing & other.facing & directions) != 0 || !one.box.intersects(other.box)) continue;
                    const std::uint32_t s = one.triangle, t = other.triangle;
                    const TriangleRelation relation = relationOf(mesh_.triangles[s], mesh_.triangles[t], positionOf);
                    if (relation == TriangleRelation::apart) continue;
                    const bool face_alike = (one.facing & other.facing) != 0;
                    if (relation == TriangleRelation::undecided && (face_alike || flat(s) || flat(t))) continue;
                    (relation == TriangleRelation::crossing ? out.crossing : out.undecided)
                        .push_back({std::min(s, t), std::max(s, t)});
                }
        }
    }
}

}  // namespace betamesh
