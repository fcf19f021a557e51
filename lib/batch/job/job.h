// Runs the frames of a plan in parallel, independently of each other.

#pragma once

#include "batch/job/output_plan.h"
#include "batch/platform/exit_code.h"
#include "batch/platform/interrupt.h"
#include "batch/platform/worker.h"
#include "batch/report/report.h"

#include <functional>
#include <vector>

namespace betamesh {

struct JobResult {
    std::size_t written = 0;  ///< empty frames included
    std::size_t skipped = 0;
    std::size_t failed = 0;
    bool out_of_memory = false;
    bool layer_failed = false;  ///< the layer that plays the frames could not be written
    int signal = 0;             ///< that ended the job before all frames were done; 0: none
    int exitCode() const;
};

/// Called for each frame when it ends, from one thread at a time, with the results of its outputs.
using FrameEnded = std::function<void(const std::vector<FrameResult>& outputs)>;

/// Meshes the frames of a job, each with all its outputs. A frame that fails writes no mesh, leaves an older one as it
/// was, and does not keep other frames from being written. If its preview alone fails, its mesh is written.
///
/// After the loss of a worker process, the frames that were in progress then are run first and one at a time, because
/// one of them may be the cause.
///
/// in      outputs: at least one, from planOutputs()
///         history: what earlier workers have done, which the result includes
/// out     for each output of each frame the mesh, its spheres if it has any, its manifest, then its preview. Each file
///         is complete or absent. If several processes mesh the same frame, one complete set of files wins
/// same    bytes of meshes and spheres for any number of threads and frames in flight
/// errors  an output folder that cannot be created, before any frame is begun; all other errors are in the results
JobResult runJob(const std::vector<Plan>& outputs, const JobHistory& history, SignalWatch& signals,
                 const WorkerEvents& events, const FrameEnded& frameEnded);

}  // namespace betamesh
