
#include "batch/platform/worker.h"

#include "batch/platform/exit_code.h"
#include "batch/platform/interrupt.h"
#include "batch/platform/machine.h"
#include "batch/report/log.h"
#include "betamesh/error.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <thread>
#include <utility>

namespace betamesh {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::duration<double, std::milli> kLongestPoll = std::chrono::hours(1);

/// Smaller than PIPE_BUF, so that events from several threads do not mix in the pipe.
struct Event {
    int frame;
    enum { measuring, meshing, left, written, skipped, failed } what;
};

void writeEvent(int pipe, const Event& event) {
    if (pipe < 0) return;
    while (::write(pipe, &event, sizeof event) < 0 && errno == EINTR) {
    }
}

/// False at the end of the pipe.
bool readEvent(int pipe, Event& event) {
    std::array<char, sizeof(Event)> bytes{};
    for (std::size_t have = 0; have < bytes.size();) {
        const ssize_t count = ::read(pipe, bytes.data() + have, bytes.size() - have);
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) return false;
        have += static_cast<std::size_t>(count);
    }
    std::memcpy(&event, bytes.data(), sizeof event);
    return true;
}

struct Worker {
    pid_t process;
    int pipe;
};

/// What a worker has left unfinished when it ends.
struct Unfinished {
    std::map<int, Clock::time_point> frames;  ///< in progress, with the time at which each was begun
    bool measuring = false;
    std::optional<int> overdue;    ///< the frame that exceeded the time limit, for which the worker was killed
    bool overdue_did_end = false;  ///< the overdue frame ended just before the kill
};

/// Waits for an event or the end of the pipe. Returns the first frame to exceed the time limit, if any does meanwhile.
std::optional<int> waitForEvent(int pipe, const Unfinished& left, std::chrono::duration<double> timeout) {
    const auto begunBefore = [](const auto& a, const auto& b) { return a.second < b.second; };
    for (;;) {
        const auto oldest = std::min_element(left.frames.begin(), left.frames.end(), begunBefore);
        std::chrono::duration<double, std::milli> rest = kLongestPoll;
        if (timeout.count() > 0 && oldest != left.frames.end()) rest = timeout - (Clock::now() - oldest->second);
        if (rest.count() <= 0) return oldest->first;
        pollfd poll_pipe{pipe, POLLIN,
                         0};  // poll() rather than read(): ThreadSanitizer delivers no signal during read()
        if (::poll(&poll_pipe, 1, static_cast<int>(std::min(rest, kLongestPoll).count()) + 1) > 0) return std::nullopt;
    }
}

/// Follows a worker until it ends, updates the history, and kills the worker if a frame exceeds the time limit.
Unfinished followWorker(const Worker& worker, JobHistory& history, std::chrono::duration<double> timeout) {
    Unfinished left;
    for (;;) {
        if (!left.overdue) {
            left.overdue = waitForEvent(worker.pipe, left, timeout);
            if (left.overdue) ::kill(worker.process, SIGKILL);
        }
        Event event{};
        if (!readEvent(worker.pipe, event)) break;
        if (event.what == Event::measuring || event.what == Event::meshing) {
            left.measuring = event.what == Event::measuring;
            left.frames[event.frame] = Clock::now();
            continue;
        }
        left.frames.erase(event.frame);
        if (event.what == Event::left) continue;
        history.begun.erase(event.frame);
        history.ended.insert(event.frame);
        ++(event.what == Event::written   ? history.written
           : event.what == Event::skipped ? history.skipped
                                          : history.failed);
    }
    left.overdue_did_end = left.overdue && !left.frames.contains(*left.overdue);
    return left;
}

/// Whether a worker was ended by a signal that means a crash or a lack of memory, rather than a request by the user.
bool isLoss(int status) {
    constexpr std::array kSignals{SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGKILL, SIGSEGV};
    return WIFSIGNALED(status) && std::find(kSignals.begin(), kSignals.end(), WTERMSIG(status)) != kSignals.end();
}

std::string lossBy(int signal) {
    const std::string name = "was ended by signal " + std::to_string(signal) + " (" + ::strsignal(signal) + ')';
    return signal == SIGKILL ? name + ", which the system sends when memory runs out" : name;
}

std::string lossBy(std::chrono::duration<double> timeout) {
    std::ostringstream text;
    text << "took longer than " << timeout.count() << " s (run.timeout)";
    return text.str();
}

/// Continues the sentence of JobHistory::last_loss where the job cannot go on.
std::string whenLost(const Unfinished& left) {
    if (left.frames.empty()) return " while no frame was in progress";
    std::string frames;
    for (const auto& frame : left.frames) frames += (frames.empty() ? "" : ", ") + std::to_string(frame.first);
    return " while spacing and camera were measured in frame " + frames +
           ". Repair or remove the frame, or set --spacing and the camera";
}

/// The state of a thread as the kernel names it; S: asleep.
char stateOfThread(const std::filesystem::path& thread) {
    std::ifstream file(thread / "stat");
    const std::string line{std::istreambuf_iterator<char>(file), {}};
    const std::size_t name_end = line.rfind(')');
    return name_end + 2 < line.size() ? line[name_end + 2] : 'S';
}

