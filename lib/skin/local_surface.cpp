#include "skin/local_surface.h"

#include "base/index.h"
#include "base/parallel.h"
#include "mesh/mesh_edges.h"

#include <utility>

namespace betamesh {

std::vector<std::uint32_t> withRings(const BetaMesh& mesh, const std::vector<std::uint32_t>& triangles, int rings) {
    std::vector<std::uint32_t> rows = triangles;
    std::vector<std::uint8_t> is_near(mesh.vertex.size(), 0);
    for (int ring = 0; ring < rings; ++ring) {
        for (const std::uint32_t t : rows)
            for (const std::uint32_t v : mesh.triangles[t]) is_near[v] = 1;
        rows = indicesWhere(mesh.triangles.size(), [&](std::uint32_t t) {
            const auto& [a, b, c] = mesh.triangles[t];
            return (is_near[a] | is_near[b] | is_near[c]) != 0;
        });
    }
    return rows;
}

LocalSurface::LocalSurface(const BetaMesh& mesh, std::vector<std::uint32_t> rows) : row(std::move(rows)) {
    std::vector<std::uint32_t> local(mesh.vertex.size(), kInvalidIndex);
    triangles.reserve(row.size());
    for (const std::uint32_t r : row) {
        Triangle& t = triangles.emplace_back(mesh.triangles[r]);
        for (std::uint32_t& v : t) {
            if (local[v] == kInvalidIndex) {
                local[v] = static_cast<std::uint32_t>(position.size());
                position.push_back(mesh.vertex[v].position);
                vertex.push_back(v);
            }
            v = local[v];
        }
    }
    first_at = firstVerticesAtPositions(position);
    across = trianglesAcross(sortedSides(triangles));
}

}  // namespace betamesh
