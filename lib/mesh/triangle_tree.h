// A bounding-volume tree over triangles: overlapping pairs, nearest triangles, ray-like queries.

#pragma once

#include "base/box.h"
#include "betamesh/mesh.h"

#include <algorithm>
#include <span>

namespace betamesh {

/// A complete binary tree over triangles in Morton order, kLeaf triangles per leaf. Nodes are stored in one array, root
/// at 1, children of node i at 2i and 2i + 1, leaves last. Refers to the mesh it was made of.
class TriangleTree {
public:
    static constexpr std::size_t kLeaf = 4;

    /// in      triangles whose vertices exist and have finite positions; margin: how far boxes reach beyond their
    ///         triangles, world units, so that pairs are visited that are up to twice as far apart
    /// same    tree for any thread count
    /// cost    O(triangles log triangles)
    TriangleTree(std::span<const Vec3> position, std::span<const Triangle> triangles, double margin = 0);
    /// Fits the boxes to positions that have changed since. The order stays, so that far moves make queries slower.
    ///
    /// in      former: where the vertices were; boxes then contain that as well, so that no triangle that moves on a
    ///         straight path leaves its own. Empty: nothing more
    void refit(std::span<const Vec3> former = {});

    std::size_t leaves() const { return (order_.size() + kLeaf - 1) / kLeaf; }
    std::span<const Vec3> position() const { return position_; }
    std::span<const Triangle> triangles() const { return triangles_; }

    /// Calls visit(s, t), s < t, for every pair of triangles whose boxes overlap and whose lower leaf is this one. Over
    /// all leaves every pair is visited once.
    template <typename Visit>
    void forPairsOfLeaf(std::size_t leaf, const Visit& visit) const {
        const std::size_t end = std::min(order_.size(), (leaf + 1) * kLeaf);
        for (std::size_t i = leaf * kLeaf; i < end; ++i)
            for (std::size_t j = i + 1; j < end; ++j) visitPair(i, j, visit);
        const Box& own = node_[first_leaf_ + leaf];
        walk([&](const Box& box, std::size_t last) { return last > leaf && box.intersects(own); },
             [&](std::size_t other) {
                 if (other <= leaf) return;
                 const std::size_t other_end = std::min(order_.size(), (other + 1) * kLeaf);
                 for (std::size_t i = leaf * kLeaf; i < end; ++i) {
                     if (!box_[i].intersects(node_[first_leaf_ + other])) continue;
                     for (std::size_t j = other * kLeaf; j < other_end; ++j) visitPair(i, j, visit);
                 }
             });
    }

    /// Calls visit(t) for every triangle whose box satisfies `wanted`, until visit returns false. wanted must hold for
    /// every box that contains one for which it holds.
    template <typename Wanted, typename Visit>
    void forTriangles(const Wanted& wanted, const Visit& visit) const {
        bool go_on = true;
        walk([&](const Box& box, std::size_t) { return go_on && wanted(box); },
             [&](std::size_t leaf) {
                 const std::size_t end = std::min(order_.size(), (leaf + 1) * kLeaf);
                 for (std::size_t i = leaf * kLeaf; go_on && i < end; ++i)
                     if (wanted(box_[i])) go_on = visit(order_[i]);
             });
    }

    /// Distance from a point to the nearest triangle, to rounding; infinite without triangles.
    double distanceTo(const Vec3& point) const {
        std::size_t hint = 0;
        return distanceTo(point, hint);
    }

    /// The same, much faster if `hint` is the position in the tree of a triangle nearby. It is set to the position of
    /// the nearest triangle. Any value is allowed; it may change the distance by rounding.
    double distanceTo(const Vec3& point, std::size_t& hint) const;
    /// The triangle at a position in the tree.
    std::uint32_t triangleAt(std::size_t position) const { return order_[position]; }

private:
    template <typename Visit>
    void visitPair(std::size_t i, std::size_t j, const Visit& visit) const {
        if (box_[i].intersects(box_[j])) visit(std::min(order_[i], order_[j]), std::max(order_[i], order_[j]));
    }

    /// Calls atLeaf(leaf) for the leaves reached through nodes with wanted(box, last leaf below the node), in order.
    template <typename Wanted, typename AtLeaf>
    void walk(const Wanted& wanted, const AtLeaf& atLeaf) const {
        if (order_.empty()) return;
        std::size_t stack[64], depth = 0;
        stack[depth++] = 1;
        while (depth > 0) {
            const std::size_t node = stack[--depth];
            if (!wanted(node_[node], lastLeaf(node))) continue;
            if (node >= first_leaf_) {
                atLeaf(node - first_leaf_);
            } else {
                stack[depth++] = 2 * node + 1;
                stack[depth++] = 2 * node;
            }
        }
    }
    std::size_t lastLeaf(std::size_t node) const;

    std::span<const Vec3> position_;
    std::span<const Triangle> triangles_;
    double margin_;
    std::vector<std::uint32_t> order_;  ///< triangles in Morton order
    std::vector<Box> box_;              ///< of each triangle, in the same order
    std::vector<Box> node_;             ///< of each node; entry 0 is unused
    std::size_t first_leaf_ = 1;        ///< node of leaf 0, a power of two
};

}  // namespace betamesh
