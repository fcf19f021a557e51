
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

// The triangles of a mesh near a box, with vertices renumbered from 0.
struct Submesh {
    std::vector<std::uint32_t> vertex;  // vertex of the mesh
    std::vector<double> distance;       // of each vertex to the nearest query point
    std::vector<Triangle> triangles;
    std::vector<TriangleSide> sides;

    bool isWithin(std::uint32_t v, double reach) const { return distance[v] <= reach; }
};

// The number of closed curves along which the part within `reach` is cut out. Such a curve passes through triangles,
// from one edge that crosses the distance to the next.
std::int64_t rimsOf(const Submesh& submesh, double reach) {
    std::vector<std::optional<std::uint32_t>> edge_of_side(submesh.sides.size());
    std::uint32_t edges = 0;
    forEveryEdge(submesh.sides, [&](std::span<const TriangleSide> edge) {
        if (submesh.isWithin(edge[0].low, reach) == submesh.isWithin(edge[0].high, reach)) return;
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

LocalTopologyQuery::LocalTopologyQuery(const Mesh& mesh)
    : position_(mesh.position),
      triangles_(measurableTriangles(mesh)),
      tree_(position_, triangles_),
      components_(componentsOf(position_.size(), triangles_)),
      volume_(components_.count, 0) {
    for (const Triangle& t : triangles_) {
        const Vec3& origin = position_[triangles_[0][0]];
        volume_[components_.of_vertex[t[0]]] +=
            volumeBelow(position_[t[0]] - origin, position_[t[1]] - origin, position_[t[2]] - origin);
    }
}

std::vector<LocalTopology> LocalTopologyQuery::near(std::span<const Vec3> points,
                                                    std::span<const double> distances) const {
    std::vector<Triangle> single;
    Box box;
    for (std::uint32_t i = 0; i < points.size(); ++i) {
        single.push_back({i, i, i});
        box.extendBy(points[i]);
    }
    const Vec3 farthest(*std::max_element(distances.begin(), distances.end()));
    box.min -= farthest, box.max += farthest;

    const TriangleTree nearest(points, single);
    Submesh submesh;
    std::unordered_map<std::uint32_t, std::uint32_t> local;
    tree_.forTriangles([&](const Box& other) { return box.intersects(other); },
                       [&](std::uint32_t row) {
                           Triangle& t = submesh.triangles.emplace_back(triangles_[row]);
                           for (std::uint32_t& v : t) {
                               const auto [at, is_new] = local.insert({v, static_cast<std::uint32_t>(local.size())});
                               if (is_new) {
                                   submesh.vertex.push_back(v);
                                   submesh.distance.push_back(nearest.distanceTo(position_[v]));
                               }
                               v = at->second;
                           }
                           return true;
                       });
    submesh.sides = sortedSides(submesh.triangles);

    std::vector<LocalTopology> found;
    for (const double reach : distances) {
        LocalTopology topology;
        std::set<std::uint32_t> components;
        for (std::uint32_t v = 0; v < submesh.vertex.size(); ++v) {
            if (!submesh.isWithin(v, reach)) continue;
            ++topology.euler;
            components.insert(components_.of_vertex[submesh.vertex[v]]);
        }
        for (const std::uint32_t component : components)
            ++(volume_[component] < 0 ? topology.voids : topology.outer_surfaces);
        const std::int64_t outside = static_cast<std::int64_t>(submesh.vertex.size()) - topology.euler;
        UnionFind patches(submesh.vertex.size());
        forEveryEdge(submesh.sides, [&](std::span<const TriangleSide> edge) {
            const bool low = submesh.isWithin(edge[0].low, reach), high = submesh.isWithin(edge[0].high, reach);
            if (low && high) {
                --topology.euler;
                patches.join(edge[0].low, edge[0].high);
            }
            topology.closed = topology.closed && (edge.size() == 2 || !(low || high));
        });
        for (const Triangle& t : submesh.triangles)
            topology.euler +=
                std::all_of(t.begin(), t.end(), [&](std::uint32_t v) { return submesh.isWithin(v, reach); });
        topology.patches = static_cast<std::int64_t>(patches.groups()) - outside;
        topology.rims = rimsOf(submesh, reach);
        found.push_back(topology);
    }
    return found;
}

}  // namespace betamesh
