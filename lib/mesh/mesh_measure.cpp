
#include "mesh/mesh_measure.h"

#include "base/compressed_rows.h"
#include "base/index.h"
#include "base/parallel.h"
#include "exact/orientation.h"

#include <algorithm>
#include <cstdlib>
#include <iterator>

namespace betamesh {

namespace {

constexpr std::size_t kBlock = 1 << 16;  // triangles that one task sums up in order

struct EdgeCount {
    std::size_t edges = 0, unpaired = 0;
};

// Each side is stored in the row of its lower vertex: the higher vertex, below 2^31, and its direction in the last bit.
EdgeCount countEdges(const std::vector<Triangle>& triangles, std::size_t vertices) {
    IndexRows others = sortedIntoRows<std::uint32_t>(vertices, triangles.size(), [&](std::size_t t, const auto& visit) {
        const auto add = [&](std::uint32_t from, std::uint32_t to) {
            visit(std::min(from, to), std::max(from, to) << 1 | (from < to ? 1 : 0));
        };
        const auto& [a, b, c] = triangles[t];
        add(a, b), add(b, c), add(c, a);
    });
    constexpr std::size_t kVerticesPerTask = 4096;
    std::vector<EdgeCount> part((vertices + kVerticesPerTask - 1) / kVerticesPerTask);
    parallelFor(part.size(), 1, [&](std::size_t p) {
        for (std::size_t v = p * kVerticesPerTask; v < std::min(vertices, (p + 1) * kVerticesPerTask); ++v) {
            auto side = others[v].begin();
            const auto last = others[v].end();
            std::sort(side, last);
            while (side != last) {
                std::int64_t surplus = 0;
                for (const std::uint32_t high = *side >> 1; side != last && *side >> 1 == high; ++side)
                    surplus += *side & 1 ? 1 : -1;
                part[p].unpaired += static_cast<std::size_t>(std::abs(surplus));
                ++part[p].edges;
            }
        }
    });
    EdgeCount sum;
    for (const EdgeCount& p : part) sum.edges += p.edges, sum.unpaired += p.unpaired;
    return sum;
}

struct Size {
    double volume = 0, area = 0;
};

Size sizeOf(const Mesh& mesh) {
    const Vec3 origin = mesh.position.empty() ? Vec3(0) : mesh.position[0];
    std::vector<Size> part((mesh.triangles.size() + kBlock - 1) / kBlock);
    parallelFor(part.size(), 1, [&](std::size_t p) {
        for (std::size_t t = p * kBlock; t < std::min(mesh.triangles.size(), (p + 1) * kBlock); ++t) {
            const auto at = [&](std::size_t k) { return mesh.position[mesh.triangles[t][k]] - origin; };
            const Vec3 a = at(0), b = at(1), c = at(2);
            part[p].volume += volumeBelow(a, b, c);
            part[p].area += areaOf(a, b, c);
        }
    });
    Size sum;
    for (const Size& p : part) sum.volume += p.volume, sum.area += p.area;
    return sum;
}

}  // namespace

MeshMeasure measureMesh(const Mesh& mesh) {
    MeshMeasure measure;
    Components components;
    EdgeCount edges;
    Size size;
    // componentsOf() runs on one thread and takes about as long as the other two together.
    parallelBoth([&] { components = componentsOf(mesh.position.size(), mesh.triangles); },
                 [&] {
                     edges = countEdges(mesh.triangles, mesh.position.size());
                     size = sizeOf(mesh);
                 });
    measure.components = components.count;
    measure.unpaired_edges = edges.unpaired;
    measure.volume = size.volume;
    measure.area = size.area;
    measure.euler = std::count_if(components.of_vertex.begin(), components.of_vertex.end(),
                                  [](std::uint32_t component) { return component != kInvalidIndex; });
    measure.euler += static_cast<std::int64_t>(mesh.triangles.size()) - static_cast<std::int64_t>(edges.edges);
    return measure;
}

std::vector<Triangle> measurableTriangles(const Mesh& mesh) {
    std::vector<Triangle> measurable;
    std::copy_if(mesh.triangles.begin(), mesh.triangles.end(), std::back_inserter(measurable), [&](const Triangle& t) {
        return std::all_of(t.begin(), t.end(),
                           [&](std::uint32_t v) { return v < mesh.position.size() && isInRange(mesh.position[v]); });
    });
    return measurable;
}

}  // namespace betamesh
