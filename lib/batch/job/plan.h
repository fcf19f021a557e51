// Plans a job: what is done with each frame of each output, and with which parameters. Nothing is written yet.

#pragma once

#include "batch/job/output_plan.h"

#include <cstdint>
#include <string>
#include <vector>

namespace betamesh {

/// The threads of a job: run.threads, at most mostThreads(), or availableThreads() if that is auto.
int threadsOf(const Config& config);

/// The memory for all frames in progress together, bytes: four fifths of run.memory_limit or of availableMemory(). The
/// rest is for other processes, and for memory that is allocated but not used, which an enforced limit counts.
std::uint64_t memoryBudget(const Config& config);

/// Checks a configuration as far as possible without the files of the job. Paths may be missing, as in a file that
/// others include.
///
/// errors  those of planOutputs() that do not depend on files
void checkConfig(const Config& config);

/// Plans all outputs of a job. Reads inputs to measure the particle spacing and to place the camera, if the
/// configuration needs that.
///
/// errors  missing or contradictory paths; a file that would be both read and written, or written twice; a folder that
///         cannot be written to; no frames; an output that exists although neither overwrite nor skip_existing is set;
///         a spacing that cannot be measured; lengths that 32-bit floats cannot store
std::vector<Plan> planOutputs(const Config& config, const PlanOptions& options);

/// The line of --dry-run for a frame.
std::string taskLine(const FrameTask& task);

}  // namespace betamesh
