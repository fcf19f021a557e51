#include "batch/interrupt.h"

#include <csignal>

#include <atomic>

namespace betamesh {
namespace {

std::atomic<int> caught_signal = 0;
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler may only write what needs no lock");

void remember(int signal) { caught_signal = signal; }

}  // namespace

void rememberSignals() {
    struct sigaction action {};
    action.sa_handler = remember;
    action.sa_flags = SA_RESTART | static_cast<int>(SA_RESETHAND);
    sigemptyset(&action.sa_mask);
    sigaction(SIGTERM, &action, nullptr);
    sigaction(SIGINT, &action, nullptr);
    std::signal(SIGPIPE, SIG_IGN);
}

int caughtSignal() { return caught_signal; }

}  // namespace betamesh
