// The local origin of a sequence whose coordinates are too large for single precision.

#pragma once

#include "batch/config/config.h"
#include "batch/platform/worker.h"

#include <map>
#include <string>

namespace betamesh {

/// The point that is subtracted from all positions, in units of the file: input.origin if it is given. For auto it is
/// the localOriginOf() the first frame on disk that can be read and has particles.
///
/// in      frames_on_disk: all frames of the input, also those that are not to be meshed
///         events: reports each frame that is read to the supervising process
/// same    the origin for any choice of frames
Vec3 resolvedLocalOrigin(const Config& config, const std::map<int, std::string>& frames_on_disk,
                         const WorkerEvents& events = {});

}  // namespace betamesh
