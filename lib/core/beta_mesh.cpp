#include "core/beta_mesh.h"

#include "core/parallel.h"
#include "core/vertex_normals.h"

namespace betamesh {

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
