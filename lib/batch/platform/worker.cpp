
#include "batch/platform/worker.h"

#include "batch/job/job.h"
#include "batch/platform/interrupt.h"
#include "batch/platform/machine.h"
#include "batch/report/log.h"
#include "batch/report/report.h"
#include "betamesh/error.h"
#include "io/vdb_process.h"

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
#include <cstring>
#include <optional>
#include <sstream>
#include <utility>

namespace betamesh {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::duration<double, std::milli> kLongestPoll = std::chrono::hours(1);

/// In one piece in the pipe, from whichever thread.
struct Note {
    int frame;
    enum { measuring, meshing, left, written, skipped, failed } what;
};

void writeNote(int pipe, const Note& note) {
    if (pipe < 0) return;
    while (::write(pipe, &note, sizeof note) < 0 && errno == EINTR) {
    }
}

struct Worker {
    pid_t process;
    int pipe;
};

bool readNote(int pipe, Note& note) {
    std::array<char, sizeof(Note)> bytes{};
    for (std::size_t have = 0; have < bytes.size();) {
        const ssize_t count = ::read(pipe, bytes.data() + have, bytes.size() - have);
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) return false;
        have += static_cast<std::size_t>(count);
    }
    std::memcpy(&note, bytes.data(), sizeof note);
    return true;
}

/// What a worker that has ended leaves unfinished.
struct Unfinished {
    std::map<int, Clock::time_point> frames;  ///< and since when they were at work
    bool measuring = false;
    std::optional<int> overdue;    ///< a frame for which it was ended
    bool overdue_did_end = false;  ///< though, in the same moment
};

/// Waits for the worker to say something, or to end. Returns the first frame that takes too long, if one does.
std::optional<int> wait(int pipe, const Unfinished& left, std::chrono::duration<double> timeout) {
    const auto begunBefore = [](const auto& a, const auto& b) { return a.second < b.second; };
    for (;;) {
        const auto oldest = std::min_element(left.frames.begin(), left.frames.end(), begunBefore);
        std::chrono::duration<double, std::milli> rest = kLongestPoll;
        if (timeout.count() > 0 && oldest != left.frames.end()) rest = timeout - (Clock::now() - oldest->second);
        if (rest.count() <= 0) return oldest->first;
        pollfd note{pipe, POLLIN, 0};  // a signal wakes poll(); ThreadSanitizer delivers none to a read() that waits
        if (::poll(&note, 1, static_cast<int>(std::min(rest, kLongestPoll).count()) + 1) > 0) return std::nullopt;
    }
}

/// Until the worker has ended; ends it where a frame takes longer than timeout.
Unfinished follow(const Worker& worker, JobHistory& history, std::chrono::duration<double> timeout) {
    Unfinished left;
    for (;;) {
        if (!left.overdue) {
            left.overdue = wait(worker.pipe, left, timeout);
            if (left.overdue) ::kill(worker.process, SIGKILL);
        }
        Note note{};
        if (!readNote(worker.pipe, note)) break;
        if (note.what == Note::measuring || note.what == Note::meshing) {
            left.measuring = note.what == Note::measuring;
            left.frames[note.frame] = Clock::now();
            continue;
        }
        left.frames.erase(note.frame);
        if (note.what == Note::left) continue;
        history.begun.erase(note.frame);
        history.ended.insert(note.frame);
        ++(note.what == Note::written   ? history.written
           : note.what == Note::skipped ? history.skipped
                                        : history.failed);
    }
    left.overdue_did_end = left.overdue && !left.frames.contains(*left.overdue);
    return left;
}

/// Signals by which a library or the system ends a process, not a person.
bool isLoss(int status) {
    constexpr std::array kSignals{SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGKILL, SIGSEGV};
    if (!WIFSIGNALED(status)) return false;
    for (const int signal : kSignals)
        if (WTERMSIG(status) == signal) return true;
    return false;
}

std::string lossBy(int signal) {
    const std::string name = "was ended by signal " + std::to_string(signal) + " (" + ::strsignal(signal) + ')';
    return signal == SIGKILL ? name + ", as systems send it that run out of memory" : name;
}

std::string lossBy(std::chrono::duration<double> timeout) {
    std::ostringstream text;
    text << "took longer than " << timeout.count() << " s (run.timeout)";
    return text.str();
}

