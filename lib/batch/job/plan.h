// Plans a job: what is done with each frame, and with which parameters. Nothing is written yet.

#pragma once

#include "batch/config/config.h"
#include "batch/job/frame_task.h"
#include "batch/job/frames.h"
#include "batch/job/render_frames.h"
#include "batch/platform/worker.h"

#include <optional>
#include <string>
#include <vector>

namespace betamesh {

struct PlanOptions {
    Chunk chunk;
    bool overwrite = false;
    bool skip_existing = false;
    bool dry_run = false;  ///< outputs that exist become FrameAction::refuse_existing instead of an error
    JobHistory history{};  ///< frames that ended are left out; frames that were begun may have left files
    WorkerEvents notes{};  ///< receives the frames that are read to measure spacing and camera
    bool measure = true;   ///< false: leave spacing, radius and camera open unless they tell what may be skipped
};

/// The plan of one output of a job. Those of all outputs have the same frames in the same order, threads and memory.
struct Plan {
    Config config;
    std::string configuration;     ///< fingerprint of the configuration
    std::vector<FrameTask> tasks;  ///< ascending frames
    SkinParams skin;               ///< radius is 0 if no frame could be read to measure the spacing
    double spacing = 0;            ///< world units
    std::optional<RenderPlan> preview;
    int threads = 1;
    std::size_t frames_in_flight = 1;   ///< at most; fewer if memory is short
    std::uint64_t memory_budget = 0;    ///< for all frames in progress together, bytes
    std::vector<std::string> notes;     ///< lines for the log
    std::vector<std::string> warnings;  ///< lines for the log
};

/// The threads of a job: run.threads, at most mostThreads(), or availableThreads() if that is auto.
int threadsOf(const Config& config);

/// The memory for all frames in progress together, bytes: four fifths of run.memory_limit or of availableMemory(). The
/// rest is for other processes, and for memory that is allocated but not used, which an enforced limit counts.
std::uint64_t memoryBudget(const Config& config);

/// Plans all outputs of a job. Reads inputs to measure the particle spacing and to place the camera, if the
/// configuration needs that.
///
/// errors  missing or contradictory paths; a file that would be both read and written, or written twice; a folder that
///         cannot be written to; no frames; an output that exists although neither overwrite nor skip_existing is set;
///         a spacing that cannot be measured; lengths that 32-bit floats cannot store
std::vector<Plan> planOutputs(const Config& config, const PlanOptions& options);

/// Plans the first output of a job.
Plan planJob(const Config& config, const PlanOptions& options);

/// The line of --dry-run for a frame.
std::string taskLine(const FrameTask& task);

}  // namespace betamesh
