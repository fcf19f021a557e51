// Renders a frame: a mesh, spheres beside it, a camera and settings become a picture.

#pragma once

#include "render/camera.h"
#include "render/picture.h"
#include "render/render_settings.h"

namespace betamesh {

/// Ray traces a mesh and spheres. They are motion blurred if they have velocities and the exposure time is positive.
///
/// same    pixels for any thread count
/// cost    O(triangles log triangles + pixels · samples)
/// errors  the mesh lacks the attribute to colour by; a camera farther away than 1e15 times the size of the scene
Picture renderFrame(const Mesh& mesh, const Spheres& spheres, const Camera& camera, const RenderSettings& settings);

}  // namespace betamesh
