// What a dry run finds out about a frame without meshing it.

#pragma once

#include "batch/job/output_plan.h"

#include <string>

namespace betamesh {

/// Why a frame will fail: its particles cannot be read, or lack an attribute that the output needs. Empty if nothing
/// speaks against it. Reads the whole file.
std::string whyFrameFails(const FrameTask& task, const Plan& plan);

}  // namespace betamesh
