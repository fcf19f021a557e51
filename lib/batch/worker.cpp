#include "batch/worker.h"

#include "batch/interrupt.h"
#include "batch/job.h"
#include "batch/log.h"
#include "batch/report.h"
#include "core/error.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <utility>

namespace betamesh {
namespace {

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

/// Until the worker has ended. at_work: what it then leaves unfinished. Returns whether it was still measuring.
bool follow(int pipe, JobHistory& history, std::set<int>& at_work) {
    bool measuring = false;
    for (Note note{}; readNote(pipe, note);) {
        if (note.what == Note::measuring || note.what == Note::meshing) {
            measuring = note.what == Note::measuring;
            at_work.insert(note.frame);
            continue;
        }
        at_work.erase(note.frame);
        if (note.what == Note::left) continue;
        history.begun.erase(note.frame);
        history.ended.insert(note.frame);
        ++(note.what == Note::written   ? history.written
           : note.what == Note::skipped ? history.skipped
                                        : history.failed);
    }
    return measuring;
}

/// Signals by which a library or the system ends a process, not a person.
bool isLoss(int status) {
    constexpr std::array kSignals{SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGKILL, SIGSEGV};
    if (!WIFSIGNALED(status)) return false;
    for (const int signal : kSignals)
        if (WTERMSIG(status) == signal) return true;
    return false;
}

std::string lossOf(int signal) {
    const std::string name = "ended by signal " + std::to_string(signal) + " (" + ::strsignal(signal) + ')';
    return signal == SIGKILL ? name + ", as systems send it that run out of memory" : name;
}

pid_t startWorker(std::array<int, 2>& pipe) {
    const pid_t watching = ::getpid();
    if (::pipe2(pipe.data(), O_CLOEXEC) != 0)
        throw Error(std::string("a pipe to a process cannot be made: ") + std::strerror(errno));
    const pid_t worker = ::fork();
    if (worker < 0) throw Error(std::string("a process cannot be made: ") + std::strerror(errno));
    if (worker == 0) {
        ::prctl(PR_SET_PDEATHSIG, SIGKILL);
        if (::getppid() != watching) ::_exit(kSignalBase + SIGKILL);  // ended in between
    }
    ::close(pipe[worker == 0 ? 0 : 1]);
    return worker;
}

}  // namespace

FrameNotes::AtWork::AtWork(const FrameNotes& notes, int frame, Doing doing) : notes_(notes), frame_(frame) {
    writeNote(notes_.pipe_, {frame_, doing == Doing::measuring ? Note::measuring : Note::meshing});
}

FrameNotes::AtWork::~AtWork() { writeNote(notes_.pipe_, {frame_, Note::left}); }

void FrameNotes::ended(int frame, FrameStatus status) const {
    writeNote(pipe_, {frame, status == FrameStatus::failed    ? Note::failed
                             : status == FrameStatus::skipped ? Note::skipped
                                                              : Note::written});
}

Watched watchOverWorkers() {
    JobHistory history;
    for (;;) {
        std::array<int, 2> pipe{};
        const pid_t worker = startWorker(pipe);
        if (worker == 0) return {true, FrameNotes(pipe[1]), std::move(history), 0};
        std::set<int> at_work;
        const bool measuring = follow(pipe[0], history, at_work);
        ::close(pipe[0]);
        int status = 0;
        while (::waitpid(worker, &status, 0) < 0 && errno == EINTR) {
        }
        if (WIFEXITED(status)) return {false, {}, {}, WEXITSTATUS(status)};
        const int signal = WTERMSIG(status);
        if (caughtSignal() != 0) return {false, {}, {}, kSignalBase + caughtSignal()};
        if (!isLoss(status)) return {false, {}, {}, kSignalBase + signal};
        const bool by_memory = signal == SIGKILL;
        history.kills += by_memory ? 1 : 0;
        history.last_loss = lossOf(signal);
        if (at_work.empty() || (measuring && by_memory)) {
            logError("a process was " + history.last_loss + ", before frames were begun or after they ended");
            return {false, {}, {}, by_memory ? kOutOfMemory : kSomeFailed};
        }
        history.begun.insert(at_work.begin(), at_work.end());
        if (at_work.size() > 1) continue;
        history.lost[*at_work.begin()] = history.last_loss;
        if (measuring) history.unmeasured.insert(*at_work.begin());
        history.out_of_memory = history.out_of_memory || by_memory;
    }
}

}  // namespace betamesh
