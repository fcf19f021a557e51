// What a surface is coloured by.

#pragma once

#include "betamesh/mesh.h"
#include "render/render_settings.h"

namespace betamesh {

/// Linear red, green, blue. One of `vertex` and `triangle` has rows, or neither: then all is `plain`.
struct SurfaceColours {
    Vec3f plain{0, 0, 0};
    std::vector<Vec3f> vertex;
    std::vector<Vec3f> triangle;
    std::vector<Vec3f> sphere;  ///< none: plain
};

/// normal: of the vertices; only curvature looks at it, and at none else.
///
/// errors  an attribute that the mesh has not
SurfaceColours surfaceColours(const Mesh& mesh, const Spheres& spheres, const std::vector<Vec3>& normal,
                              const Colouring& colouring);

/// The mean over the edges of each vertex of the curvature along them, 1 / world units; 0 without triangles.
std::vector<float> vertexCurvatures(const Mesh& mesh, const std::vector<Vec3>& normal);

}  // namespace betamesh
