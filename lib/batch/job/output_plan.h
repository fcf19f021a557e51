// The plan of one output of a job: what is done with each frame, and with which parameters.

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
    bool dry_run = false;   ///< outputs that exist become FrameAction::refuse_existing instead of an error
    JobHistory history{};   ///< frames that ended are left out; frames that were begun may have left files
    WorkerEvents events{};  ///< receives the frames that are read to measure spacing and camera
    bool measure = true;    ///< false: leave spacing, radius and camera open unless they tell what may be skipped
};

/// The plan of one output of a job. Those of all outputs have the same frames in the same order, threads and memory.
struct Plan {
    Config config;
    std::string config_hash;       ///< see configHash()
    std::string preview_hash;      ///< see previewHash()
    std::vector<FrameTask> tasks;  ///< ascending frames
    SkinParams skin;               ///< radius is 0 if no frame could be read to measure the spacing
    double spacing = 0;            ///< world units
    double simplify = 0;           ///< tolerance of simplified(), world units; 0: meshes stay as they are
    std::optional<RenderPlan> preview;
    int threads = 1;
    std::size_t frames_in_flight = 1;   ///< at most; fewer if memory is short
    std::uint64_t memory_budget = 0;    ///< for all frames in progress together, bytes
    std::vector<std::string> notes;     ///< lines for the log
    std::vector<std::string> warnings;  ///< lines for the log
};

}  // namespace betamesh
