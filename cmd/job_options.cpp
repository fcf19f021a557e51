#include "job_options.h"

#include "base/parallel.h"
#include "batch/config/presets.h"
#include "batch/job/dry_run.h"
#include "batch/job/job.h"
#include "batch/job/output_files.h"
#include "batch/job/plan.h"
#include "batch/platform/interrupt.h"
#include "batch/platform/machine.h"
#include "batch/platform/worker.h"
#include "batch/report/log.h"
#include "batch/report/printable.h"
#include "batch/report/progress.h"
#include "batch/report/report.h"
#include "betamesh/error.h"
#include "help.h"
#include "io/extension.h"
#include "io/frame_number.h"
#include "io/particle_file.h"
#include "io/up_axis.h"
#include "value_checks.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <iostream>

namespace betamesh {
namespace {

bool isPreview(const ConfigKey& key) { return key.path.starts_with("preview."); }

/// The group of a key's option in the help.
const char* groupOf(const ConfigKey& key) {
    if (!key.replaced_by.empty()) return kDeprecatedGroup;
    const std::string section = key.path.substr(0, key.path.find('.'));
    if (section == "surface" || section == "perturbation" || section == "features") return "Surface";
    if (section == "smoothing") return "Smoothing";
    if (section == "output" || section == "picture") return "Output";
    if (section == "preview") return "Preview";
    if (section == "run") return "Running";
    return "Input";
}

/// What stands for the value in the help of a key's option: "LENGTH", "beta|alpha|union".
std::string typeNameOf(const ConfigKey& key) {
    if (key.path == "preset") return presetNames("|");
    if (key.path == "frames") return "FRAMES";
    if (key.unit == "bytes") return "SIZE";
    switch (key.kind) {
        case ConfigKey::Kind::length:
            return "LENGTH";
        case ConfigKey::Kind::number:
            return "N";
        case ConfigKey::Kind::list:
            return "A,B,...";
        case ConfigKey::Kind::choice: {
            std::string choices;
            for (const std::string& choice : key.choices) choices += (choices.empty() ? "" : "|") + choice;
            return choices;
        }
        case ConfigKey::Kind::text:
        case ConfigKey::Kind::boolean:
            break;
    }
    return "VALUE";
}

std::string summary(const JobResult& result, std::size_t frames, double seconds) {
    char time[32];
    std::snprintf(time, sizeof time, "%.1f s", seconds);
    return std::to_string(result.written) + " of " + std::to_string(frames) + " frames written, " +
           std::to_string(result.skipped) + " skipped, " + std::to_string(result.failed) + " failed in " + time;
}

/// Prints the plans for --dry-run, and tries to read the first frame that would be meshed. Returns the exit code that
/// running the job would have, as far as this tells.
int printPlans(const std::vector<Plan>& outputs, bool json) {
    bool refused = false;
    bool failing = false;
    for (std::size_t i = 0; i < outputs.front().tasks.size(); ++i) {
        for (const Plan& plan : outputs) {
            const FrameTask& task = plan.tasks[i];
            refused = refused || task.action == FrameAction::refuse_existing;
            failing = failing || task.action == FrameAction::fail_missing;
            std::cout << (json ? taskJson(task) : printable(taskLine(task))) << '\n';
        }
    }
    for (const Plan& plan : outputs) {
        const auto first = std::find_if(plan.tasks.begin(), plan.tasks.end(),
                                        [](const FrameTask& task) { return task.action == FrameAction::mesh; });
        if (first == plan.tasks.end()) continue;
        const std::string why = whyFrameFails(*first, plan);
        if (!why.empty()) logError("frame " + std::to_string(first->frame) + ": " + why);
        failing = failing || !why.empty();
    }
    if (refused) logError("Some outputs already exist. Use --overwrite to replace them or --skip-existing to resume.");
    return refused ? kWrongUsage : failing ? kSomeFailed : kAllWritten;
}

/// The lines of all outputs, each once. Those that only some outputs have begin with the paths of these.
std::vector<std::string> linesOf(const std::vector<Plan>& outputs, std::vector<std::string> Plan::*lines) {
    std::vector<std::string> all;
    for (const Plan& plan : outputs)
        for (const std::string& line : plan.*lines) {
            std::size_t count = 0;
            std::string paths;
            for (const Plan& other : outputs) {
                if (std::find((other.*lines).begin(), (other.*lines).end(), line) == (other.*lines).end()) continue;
                paths += (count++ == 0 ? "" : ", ") + other.config.output.path;
            }
            const std::string text = count == outputs.size() ? line : paths + ": " + line;
            if (std::find(all.begin(), all.end(), text) == all.end()) all.push_back(text);
        }
    return all;
}

/// Limits the memory, after starting the threads that the job needs, so that these do not count.
void enforceMemoryLimit(const Config& config) {
    const int threads = threadsOf(config);
    withThreads(threads, [&] { startThreads(threads); });
    limitMemory(config.run.memory_limit);
}

void logPlans(const std::vector<Plan>& outputs) {
    for (const std::string& note : linesOf(outputs, &Plan::notes)) logInfo(note);
    const Plan& plan = outputs.front();
    logDetail(std::to_string(plan.tasks.size()) + " frames, " + std::to_string(plan.threads) + " threads, at most " +
              std::to_string(plan.frames_in_flight) + " frames in flight in " +
              std::to_string(plan.memory_budget >> 20) + " MiB");
}

void logResult(const JobResult& result, const std::string& summary, Progress& progress) {
    if (result.exitCode() == kAllWritten) {
        logInfo(summary);
        return;
    }
    const std::string reason = result.signal != 0 ? "interrupted: " : result.out_of_memory ? "out of memory: " : "";
    logError(reason + summary);
    progress.jobFailed(reason + summary);
}

}  // namespace

void addKeyOptions(CLI::App& command, std::map<std::string, std::string>& values,
                   const std::function<bool(const ConfigKey&)>& wanted) {
    const Config defaults;
    for (const ConfigKey& key : configKeys()) {
        if (key.option.empty() || !wanted(key)) continue;
        const std::string standard = key.get(defaults);
        const std::string help = key.help + (key.unit.empty() ? "" : " Unit: " + key.unit + '.') + " [" + key.path +
                                 ", default: " + (standard.empty() ? "empty" : standard) + "]";
        CLI::Option* option = nullptr;
        const auto store = [&values, path = key.path](const std::string& value) { values[path] = value; };
        if (key.kind == ConfigKey::Kind::boolean) {
            option = command.add_flag_callback(
                key.option, [store] { store("true"); }, help);
        } else {
            option = command.add_option_function<std::string>(key.option, store, help)->type_name(typeNameOf(key));
        }
        option->group(groupOf(key));
    }
}

void addParticleOptions(CLI::App& command, std::map<std::string, std::string>& values) {
    addKeyOptions(command, values, [](const ConfigKey& key) { return key.path.starts_with("input."); });
}

void addMeshAxisOption(CLI::App& command, std::map<std::string, std::string>& values) {
    command
        .add_option_function<std::string>(
            "--output-up-axis", [&values](const std::string& value) { values["output.up_axis"] = value; },
            "Axis that points up in the meshes. Without it, that in the manifest beside each mesh, or y.")
        ->type_name("y|z")
        ->check(oneOf({"y", "z"}))
        ->group("Input");
}

void addFramesOption(CLI::App& command, std::string& frames) {
    command
        .add_option("--frames", frames,
                    "Choose frames, such as 1-24: by the numbers in file names, or the time samples in files.")
        ->type_name("FRAMES")
        ->capture_default_str();
}

InputFrames particleFrames(const std::string& path, const std::map<std::string, std::string>& values) {
    Config::Input input = readConfig("", keyValuesOf({}, values)).input;
    input.path = path;
    const InputFrames frames = inputFrames(input);
    formatOf(frames.pattern.text, FileKind::particles, Access::read);
    if (frames.pattern.numbered && frames.files.empty()) throw noFileOnDisk(frames.pattern);
    return frames;
}

FileFrame particlesBeside(const FileFrame& mesh, const InputFrames& particles) {
    int frame = mesh.frame;
    const bool is_numbered =
        mesh.is_one_of_several || !frameNumberIn(std::filesystem::path(mesh.file).filename().string()).empty();
    if (!is_numbered && (particles.pattern.numbered || particles.is_one_file))
        if (const auto manifest = readManifest(manifestPath(mesh.file))) frame = manifest->frame;
    return fileFrame(particles, frame);
}

Particles particlesOf(const std::string& mesh_file, const FileFrame& particles,
                      const std::map<std::string, std::string>& values) {
    const Config config = readConfig("", keyValuesOf({}, values));
    const auto manifest = readManifest(manifestPath(mesh_file));
    const bool has_provenance = manifest && manifest->provenance;
    ParticleInput input = config.input;
    UpAxis mesh_up = config.output.up_axis;
    if (has_provenance && !values.contains("output.up_axis")) mesh_up = manifest->provenance->up_axis;
    if (const auto& given = config.input.given_origin) {
        input.origin = Vec3((*given)[0], (*given)[1], (*given)[2]);
    } else if (has_provenance) {
        const Vec3 o = manifest->provenance->local_origin / input.scale;
        if (input.up_axis == mesh_up)
            input.origin = o;
        else
            input.origin = mesh_up == UpAxis::z ? Vec3(o.x, o.z, -o.y) : Vec3(o.x, -o.z, o.y);
    }
    input.frame = particles.sample();
    Particles read = readParticles(particles.file, input);
    return mesh_up == UpAxis::z ? withZUp(std::move(read)) : read;
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
        .add_option("--set", options.assignments,
                    "Set any key of a pipeline file, as in --set smoothing.passes=2; may be repeated. An option for "
                    "the same key wins over --set.")
        ->type_name("KEY=VALUE")
        ->expected(1)
        ->take_all()
        ->group("Running");
    command.add_flag("--overwrite", options.overwrite, "Replace outputs that already exist.")->group("Running");
    command
        .add_flag("--skip-existing", options.skip_existing,
                  "Resume a job: skip every frame whose mesh exists and whose manifest names the same input, "
                  "configuration and program version.")
        ->group("Running");
    command
        .add_flag(
            "--dry-run", options.dry_run,
            "List the input, output, planned action and estimated memory of every frame, but write nothing. Makes the "
            "checks of a real run, and reads the first frame to be meshed.")
        ->group("Running");
    command
        .add_option("--chunk", options.chunk,
                    "For farms: divide the frames into N contiguous chunks and process only the i-th, 1 <= i <= N.")
        ->type_name("i/N")
        ->capture_default_str()
        ->group("Farm and log");
    command
        .add_flag("--json", options.json,
                  "Print one JSON object per frame on stdout, in the order in which frames finish, and nothing else.")
        ->group("Farm and log");
    command
        .add_option("--progress", options.progress,
                    "How to report progress. auto: a bar on a terminal, otherwise one line per frame, both on stderr. "
                    "openjd, tractor: the lines that these farm engines read. json: one object per frame. These three "
                    "print on stdout, or on stderr if --json is given.")
        ->type_name(progressNames("|"))
        ->capture_default_str()
        ->group("Farm and log");
    command
        .add_option("--log-file", options.log_file,
                    "Also append all messages, including those of --verbose, to this file. It is renamed at " +
                        std::to_string(kMaxLogFileBytes / 1'000'000) + " MB; the last " + std::to_string(kOldLogFiles) +
                        " old files are kept.")
        ->type_name("FILE")
        ->group("Farm and log");
    command.add_flag("-q,--quiet", options.quiet, "Print only errors.")->group("Farm and log");
    command.add_flag("-v,--verbose", options.verbose, "Also print the timings of every frame.")->group("Farm and log");
}

int runWithOptions(const std::string& pipeline, std::vector<KeyValue> given, const JobOptions& options) {
    setLogLevel(options.quiet ? LogLevel::quiet : options.verbose ? LogLevel::verbose : LogLevel::normal);
    const auto from_options = keyValuesOf(options.assignments, options.values);
    given.insert(given.end(), from_options.begin(), from_options.end());
    const Config config = readConfig(pipeline, given);
    const bool silent = options.quiet && options.progress == "auto";
    const ProgressKind progress_kind = silent ? ProgressKind::none : progressNamed(options.progress);
    if (!options.log_file.empty()) requireDistinctLog(options.log_file, pipeline, config);
    rememberSignals();
    const auto begin = std::chrono::steady_clock::now();
    const Supervision watched = superviseWorkers(isVdb(inputPattern(config.input.path).text), config.run.timeout);
    if (!watched.is_worker) return watched.exit_code;
    if (!options.log_file.empty()) setLogFile(options.log_file);
    if (config.run.memory_limit > 0) enforceMemoryLimit(config);

    SignalWatch signals;
    const JobHistory& history = watched.history;
    const std::vector<Plan> outputs =
        planOutputs(config, {parseChunk(options.chunk), options.overwrite, options.skip_existing, options.dry_run,
                             history, watched.events});
    for (const std::string& warning : linesOf(outputs, &Plan::warnings)) logWarning(warning);
    if (options.dry_run) return printPlans(outputs, options.json);
    logPlans(outputs);

    const std::size_t frames = history.ended.size() + outputs.front().tasks.size();
    Progress progress(progress_kind, {frames, history.ended.size(), history.failed, 0, 0, {}},
                      options.json || options.stdout_is_taken);
    const FrameEnded frameEnded = [&](const std::vector<FrameResult>& results) {
        if (options.json)
            for (const FrameResult& result : results) std::cout << manifestJson(result) << std::endl;
        progress.frameEnded(results);
    };
    const JobResult result = runJob(outputs, history, signals, watched.events, frameEnded);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    logResult(result, summary(result, frames, seconds.count()), progress);
    return result.exitCode();
}

}  // namespace betamesh
