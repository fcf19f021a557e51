// Runs a plan: many frames at once, each for itself.

#pragma once

#include "batch/job/plan.h"
#include "batch/platform/interrupt.h"
#include "batch/report/report.h"

#include <functional>

namespace betamesh {

/// What all commands return.
enum ExitCode {
    kAllWritten = 0,
    kSomeFailed = 1,
    kWrongUsage = 2,
    kOutOfMemory = 33,
    kSignalBase = 128  ///< plus the signal: 130 SIGINT, 143 SIGTERM
};

struct JobResult {
    std::size_t written = 0;  ///< empty frames included
    std::size_t skipped = 0;
    std::size_t failed = 0;
    bool out_of_memory = false;
    int signal = 0;  ///< that ended the job before all frames were begun
    int exitCode() const;
};

/// Called as each frame ends, in the order in which they end; one thread at a time.
using FrameEnded = std::function<void(const FrameReport&)>;

/// Meshes the frames of a plan. Every frame stands for itself: one that fails does not keep the
/// others from being written, writes no mesh of its own and leaves an older one as it was.
///
/// out     for each frame the mesh, its spheres if it has any, then its report; each complete or absent, and of one
///         writer even where several processes mesh the same frame
/// same    bytes of meshes and spheres for any number of threads and frames in flight
/// errors  an output folder that cannot be made, before any frame begins; what else goes wrong is in the
///         reports
JobResult runJob(const Plan& plan, SignalWatch& signals, const WorkerEvents& notes, const FrameEnded& frameEnded);

}  // namespace betamesh
