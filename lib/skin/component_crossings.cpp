
#include "skin/component_crossings.h"

#include "base/simd.h"
#include "skin/patch_tree.h"
#include "skin/triangle_run.h"

#include <algorithm>

namespace betamesh {

namespace {

constexpr float kSteps = 126;  // of a body's box: below 2^7
constexpr std::uint8_t kTopBit = 0x80;
constexpr float kOverAPlane = 0.05F;  // cosine of the angle to its normal, within which triangles lie over a plane

template <std::size_t kWidth>
using Bytes = typename VectorOf<std::uint8_t, kWidth>::Type;

constexpr std::uint8_t sevenBits(std::uint64_t facing, std::size_t column) {
    return static_cast<std::uint8_t>(facing >> (7 * column) & 0x7f);
}

}  // namespace

// Marks the triangles of a block that may meet one with kTopBit: their boxes do, and they face no common way. Numbers
// of seven bits leave the top one to tell which of two is larger, and whether two have any in common: g++ takes
// comparisons of bytes apart.
struct ComponentCrossings::MarkNear {
    const StepBox& box;
    std::uint64_t facing;
    const Block& block;
    std::array<std::uint8_t, kBlock>& near;

    template <std::size_t kFloats>
    __attribute__((always_inline)) void operator()() const {
        constexpr std::size_t kWidth = kFloats * sizeof(float);
        for (std::size_t first = 0; first < kBlock; first += kWidth) {
            Bytes<kWidth> column, common{};
            for (std::size_t c = 0; c < kFacingColumns; ++c) {
                std::memcpy(&column, &block.facing[c][first], kWidth);
                common |= column & sevenBits(facing, c);
            }
            Bytes<kWidth> apart = common + static_cast<std::uint8_t>(kTopBit - 1);
            for (std::size_t k = 0; k < 3; ++k) {
                std::memcpy(&column, &block.low[k][first], kWidth);
                apart |= box.high[k] - column;
                std::memcpy(&column, &block.high[k][first], kWidth);
                apart |= column - box.low[k];
            }
            const Bytes<kWidth> marks = ~apart & kTopBit;
            std::memcpy(&near[first], &marks, kWidth);
        }
    }
};

bool ComponentCrossings::crossesNothing(std::span<const TriangleRange> parts) {
    if (!gather(parts)) return false;
    makeBlocks();
    return !meetsItself() && !foldsAtAVertex();
}

// Returns false where one has turned over.
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
            const float step = (corner[k] - whole.min[k]) * scale[k];  // not a number where floats end
            steps[static_cast<std::size_t>(k)] = static_cast<std::uint8_t>(step < kSteps ? step : kSteps);
        }
        return steps;
    };
    step_box_.clear();
    for (const Boxf& box : box_) step_box_.push_back({inSteps(box.min), inSteps(box.max)});

    block_.assign((triangle_.size() + kBlock - 1) / kBlock, {});
    for (std::size_t i = 0; i < block_.size() * kBlock; ++i) {
        const bool is_there = i < triangle_.size();
        const StepBox box = is_there ? step_box_[i] : StepBox();  // which meets none
        Block& block = block_[i / kBlock];
        for (std::size_t k = 0; k < 3; ++k) {
            block.low[k][i % kBlock] = box.low[k];
            block.high[k][i % kBlock] = box.high[k];
            block.box.low[k] = std::min(block.box.low[k], box.low[k]);
            block.box.high[k] = std::max(block.box.high[k], box.high[k]);
        }
        for (std::size_t c = 0; c < kFacingColumns; ++c)
            block.facing[c][i % kBlock] = sevenBits(is_there ? facing_[i] : 0, c);
    }
}

bool ComponentCrossings::mayCross(std::size_t row, std::size_t other) const {
    if (((facing_[row] | facing_[other]) & kFlat) != 0) return false;
    const Triangle &s = mesh_.triangles[triangle_[row]], &t = mesh_.triangles[triangle_[other]];
    const Meeting meeting = meetingOf(s, t, [&](std::uint32_t v) { return mesh_.vertex[v].position; });
    if (meeting != Meeting::doubtful) return meeting == Meeting::crossing;
    return !isFlat(mesh_.vertex, s) && !isFlat(mesh_.vertex, t);
}

bool ComponentCrossings::meetsItself() const {
    std::array<std::uint8_t, kBlock> near;
    for (std::size_t i = 0; i < triangle_.size(); ++i)
        for (std::size_t b = i / kBlock; b < block_.size(); ++b) {
            if (!step_box_[i].intersects(block_[b].box)) continue;
            onThisCpu(MarkNear{step_box_[i], facing_[i], block_[b], near});
            for (std::size_t first = 0; first < kBlock; first += sizeof(std::uint64_t)) {
                std::uint64_t any;
                std::memcpy(&any, &near[first], sizeof any);
                if (any == 0) continue;
                for (std::size_t k = first; k < first + sizeof any; ++k)
                    if (const std::size_t j = b * kBlock + k; near[k] && j > i && mayCross(i, j)) return true;
            }
        }
    return false;
}

// All triangles of a vertex, by a way of their own: the fixed ones lie some 20 degrees from any that is asked for.
bool ComponentCrossings::isOverAPlane(std::span<const Corner> star) const {
    Vec3f sum(0);
    for (const Corner& corner : star) sum += normal_[corner.row];
    const float least = kOverAPlane * sum.length();
    return std::all_of(star.begin(), star.end(), [&](const Corner& corner) {
        const Vec3f& normal = normal_[corner.row];
        return normal.dot(sum) > least || normal == Vec3f(0);
    });
}

// Where the triangles at a vertex face no common way, two of them may cross that do, which no others might tell.
bool ComponentCrossings::foldsAtAVertex() {
    std::uint64_t* const facing = facing_of_vertices_.data();
    for (const std::uint32_t t : triangle_)
        for (const std::uint32_t v : mesh_.triangles[t]) facing[v] = ~std::uint64_t{0};
    for (std::size_t i = 0; i < triangle_.size(); ++i)
        for (const std::uint32_t v : mesh_.triangles[triangle_[i]]) facing[v] &= facing_[i];
    loose_.clear();
    for (std::uint32_t i = 0; i < triangle_.size(); ++i)
        for (const std::uint32_t v : mesh_.triangles[triangle_[i]])
            if (facing[v] == 0) loose_.push_back({v, i});
    std::sort(loose_.begin(), loose_.end(), [](const Corner& a, const Corner& b) {
        return a.vertex != b.vertex ? a.vertex < b.vertex : a.row < b.row;
    });
    const auto haveAnEdge = [&](std::size_t row, std::size_t other) {  // in common, so they cannot cross
        int common = 0;
        for (const std::uint32_t u : mesh_.triangles[triangle_[row]])
            for (const std::uint32_t v : mesh_.triangles[triangle_[other]]) common += u == v;
        return common > 1;
    };
    for (std::size_t begin = 0, end; begin < loose_.size(); begin = end) {
        end = begin + 1;
        while (end < loose_.size() && loose_[end].vertex == loose_[begin].vertex) ++end;
        const std::span<const Corner> star(&loose_[begin], end - begin);
        if (isOverAPlane(star)) continue;
        for (std::size_t i = 0; i < star.size(); ++i)
            for (std::size_t j = i + 1; j < star.size(); ++j) {
                const std::size_t one = star[i].row, other = star[j].row;
                if ((facing_[one] & facing_[other]) != 0 && !haveAnEdge(one, other) && mayCross(one, other))
                    return true;
            }
    }
    return false;
}

}  // namespace betamesh
