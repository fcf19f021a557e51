// A frame as a picture: the whole room on one screen.

#pragma once

#include "render/camera.h"
#include "render/picture.h"
#include "render/render_settings.h"

namespace betamesh {

/// Casts rays at a mesh and the spheres beside it, with motion blur where they have velocities and the shutter opens.
///
/// same    pixels for any thread count
/// cost    O(triangles log triangles + pixels · samples)
/// errors  an attribute to colour by that the mesh has not
Picture renderFrame(const Mesh& mesh, const Spheres& spheres, const Camera& camera, const Look& look);

}  // namespace betamesh
