#include "each_file.h"

#include "base/parallel.h"
#include "batch/job/frames.h"
#include "batch/job/job.h"
#include "batch/job/plan.h"
#include "batch/platform/worker.h"
#include "batch/report/log.h"
#include "betamesh/error.h"

#include <iostream>

namespace betamesh {

int forEachFile(std::size_t files, const std::function<NamedFile(std::size_t)>& nameOf,
                const std::function<bool(std::size_t)>& process,
                const std::function<void(std::size_t, const std::string& error)>& failed) {
    const Supervision watched = superviseWorkers(true);
    if (!watched.is_worker) return watched.exit_code;
    const JobHistory& history = watched.history;
    bool any_failed = history.failed > 0, out_of_memory = history.out_of_memory;
    const auto processFile = [&](std::size_t i) {
        const int number = static_cast<int>(i);
        if (history.ended.contains(number)) return;
        const WorkerEvents::FrameInProgress at_work(watched.events, number);
        bool is_good = false;
        const auto fail = [&](const Error& error) {
            const auto [name, frame] = nameOf(i);
            const std::string advice = adviceOnStars(name);
            const std::string text = (frame ? "frame " + std::to_string(*frame) + ": " : "") + error.what() +
                                     (advice.empty() ? "" : '.' + advice);
            logError(text);
            failed(i, text);
        };
        try {
            if (const auto lost = history.lost.find(number); lost != history.lost.end())
                throw Error(nameOf(i).name + ": " + lost->second);
            is_good = process(i);
        } catch (const MemoryError& error) {
            out_of_memory = true;
            fail(error);
        } catch (const Error& error) {
            fail(error);
        }
        any_failed = any_failed || !is_good;
        std::cout.flush();  // before the file counts as ended, so that its output is neither lost nor repeated
        watched.events.ended(number, is_good ? FrameStatus::ok : FrameStatus::failed);
    };
    withThreads(threadsOf(Config{}), [&] {
        for (std::size_t i = 0; i < files; ++i) processFile(i);
    });
    return out_of_memory ? kOutOfMemory : any_failed ? kSomeFailed : kAllWritten;
}

}  // namespace betamesh
