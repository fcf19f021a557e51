// Signals: SIGTERM and SIGINT end a job in order; SIGPIPE does not end it.

#pragma once

#include <atomic>
#include <thread>

namespace betamesh {

/// From now on the first SIGTERM or SIGINT is only recorded, here and in processes that this one forks; the second one
/// ends the process at once. SIGPIPE is ignored, so that a job goes on if the reader of its output ends, and SIGXFSZ,
/// so that a file beyond the size limit of the process (`ulimit -f`) fails alone.
void rememberSignals();

/// The recorded signal, SIGTERM or SIGINT; 0 if there was none.
int caughtSignal();

/// Thrown to abandon work after a signal.
struct Interrupted {};

/// Throws Interrupted if a signal has been recorded.
void leaveIfInterrupted();

/// Ends the process some seconds after a signal, if work has not been abandoned at leaveIfInterrupted() by then: a farm
/// would kill the process later. It does not end the process while files are being written.
class SignalWatch {
public:
    SignalWatch();

    /// Lets the process live while it exists. Throws Interrupted if a signal has been recorded.
    class Writing {
    public:
        explicit Writing(SignalWatch& watch);
        ~Writing();
        Writing(const Writing&) = delete;
        Writing& operator=(const Writing&) = delete;

    private:
        SignalWatch& watch_;
    };

private:
    void run(const std::stop_token& stop);

    std::atomic<int> writing_ = 0;
    std::jthread thread_;  // last member: ends before the others are destroyed
};

}  // namespace betamesh
