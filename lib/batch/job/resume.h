// What is done with a frame whose output may exist already.

#pragma once

#include "batch/job/output_plan.h"

#include <span>

namespace betamesh {

/// Why the existing output of a task is not up to date.
struct Staleness {
    std::string why;            ///< empty: it is up to date
    bool only_preview = false;  ///< all but the preview is up to date
};

/// Whether the manifest beside an output says that a file in its folder was written with it.
bool isListed(const std::string& file, const std::string& output);

/// Compares an output with its manifest, and that with the plan. Reads the input if its size is the same and its time
/// is not.
Staleness stalenessOf(const FrameTask& task, bool input_exists, const Plan& plan);

/// Decides what is done with a task, and sets task.action and task.why.
///
/// in      plan: the plan of the task, with radius and spacing if the output exists and is to be resumed
void chooseAction(FrameTask& task, bool input_exists, const Plan& plan, const PlanOptions& options);

/// errors  tasks whose outputs exist and must not be replaced
void refuseExisting(std::span<const Plan> outputs);

}  // namespace betamesh
