
#include "mesh/triangle_tree.h"

#include "base/parallel.h"

#include <bit>
#include <cmath>
#include <limits>

namespace betamesh {

namespace {

Box boxOf(std::span<const Vec3> position, const Triangle& t) {
    Box box;
    for (const std::uint32_t v : t) box.extendBy(position[v]);
    return box;
}

double squaredDistanceToSegment(const Vec3& p, const Vec3& a, const Vec3& b) {
    const Vec3 along = b - a;
    const double squared = along.length2();
    const double t = squared > 0 ? std::clamp(dot(p - a, along) / squared, 0.0, 1.0) : 0;
    return (p - a - along * t).length2();
}

// Distance to the plane where the foot of the perpendicular is inside the triangle, else to the nearest side.
double squaredDistance(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
    const Vec3 normal = cross(b - a, c - a);
    const double squared = normal.length2();
    if (squared > 0 && dot(cross(b - a, p - a), normal) >= 0 && dot(cross(c - b, p - b), normal) >= 0 &&
        dot(cross(a - c, p - c), normal) >= 0) {
        const double height = dot(p - a, normal);
        return height * height / squared;
    }
    return std::min(
        {squaredDistanceToSegment(p, a, b), squaredDistanceToSegment(p, b, c), squaredDistanceToSegment(p, c, a)});
}

}  // namespace

TriangleTree::TriangleTree(std::span<const Vec3> position, std::span<const Triangle> triangles, double margin)
    : position_(position), triangles_(triangles), margin_(margin), order_(triangles.size()), box_(triangles.size()) {
    const std::size_t n = triangles.size();
    struct CodedTriangle {
        std::uint64_t morton_code;
        std::uint32_t triangle;
    };
    Box bounds;
    for (const Triangle& t : triangles)
        for (const std::uint32_t v : t) bounds.extendBy(position[v]);
    std::vector<CodedTriangle> sorted(n);
    parallelFor(n, 4096, [&](std::size_t t) {
        sorted[t] = {mortonCode(boxOf(position, triangles[t]), bounds), static_cast<std::uint32_t>(t)};
    });
    parallelSort(sorted, [](const CodedTriangle& a, const CodedTriangle& b) {
        return a.morton_code != b.morton_code ? a.morton_code < b.morton_code : a.triangle < b.triangle;
    });

    parallelFor(n, 8192, [&](std::size_t i) { order_[i] = sorted[i].triangle; });
    refit();
}

void TriangleTree::refit(std::span<const Vec3> former) {
    first_leaf_ = std::bit_ceil(std::max<std::size_t>(leaves(), 1));
    node_.assign(2 * first_leaf_, {});
    parallelFor(leaves(), 1024, [&](std::size_t leaf) {
        Box& leaf_box = node_[first_leaf_ + leaf];
        for (std::size_t i = leaf * kLeaf; i < std::min(order_.size(), (leaf + 1) * kLeaf); ++i) {
            box_[i] = boxOf(position_, triangles_[order_[i]]);
            if (!former.empty()) box_[i].extendBy(boxOf(former, triangles_[order_[i]]));
            box_[i].min -= Vec3(margin_);
            box_[i].max += Vec3(margin_);
            leaf_box.extendBy(box_[i]);
        }
    });
    for (std::size_t level = first_leaf_ / 2; level > 0; level /= 2)
        parallelFor(level, 1024, [&](std::size_t i) {
            Box& box = node_[level + i];
            for (const std::size_t child : {2 * (level + i), 2 * (level + i) + 1}) box.extendBy(node_[child]);
        });
}

std::size_t TriangleTree::lastLeaf(std::size_t node) const {
    const int down = std::countl_zero(node) - std::countl_zero(first_leaf_);
    return ((node + 1) << down) - 1 - first_leaf_;
}

double TriangleTree::distanceTo(const Vec3& point, std::size_t& hint) const {
    if (order_.empty()) return std::numeric_limits<double>::infinity();
    const auto squaredTo = [&](std::size_t i) {
        const Triangle& t = triangles_[order_[i]];
        return squaredDistance(point, position_[t[0]], position_[t[1]], position_[t[2]]);
    };
    hint = std::min(hint, order_.size() - 1);
    double nearest = squaredTo(hint);
    struct Entry {
        std::size_t node;
        double distance;
    };
    Entry stack[64];
    std::size_t depth = 0;
    stack[depth++] = {1, squaredDistance(node_[1], point)};
    while (depth > 0) {
        const Entry next = stack[--depth];
        if (next.distance >= nearest) continue;
        if (next.node >= first_leaf_) {
            const std::size_t leaf = next.node - first_leaf_;
            for (std::size_t i = leaf * kLeaf; i < std::min(order_.size(), (leaf + 1) * kLeaf); ++i) {
                if (squaredDistance(box_[i], point) >= nearest) continue;
                const double squared = squaredTo(i);
                if (squared >= nearest) continue;
                nearest = squared;
                hint = i;
            }
            continue;
        }
        Entry closer{2 * next.node, squaredDistance(node_[2 * next.node], point)};
        Entry farther{2 * next.node + 1, squaredDistance(node_[2 * next.node + 1], point)};
        if (farther.distance < closer.distance) std::swap(closer, farther);
        if (farther.distance < nearest) stack[depth++] = farther;
        if (closer.distance < nearest) stack[depth++] = closer;
    }
    return std::sqrt(nearest);
}

}  // namespace betamesh
