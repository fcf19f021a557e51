// Makes the outputs of one frame.

#pragma once

#include "batch/job/job_state.h"
#include "batch/job/output_plan.h"
#include "batch/report/report.h"

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace betamesh {

/// Makes the outputs of a frame one after the other. Outputs that select the same particles read the frame once, and
/// those that also have the same surface settings skin it once.
///
/// in      row: of the frame in the tasks of each plan; near_surface: keep only the particles near the surface in
///         memory, even if all would fit
///         results: of outputs that an earlier call has completed; they are not made again
/// out     results: those of all outputs, with the errors of those that failed
/// errors  Interrupted and std::bad_alloc; `results` then has the outputs that are complete
void processFrame(std::span<const Plan> outputs, std::size_t row, bool near_surface, JobState& job,
                  std::vector<FrameResult>& results);

/// Adds the results of the outputs that are not in `results` yet: they failed because of `why`.
void failFrame(std::span<const Plan> outputs, std::size_t row, const std::string& why,
               std::vector<FrameResult>& results);

}  // namespace betamesh
