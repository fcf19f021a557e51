// The radius of the balls in world units: one for all frames of a sequence, whoever meshes which of them.

#pragma once

#include "batch/config/config.h"
#include "batch/platform/worker.h"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace betamesh {

/// World units.
struct ResolvedRadius {
    double radius = 0;
    double spacing = 0;
    std::string origin;  ///< how the spacing was found, for people
    std::vector<std::string> warnings;
};

/// in      all frames on disk of the input, whichever of them are to be meshed
/// notes   told of each frame that is read
/// out     nothing when the spacing must be measured and no frame can be read
/// errors  the spacing must be measured and no readable frame has seven distinct particles
std::optional<ResolvedRadius> resolveRadius(const Config& config, const std::map<int, std::string>& frames_on_disk,
                                            const WorkerEvents& notes = {});

}  // namespace betamesh
