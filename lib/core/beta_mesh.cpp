#include "core/beta_mesh.h"

#include "core/mesh_edges.h"
#include "core/parallel.h"
#include "core/vertex_normals.h"

namespace betamesh {

Mesh asMesh(const std::vector<Moving>& vertex, std::vector<Triangle> triangles) {
    const std::vector<std::uint32_t> used = verticesOf(triangles, vertex.size());
    std::vector<std::uint32_t> place(vertex.size());
    Mesh mesh;
    resizeOnAll(mesh.position, used.size());
    resizeOnAll(mesh.velocity, used.size());
    parallelFor(used.size(), 4096, [&](std::size_t i) {
        const std::uint32_t v = used[i];
        place[v] = static_cast<std::uint32_t>(i);
        mesh.position[i] = vertex[v].position;
        mesh.velocity[i] = vertex[v].velocity;
    });
    mesh.triangles = std::move(triangles);
    parallelFor(mesh.triangles.size(), 4096, [&](std::size_t t) {
        for (std::uint32_t& v : mesh.triangles[t]) v = place[v];
    });
    return mesh;
}

MovingPoints copyOf(const std::vector<Moving>& points) {
    MovingPoints copy;
    copy.position.resize(points.size());
    copy.velocity.resize(points.size());
    parallelFor(points.size(), 4096, [&](std::size_t i) {
        copy.position[i] = points[i].position;
        copy.velocity[i] = Vec3f(points[i].velocity);
    });
    return copy;
}

std::vector<Vec3> vertexNormals(const BetaMesh& mesh) {
    return vertexNormals(mesh.vertex.size(), mesh.triangles,
                         [&](std::uint32_t v) -> const Vec3& { return mesh.vertex[v].position; });
}

}  // namespace betamesh
