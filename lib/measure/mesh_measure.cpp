#include "measure/mesh_measure.h"

#include "core/parallel.h"
#include "core/union_find.h"

#include <algorithm>

namespace betamesh {

namespace {

struct Edge {
    std::uint32_t low, high;
    std::int32_t direction;  // +1 from low to high, -1 back
};

std::vector<Edge> sortedEdges(const Mesh& mesh) {
    std::vector<Edge> edges(3 * mesh.triangles.size());
    parallelFor(mesh.triangles.size(), 4096, [&](std::size_t t) {
        for (std::size_t m = 0; m < 3; ++m) {
            const std::uint32_t a = mesh.triangles[t][m], b = mesh.triangles[t][(m + 1) % 3];
            edges[3 * t + m] = {std::min(a, b), std::max(a, b), a < b ? 1 : -1};
        }
    });
    parallelSort(edges, [](const Edge& a, const Edge& b) {
        if (a.low != b.low) return a.low < b.low;
        if (a.high != b.high) return a.high < b.high;
        return a.direction < b.direction;
    });
    return edges;
}

}  // namespace

MeshMeasure measureMesh(const Mesh& mesh) {
    MeshMeasure measure;
    UnionFind pieces(mesh.position.size());
    std::vector<bool> used(mesh.position.size(), false);
    std::size_t vertices = 0;
    const Vec3 origin = mesh.position.empty() ? Vec3(0) : mesh.position[0];
    for (const Triangle& t : mesh.triangles) {
        for (const std::uint32_t v : t) {
            if (!used[v]) ++vertices;
            used[v] = true;
        }
        pieces.join(t[0], t[1]);
        pieces.join(t[1], t[2]);
        const Vec3 a = mesh.position[t[0]] - origin, b = mesh.position[t[1]] - origin, c = mesh.position[t[2]] - origin;
        measure.volume += dot(a, cross(b, c)) / 6;
        measure.area += cross(b - a, c - a).length() / 2;
    }
    measure.components = pieces.groups() - (mesh.position.size() - vertices);

    const std::vector<Edge> edges = sortedEdges(mesh);
    std::size_t distinct = 0;
    for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
        std::int64_t surplus = 0;
        for (end = begin;
             end < edges.size() && edges[end].low == edges[begin].low && edges[end].high == edges[begin].high; ++end)
            surplus += edges[end].direction;
        measure.unpaired_edges += static_cast<std::size_t>(std::abs(surplus));
        ++distinct;
    }
    measure.euler = static_cast<std::int64_t>(vertices) - static_cast<std::int64_t>(distinct) +
                    static_cast<std::int64_t>(mesh.triangles.size());
    return measure;
}

}  // namespace betamesh
