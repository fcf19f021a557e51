// Signals: farms and people ask a job to end; those who read what it says go away.

#pragma once

#include <atomic>
#include <thread>

namespace betamesh {

/// From here on the first SIGTERM or SIGINT is only remembered, by processes that this one starts too; the second one
/// ends the process at once.
/// A pipe whose reader is gone no longer ends the process: frames matter more than who watches them.
void rememberSignals();

/// SIGTERM, SIGINT, or 0 when none has come.
int caughtSignal();

/// Thrown to leave work that nobody waits for any more.
struct Interrupted {};

/// Throws Interrupted once a signal has come.
void leaveIfInterrupted();

/// Work leaves by itself when a signal has come, at leaveIfInterrupted(); what is still under way some seconds later is
/// cut off with the process, because a farm would otherwise kill it. Never while files are being written: while a
/// Writing lives the process goes on, and once a signal has come none begins.
class SignalWatch {
public:
    SignalWatch();

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
    std::jthread thread_;  // last: outlived by all
};

}  // namespace betamesh
