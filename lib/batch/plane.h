// Frames in two dimensions: what a job may ask of them, and writing them.

#pragma once

#include "batch/config.h"
#include "io/svg.h"
#include "planar/skin_plane.h"

#include <string>

namespace betamesh {

/// errors  keys that only three dimensions know; keys of pictures where none are written
void requirePlanar(const Config& config, const SkinParams& params);

/// What picture.layers and picture.bounds ask for.
std::vector<Layer> layersOf(const std::vector<std::string>& names);
PlaneBounds boundsOf(const std::string& text);

/// Curves; or, to an .svg, the layers that picture.layers names. centres: of all discs.
void writePlane(const std::string& output, const SkinnedPlane& plane, const std::vector<Vec3f>& centres,
                const SkinParams& params, const Config& config);

}  // namespace betamesh
