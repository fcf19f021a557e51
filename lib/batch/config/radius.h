// The ball radius and particle spacing of a sequence in world units: the same for all frames, whichever are meshed.

#pragma once

#include "batch/config/config.h"
#include "batch/platform/worker.h"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace betamesh {

/// Ball radius and particle spacing in world units.
struct ResolvedRadius {
    double radius = 0;
    double spacing = 0;
    std::string origin;  ///< where the spacing comes from, for the log: "as given", "measured in a.0001.vdb"
    std::vector<std::string> warnings;
};

/// Takes the spacing from the configuration or measures it in the first frame on disk that allows it.
///
/// in      frames_on_disk: all frames of the input, also those that are not to be meshed
///         events: reports each frame that is read to the supervising process
/// out     nullopt if the spacing has to be measured and no frame can be read
/// errors  the spacing has to be measured and no readable frame has seven distinct particles
std::optional<ResolvedRadius> resolveRadius(const Config& config, const std::map<int, std::string>& frames_on_disk,
                                            const WorkerEvents& events = {});

}  // namespace betamesh
