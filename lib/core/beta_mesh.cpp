#include "core/beta_mesh.h"

#include "core/angles.h"
#include "core/parallel.h"

#include <cmath>

namespace betamesh {

std::vector<Vec3> vertexNormals(const BetaMesh& mesh) {
    struct Corners {
        Vec3 normal;      // of the triangle
        float weight[3];  // its angles
    };
    std::vector<Corners> corners(mesh.triangles.size());
    parallelFor(corners.size(), 1024, [&](std::size_t i) {
        const Triangle& t = mesh.triangles[i];
        for (std::size_t m = 0; m < 3; ++m) {
            const Vec3& at = mesh.vertex[t[m]].position;
            const Vec3 u = mesh.vertex[t[(m + 1) % 3]].position - at, v = mesh.vertex[t[(m + 2) % 3]].position - at;
            const Vec3 across = cross(u, v);
            const double doubled_area = across.length();
            corners[i].weight[m] = static_cast<float>(angleOf(doubled_area, dot(u, v)));
            corners[i].normal = doubled_area > 0 ? across / doubled_area : Vec3(0, 0, 0);
        }
    });
    std::vector<Vec3> normals(mesh.vertex.size(), Vec3(0, 0, 0));
    for (std::size_t i = 0; i < corners.size(); ++i)
        for (std::size_t m = 0; m < 3; ++m)
            normals[mesh.triangles[i][m]] += corners[i].normal * static_cast<double>(corners[i].weight[m]);
    for (Vec3& normal : normals) normal.normalize();
    return normals;
}

}  // namespace betamesh
