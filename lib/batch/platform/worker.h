// A job in a process of its own: what ends that process, a library that gives up or a system short of memory, does not
// end the job.

#pragma once

#include <cstddef>
#include <map>
#include <set>
#include <string>

namespace betamesh {

enum class FrameStatus;

/// What workers before this one did; nothing in the first.
struct JobHistory {
    std::set<int> ended;                               ///< frames
    std::size_t written = 0, skipped = 0, failed = 0;  ///< of these
    std::set<int> begun;              ///< at work when a worker was lost, and not ended since; may have left files
    std::map<int, std::string> lost;  ///< those of them that are not to be begun again, and why: words of an error
    std::map<int, std::string> unmeasured;  ///< those of these that the job was being planned by
    int kills = 0;                          ///< workers lost as systems do it that run out of memory
    bool out_of_memory = false;             ///< one frame alone was enough for that
    std::string last_loss;                  ///< what ended the last worker; empty: there was none
};

/// Those of the files of all frames that a job may be planned by.
std::map<int, std::string> measurableOf(std::map<int, std::string> files, const JobHistory& history);

/// What a worker says of its frames to the process that watches over it. From any thread.
class WorkerEvents {
public:
    /// Tells nobody.
    WorkerEvents() = default;
    /// Writes to a pipe.
    explicit WorkerEvents(int pipe) : pipe_(pipe) {}

    enum class Doing { meshing, measuring };  // what the job is planned by

    /// While it lives, a frame is at work.
    class AtWork {
    public:
        AtWork(const WorkerEvents& notes, int frame, Doing doing = Doing::meshing);
        ~AtWork();
        AtWork(const AtWork&) = delete;
        AtWork& operator=(const AtWork&) = delete;

    private:
        const WorkerEvents& notes_;
        int frame_;
    };

    /// Nothing of a frame is left to do.
    void ended(int frame, FrameStatus status) const;

private:
    int pipe_ = -1;
};

/// Where a worker came from: true in the worker, with what it is to know; false in the process that watched, when all
/// is over, with the exit code.
///
/// To be called once, before the process has a second thread. reads_vdb: .vdb files may be read, which another process
/// does for a worker (io/vdb_process.h). Frames that were at work when a worker was lost are begun again, one after the
/// other; one that ends a worker alone is lost. So is one that takes longer than `timeout`, in seconds (0: any time is
/// well), for which its worker is ended. Where that happens while the job is being planned, or memory runs out then,
/// all is over: another frame would give another spacing. Signals reach the worker by rememberSignals(), which comes
/// before.
struct Watched {
    bool working = false;
    WorkerEvents notes;
    JobHistory history;
    int exit_code = 0;
};
Watched superviseWorkers(bool reads_vdb, double timeout = 0);

}  // namespace betamesh
