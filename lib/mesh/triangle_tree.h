// Triangles in a tree of boxes: who meets whom, who is nearest, how often a point is enclosed.

#pragma once

#include "base/box.h"
#include "betamesh/mesh.h"

#include <algorithm>
#include <span>

namespace betamesh {

/// A binary tree over triangles in the order of a space-filling curve. Leaf j holds kLeaf of them; the nodes
/// lie in one array, the children of i at 2i and 2i + 1, the leaves last. Refers to the mesh it was made of.
class TriangleTree {
public:
    static constexpr std::size_t kLeaf = 4;

    /// in      corners that exist, with finite coordinates
    /// same    tree for any thread count
    /// cost    O(triangles log triangles)
    TriangleTree(std::span<const Vec3> position, std::span<const Triangle> triangles);

    std::size_t leaves() const { return (order_.size() + kLeaf - 1) / kLeaf; }
    std::span<const Vec3> position() const { return position_; }
    std::span<const Triangle> triangles() const { return triangles_; }

    /// Calls visit(s, t), s < t, for every pair of triangles whose boxes meet and whose first leaf is this
    /// one: over all leaves, every pair once.
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

    /// Calls visit(t) for every triangle whose box `wanted` accepts; wanted must accept the boxes round
    /// those it accepts. Stops when visit returns false.
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

    /// From a point to the nearest point of any triangle; infinite where there is none. Correct to rounding.
    double distanceTo(const Vec3& point) const {
        std::size_t near = 0;
        return distanceTo(point, near);
    }

    /// The same, much quicker where a triangle close by is known: `near` is its place in the tree, and becomes that
    /// of the nearest triangle. Any number does; it may change the distance by rounding.
    double distanceTo(const Vec3& point, std::size_t& near) const;

private:
    template <typename Visit>
    void visitPair(std::size_t i, std::size_t j, const Visit& visit) const {
        if (box_[i].intersects(box_[j])) visit(std::min(order_[i], order_[j]), std::max(order_[i], order_[j]));
    }

    /// Descends where wanted(box, last leaf below it), first children first.
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
    std::vector<std::uint32_t> order_;  ///< triangles along the curve
    std::vector<Box> box_;              ///< of each, along the curve
    std::vector<Box> node_;             ///< 1 is the root
    std::size_t first_leaf_ = 1;        ///< a power of two
};

}  // namespace betamesh
