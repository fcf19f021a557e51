// What frames without particles have in common with the other frames of a sequence.

#pragma once

#include "batch/config/config.h"

#include <vector>

namespace betamesh {

/// The attributes of the meshes of a job, without rows: those that are requested or always transferred and that the
/// first frame on disk with particles has. So all frames of a sequence have the same attributes, whichever of them a
/// job meshes.
///
/// cost    reads the beginning of frames, until one has particles. Frames that cannot be read are left out
std::vector<Attribute> attributesOfEmptyFrames(const Config& config);

/// Puts these attributes before those that a mesh without vertices has; of two with the same name the first stays.
void putFirst(const std::vector<Attribute>& columns, std::vector<Attribute>& attributes);

}  // namespace betamesh
