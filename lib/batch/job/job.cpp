#include "batch/job/job.h"

#include "base/parallel.h"
#include "batch/job/frames.h"
#include "batch/job/process_frame.h"
#include "batch/job/usd_sequence.h"
#include "batch/platform/frame_lock.h"
#include "batch/platform/machine.h"
#include "batch/platform/memory.h"
#include "batch/report/log.h"
#include "betamesh/error.h"
#include "io/output_file.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <new>
#include <set>
#include <span>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace betamesh {
namespace {

namespace fs = std::filesystem;

/// The folders of all outputs, and whether this job writes to each, or a worker that was lost may have.
std::map<std::string, bool> foldersOf(std::span<const Plan> outputs) {
    std::map<std::string, bool> folders;
    for (const Plan& plan : outputs)
        for (const FrameTask& task : plan.tasks)
            for (const std::string& output : {task.output, task.preview})
                if (!output.empty())
                    folders[folderOf(output)] |= isWritten(task.action) || task.action == FrameAction::fail_lost;
    return folders;
}

/// Removes temporary files and locks of jobs that were killed.
void sweep(const std::map<std::string, bool>& folders) {
    for (const auto& [folder, is_written_to] : folders) {
        sweepTemporaries(folder);
        sweepLocks(folder);
    }
}

/// Calls doFrame(i, alone) for all tasks in order, several at once; it returns false if memory ran out. How many frames
/// fit into memory is learnt from those that have ended, so tasks run in rounds: each round has as many in flight as
/// the estimates allow when it begins. A frame that ran out of memory is repeated alone; outOfMemory(i) is called if
/// that fails as well.
template <typename DoFrame, typename OutOfMemory>
void runInRounds(std::span<const Plan> outputs, const DoFrame& doFrame, const OutOfMemory& outOfMemory) {
    const Plan& plan = outputs.front();
    std::vector<std::uint64_t> estimates(plan.tasks.size());  // bytes
    for (const Plan& each : outputs)
        for (std::size_t i = 0; i < estimates.size(); ++i) estimates[i] = std::max(estimates[i], each.tasks[i].memory);
    MemoryWatch memory(plan.memory_budget);
    std::size_t most = plan.frames_in_flight;
    const auto fitting = [&](std::size_t first) {
        const auto from = estimates.begin() + static_cast<std::ptrdiff_t>(first);
        const std::size_t rows = std::min(estimates.size() - first, 2 * most);
        const auto largest = std::max_element(from, from + static_cast<std::ptrdiff_t>(rows));
        return std::min(most, memory.fitting(rows > 0 ? *largest : 0));
    };
    std::mutex mutex;  // guards again
    std::vector<std::size_t> again;
    const auto anyAgain = [&] {
        const std::scoped_lock lock(mutex);
        return !again.empty();
    };
    for (std::size_t next = 0; next < estimates.size() && caughtSignal() == 0;) {
        const std::size_t first = next, in_flight = fitting(first);
        const auto mayBegin = [&] {
            if (caughtSignal() != 0) return false;
            const std::uint64_t estimate = estimates[next];
            const bool next_round = anyAgain() || fitting(next) > in_flight + in_flight / 2;
            if (next > first && (next_round || !memory.hasRoomFor(estimate))) return false;
            memory.begins(estimate);
            ++next;
            return true;
        };
        parallelInFlight(estimates.size() - first, in_flight, mayBegin, [&](std::size_t i) {
            if (!doFrame(first + i, false)) {
                const std::scoped_lock lock(mutex);
                again.push_back(first + i);
            }
            memory.ends(estimates[first + i]);
        });
        if (again.empty()) continue;
        most = std::max<std::size_t>(1, in_flight / 2);
        for (const std::size_t i : std::exchange(again, {})) {
            releaseFreeMemory();
            if (caughtSignal() == 0 && !doFrame(i, true)) outOfMemory(i);
        }
    }
}

/// The status of a frame: failed if one of its outputs failed, otherwise that of an output that was written, if any.
FrameStatus statusOf(const std::vector<FrameResult>& outputs) {
    FrameStatus status = FrameStatus::skipped;
    for (const FrameResult& result : outputs) {
        if (result.status == FrameStatus::failed) return FrameStatus::failed;
        if (result.status != FrameStatus::skipped) status = result.status;
    }
    return status;
}

std::string outOfMemoryError(std::span<const Plan> outputs, std::size_t row, JobState& job) {
    const Plan& plan = outputs.front();
    const int frame = plan.tasks[row].frame;
    const std::string &near = job.near_surface[frame], &error = job.memory_error[frame];
    return "out of memory, although no other frame was in progress; " + std::to_string((plan.memory_budget >> 20) + 1) +
           " MiB are not enough (run.memory_limit)" + (near.empty() ? "" : "; " + near) +
           (error.empty() ? "" : "; " + error);
}

/// Writes the layers that play the frames. Returns whether all could be written.
bool writeSequenceLayers(std::span<const Plan> outputs) {
    bool all = true;
    for (const Plan& plan : outputs) {
        try {
            writeSequenceLayer(framePattern(plan.config.output.path), plan.config.output);
        } catch (const Error& error) {
            logError(error.what());
            all = false;
        }
    }
    return all;
}

/// Runs all frames of the plans.
JobResult runFrames(std::span<const Plan> outputs, SignalWatch& signals, const WorkerEvents& events,
                    const FrameEnded& frameEnded) {
    const std::map<std::string, bool> folders = foldersOf(outputs);
    for (const auto& [folder, is_written_to] : folders) {
        std::error_code error;
        if (is_written_to) fs::create_directories(folder, error);
        if (error) throw Error("'" + folder + "': the folder cannot be created: " + error.message());
    }
    sweep(folders);
    const std::size_t frames = outputs.front().tasks.size();
    JobResult result;
    std::mutex mutex;  // guards result and frameEnded
    JobState job{signals};
    std::vector<std::vector<FrameResult>> results(frames);  // by frame, of the outputs that have ended

    const auto finish = [&](std::vector<FrameResult>& of_frame) {
        const std::scoped_lock lock(mutex);
        const FrameStatus status = statusOf(of_frame);
        if (status == FrameStatus::failed) {
            job.forgetVelocity(of_frame.front().frame);
            ++result.failed;
        } else if (status == FrameStatus::skipped) {
            ++result.skipped;
        } else {
            ++result.written;
        }
        frameEnded(of_frame);
        events.ended(of_frame.front().frame, status);
        of_frame = {};
    };
    const auto doFrame = [&](std::size_t i, bool alone) {
        const WorkerEvents::FrameInProgress in_progress(events, outputs.front().tasks[i].frame);
        try {
            processFrame(outputs, i, alone, job, results[i]);
            finish(results[i]);
        } catch (const Interrupted&) {
        } catch (const std::bad_alloc&) {
            return false;
        }
        return true;
    };
    const auto outOfMemory = [&](std::size_t i) {
        result.out_of_memory = true;
        failFrame(outputs, i, outOfMemoryError(outputs, i, job), results[i]);
        finish(results[i]);
    };
    withThreads(outputs.front().threads, [&] { runInRounds(outputs, doFrame, outOfMemory); });

    if (const std::set<int>& none = job.without_velocity;
        !none.empty() && none.size() < result.written + result.skipped)
        logWarning(std::to_string(none.size()) + " of " + std::to_string(result.written) +
                   " frames written have no velocity, and zero velocities are written for them: " +
                   printFrames({none.begin(), none.end()}));
    result.layer_failed = !writeSequenceLayers(outputs);
    sweep(folders);  // again: jobs killed since the first time have left files, too
    if (result.written + result.skipped + result.failed < frames) result.signal = caughtSignal();
    return result;
}

void add(JobResult& sum, const JobResult& result) {
    sum.written += result.written;
    sum.skipped += result.skipped;
    sum.failed += result.failed;
    sum.out_of_memory = sum.out_of_memory || result.out_of_memory;
    sum.layer_failed = sum.layer_failed || result.layer_failed;
    if (result.signal != 0) sum.signal = result.signal;
}

}  // namespace

