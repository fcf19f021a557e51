// Where a mesh that has been moved passes through itself.

#pragma once

#include "base/box.h"
#include "skin/beta_mesh.h"

#include <memory>
#include <span>

namespace betamesh {

/// Two triangles by row, the smaller first.
using TrianglePair = std::array<std::uint32_t, 2>;

/// How two triangles meet, as far as they alone show it.
enum class Meeting {
    none,      ///< or in what they share
    doubtful,  ///< an edge of one lies in the plane of the other: they may touch, which can be part of a crossing
    crossing,  ///< an edge of one passes through the other, whichever way
};

/// Decided by exact signs. positionOf(v): where vertex v is, which may be elsewhere than in any mesh.
template <typename PositionOf>
Meeting meetingOf(const Triangle& s, const Triangle& t, const PositionOf& positionOf);

/// Ascending. Of what is doubtful, no triangle is without area.
struct Meetings {
    std::vector<TrianglePair> crossing, doubtful;
};

/// Patches of triangles in a binary tree. Each triangle knows which directions it faces, each node which ones all of
/// its triangles face: two with a common one are parts of a surface over a plane, which cannot cross. Layers that face
/// the same way have others between them, which would cross first, or meet in a vertex whose triangles face all ways:
/// there, and where triangles have turned over, no such thing is relied on. Triangles that had no area and have none
/// cross nothing, nor have they turned over: lattices are full of them.
///
/// A body is a piece of surface that does not cross itself, which is known from elsewhere until it is woken. It is cut
/// into few patches, and these are not compared with each other.
///
/// Patches are awake or asleep. A meeting is found if one of its triangles is in a patch that is awake.
///
/// in      a mesh, which has to stay where it is; where its vertices were before, when nothing crossed; the radius of
///         the balls, world units. Patches that have not moved since then are asleep
/// same    meetings for any thread count
/// cost    O(triangles), and the pairs of patches that are near each other and face different ways
/// source  a surface over a plane does not cross itself: Volino & Magnenat-Thalmann 1994
class PatchTree {
public:
    struct BodyPart {
        std::uint32_t begin, end;  ///< of its triangles
        std::uint32_t body;        ///< from 1
    };
    /// bodies: ascending.
    PatchTree(const BetaMesh& mesh, const std::vector<Vec3>& before, double radius,
              std::span<const BodyPart> bodies = {});

    Meetings meetings() const;

    void sleep();
    /// Patches no farther from the box than this. From now on they are compared with all others, whichever way they
    /// face.
    void wake(const Box& box, double distance);
    /// Patches without a vertex that moves(v) fall asleep.
    template <typename Moves>
    void sleepUnless(const Moves& moves) {
        for (std::size_t p = 0; p < patches(); ++p)
            if (std::uint8_t& awake = node_[first_leaf_ + p].awake; awake) {
                awake = 0;
                for (const std::uint32_t t : trianglesOf(range_[p]))
                    for (const std::uint32_t v : mesh_.triangles[t]) awake |= moves(v);
            }
        gatherAwake();
    }
    /// After vertices of patches that are awake have moved.
    void refit();

    /// Calls visit(triangle) for those in patches that are awake.
    template <typename Visit>
    void forTrianglesAwake(const Visit& visit) const {
        for (std::size_t p = 0; p < patches(); ++p)
            if (node_[first_leaf_ + p].awake)
                for (const std::uint32_t t : trianglesOf(range_[p])) visit(mesh_.triangles[t]);
    }

private:
    struct Node {
        Boxf box;
        std::uint64_t facing = ~std::uint64_t{0};  // directions that all of it faces
        std::uint32_t body = 0;                    // that all is part of; 0: of none, or of several
        std::uint8_t awake = 0;
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
        bool turned;  // a triangle of it has turned over
    };

    std::size_t patches() const { return range_.size(); }
    std::span<const std::uint32_t> trianglesOf(const Range& range) const {
        return {&triangle_[range.begin], range.end - range.begin};
    }
    Boxf boxOf(std::uint32_t triangle) const;
    std::span<const Boxed> boxesNear(const Range& range, const Node& node, std::span<Boxed> near) const;
    std::vector<Patch> makePatches(const std::vector<Vec3>& before, std::span<const BodyPart> bodies);
    void addPatches(const std::vector<Vec3>& before, std::uint32_t begin, std::uint32_t size, std::vector<Patch>& into);
    std::uint32_t endOfRun(std::uint32_t begin, std::uint32_t end) const;
    void addBodyPart(const std::vector<Vec3>& before, const BodyPart& part, std::vector<Patch>& into);
    void makeTree(const std::vector<Patch>& patches);
    std::vector<Box> foldedStars(const std::vector<Patch>& patches) const;
    void gatherBoxes();
    void gatherAwake();
    bool areLeaves(const TrianglePair& nodes) const { return nodes[0] >= first_leaf_ && nodes[1] >= first_leaf_; }
    void descend(const TrianglePair& nodes, std::vector<TrianglePair>& into) const;
    void addMeetings(const TrianglePair& leaves, Meetings& out) const;

    const BetaMesh& mesh_;
    std::unique_ptr<std::uint32_t[]> triangle_;  // those of a patch are neighbours
    std::unique_ptr<std::uint64_t[]> facing_;    // of these: a bit for each direction, and kFlat
    std::vector<Range> range_;                   // of patches, in the order of leaves
    std::size_t first_leaf_ = 1;                 // so many leaves; node 1 is the root, those below i are 2i and 2i + 1
    std::vector<Node> node_;
};

/// The same of triangles that are given by their corners, and by which of these they have in common.
Meeting meetingOf(const std::array<Vec3, 3>& s, const std::array<Vec3, 3>& t, const std::array<bool, 3>& s_common,
                  const std::array<bool, 3>& t_common);

template <typename PositionOf>
Meeting meetingOf(const Triangle& s, const Triangle& t, const PositionOf& positionOf) {
    std::array<Vec3, 3> at_s, at_t;
    std::array<bool, 3> s_common, t_common;
    for (std::size_t m = 0; m < 3; ++m) {
        at_s[m] = positionOf(s[m]);
        at_t[m] = positionOf(t[m]);
        s_common[m] = s[m] == t[0] || s[m] == t[1] || s[m] == t[2];
        t_common[m] = t[m] == s[0] || t[m] == s[1] || t[m] == s[2];
    }
    return meetingOf(at_s, at_t, s_common, t_common);
}

}  // namespace betamesh
