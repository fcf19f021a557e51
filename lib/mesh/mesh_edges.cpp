
#include "mesh/mesh_edges.h"

#include "base/compressed_rows.h"
#include "base/index.h"
#include "base/parallel.h"

#include <algorithm>
#include <atomic>
#include <utility>

namespace betamesh {

std::vector<std::uint32_t> verticesOf(std::span<const Triangle> triangles, std::size_t vertices) {
    std::vector<std::uint8_t> is_used(vertices, 0);
    parallelFor(triangles.size(), 4096, [&](std::size_t t) {
        for (const std::uint32_t v : triangles[t]) std::atomic_ref(is_used[v]).store(1, std::memory_order_relaxed);
    });
    return indicesWhere(vertices, [&](std::uint32_t v) { return is_used[v] != 0; });
}

std::vector<TriangleSide> sortedSides(std::span<const Triangle> triangles) {
    // Bucket sort by the lower vertex, then a sort of each bucket, which has about three sides.
    std::uint32_t vertices = 0;
    for (const Triangle& t : triangles) vertices = std::max({vertices, t[0] + 1, t[1] + 1, t[2] + 1});
    CompressedRows<TriangleSide> sides =
        sortedIntoRows<TriangleSide>(vertices, triangles.size(), [&](std::size_t t, const auto& visit) {
            for (std::size_t m = 0; m < 3; ++m) {
                const std::uint32_t a = triangles[t][m], b = triangles[t][(m + 1) % 3];
                const auto [low, high] = std::minmax(a, b);
                visit(low, {low, high, static_cast<std::uint32_t>(3 * t + m), a < b ? 1 : -1});
            }
        });
    parallelFor(vertices, 4096, [&](std::size_t v) {
        std::sort(sides[v].begin(), sides[v].end(), [](const TriangleSide& a, const TriangleSide& b) {
            return a.high != b.high ? a.high < b.high : a.side < b.side;
        });
    });
    return std::move(sides.item);
}

std::vector<std::uint32_t> trianglesAcross(const std::vector<TriangleSide>& sides) {
    std::vector<std::uint32_t> across(sides.size(), kInvalidIndex);
    forEveryEdge(sides, [&](std::span<const TriangleSide> edge) {
        if (edge.size() != 2) return;
        across[edge[0].side] = edge[1].side / 3;
        across[edge[1].side] = edge[0].side / 3;
    });
    return across;
}

std::vector<std::uint32_t> placesOfVertices(const std::vector<Vec3>& position) {
    std::vector<std::uint32_t> order(position.size()), first(position.size());
    parallelFor(order.size(), 4096, [&](std::size_t v) { order[v] = static_cast<std::uint32_t>(v); });
    std::erase_if(order, [&](std::uint32_t v) {
        first[v] = v;
        return !isFinite(position[v]);
    });
    parallelSort(order, [&](std::uint32_t v, std::uint32_t w) {
        const Vec3 &p = position[v], &q = position[w];
        if (p.x != q.x) return p.x < q.x;
        if (p.y != q.y) return p.y < q.y;
        if (p.z != q.z) return p.z < q.z;
        return v < w;
    });
    for (std::size_t i = 1; i < order.size(); ++i)
        if (position[order[i]] == position[order[i - 1]]) first[order[i]] = first[order[i - 1]];
    return first;
}

}  // namespace betamesh
