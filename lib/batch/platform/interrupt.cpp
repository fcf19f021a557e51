
#include "batch/platform/interrupt.h"

#include "batch/platform/exit_code.h"
#include "batch/report/log.h"

#include <sys/mman.h>

#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstdlib>
#include <mutex>
#include <new>
#include <optional>
#include <system_error>

namespace betamesh {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kSignalPoll = std::chrono::milliseconds(50);
constexpr auto kPatience =
    std::chrono::milliseconds(3000);  // then the process is ended; Slurm kills after 30 s, OpenJD after 120 s

std::atomic<int> unshared_signal = 0;
std::atomic<int>* caught_signal = &unshared_signal;
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler may only use atomics without lock");

void recordSignal(int signal) { *caught_signal = signal; }

/// Moves caught_signal to memory that forked processes share.
void shareCaughtSignal() {
    void* const shared =
        ::mmap(nullptr, sizeof(std::atomic<int>), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (shared == MAP_FAILED) throw std::bad_alloc();
    caught_signal = new (shared) std::atomic<int>(0);
}

/// Throws std::bad_alloc if the thread cannot be started, which is for lack of memory for its stack as a rule.
template <typename Body>
std::jthread newThread(const Body& body) {
    try {
        return std::jthread(body);
    } catch (const std::system_error&) {
        throw std::bad_alloc();
    }
}

}  // namespace

void rememberSignals() {
    if (caught_signal == &unshared_signal) shareCaughtSignal();
    struct sigaction action {};
    action.sa_handler = recordSignal;
    action.sa_flags = SA_RESTART | static_cast<int>(SA_RESETHAND);
    sigemptyset(&action.sa_mask);
    sigaction(SIGTERM, &action, nullptr);
    sigaction(SIGINT, &action, nullptr);
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);
}

int caughtSignal() { return *caught_signal; }

void leaveIfInterrupted() {
    if (caughtSignal() != 0) throw Interrupted{};
}

SignalWatch::SignalWatch() : thread_(newThread([this](const std::stop_token& stop) { run(stop); })) {}

void SignalWatch::run(const std::stop_token& stop) {
    std::mutex mutex;
    std::condition_variable_any stopped;
    std::optional<Clock::time_point> caught;
    while (!stop.stop_requested()) {
        std::unique_lock lock(mutex);
        stopped.wait_for(lock, stop, kSignalPoll, [] { return false; });
        if (caughtSignal() == 0) continue;
        if (!caught) caught = Clock::now();
        if (writing_ == 0 && Clock::now() - *caught > kPatience) {
            logError("interrupted: frames in progress are given up");
            std::_Exit(kSignalBase + caughtSignal());
        }
    }
}

SignalWatch::Writing::Writing(SignalWatch& watch) : watch_(watch) {
    ++watch_.writing_;
    if (caughtSignal() == 0) return;
    --watch_.writing_;
    throw Interrupted{};
}

SignalWatch::Writing::~Writing() { --watch_.writing_; }

}  // namespace betamesh