int JobResult::exitCode() const {
    if (signal != 0) return kSignalBase + signal;
    if (out_of_memory) return kOutOfMemory;
    return failed > 0 || layer_failed ? kSomeFailed : kAllWritten;
}

JobResult runJob(const std::vector<Plan>& outputs, const JobHistory& history, SignalWatch& signals,
                 const WorkerEvents& events, const FrameEnded& frameEnded) {
    if (history.last_loss.empty()) return runFrames(outputs, signals, events, frameEnded);
    logWarning(history.last_loss + "; the frames in progress at that time are restarted one at a time");
    const auto wasInProgress = [&](const FrameTask& task) { return history.begun.contains(task.frame); };
    std::vector<Plan> restarted = outputs, others = outputs;
    for (Plan& plan : restarted) {
        std::erase_if(plan.tasks, [&](const FrameTask& task) { return !wasInProgress(task); });
        plan.frames_in_flight = 1;
    }
    for (Plan& plan : others) {
        std::erase_if(plan.tasks, wasInProgress);
        plan.frames_in_flight = std::max<std::size_t>(1, plan.frames_in_flight >> history.kills);
    }
    JobResult result{.written = history.written,
                     .skipped = history.skipped,
                     .failed = history.failed,
                     .out_of_memory = history.out_of_memory};
    add(result, runFrames(restarted, signals, events, frameEnded));
    add(result, runFrames(others, signals, events, frameEnded));
    return result;
}

}  // namespace betamesh
