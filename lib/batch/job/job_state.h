// What the frames of a running job share.

#pragma once

#include "batch/job/output_plan.h"
#include "batch/platform/interrupt.h"
#include "betamesh/particles.h"

#include <map>
#include <mutex>
#include <set>
#include <string>
#include <vector>

namespace betamesh {

/// State that the frames of a running job share.
struct JobState {
    SignalWatch& signals;
    std::mutex mutex{};                         // guards the following
    std::set<std::string> remarked{};           ///< kinds of remarks that the log has shown
    std::set<int> without_velocity{};           ///< frames that have none and did not fail
    std::map<int, std::string> near_surface{};  ///< by frame: a line on the particles near its surface
    std::map<int, std::string> memory_error{};  ///< by frame: why an output was not begun for lack of memory

    std::map<const Plan*, std::vector<Attribute>> columns{};  ///< attributesOfEmptyFrames() of outputs

    /// Whether a remark is the first of its kind.
    bool isFirst(const std::string& kind);
    void noteNoVelocity(int frame);
    void forgetVelocity(int frame);
    /// The attributes of an output's meshes without vertices.
    const std::vector<Attribute>& columnsOf(const Plan& plan);
};

}  // namespace betamesh
