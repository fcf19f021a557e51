// Small components of the surface whose self-crossings are ruled out by comparing all pairs of triangles.

#pragma once

#include "base/box.h"
#include "skin/ball_boundary.h"
#include "skin/beta_mesh.h"
#include "skin/patch_tree.h"

#include <array>
#include <span>
#include <vector>

namespace betamesh {

/// Consecutive triangles of a mesh.
struct TriangleRange {
    std::uint32_t begin, end;
};

/// The parts of a mesh that are small connected components and certainly free of self-crossings, in ascending order of
/// triangles.
///
/// in      before: positions of the vertices before the displacement, when nothing crossed
/// same    result for any thread count
/// cost    O(triangles · triangles per component / 64)
std::vector<PatchTree::ComponentPart> crossingFreeComponents(const BallBoundary& boundary,
                                                             const std::vector<Vec3>& before, const BetaMesh& mesh);

/// Tells whether a component whose vertices have moved crosses itself. For small components it is faster to compare all
/// pairs, as many per instruction as fit into a register, than to build a PatchTree.
///
/// in      a mesh; the positions of its vertices before the displacement, when nothing crossed; scratch space with a
///         number per vertex, which objects for other components of the same mesh on other threads may share
/// source  pairs that are not compared: as in PatchTree
class ComponentCrossings {
public:
    ComponentCrossings(const BetaMesh& mesh, const std::vector<Vec3>& before,
                       std::span<std::uint64_t> facing_of_vertices)
        : mesh_(mesh), before_(before), facing_of_vertices_(facing_of_vertices) {}

    /// True if no two triangles of the component cross, for certain. False also if a triangle has turned over or may
    /// touch another one.
    ///
    /// in      parts: all triangles of the component; consecutive ones should be near each other
    /// cost    O(triangles² / 64), some 150 ns a triangle where there are a few hundred
    bool crossesNothing(std::span<const TriangleRange> parts);

private:
    static constexpr std::size_t kBlock = 64;  // triangles compared at once

    // A box on a grid of kSteps steps over the component's box.
    struct StepBox {
        std::array<std::uint8_t, 3> low{127, 127, 127}, high{0, 0, 0};

        bool intersects(const StepBox& other) const {
            bool apart = false;
            for (std::size_t k = 0; k < 3; ++k) apart |= (low[k] > other.high[k]) | (high[k] < other.low[k]);
            return !apart;
        }
    };
    // The boxes of kBlock triangles, column by column.
    struct Block {
        std::array<std::array<std::uint8_t, kBlock>, 3> low, high;
        StepBox box;  // of all of them
    };
    struct Corner {
        std::uint32_t vertex, row;
    };
    struct MarkNear;

    bool gather(std::span<const TriangleRange> parts);
    void makeBlocks();
    std::size_t commonCorners(std::size_t row, std::size_t other) const;
    bool mayCross(std::size_t row, std::size_t other, bool even_if_touching) const;
    bool crossesItself() const;
    bool isOverAPlane(std::span<const Corner> one_ring) const;
    bool hasFoldedOneRing();

    const BetaMesh& mesh_;
    const std::vector<Vec3>& before_;
    std::span<std::uint64_t> facing_of_vertices_;  // directions that all triangles at a vertex face
    std::vector<std::uint32_t> triangle_;          // of the component: rows of the mesh
    std::vector<std::uint64_t> facing_;
    std::vector<Vec3f> normal_;
    std::vector<Boxf> box_;
    std::vector<StepBox> step_box_;
    std::vector<Block> block_;
    std::vector<Corner> corner_;  // at vertices whose triangles face no common direction
};

}  // namespace betamesh
