// Runs a job in a worker process under supervision. A crash in a library, a frame that takes too long or a system that
// runs out of memory ends the worker, but not the job.

#pragma once

#include "batch/job/frame_task.h"

#include <cstddef>
#include <map>
#include <set>
#include <string>

namespace betamesh {

/// What earlier workers of the same job have done. Empty in the first worker.
struct JobHistory {
    std::set<int> ended;                               ///< frames
    std::size_t written = 0, skipped = 0, failed = 0;  ///< how many of the ended frames
    std::set<int> begun;              ///< in progress when a worker was lost, not ended since; may have left files
    std::map<int, std::string> lost;  ///< frames that must not be tried again, with the reason for the error message
    std::map<int, std::string> unmeasured;  ///< the lost frames that were being measured to plan the job
    int kills = 0;                          ///< workers ended by SIGKILL, as the system does when memory runs out
    bool out_of_memory = false;             ///< a single frame was enough for that
    std::string last_loss;                  ///< how the last worker ended; empty if none was lost
};

/// The files, by frame, that may be used to plan the job: all but history.unmeasured.
std::map<int, std::string> measurableOf(std::map<int, std::string> files, const JobHistory& history);

/// Reports the progress of a worker to its supervisor. Safe to call from any thread.
class WorkerEvents {
public:
    /// Reports to nobody.
    WorkerEvents() = default;
    /// Writes to this end of a pipe.
    explicit WorkerEvents(int pipe) : pipe_(pipe) {}

    enum class Doing { meshing, measuring };  ///< measuring: reading a frame to plan the job (spacing, camera)

    /// Marks a frame as in progress during the lifetime of the object.
    class FrameInProgress {
    public:
        FrameInProgress(const WorkerEvents& events, int frame, Doing doing = Doing::meshing);
        ~FrameInProgress();
        FrameInProgress(const FrameInProgress&) = delete;
        FrameInProgress& operator=(const FrameInProgress&) = delete;

    private:
        const WorkerEvents& events_;
        int frame_;
    };

    /// Reports that a frame is complete, or has failed for good.
    void ended(int frame, FrameStatus status) const;

private:
    int pipe_ = -1;
};

/// Where superviseWorkers() has returned.
struct Supervision {
    bool is_worker = false;  ///< true in a worker, false in the supervisor
    WorkerEvents events;     ///< in a worker: reports to the supervisor
    JobHistory history;      ///< in a worker: what earlier workers have done
    int exit_code = 0;       ///< in the supervisor: the exit code of the job
};

/// Starts a worker process, which returns at once and does the job. The calling process becomes its supervisor: it
/// starts a new worker whenever one is lost, and returns when the job has ended.
///
/// A worker is lost if a signal such as SIGSEGV or SIGKILL ends it, or if a frame takes longer than `timeout` (then the
/// supervisor kills it). The next worker repeats the frames that were in progress, one at a time; a frame that ends a
/// worker alone is given up (JobHistory::lost). The job ends with an error if a worker is lost while no frame is in
/// progress, or for lack of memory or time while the job is being planned: leaving out that frame would silently
/// change the measured spacing.
///
/// With BETAMESH_SUPERVISE=0 in the environment, for debuggers and emulators, the calling process does the job itself.
///
/// Call it once, before this process has started threads, after rememberSignals(), through which signals reach workers.
///
/// in      reads_vdb: the job may read .vdb files. OpenVDB allocates whatever sizes a damaged file contains, so workers
///         are then limited to the memory of the machine (availableMemory())
///         timeout: seconds per frame; 0: no limit
/// errors  the system refuses a process or a pipe
Supervision superviseWorkers(bool reads_vdb, double timeout = 0);

}  // namespace betamesh