/// OpenVDB's log (log4cplus) starts a pool of threads when it is loaded. A child inherits locks but not the threads
/// that hold them, so a fork has to wait until these threads have started and are idle. Gives up after a second.
void awaitIdleThreads() {
    const std::string self = std::to_string(::getpid());
    const auto latest = Clock::now() + std::chrono::seconds(1);
    for (bool any_running = true; any_running && Clock::now() < latest;) {
        any_running = false;
        for (const auto& thread : std::filesystem::directory_iterator("/proc/self/task"))
            any_running |= thread.path().filename() != self && stateOfThread(thread) != 'S';
        if (any_running) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
}

/// In the supervisor: the worker and the end of the pipe to read from. In the worker: process 0, the end to write to.
Worker startWorker() {
    const pid_t supervisor = ::getpid();
    std::array<int, 2> pipe{};
    if (::pipe2(pipe.data(), O_CLOEXEC) != 0)
        throw Error(std::string("cannot create a pipe for a worker process: ") + std::strerror(errno));
    awaitIdleThreads();
    const pid_t worker = ::fork();
    if (worker < 0) throw Error(std::string("cannot start a worker process: ") + std::strerror(errno));
    if (worker == 0) {
        ::prctl(PR_SET_PDEATHSIG, SIGKILL);
        if (::getppid() != supervisor) ::_exit(kSignalBase + SIGKILL);  // the supervisor ended before prctl()
    }
    ::close(pipe[worker == 0 ? 0 : 1]);
    return {worker, pipe[worker == 0 ? 1 : 0]};
}

/// Waits for the end of the process.
int exitStatusOf(const Worker& worker) {
    ::close(worker.pipe);
    int status = 0;
    while (::waitpid(worker.process, &status, 0) < 0 && errno == EINTR) {
    }
    return status;
}

/// Debuggers, emulators and ThreadSanitizer do not follow a process with threads into its child.
bool isSupervisionOff() {
#if defined(__SANITIZE_THREAD__)
    return true;
#else
    const char* const supervise = std::getenv("BETAMESH_SUPERVISE");
    return supervise != nullptr && std::strcmp(supervise, "0") == 0;
#endif
}

Supervision inWorker(int pipe, JobHistory history, bool reads_vdb) {
    keepFreedMemory();
    if (reads_vdb) limitToMachine();
    return {true, WorkerEvents(pipe), std::move(history), 0};
}

}  // namespace

std::map<int, std::string> measurableOf(std::map<int, std::string> files, const JobHistory& history) {
    for (const auto& unmeasured : history.unmeasured) files.erase(unmeasured.first);
    return files;
}

WorkerEvents::FrameInProgress::FrameInProgress(const WorkerEvents& events, int frame, Doing doing)
    : events_(events), frame_(frame) {
    writeEvent(events_.pipe_, {frame_, doing == Doing::measuring ? Event::measuring : Event::meshing});
}

WorkerEvents::FrameInProgress::~FrameInProgress() { writeEvent(events_.pipe_, {frame_, Event::left}); }

void WorkerEvents::ended(int frame, FrameStatus status) const {
    writeEvent(pipe_, {frame, status == FrameStatus::failed    ? Event::failed
                              : status == FrameStatus::skipped ? Event::skipped
                                                               : Event::written});
}

Supervision superviseWorkers(bool reads_vdb, double timeout) {
    if (isSupervisionOff()) return inWorker(-1, {}, reads_vdb);
    const std::chrono::duration<double> longest(timeout);
    JobHistory history;
    for (;;) {
        const Worker worker = startWorker();
        if (worker.process == 0) return inWorker(worker.pipe, std::move(history), reads_vdb);
        const Unfinished left = followWorker(worker, history, longest);
        const int status = exitStatusOf(worker);
        if (WIFEXITED(status)) return {false, {}, {}, WEXITSTATUS(status)};
        const int signal = WTERMSIG(status);
        if (caughtSignal() != 0) return {false, {}, {}, kSignalBase + caughtSignal()};
        if (!isLoss(status)) return {false, {}, {}, kSignalBase + signal};
        const bool by_memory = signal == SIGKILL && !left.overdue;
        history.kills += by_memory ? 1 : 0;
        history.last_loss = left.overdue ? "frame " + std::to_string(*left.overdue) + ' ' + lossBy(longest)
                                         : "a worker process " + lossBy(signal);
        for (const auto& frame : left.frames) history.begun.insert(frame.first);
        if (left.overdue_did_end) continue;
        if (left.frames.empty() || (left.measuring && signal == SIGKILL)) {
            logError(history.last_loss + whenLost(left));
            return {false, {}, {}, by_memory ? kOutOfMemory : kSomeFailed};
        }
        if (left.frames.size() > 1 && !left.overdue) continue;
        const int frame = left.overdue.value_or(left.frames.begin()->first);
        const std::string why =
            left.overdue ? lossBy(longest)
                         : "the process that worked on it " + lossBy(signal) +
                               ". Check whether the file is damaged and whether there is enough memory for it";
        history.lost[frame] = why;
        if (left.measuring) history.unmeasured[frame] = why;
        history.out_of_memory = history.out_of_memory || by_memory;
    }
}

}  // namespace betamesh
