// What a job is going to do, decided before anything is written.

#pragma once

#include "batch/config/config.h"
#include "batch/job/frames.h"
#include "batch/job/preview.h"
#include "batch/platform/worker.h"

#include <optional>
#include <string>
#include <vector>

namespace betamesh {

enum class FrameAction {
    mesh,            ///< read, skin, write
    write_empty,     ///< no input; an empty mesh was asked for
    skip_missing,    ///< no input; to be left out
    fail_missing,    ///< no input; an error
    fail_lost,       ///< ended the process that worked on it
    skip_existing,   ///< the output is there, and would be made the same again
    refuse_existing  ///< something is there; only in plans that are not run
};

const char* actionName(FrameAction action);

struct FrameTask {
    int frame = 0;
    std::string input;
    std::string output;
    FrameAction action = FrameAction::mesh;
    std::string picture{};      ///< empty: none
    std::string why{};          ///< an output that is there is made again
    std::uint64_t memory = 0;   ///< that the frame is likely to take at its peak, bytes
    bool near_surface = false;  ///< that is too much: only particles near the surface are to be in memory
};

struct PlanOptions {
    Chunk chunk;
    bool overwrite = false;
    bool skip_existing = false;
    bool dry_run = false;  ///< an existing output does not end the planning; reads only to tell what may be skipped
    JobHistory history{};  ///< frames that ended are left out, those that began may have left files
    WorkerEvents notes{};    ///< told what is read to measure the spacing
};

struct Plan {
    Config config;
    std::string configuration;     ///< its fingerprint
    std::vector<FrameTask> tasks;  ///< ascending frames
    SkinParams skin;               ///< its radius is 0 when no frame could be read to measure it
    double spacing = 0;            ///< world units
    std::optional<PreviewPlan> preview;
    int threads = 1;
    std::size_t frames_in_flight = 1;   ///< at most; fewer where memory is short
    std::uint64_t memory_budget = 0;    ///< for all frames at work, bytes
    std::vector<std::string> notes;     ///< for the log
    std::vector<std::string> warnings;  ///< for the log
};

/// How many threads a job uses: as many as it says, or as the machine grants.
int threadsOf(const Config& config);

/// For all that is at work at once, bytes. What the machine has is not all for this process, and a limit that is
/// enforced counts memory that is set aside but not held.
std::uint64_t memoryBudget(const Config& config);

/// errors  paths that are missing or do not fit together; no frame at all; an output that exists while
///         neither overwrite nor skip_existing is set; a spacing that cannot be measured
Plan planJob(const Config& config, const PlanOptions& options);

/// A line of --dry-run.
std::string taskLine(const FrameTask& task);

/// The report beside an output: "o.0001.ply" -> "o.0001.ply.json".
std::string reportPath(const std::string& output);

/// The spheres beside an output: "o.0001.ply" -> "o.0001.spheres.ply". An .obj or .svg cannot hold a radius: .ply then.
std::string spheresPath(const std::string& output);

}  // namespace betamesh
