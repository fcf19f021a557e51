#include "job_options.h"

#include "base/parallel.h"
#include "batch/config/presets.h"
#include "batch/job/job.h"
#include "batch/job/plan.h"
#include "batch/platform/interrupt.h"
#include "batch/platform/machine.h"
#include "batch/platform/worker.h"
#include "batch/report/log.h"
#include "batch/report/progress.h"
#include "io/extension.h"
#include "io/particle_file.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <iostream>

namespace betamesh {
namespace {

bool isPreview(const ConfigKey& key) { return key.path.starts_with("preview."); }

const char* groupOf(const ConfigKey& key) {
    if (!key.replaced_by.empty()) return "Deprecated";
    return key.path.starts_with("run.") ? "Running" : isPreview(key) ? "Picture" : "Surface and input";
}

/// "beta|alpha|union" where these are all there is.
std::string valueOf(const ConfigKey& key) {
    if (key.path == "preset") return presetNames("|");
    constexpr std::string_view kOneOf = "one of ";
    if (key.kind != ConfigKey::Kind::choice || !key.expects.starts_with(kOneOf)) return "VALUE";
    std::string words = key.expects.substr(kOneOf.size());
    std::replace(words.begin(), words.end(), ' ', '|');
    return words;
}

std::string summary(const JobResult& result, std::size_t frames, double seconds) {
    char time[32];
    std::snprintf(time, sizeof time, "%.1f s", seconds);
    return std::to_string(result.written) + " of " + std::to_string(frames) + " frames written, " +
           std::to_string(result.skipped) + " skipped, " + std::to_string(result.failed) + " failed in " + time;
}

void add(JobResult& sum, const JobResult& result) {
    sum.written += result.written;
    sum.skipped += result.skipped;
    sum.failed += result.failed;
    sum.out_of_memory = sum.out_of_memory || result.out_of_memory;
    if (result.signal != 0) sum.signal = result.signal;
}

/// What is left of a job after workers were lost: frames that may be to blame one after the other, then all others.
JobResult runRest(Plan plan, SignalWatch& signals, const WorkerEvents& notes, const JobHistory& history,
                  const FrameEnded& frameEnded) {
    JobResult result{history.written, history.skipped, history.failed, history.out_of_memory, 0};
    logWarning(history.last_loss + "; frames at work then are begun again, one after the other");
    Plan others = plan;
    const auto begun = [&](const FrameTask& task) { return history.begun.contains(task.frame); };
    std::erase_if(others.tasks, begun);
    std::erase_if(plan.tasks, [&](const FrameTask& task) { return !begun(task); });
    plan.frames_in_flight = 1;
    others.frames_in_flight = std::max<std::size_t>(1, others.frames_in_flight >> history.kills);
    add(result, runJob(plan, signals, notes, frameEnded));
    add(result, runJob(others, signals, notes, frameEnded));
    return result;
}

/// A plan with --dry-run ends as the job would, but writes nothing.
int showPlan(const Plan& plan, bool json) {
    bool refused = false;
    bool failing = false;
    for (const FrameTask& task : plan.tasks) {
        refused = refused || task.action == FrameAction::refuse_existing;
        failing = failing || task.action == FrameAction::fail_missing;
        std::cout << (json ? taskJson(task) : taskLine(task)) << '\n';
    }
    if (refused) logError("outputs exist; expected none, or --overwrite or --skip-existing");
    return refused ? kWrongUsage : failing ? kSomeFailed : kAllWritten;
}

}  // namespace

void addKeyOptions(CLI::App& command, std::map<std::string, std::string>& values,
                   const std::function<bool(const ConfigKey&)>& wanted) {
    const Config defaults;
    for (const ConfigKey& key : configKeys()) {
        if (key.option.empty() || !wanted(key)) continue;
        const std::string standard = key.get(defaults);
        const std::string help =
            key.reason + " [" + key.path + ", default " + (standard.empty() ? "empty" : standard) + "]";
        CLI::Option* option = nullptr;
        const auto remember = [&values, path = key.path](const std::string& value) { values[path] = value; };
        if (key.kind == ConfigKey::Kind::boolean) {
            option = command.add_flag_callback(
                key.option, [remember] { remember("true"); }, help);
        } else {
            option = command.add_option_function<std::string>(key.option, remember, help)->type_name(valueOf(key));
        }
        option->group(groupOf(key));
    }
}

std::vector<KeyValue> keyValuesOf(const std::vector<std::string>& assignments,
                                  const std::map<std::string, std::string>& values) {
    std::vector<KeyValue> all;
    for (const std::string& assignment : assignments) all.push_back(keyValueOf(assignment));
    for (const ConfigKey& key : configKeys()) {
        const auto value = values.find(key.path);
        if (value != values.end()) all.push_back({key.path, value->second, key.option});
    }
    return all;
}

void addJobOptions(CLI::App& command, JobOptions& options) {
    addKeyOptions(command, options.values, [](const ConfigKey& key) { return !isPreview(key); });
    command
        .add_option(
            "--set", options.assignments,
            "Any key of a pipeline file, as in --set smoothing.passes=2; may be repeated. The options above win.")
        ->type_name("KEY=VALUE")
        ->expected(1)
        ->take_all()
        ->group("Running");
    command
        .add_option("--chunk", options.chunk,
                    "Only the i-th of N contiguous pieces of the frames, 1 <= i <= N: for farms.")
        ->type_name("i/N")
        ->group("Running");
    command.add_flag("--overwrite", options.overwrite, "Replace outputs that exist.")->group("Running");
    command
        .add_flag(
            "--skip-existing", options.skip_existing,
            "Leave out frames that would be made the same again: the mesh is there, and its report names the same "
            "input, configuration and version of this program.")
        ->group("Running");
    command
        .add_flag(
            "--dry-run", options.dry_run,
            "Print each frame with its input, output, what would be done and about how much memory that would take; "
            "do nothing.")
        ->group("Running");
    command
        .add_flag(
            "--json", options.json,
            "Print one JSON object per frame on stdout, in the order in which frames end; nothing else goes there.")
        ->group("Messages");
    command.add_flag("-q,--quiet", options.quiet, "Only errors.")->group("Messages");
    command.add_flag("-v,--verbose", options.verbose, "Timings of every frame.")->group("Messages");
    command
        .add_option("--progress", options.progress,
                    "auto: a bar on a terminal, otherwise a line a frame, on stderr. openjd, tractor: their lines on "
                    "stdout, or on stderr with --json; json: an object a frame there.")
        ->type_name("auto|bar|none|openjd|tractor|json")
        ->group("Messages");
    command
        .add_option(
            "--log-file", options.log_file,
            "All messages, those of -v too, into this file as well; it is begun anew at 10 MB, and five are kept.")
        ->type_name("FILE")
        ->group("Messages");
}

int runWithOptions(const std::string& pipeline, std::vector<KeyValue> given, const JobOptions& options) {
    setLogLevel(options.quiet ? LogLevel::quiet : options.verbose ? LogLevel::verbose : LogLevel::normal);
    const auto by_options = keyValuesOf(options.assignments, options.values);
    given.insert(given.end(), by_options.begin(), by_options.end());
    const Config config = readConfig(pipeline, given);
    const bool silent = options.quiet && options.progress == "auto";
    const ProgressKind progress_kind = silent ? ProgressKind::none : progressKind(options.progress);
    rememberSignals();
    const auto begin = std::chrono::steady_clock::now();
    const Watched watched = superviseWorkers(isVdb(config.input.path), config.run.timeout);
    if (!watched.working) return watched.exit_code;
    if (!options.log_file.empty()) setLogFile(options.log_file);
    if (config.run.memory_limit > 0) {
        const int threads = threadsOf(config);
        withThreads(threads, [&] { startThreads(threads); });
        limitMemory(config.run.memory_limit);
    }

    SignalWatch signals;

    const JobHistory& history = watched.history;
    const Plan plan = planJob(config, {parseChunk(options.chunk), options.overwrite, options.skip_existing,
                                       options.dry_run, history, watched.notes});
    for (const std::string& warning : plan.warnings) logWarning(warning);
    if (options.dry_run) return showPlan(plan, options.json);
    for (const std::string& note : plan.notes) logInfo(note);
    logDetail(std::to_string(plan.tasks.size()) + " frames, " + std::to_string(plan.threads) + " threads, at most " +
              std::to_string(plan.frames_in_flight) + " frames in flight in " +
              std::to_string(plan.memory_budget >> 20) + " MiB");

    const std::size_t frames = history.ended.size() + plan.tasks.size();
    Progress progress(progress_kind, {frames, history.ended.size(), history.failed, 0, 0, {}}, options.json);
    const FrameEnded frameEnded = [&](const FrameReport& report) {
        if (options.json) std::cout << reportJson(report) << std::endl;
        progress.frameEnded(report);
    };
    const JobResult result = history.last_loss.empty() ? runJob(plan, signals, watched.notes, frameEnded)
                                                       : runRest(plan, signals, watched.notes, history, frameEnded);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    const std::string words = summary(result, frames, seconds.count());
    if (result.exitCode() == kAllWritten) {
        logInfo(words);
    } else {
        const std::string why = result.signal != 0 ? "interrupted: " : result.out_of_memory ? "out of memory: " : "";
        logError(why + words);
        progress.jobFailed(why + words);
    }
    return result.exitCode();
}

}  // namespace betamesh