/// Where a worker was lost, as the end of a sentence.
std::string placeOf(const Unfinished& left) {
    if (left.frames.empty()) return ", before frames were begun or after they ended";
    std::string frames;
    for (const auto& frame : left.frames) frames += (frames.empty() ? "" : ", ") + std::to_string(frame.first);
    return ", while spacing and camera were measured in frame " + frames +
           "; expected them to be readable, or --spacing and where the camera stands";
}

/// A worker, or in it itself: process 0, and the end of the pipe that is written.
Worker startWorker() {
    const pid_t watching = ::getpid();
    std::array<int, 2> pipe{};
    if (::pipe2(pipe.data(), O_CLOEXEC) != 0)
        throw Error(std::string("a pipe to a process cannot be made: ") + std::strerror(errno));
    const pid_t worker = ::fork();
    if (worker < 0) throw Error(std::string("a process cannot be made: ") + std::strerror(errno));
    if (worker == 0) {
        ::prctl(PR_SET_PDEATHSIG, SIGKILL);
        if (::getppid() != watching) ::_exit(kSignalBase + SIGKILL);  // ended in between
    }
    ::close(pipe[worker == 0 ? 0 : 1]);
    return {worker, pipe[worker == 0 ? 1 : 0]};
}

/// Its status, when it has ended.
int statusOf(const Worker& worker) {
    ::close(worker.pipe);
    int status = 0;
    while (::waitpid(worker.process, &status, 0) < 0 && errno == EINTR) {
    }
    return status;
}

}  // namespace

std::map<int, std::string> measurableOf(std::map<int, std::string> files, const JobHistory& history) {
    for (const auto& unmeasured : history.unmeasured) files.erase(unmeasured.first);
    return files;
}

WorkerEvents::AtWork::AtWork(const WorkerEvents& notes, int frame, Doing doing) : notes_(notes), frame_(frame) {
    writeNote(notes_.pipe_, {frame_, doing == Doing::measuring ? Note::measuring : Note::meshing});
}

WorkerEvents::AtWork::~AtWork() { writeNote(notes_.pipe_, {frame_, Note::left}); }

void WorkerEvents::ended(int frame, FrameStatus status) const {
    writeNote(pipe_, {frame, status == FrameStatus::failed    ? Note::failed
                             : status == FrameStatus::skipped ? Note::skipped
                                                              : Note::written});
}

Watched superviseWorkers(bool reads_vdb, double timeout) {
    const std::chrono::duration<double> longest(timeout);
    JobHistory history;
    for (;;) {
        const Worker worker = startWorker();
        if (worker.process == 0) {
            keepFreedMemory();  // here: huge pages that two processes have would be copied in small ones
            if (reads_vdb) startVdbProcess();
            return {true, WorkerEvents(worker.pipe), std::move(history), 0};
        }
        const Unfinished left = follow(worker, history, longest);
        const int status = statusOf(worker);
        if (WIFEXITED(status)) return {false, {}, {}, WEXITSTATUS(status)};
        const int signal = WTERMSIG(status);
        if (caughtSignal() != 0) return {false, {}, {}, kSignalBase + caughtSignal()};
        if (!isLoss(status)) return {false, {}, {}, kSignalBase + signal};
        const bool by_memory = signal == SIGKILL && !left.overdue;
        history.kills += by_memory ? 1 : 0;
        history.last_loss = left.overdue ? "frame " + std::to_string(*left.overdue) + ' ' + lossBy(longest)
                                         : "a process " + lossBy(signal);
        for (const auto& frame : left.frames) history.begun.insert(frame.first);
        if (left.overdue_did_end) continue;
        if (left.frames.empty() || (left.measuring && signal == SIGKILL)) {
            logError(history.last_loss + placeOf(left));
            return {false, {}, {}, by_memory ? kOutOfMemory : kSomeFailed};
        }
        if (left.frames.size() > 1 && !left.overdue) continue;
        const int frame = left.overdue.value_or(left.frames.begin()->first);
        const std::string why = left.overdue ? lossBy(longest)
                                             : "the process that worked on it " + lossBy(signal) +
                                                   "; expected a file that is not damaged, and enough memory";
        history.lost[frame] = why;
        if (left.measuring) history.unmeasured[frame] = why;
        history.out_of_memory = history.out_of_memory || by_memory;
    }
}

}  // namespace betamesh
