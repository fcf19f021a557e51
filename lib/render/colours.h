// Surface colours from velocity, kind, curvature, component or an attribute.

#pragma once

#include "betamesh/mesh.h"
#include "render/render_settings.h"

namespace betamesh {

/// Linear red, green, blue. At most one of `vertex` and `triangle` has rows; if neither has, the mesh is `plain`.
struct SurfaceColours {
    Vec3f plain{0, 0, 0};
    std::vector<Vec3f> vertex;
    std::vector<Vec3f> triangle;
    std::vector<Vec3f> sphere;  ///< empty: plain
};

/// in      normal: of the vertices; may be empty unless the colour is that of curvature
/// errors  the mesh, or the spheres if there is no mesh, lack the attribute to colour by; lists the attributes that
///         there are. Spheres beside a mesh that lack it are plain
SurfaceColours surfaceColours(const Mesh& mesh, const Spheres& spheres, const std::vector<Vec3>& normal,
                              const Colouring& colouring);

/// Mean curvature at each vertex, 1 / world units: the mean of the normal curvatures along its edges. 0 without edges.
std::vector<float> vertexCurvatures(const Mesh& mesh, const std::vector<Vec3>& normal);

}  // namespace betamesh
