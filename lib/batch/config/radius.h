// The ball radius and particle spacing of a sequence in world units: the same for all frames, whichever are meshed.

#pragma once

#include "batch/config/config.h"
#include "batch/platform/worker.h"
#include "skin/spacing.h"

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

/// Radius and spacing as far as the configuration alone tells them: nullopt if the spacing has to be measured.
std::optional<ResolvedRadius> givenRadius(const Config& config);

/// The particle spacing in a sequence.
struct MeasuredSpacing {
    ParticleInput input{};  ///< which particles were measured
    int dimension = 3;
    std::optional<SpacingEstimate> estimate{};  ///< nullopt: no frame has enough distinct particles
    std::size_t most_particles = 0;             ///< in a frame that could be read
    std::string where{};                        ///< "a.0001.vdb", "frames 1, 50 and 99"
    std::vector<std::string> warnings{};
};
using MeasuredSpacings = std::vector<MeasuredSpacing>;

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
                                            const WorkerEvents& events, MeasuredSpacings& measured);

/// How radius and spacing suit the particles of one frame.
struct FrameSpacing {
    std::optional<double> own;         ///< the frame's own spacing, world units
    std::optional<std::string> drift;  ///< warning: the frame's own spacing differs by more than a quarter
    std::optional<std::string> scale;  ///< warning otherwise: the radius is outside 0.8 to 3 of the own spacing
};

/// in      radius, spacing: as used, world units
/// cost    O(n log n), under 1 % of skinning the frame
FrameSpacing compareSpacing(const std::vector<Vec3f>& positions, double radius, double spacing, int dimension);

}  // namespace betamesh
