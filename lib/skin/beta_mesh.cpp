#include "skin/beta_mesh.h"

#include "base/parallel.h"
#include "mesh/mesh_edges.h"
#include "mesh/vertex_normals.h"

namespace betamesh {

Mesh asMesh(const std::vector<DualVec3>& vertex, std::vector<Triangle> triangles) {
    const std::vector<std::uint32_t> used = verticesOf(triangles, vertex.size());
    std::vector<std::uint32_t> new_index(vertex.size());
    Mesh mesh;
    firstTouchResize(mesh.position, used.size());
    firstTouchResize(mesh.velocity, used.size());
    parallelFor(used.size(), 4096, [&](std::size_t i) {
        const std::uint32_t v = used[i];
        new_index[v] = static_cast<std::uint32_t>(i);
        mesh.position[i] = vertex[v].position;
        mesh.velocity[i] = vertex[v].velocity;
    });
    mesh.triangles = std::move(triangles);
    parallelFor(mesh.triangles.size(), 4096, [&](std::size_t t) {
        for (std::uint32_t& v : mesh.triangles[t]) v = new_index[v];
    });
    return mesh;
}

BetaMesh asBetaMesh(const Mesh& mesh) {
    BetaMesh beta;
    beta.triangles = mesh.triangles;
    beta.vertex.reserve(mesh.position.size());
    for (const Vec3& p : mesh.position) beta.vertex.push_back({p, Vec3(0)});
    return beta;
}

void roundToFloats(BetaMesh& mesh) {
    parallelFor(mesh.vertex.size(), 8192,
                [&](std::size_t v) { mesh.vertex[v].position = roundedToFloats(mesh.vertex[v].position); });
}

void reorderVertices(BetaMesh& mesh, const std::vector<std::uint32_t>& order) {
    std::vector<std::uint32_t> new_index(order.size());
    std::vector<DualVec3> vertex(order.size());
    std::vector<Dual> rim_distance(mesh.rim_distance.size());
    std::vector<float> scale(mesh.scale.size());
    parallelFor(order.size(), 8192, [&](std::size_t i) {
        new_index[order[i]] = static_cast<std::uint32_t>(i);
        vertex[i] = mesh.vertex[order[i]];
        if (!rim_distance.empty()) rim_distance[i] = mesh.rim_distance[order[i]];
        if (!scale.empty()) scale[i] = mesh.scale[order[i]];
    });
    mesh.vertex = std::move(vertex);
    mesh.rim_distance = std::move(rim_distance);
    mesh.scale = std::move(scale);
    parallelFor(mesh.triangles.size(), 8192, [&](std::size_t t) {
        for (std::uint32_t& v : mesh.triangles[t]) v = new_index[v];
    });
    for (std::vector<FadingVertex>& group : mesh.fading)
        parallelFor(group.size(), 4096, [&](std::size_t i) {
            group[i].vertex = new_index[group[i].vertex];
            for (std::uint32_t& from : group[i].support) from = new_index[from];
        });
    for (VolumeOffset& offset : mesh.volume_offsets) offset.vertex = new_index[offset.vertex];
}

DualPoints dualPoints(const std::vector<DualVec3>& points) {
    DualPoints copy;
    copy.position.resize(points.size());
    copy.velocity.resize(points.size());
    parallelFor(points.size(), 4096, [&](std::size_t i) {
        copy.position[i] = points[i].position;
        copy.velocity[i] = Vec3f(points[i].velocity);
    });
    return copy;
}

void addLastRefinement(const FadingVertices& fading, DualPoints& points) {
    for (const std::size_t group : {kLastRefinement, kLastRefinement + 1})
        for (const FadingVertex& v : fading[group]) {
            DualVec3 sum;
            for (std::size_t k = 0; k < 4; ++k) sum = sum + points[v.support[k]] * v.support_weight[k];
            points.position.push_back(sum.position);
            points.velocity.emplace_back(sum.velocity);
        }
}

std::vector<Vec3> vertexNormals(const BetaMesh& mesh) {
    return vertexNormals(mesh.vertex.size(), mesh.triangles,
                         [&](std::uint32_t v) -> const Vec3& { return mesh.vertex[v].position; });
}

void blendFading(const FadingVertices& fading, std::vector<DualVec3>& displacement) {
    constexpr int kRounds = 4;  // vertices on facets are supports of each other
    std::vector<DualVec3> own, blended;
    for (const std::vector<FadingVertex>& group : fading) {
        own.resize(group.size());
        blended.resize(group.size());
        for (std::size_t i = 0; i < group.size(); ++i) own[i] = displacement[group[i].vertex];
        for (int round = 0; round < kRounds; ++round) {
            parallelFor(group.size(), 1024, [&](std::size_t i) {
                const FadingVertex& v = group[i];
                DualVec3 from;
                for (std::size_t k = 0; k < 4; ++k) from = from + displacement[v.support[k]] * v.support_weight[k];
                blended[i] = own[i] * v.fade + from * (1 - v.fade);
            });
            for (std::size_t i = 0; i < group.size(); ++i) displacement[group[i].vertex] = blended[i];
        }
    }
}

}  // namespace betamesh
