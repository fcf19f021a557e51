// Finds the pairs of triangles at which a mesh whose vertices have moved crosses itself.

#pragma once

#include "base/box.h"
#include "skin/beta_mesh.h"

#include <memory>
#include <span>

namespace betamesh {

/// Two triangles by row, the smaller first.
using TrianglePair = std::array<std::uint32_t, 2>;

/// How two triangles relate, without regard to the surface around them.
enum class TriangleRelation {
    apart,      ///< disjoint, or in contact only at shared vertices and edges
    undecided,  ///< an edge of one is in the plane of the other: they may touch, which can be part of a crossing
    crossing,   ///< an edge of one passes through the other
};

/// Decided by exact signs. positionOf(v): the position of vertex v, which need not be that in a mesh.
template <typename PositionOf>
TriangleRelation relationOf(const Triangle& s, const Triangle& t, const PositionOf& positionOf);

/// Pairs in ascending order. Triangles of undecided pairs have an area.
struct CandidatePairs {
    std::vector<TrianglePair> crossing, undecided;
};

/// Patches of triangles in a binary tree. A facing mask tells for 42 directions whether a triangle faces them, the mask
/// of a patch whether all of its triangles do. Two patches that have a vertex in common and face a common direction are
/// part of a surface over a plane, which cannot cross itself, and are not compared; nor are two such triangles. Only
/// layers that meet in a vertex with a folded one-ring could cross nevertheless. Masks are therefore ignored at folded
/// one-rings and at triangles that have turned over. Degenerate triangles, frequent on lattices, cross nothing and do
/// not count as turned over.
///
/// A component is a part of the surface known to be free of self-crossings until it is activated. It is divided into
/// few patches, which are not compared with each other.
///
/// Pairs are found if at least one of the triangles is in an active patch.
///
/// in      a mesh, which is referenced; the positions of its vertices before the displacement, when nothing crossed;
///         radius of the balls, world units. Patches that have moved are active
/// same    pairs for any thread count
/// cost    O(triangles), plus the pairs of patches whose boxes meet
/// source  a surface over a plane does not cross itself: Volino & Magnenat-Thalmann 1994
class PatchTree {
public:
    /// Consecutive triangles of a component known to be free of crossings.
    struct ComponentPart {
        std::uint32_t begin, end;  ///< of its triangles
        std::uint32_t component;   ///< >= 1
    };
    /// components: in ascending order of triangles.
    PatchTree(const BetaMesh& mesh, const std::vector<Vec3>& before, double radius,
              std::span<const ComponentPart> components = {});

    CandidatePairs candidatePairs() const;

    void deactivateAll();
    /// Activates the patches within `distance` (world units) of a box. From then on they are compared with all others,
    /// whatever they face.
    void activate(const Box& box, double distance);
    /// Deactivates active patches without a vertex for which moves(v) is true.
    template <typename Moves>
    void keepActive(const Moves& moves) {
        for (std::size_t p = 0; p < patches(); ++p)
            if (std::uint8_t& active = node_[first_leaf_ + p].active; active) {
                active = 0;
                for (const std::uint32_t t : trianglesOf(range_[p]))
                    for (const std::uint32_t v : mesh_.triangles[t]) active |= moves(v);
            }
        gatherActive();
    }
    /// Updates boxes. To be called after vertices of active patches have moved.
    void refit();

    /// Calls visit(triangle) for the triangles of active patches.
    template <typename Visit>
    void forActiveTriangles(const Visit& visit) const {
        for (std::size_t p = 0; p < patches(); ++p)
            if (node_[first_leaf_ + p].active)
                for (const std::uint32_t t : trianglesOf(range_[p])) visit(mesh_.triangles[t]);
    }

private:
    struct Node {
        Boxf box;
        std::uint64_t facing = ~std::uint64_t{0};  // directions that all triangles of a patch face
        std::uint32_t component = 0;               // of all its triangles; 0: of none, or of several
        std::uint8_t active = 0;
        bool was_activated = false;  // since then its triangles are compared with all others
    };
    struct Range {
        std::uint32_t begin, end;  // of triangle_ and facing_
    };
    struct Boxed {
        std::uint32_t triangle;
        std::uint64_t facing;
        Boxf box;
    };
    struct Patch {
        Range range;
        Node node;
        bool turned;  // one of its triangles has turned over
    };

    std::size_t patches() const { return range_.size(); }
    std::span<const std::uint32_t> trianglesOf(const Range& range) const {
        return {&triangle_[range.begin], range.end - range.begin};
    }
    Boxf boxOf(std::uint32_t triangle) const;
    bool areConnected(const Range& one, const Range& other) const;
    std::span<const Boxed> boxesNear(const Range& range, const Boxf& box, std::uint64_t directions,
                                     std::span<Boxed> near) const;
    std::vector<Patch> makePatches(const std::vector<Vec3>& before, std::span<const ComponentPart> components);
    void addPatches(const std::vector<Vec3>& before, std::uint32_t begin, std::uint32_t size, std::vector<Patch>& into);
    std::uint32_t endOfRun(std::uint32_t begin, std::uint32_t end) const;
    void addComponentPart(const std::vector<Vec3>& before, const ComponentPart& part, std::vector<Patch>& into);
    void makeTree(const std::vector<Patch>& patches);
    std::vector<Box> foldedOneRings(const std::vector<Patch>& patches) const;
    void gatherBoxes();
    void gatherActive();
    bool areLeaves(const TrianglePair& nodes) const { return nodes[0] >= first_leaf_ && nodes[1] >= first_leaf_; }
    void descend(const TrianglePair& nodes, std::vector<TrianglePair>& into) const;
    void addPairs(const TrianglePair& leaves, CandidatePairs& out) const;

    const BetaMesh& mesh_;
    std::unique_ptr<std::uint32_t[]> triangle_;  // the triangles of a patch are consecutive
    std::unique_ptr<std::uint64_t[]> facing_;    // facing mask of each, and kFlat
    std::vector<Range> range_;                   // of patches, in the order of the leaves
    std::size_t first_leaf_ = 1;                 // and their number; node i has the children 2i, 2i + 1
    std::vector<Node> node_;
};

/// The same for triangles given by the positions of their corners; s_common, t_common: which corners they share.
TriangleRelation relationOf(const std::array<Vec3, 3>& s, const std::array<Vec3, 3>& t,
                            const std::array<bool, 3>& s_common, const std::array<bool, 3>& t_common);

template <typename PositionOf>
TriangleRelation relationOf(const Triangle& s, const Triangle& t, const PositionOf& positionOf) {
    std::array<Vec3, 3> at_s, at_t;
    std::array<bool, 3> s_common, t_common;
    for (std::size_t m = 0; m < 3; ++m) {
        at_s[m] = positionOf(s[m]);
        at_t[m] = positionOf(t[m]);
        s_common[m] = s[m] == t[0] || s[m] == t[1] || s[m] == t[2];
        t_common[m] = t[m] == s[0] || t[m] == s[1] || t[m] == s[2];
    }
    return relationOf(at_s, at_t, s_common, t_common);
}

}  // namespace betamesh
