// Plans a job: what is done with each frame, and with which parameters. Nothing is written yet.

#pragma once

#include "batch/config/config.h"
#include "batch/job/frames.h"
#include "batch/job/render_frames.h"
#include "batch/platform/worker.h"

#include <optional>
#include <string>
#include <vector>

namespace betamesh {

enum class FrameAction {
    mesh,            ///< read, skin, write
    write_empty,     ///< the input is missing; run.on_missing is empty
    skip_missing,    ///< the input is missing; run.on_missing is skip
    fail_missing,    ///< the input is missing; run.on_missing is error
    fail_lost,       ///< the frame ended an earlier worker process
    skip_existing,   ///< the output exists and is up to date
    refuse_existing  ///< an output exists and must not be replaced; only if PlanOptions::dry_run
};

const char* actionName(FrameAction action);

struct FrameTask {
    int frame = 0;
    std::string input;
    std::string output;
    FrameAction action = FrameAction::mesh;
    std::string picture{};      ///< path; empty: no picture
    std::string why{};          ///< why an existing output is made again, or why the frame was lost
    std::uint64_t memory = 0;   ///< estimated peak memory of the frame, bytes
    bool near_surface = false;  ///< the frame does not fit: load only the particles near its surface
};

struct PlanOptions {
    Chunk chunk;
    bool overwrite = false;
    bool skip_existing = false;
    bool dry_run = false;  ///< outputs that exist become FrameAction::refuse_existing instead of an error
    JobHistory history{};  ///< frames that ended are left out; frames that were begun may have left files
    WorkerEvents notes{};  ///< receives the frames that are read to measure spacing and camera
    bool measure = true;   ///< false: leave spacing, radius and camera open unless they tell what may be skipped
};

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

/// Plans a job. Reads inputs to measure the particle spacing and to place the camera, if the configuration needs that.
///
/// errors  missing or contradictory paths; a file that would be both read and written, or written twice; a folder that
///         cannot be written to; no frames; an output that exists although neither overwrite nor skip_existing is set;
///         a spacing that cannot be measured; lengths that 32-bit floats cannot store
Plan planJob(const Config& config, const PlanOptions& options);

/// Refuses a log file that the job reads or writes for something else.
///
/// in      pipeline: path of the pipeline file; empty: none
/// errors  the log file, or a name that it gets when it has grown, is the pipeline file, an input or an output
void requireDistinctLog(const std::string& log_file, const std::string& pipeline, const Config& config);

/// The line of --dry-run for a frame.
std::string taskLine(const FrameTask& task);

/// The path of the report beside an output: "o.0001.ply" -> "o.0001.ply.json".
std::string reportPath(const std::string& output);

/// The path of the spheres beside an output: "o.0001.ply" -> "o.0001.spheres.ply". .ply for .obj and .svg, which cannot
/// store a radius.
std::string spheresPath(const std::string& output);

}  // namespace betamesh
