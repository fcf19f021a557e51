// Reads the particles of a frame, and says what of the file is not used.

#pragma once

#include "batch/job/output_plan.h"
#include "batch/job/provenance.h"
#include "io/particle_file.h"
#include "skin/near_surface.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace betamesh {

/// The particles of a frame.
struct FrameInput {
    Particles particles;              ///< all that are chosen, or those in near->row
    std::optional<NearSurface> near;  ///< set if only the particles near the surface were read
    InputSummary summary;
};

/// Reads the input of a frame, and its identity at the same time.
///
/// in      near_surface: read only the particles near the surface, if the output depends on these alone
///         foundNear: gets a line on the particles near the surface before they are read
/// errors  those of readParticles(); the file changes while it is read: the simulation is still writing it
FrameInput readInput(const FrameTask& task, const Plan& plan, bool near_surface, FileIdentity& identity,
                     const std::function<void(const std::string&)>& foundNear);

/// errors  an attribute of output.attributes that the particles do not have, that is read as the velocity or the id, or
///         that is a component of another one
void requireAttributes(const FrameInput& liquid, const Config& config);

/// The kind of the remark that a frame has no velocity.
inline constexpr const char* kNoVelocity = "no velocity";

/// Something about the input of a frame that the user should know.
struct InputRemark {
    std::string kind;         ///< the log shows one remark of each kind
    bool is_warning = false;  ///< goes into the manifest of each frame, too
    std::string text;
};

/// Remarks on the velocity, on particles, attributes, groups and grids that are not used, on values that are not
/// finite, on sizes that swallow other particles, and on places where single precision is coarse.
std::vector<InputRemark> remarksOn(const FrameInput& liquid, const Plan& plan);

/// The parts of a file with their use in a job: requested attributes and accelerations are "output".
std::vector<InputPart> partsOf(const FrameInput& liquid, const Config& config);

}  // namespace betamesh
