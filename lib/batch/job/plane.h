// Frames in two dimensions: what a job may ask of them, and writing them.

#pragma once

#include "batch/config/config.h"
#include "io/svg.h"
#include "planar/skin_plane.h"

#include <string>

namespace betamesh {

/// errors  an output that has no place for what surface.dimension asks for; in two dimensions keys that only three
/// know;
///         keys of pictures where none are written
void requireDimension(const Config& config, const SkinParams& params);

/// What picture.layers and picture.bounds ask for.
std::vector<Layer> layersOf(const std::vector<std::string>& names);
PlaneBounds boundsOf(const std::string& text);

/// Curves; or, to an .svg, the layers that picture.layers names. centres: of all discs.
void writePlane(const std::string& output, const SkinnedPlane& plane, const std::vector<Vec3f>& centres,
                const SkinParams& params, const Config& config);

}  // namespace betamesh
