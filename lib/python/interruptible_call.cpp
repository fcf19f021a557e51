#include "python/interruptible_call.h"

#include "base/parallel.h"
#include "betamesh/error.h"
#include "python/arrays.h"

#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <string>
#include <thread>

namespace betamesh {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kPoll = std::chrono::milliseconds(100);
constexpr int kMostThreads = 4096;

/// What the two threads of a call share.
class CallState {
public:
    void begin(std::string_view stage) {
        const std::scoped_lock lock(mutex_);
        stage_ = stage;
        is_new_ = true;
        changed_.notify_one();
    }
    void end(std::exception_ptr failure) {
        const std::scoped_lock lock(mutex_);
        failure_ = std::move(failure);
        has_ended_ = true;
        changed_.notify_one();
    }
    /// Waits until a stage begins, the work ends, or some time has passed. Returns whether the work goes on.
    bool waitForChange() {
        std::unique_lock lock(mutex_);
        changed_.wait_for(lock, kPoll, [&] { return is_new_ || has_ended_; });
        is_new_ = false;
        return !has_ended_;
    }
    std::string stage() {
        const std::scoped_lock lock(mutex_);
        return stage_;
    }
    /// What the work has thrown. Called after it has ended.
    std::exception_ptr failure() const { return failure_; }

private:
    std::mutex mutex_;
    std::condition_variable changed_;
    std::string stage_;
    bool is_new_ = false;
    bool has_ended_ = false;
    std::exception_ptr failure_;
};

}  // namespace

CallOptions callOptions(nb::handle threads, nb::handle progress) {
    CallOptions options{0, nb::borrow(progress)};
    if (!progress.is_none() && !nb::cast<bool>(nb::module_::import_("builtins").attr("callable")(progress)))
        throw Error("progress cannot be called. Use a function progress(stage, seconds), or None.");
    if (threads.is_none()) return options;
    const bool is_number = nb::try_cast<int>(threads, options.threads, false);
    if (!is_number || options.threads < 1 || options.threads > kMostThreads)
        throw Error("threads: '" + textOf(threads) + "' is not valid. Use None, or a whole number from 1 to " +
                    std::to_string(kMostThreads) + ".");
    return options;
}

void callInterruptibly(const CallOptions& options, const std::function<void(const StageBegins&)>& work) {
    const auto start = Clock::now();
    CallState state;
    CancellableRun run;
    std::exception_ptr interruption;
    {
        const nb::gil_scoped_release without_interpreter;
        const std::jthread worker([&] {
            std::exception_ptr failure;
            try {
                run.run(options.threads, [&] { work([&](std::string_view stage) { state.begin(stage); }); });
            } catch (...) {
                failure = std::current_exception();
            }
            state.end(std::move(failure));
        });
        while (state.waitForChange()) {
            const nb::gil_scoped_acquire with_interpreter;
            try {
                if (PyErr_CheckSignals() != 0) throw nb::python_error();
                const std::chrono::duration<double> seconds = Clock::now() - start;
                const std::string stage = state.stage();
                if (!options.progress.is_none() && !stage.empty()) options.progress(stage, seconds.count());
            } catch (...) {
                interruption = std::current_exception();
                run.cancel();
                break;
            }
        }
    }
    if (interruption) std::rethrow_exception(interruption);
    if (state.failure()) std::rethrow_exception(state.failure());
}

}  // namespace betamesh
