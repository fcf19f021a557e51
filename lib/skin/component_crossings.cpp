
#include "skin/component_crossings.h"

#include "base/compressed_rows.h"
#include "base/parallel.h"
#include "base/simd.h"
#include "base/union_find.h"
#include "skin/star_shaped.h"
#include "skin/triangle_run.h"

#include <algorithm>

namespace betamesh {

namespace {

constexpr std::size_t kMaxBalls = 64;        // of components that are examined
constexpr std::size_t kMaxTriangles = 4096;  // of those whose triangles are all compared
constexpr float kSteps = 126;                // along each axis of a component's box: below 2^7
constexpr std::uint8_t kTopBit = 0x80;
constexpr float kOverAPlane = 0.05F;  // least cosine to a plane's normal of triangles that count as over that plane

template <std::size_t kWidth>
using Bytes = typename VectorOf<std::uint8_t, kWidth>::Type;

}  // namespace

// Marks with kTopBit the triangles of a block whose boxes meet that of a given one. With seven bits per number, the top
// bit of a difference tells which of two numbers is larger; g++ would split comparisons of bytes into scalar code.
struct ComponentCrossings::MarkNear {
    const StepBox& box;
    const Block& block;
    std::array<std::uint8_t, kBlock>& near;

    template <std::size_t kFloats>
    __attribute__((always_inline)) void operator()() const {
        constexpr std::size_t kWidth = kFloats * sizeof(float);
        for (std::size_t first = 0; first < kBlock; first += kWidth) {
            Bytes<kWidth> column, excluded{};
            for (std::size_t k = 0; k < 3; ++k) {
                std::memcpy(&column, &block.low[k][first], kWidth);
                excluded |= box.high[k] - column;
                std::memcpy(&column, &block.high[k][first], kWidth);
                excluded |= column - box.low[k];
            }
            const Bytes<kWidth> marks = ~excluded & kTopBit;
            std::memcpy(&near[first], &marks, kWidth);
        }
    }
};

bool ComponentCrossings::crossesNothing(std::span<const TriangleRange> parts) {
    if (!gather(parts)) return false;
    makeBlocks();
    return !crossesItself() && !hasFoldedOneRing();
}

// Returns false if a triangle has turned over.
bool ComponentCrossings::gather(std::span<const TriangleRange> parts) {
    triangle_.clear();
    facing_.clear();
    normal_.clear();
    box_.clear();
    for (const auto& [begin, end] : parts)
        for (std::uint32_t first = begin; first < end; first += kRun) {
            const std::uint32_t size = std::min<std::uint32_t>(kRun, end - first);
            const TriangleRun run(mesh_, before_, first, size);
            for (std::uint32_t i = 0; i < size; ++i) {
                if (run.turned[i]) return false;
                triangle_.push_back(first + i);
                facing_.push_back(run.facing[i]);
                normal_.emplace_back(run.normal[0][i], run.normal[1][i], run.normal[2][i]);
                box_.push_back(run.box(i));
            }
        }
    return true;
}

void ComponentCrossings::makeBlocks() {
    Boxf whole;
    for (const Boxf& box : box_) whole.extendBy(box);
    Vec3f scale;
    for (int k = 0; k < 3; ++k) scale[k] = whole.max[k] > whole.min[k] ? kSteps / (whole.max[k] - whole.min[k]) : 0;
    const auto inSteps = [&](const Vec3f& corner) {
        std::array<std::uint8_t, 3> steps;
        for (int k = 0; k < 3; ++k) {
            const float step = (corner[k] - whole.min[k]) * scale[k];  // not a number if coordinates overflow
            steps[static_cast<std::size_t>(k)] = static_cast<std::uint8_t>(step < kSteps ? step : kSteps);
        }
        return steps;
    };
    step_box_.clear();
    for (const Boxf& box : box_) step_box_.push_back({inSteps(box.min), inSteps(box.max)});

    block_.assign((triangle_.size() + kBlock - 1) / kBlock, {});
    for (std::size_t i = 0; i < block_.size() * kBlock; ++i) {
        const bool exists = i < triangle_.size();
        const StepBox box = exists ? step_box_[i] : StepBox();  // which meets no other
        Block& block = block_[i / kBlock];
        for (std::size_t k = 0; k < 3; ++k) {
            block.low[k][i % kBlock] = box.low[k];
            block.high[k][i % kBlock] = box.high[k];
            block.box.low[k] = std::min(block.box.low[k], box.low[k]);
            block.box.high[k] = std::max(block.box.high[k], box.high[k]);
        }
    }
}

std::size_t ComponentCrossings::commonCorners(std::size_t row, std::size_t other) const {
    std::size_t common = 0;
    for (const std::uint32_t u : mesh_.triangles[triangle_[row]])
        for (const std::uint32_t v : mesh_.triangles[triangle_[other]]) common += u == v;
    return common;
}

bool ComponentCrossings::mayCross(std::size_t row, std::size_t other, bool even_if_touching) const {
    if (((facing_[row] | facing_[other]) & kFlat) != 0) return false;
    const Triangle &s = mesh_.triangles[triangle_[row]], &t = mesh_.triangles[triangle_[other]];
    const TriangleRelation relation = relationOf(s, t, [&](std::uint32_t v) { return mesh_.vertex[v].position; });
    if (relation != TriangleRelation::undecided) return relation == TriangleRelation::crossing;
    return even_if_touching && !isFlat(mesh_.vertex, s) && !isFlat(mesh_.vertex, t);
}

bool ComponentCrossings::crossesItself() const {
    std::array<std::uint8_t, kBlock> near;
    for (std::size_t i = 0; i < triangle_.size(); ++i)
        for (std::size_t b = i / kBlock; b < block_.size(); ++b) {
            if (!step_box_[i].intersects(block_[b].box)) continue;
            onThisCpu(MarkNear{step_box_[i], block_[b], near});
            for (std::size_t first = 0; first < kBlock; first += sizeof(std::uint64_t)) {
                std::uint64_t any;
                std::memcpy(&any, &near[first], sizeof any);
                if (any == 0) continue;
                for (std::size_t k = first; k < first + sizeof any; ++k) {
                    const std::size_t j = b * kBlock + k;
                    if (near[k] == 0 || j <= i || !box_[i].intersects(box_[j])) continue;
                    const bool face_alike = (facing_[i] & facing_[j]) != 0;
                    if (face_alike && commonCorners(i, j) > 0) continue;  // hasFoldedOneRing() tells
                    if (mayCross(i, j, !face_alike)) return true;
                }
            }
        }
    return false;
}

// Tests the mean normal of a one-ring: the fixed directions of masks may be 20 degrees away from the best plane.
bool ComponentCrossings::isOverAPlane(std::span<const Corner> one_ring) const {
    Vec3f sum(0);
    for (const Corner& corner : one_ring) sum += normal_[corner.row];
    const float least = kOverAPlane * sum.length();
    return std::all_of(one_ring.begin(), one_ring.end(), [&](const Corner& corner) {
        const Vec3f& normal = normal_[corner.row];
        return normal.dot(sum) > least || normal == Vec3f(0);
    });
}

// Where the triangles at a vertex face no common direction, two of them that do face one may cross: masks would miss
// that.
bool ComponentCrossings::hasFoldedOneRing() {
    std::uint64_t* const facing = facing_of_vertices_.data();
    for (const std::uint32_t t : triangle_)
        for (const std::uint32_t v : mesh_.triangles[t]) facing[v] = ~std::uint64_t{0};
    for (std::size_t i = 0; i < triangle_.size(); ++i)
        for (const std::uint32_t v : mesh_.triangles[triangle_[i]]) facing[v] &= facing_[i];
    corner_.clear();
    for (std::uint32_t i = 0; i < triangle_.size(); ++i)
        for (const std::uint32_t v : mesh_.triangles[triangle_[i]])
            if (facing[v] == 0) corner_.push_back({v, i});
    std::sort(corner_.begin(), corner_.end(), [](const Corner& a, const Corner& b) {
        return a.vertex != b.vertex ? a.vertex < b.vertex : a.row < b.row;
    });
    const auto shareEdge = [&](std::size_t row, std::size_t other) {  // and therefore cannot cross
        return commonCorners(row, other) > 1;
    };
    for (std::size_t begin = 0, end; begin < corner_.size(); begin = end) {
        end = begin + 1;
        while (end < corner_.size() && corner_[end].vertex == corner_[begin].vertex) ++end;
        const std::span<const Corner> one_ring(&corner_[begin], end - begin);
        if (isOverAPlane(one_ring)) continue;
        for (std::size_t i = 0; i < one_ring.size(); ++i)
            for (std::size_t j = i + 1; j < one_ring.size(); ++j) {
                const std::size_t one = one_ring[i].row, other = one_ring[j].row;
                if ((facing_[one] & facing_[other]) != 0 && !shareEdge(one, other) && mayCross(one, other, true))
                    return true;
            }
    }
    return false;
}

std::vector<PatchTree::ComponentPart> crossingFreeComponents(const BallBoundary& boundary,
                                                             const std::vector<Vec3>& before, const BetaMesh& mesh) {
    if (mesh.ball_begin.empty()) return {};
    const auto balls = static_cast<std::uint32_t>(boundary.position.size());
    UnionFind connected(balls);
    for (const auto& [a, b, c] : boundary.triangle) {
        connected.join(a, b);
        connected.join(a, c);
    }
    for (const auto& [a, b] : boundary.circle) connected.join(a, b);
    std::vector<std::uint32_t> first(balls);  // ball of the component of each
    for (std::uint32_t b = 0; b < balls; ++b) first[b] = connected.find(b);
    const IndexRows members = sortedIntoRows<std::uint32_t>(
        balls, balls, [&](std::size_t b, const auto& visit) { visit(first[b], static_cast<std::uint32_t>(b)); });

    std::vector<std::uint8_t> is_free(balls, 0);
    const auto facing_of_vertices = std::make_unique_for_overwrite<std::uint64_t[]>(mesh.vertex.size());
    parallelRanges(balls, 256, [&](std::size_t begin, std::size_t end) {
        std::vector<std::array<Vec3, 3>> triangles;
        std::vector<TriangleRange> ranges;
        ComponentCrossings check(mesh, before, {facing_of_vertices.get(), mesh.vertex.size()});
        for (std::size_t b = begin; b < end; ++b) {
            const std::span<const std::uint32_t> component = members[b];
            if (component.empty() || component.size() > kMaxBalls) continue;
            Vec3 middle(0);
            triangles.clear();
            ranges.clear();
            for (const std::uint32_t ball : component) {
                middle += boundary.centre(ball) / static_cast<double>(component.size());
                ranges.push_back({mesh.ball_begin[ball], mesh.ball_begin[ball + 1]});
                for (std::uint32_t t = mesh.ball_begin[ball]; t < mesh.ball_begin[ball + 1]; ++t) {
                    const auto at = [&](std::size_t k) { return mesh.vertex[mesh.triangles[t][k]].position; };
                    triangles.push_back({at(0), at(1), at(2)});
                }
            }
            is_free[b] =
                isStarShaped(middle, triangles) || (triangles.size() <= kMaxTriangles && check.crossesNothing(ranges));
        }
    });
    std::vector<PatchTree::ComponentPart> parts;
    for (std::uint32_t b = 0; b < balls; ++b)
        if (is_free[first[b]] && mesh.ball_begin[b] < mesh.ball_begin[b + 1])
            parts.push_back({mesh.ball_begin[b], mesh.ball_begin[b + 1], first[b] + 1});
    return parts;
}

}  // namespace betamesh
