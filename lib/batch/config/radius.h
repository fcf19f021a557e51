// The ball radius and particle spacing of a sequence in world units: the same for all frames, whichever are meshed.

#pragma once

#include "batch/config/surface_params.h"
#include "batch/platform/worker.h"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace betamesh {

/// The spacing of the particles that a job selects, measured in several frames.
struct SequenceSpacing : MeasuredSpacing {
    ParticleInput input;  ///< which particles were measured
    int dimension = 3;
    std::vector<std::string> warnings;
};

/// Takes the spacing from the configuration, or measures it in the first, the last and a middle frame on disk that
/// allow it. A radius in world units without a spacing is compared with the measured one.
///
/// in      frames_on_disk: all frames of the input, also those that are not to be meshed
///         events: reports each frame that is read to the supervising process
///         measured: measurements of the same frames, which are not repeated; a new one is added
/// out     nullopt if the spacing has to be measured, and no frame can be read or all are empty
/// errors  the spacing has to be measured and no readable frame has seven distinct particles; a radius of more than
///         50 measured spacings, or 10 if a frame has more than 5,000 particles, unless a spacing is given as well
std::optional<ResolvedRadius> resolveRadius(const Config& config, const std::map<int, std::string>& frames_on_disk,
                                            const WorkerEvents& events, std::vector<SequenceSpacing>& measured);

}  // namespace betamesh
