// Small pieces of surface of which every triangle is compared with all others.

#pragma once

#include "base/box.h"
#include "skin/beta_mesh.h"

#include <array>
#include <span>
#include <vector>

namespace betamesh {

/// Consecutive triangles of a mesh.
struct TriangleRange {
    std::uint32_t begin, end;
};

/// Tells whether a drop that has been moved passes through itself, without a tree of its patches: as long as it is
/// small it is quicker to compare everything, for which an instruction takes as many triangles as fit in a register.
///
/// in      a mesh, and where its vertices were before, when nothing crossed; room for a number per vertex, which
///         several that look at other drops of the same mesh on other threads may share
/// source  what need not be compared: as in exact/patch_tree.h
class ComponentCrossings {
public:
    ComponentCrossings(const BetaMesh& mesh, const std::vector<Vec3>& before, std::span<std::uint64_t> facing_of_vertices)
        : mesh_(mesh), before_(before), facing_of_vertices_(facing_of_vertices) {}

    /// Does nothing of it cross anything else of it, for certain? Also false where a triangle has turned over, or may
    /// touch another one.
    ///
    /// in      all triangles at their vertices; those that follow one another had better be near each other
    /// cost    O(triangles² / 64), some 150 ns a triangle where there are a few hundred
    bool crossesNothing(std::span<const TriangleRange> parts);

private:
    static constexpr std::size_t kBlock = 64;         // triangles compared at once
    static constexpr std::size_t kFacingColumns = 6;  // of seven bits: the 42 ways that can be faced

    // In steps of the body's box, rounded alike.
    struct StepBox {
        std::array<std::uint8_t, 3> low{127, 127, 127}, high{0, 0, 0};

        bool intersects(const StepBox& other) const {
            bool apart = false;
            for (std::size_t k = 0; k < 3; ++k) apart |= (low[k] > other.high[k]) | (high[k] < other.low[k]);
            return !apart;
        }
    };
    // Triangles by column.
    struct Block {
        std::array<std::array<std::uint8_t, kBlock>, 3> low, high;
        std::array<std::array<std::uint8_t, kBlock>, kFacingColumns> facing;
        StepBox box;  // of all
    };
    struct Corner {
        std::uint32_t vertex, row;
    };
    struct MarkNear;

    bool gather(std::span<const TriangleRange> parts);
    void makeBlocks();
    bool mayCross(std::size_t row, std::size_t other) const;
    bool meetsItself() const;
    bool isOverAPlane(std::span<const Corner> star) const;
    bool foldsAtAVertex();

    const BetaMesh& mesh_;
    const std::vector<Vec3>& before_;
    std::span<std::uint64_t> facing_of_vertices_;  // ways that all triangles at a vertex face
    std::vector<std::uint32_t> triangle_;          // of the body: rows of the mesh
    std::vector<std::uint64_t> facing_;
    std::vector<Vec3f> normal_;
    std::vector<Boxf> box_;
    std::vector<StepBox> step_box_;
    std::vector<Block> block_;
    std::vector<Corner> loose_;
};

}  // namespace betamesh
