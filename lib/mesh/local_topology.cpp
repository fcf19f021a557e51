
#include "mesh/local_topology.h"

#include "base/union_find.h"
#include "mesh/mesh_edges.h"
#include "mesh/mesh_measure.h"

#include <algorithm>
#include <optional>
#include <set>
#include <unordered_map>

namespace betamesh {

namespace {

// The triangles of a mesh in a box, with vertices of their own.
struct Vicinity {
    std::vector<std::uint32_t> vertex;  // of the mesh
    std::vector<double> distance;       // of each vertex
    std::vector<Triangle> triangles;
    std::vector<TriangleSide> sides;

    bool isWithin(std::uint32_t v, double reach) const { return distance[v] <= reach; }
};

// Rims run through triangles, from one edge that leads out to another.
std::int64_t rimsOf(const Vicinity& vicinity, double reach) {
    std::vector<std::optional<std::uint32_t>> edge_of_side(vicinity.sides.size());
    std::uint32_t edges = 0;
    forEveryEdge(vicinity.sides, [&](std::span<const TriangleSide> edge) {
        if (vicinity.isWithin(edge[0].low, reach) == vicinity.isWithin(edge[0].high, reach)) return;
        for (const TriangleSide& side : edge) edge_of_side[side.side] = edges;
        ++edges;
    });
    UnionFind rims(edges);
    for (std::size_t t = 0; t < edge_of_side.size(); t += 3)
        for (std::size_t m = 0; m < 3; ++m)
            if (const auto& one = edge_of_side[t + m], &next = edge_of_side[t + (m + 1) % 3]; one && next)
                rims.join(*one, *next);
    return static_cast<std::int64_t>(rims.groups());
}

}  // namespace

MeshParts::MeshParts(const Mesh& mesh)
    : position_(mesh.position),
      triangles_(placedTriangles(mesh)),
      tree_(position_, triangles_),
      pieces_(componentsOf(position_.size(), triangles_)),
      volume_(pieces_.count, 0) {
    for (const Triangle& t : triangles_) {
        const Vec3& origin = position_[triangles_[0][0]];
        volume_[pieces_.of_vertex[t[0]]] +=
            volumeBelow(position_[t[0]] - origin, position_[t[1]] - origin, position_[t[2]] - origin);
    }
}

std::vector<LocalTopology> MeshParts::near(std::span<const Vec3> points, std::span<const double> distances) const {
    std::vector<Triangle> single;
    Box box;
    for (std::uint32_t i = 0; i < points.size(); ++i) {
        single.push_back({i, i, i});
        box.extendBy(points[i]);
    }
    const Vec3 farthest(*std::max_element(distances.begin(), distances.end()));
    box.min -= farthest, box.max += farthest;

    const TriangleTree nearest(points, single);
    Vicinity vicinity;
    std::unordered_map<std::uint32_t, std::uint32_t> local;
    tree_.forTriangles([&](const Box& other) { return box.intersects(other); },
                       [&](std::uint32_t row) {
                           Triangle& t = vicinity.triangles.emplace_back(triangles_[row]);
                           for (std::uint32_t& v : t) {
                               const auto [at, is_new] = local.insert({v, static_cast<std::uint32_t>(local.size())});
                               if (is_new) {
                                   vicinity.vertex.push_back(v);
                                   vicinity.distance.push_back(nearest.distanceTo(position_[v]));
                               }
                               v = at->second;
                           }
                           return true;
                       });
    vicinity.sides = sortedSides(vicinity.triangles);

    std::vector<LocalTopology> found;
    for (const double reach : distances) {
        LocalTopology part;
        std::set<std::uint32_t> pieces;
        for (std::uint32_t v = 0; v < vicinity.vertex.size(); ++v) {
            if (!vicinity.isWithin(v, reach)) continue;
            ++part.euler;
            pieces.insert(pieces_.of_vertex[vicinity.vertex[v]]);
        }
        for (const std::uint32_t piece : pieces) ++(volume_[piece] < 0 ? part.voids : part.pieces);
        const std::int64_t outside = static_cast<std::int64_t>(vicinity.vertex.size()) - part.euler;
        UnionFind parts(vicinity.vertex.size());
        forEveryEdge(vicinity.sides, [&](std::span<const TriangleSide> edge) {
            const bool low = vicinity.isWithin(edge[0].low, reach), high = vicinity.isWithin(edge[0].high, reach);
            if (low && high) {
                --part.euler;
                parts.join(edge[0].low, edge[0].high);
            }
            part.closed = part.closed && (edge.size() == 2 || !(low || high));
        });
        for (const Triangle& t : vicinity.triangles)
            part.euler += std::all_of(t.begin(), t.end(), [&](std::uint32_t v) { return vicinity.isWithin(v, reach); });
        part.parts = static_cast<std::int64_t>(parts.groups()) - outside;
        part.rims = rimsOf(vicinity, reach);
        found.push_back(part);
    }
    return found;
}

}  // namespace betamesh
