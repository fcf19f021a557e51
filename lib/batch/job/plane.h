// Frames in two dimensions: checks of the configuration, output as curves or as a picture.

#pragma once

#include "batch/config/config.h"
#include "betamesh/skin.h"
#include "io/svg.h"

#include <string>

namespace betamesh {

/// Checks that configuration and output fit surface.dimension.
///
/// errors  an output format that cannot store meshes or curves, whichever is needed; in two dimensions, keys that are
/// for
///         three dimensions only; keys of pictures if the output is not a picture
void requireDimension(const Config& config, const SkinParams& params);

/// The values of picture.layers and picture.bounds.
std::vector<Layer> parseLayers(const std::vector<std::string>& names);
PlaneBounds parseBounds(const std::string& text);

/// Writes the curves; to an .svg, the layers in picture.layers. centres: of all discs, world units.
void writePlane(const std::string& output, const SkinnedPlane& plane, const std::vector<Vec3f>& centres,
                const SkinParams& params, const Config& config);

}  // namespace betamesh
