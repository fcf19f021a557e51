#include "core/beta_mesh.h"

#include "core/vertex_normals.h"

namespace betamesh {

std::vector<Vec3> vertexNormals(const BetaMesh& mesh) {
    return vertexNormals(mesh.vertex.size(), mesh.triangles,
                         [&](std::uint32_t v) -> const Vec3& { return mesh.vertex[v].position; });
}

}  // namespace betamesh
