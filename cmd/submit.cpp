#include "batch/farm/farm.h"
#include "batch/job/distinct_files.h"
#include "batch/job/frames.h"
#include "batch/job/job.h"
#include "batch/job/plan.h"
#include "batch/report/log.h"
#include "batch/report/printable.h"
#include "betamesh/error.h"
#include "command.h"
#include "io/output_file.h"
#include "job_options.h"
#include "value_checks.h"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <set>

namespace betamesh {
namespace {

namespace fs = std::filesystem;

constexpr double kMemoryMargin = 1.5;  // estimates are rough, and farms kill tasks that exceed their memory
constexpr std::uint64_t kProgramMemory = std::uint64_t{256} << 20;  // bytes without any frame

struct SubmitArguments {
    std::string pipeline;
    std::string farm;
    std::string frames;
    std::vector<std::string> assignments;
    std::size_t chunk_size = 0;  ///< frames per task; 0: by estimated duration
    double minutes = 5;
    std::string report;
    bool no_report = false;
    std::string program;
    std::string output;
    bool overwrite = false;
    bool print = false;
    std::vector<std::string> sbatch_options;
};

/// The plans of all outputs, which have the same frames.
std::vector<Plan> plansOf(const Config& config) {
    PlanOptions options;
    options.overwrite = true;
    options.measure = false;
    std::vector<Plan> plans = planOutputs(config, options);
    std::set<std::string> logged;
    for (const Plan& plan : plans)
        for (const std::string& warning : plan.warnings)
            if (logged.insert(warning).second) logWarning(warning);
    return plans;
}

/// The command that makes the final report on all outputs, in `<meshes>/<job>.html` unless --report names another file,
/// without --frames.
std::vector<std::string> reportCommand(const SubmitArguments& arguments, const FarmJob& job,
                                       const std::vector<Plan>& plans) {
    const fs::path page =
        arguments.report.empty()
            ? fs::path(withVariables(plans.front().config.output.path)).parent_path() / (job.name + ".html")
            : fs::path(arguments.report);
    std::vector<std::string> words{job.run.front(), "report"};
    for (const Plan& plan : plans) words.push_back(manifestPath(plan.config.output.path));
    words.insert(words.end(), {"-o", page.string()});
    return words;
}

/// Memory to request for each task in bytes; 0 if it cannot be estimated, as for inputs that do not exist yet.
std::uint64_t taskMemory(const Config& config, const std::vector<Plan>& plans) {
    if (config.run.memory_limit > 0) return config.run.memory_limit + kProgramMemory;
    if (withoutInput(plans.front().tasks) > 0) return 0;
    std::uint64_t largest = 0;
    for (const Plan& plan : plans)
        for (const FrameTask& task : plan.tasks) largest = std::max(largest, task.memory);
    if (largest == 0) return 0;
    return static_cast<std::uint64_t>(static_cast<double>(largest) * kMemoryMargin) + kProgramMemory;
}

std::vector<std::vector<int>> chunksOf(const SubmitArguments& arguments, const FarmJob& job, const Plan& plan,
                                       Farm farm) {
    const std::size_t max_tasks = farm == Farm::slurm ? maxSlurmTasks() : plan.tasks.size();
    if (arguments.chunk_size == 0) return chunksOfEqualCost(plan.tasks, job.threads, job.task_seconds, max_tasks);
    const auto chunks = chunksOfSize(plan.tasks, arguments.chunk_size);
    if (chunks.size() > max_tasks)
        throw Error("--chunk-size " + std::to_string(arguments.chunk_size) + " makes " + std::to_string(chunks.size()) +
                    " tasks, but Slurm accepts at most " + std::to_string(max_tasks) +
                    " in an array (MaxArraySize). Use a larger --chunk-size.");
    return chunks;
}

/// Sets the files that the tasks read and the folders that they write to.
void setFiles(FarmJob& job, const Config& config, const std::vector<Plan>& plans) {
    const auto absolute = [&](const fs::path& path) { return (fs::path(job.folder) / path).lexically_normal(); };
    std::set<std::string> inputs, folders;
    for (const fs::path& file : config.files) inputs.insert(absolute(file).string());
    for (const Plan& plan : plans)
        for (const FrameTask& task : plan.tasks) {
            if (fs::exists(task.input)) inputs.insert(absolute(task.input).string());
            for (const std::string& file : {task.output, task.preview})
                if (!file.empty()) folders.insert(absolute(file).parent_path().string());
        }
    if (!job.report.empty()) folders.insert(absolute(job.report.back()).parent_path().string());
    job.input_files.assign(inputs.begin(), inputs.end());
    job.output_folders.assign(folders.begin(), folders.end());
}

/// Workers to which the files of a bundle are transferred have them elsewhere.
void warnOfAbsolutePaths(const SubmitArguments& arguments, const std::vector<Plan>& plans) {
    std::vector<std::string> files{arguments.pipeline, arguments.report};
    for (const Plan& plan : plans)
        files.insert(files.end(), {plan.tasks.front().input, plan.tasks.front().output, plan.tasks.front().preview});
    const auto absolute =
        std::find_if(files.begin(), files.end(), [](const fs::path& file) { return file.is_absolute(); });
    if (absolute != files.end())
        logWarning(*absolute +
                   ": this path is absolute, so that workers must have the file there. With job attachments, make all "
                   "paths relative to the current folder.");
}

/// errors  frames that are to be found on disk, where there are none yet
void requireFrames(const Config& config) {
    if (config.frames != "all" || config.input.path.empty()) return;
    const FramePattern input = inputPattern(config.input.path);
    if (input.numbered && framesOnDisk(input).empty())
        throw Error("'" + input.text +
                    "': no frame is on disk yet. Name the frames that the simulation is going to write with --frames, "
                    "as in --frames 1-240, or with frames in the pipeline file");
}

/// Says which frames are submitted if only those on disk are, and what is not known about frames without input.
void noteFrames(const SubmitArguments& arguments, const Config& config, const std::vector<FrameTask>& tasks) {
    if (config.frames == "all" && inputPattern(config.input.path).numbered) {
        std::vector<int> frames;
        for (const FrameTask& task : tasks) frames.push_back(task.frame);
        logInfo("the frames on disk are submitted: " + printFrames(frames) +
                ". Name frames that do not exist yet with --frames");
    }
    const std::size_t missing = withoutInput(tasks);
    if (missing == 0) return;
    std::string unknown = arguments.chunk_size > 0 ? "" : "how long they take";
    std::string advice = arguments.chunk_size > 0 ? "" : "frames per task with --chunk-size";
    if (config.run.memory_limit == 0) {
        unknown += std::string(unknown.empty() ? "" : " and ") + "how much memory they need";
        advice += std::string(advice.empty() ? "" : ", and ") + "memory with --set run.memory_limit=16GiB";
    }
    logInfo(std::to_string(missing) + " of " + std::to_string(tasks.size()) + " frames have no input yet" +
            (unknown.empty() ? "" : ": " + unknown + " is not known. Give " + advice));
}

FarmJob farmJob(const SubmitArguments& arguments, Farm farm) {
    Config config = readConfig(arguments.pipeline, keyValuesOf(arguments.assignments));
    if (!arguments.frames.empty()) setConfigKey(config, "frames", arguments.frames, "--frames");
    requireFrames(config);
    const std::vector<Plan> plans = plansOf(config);
    noteFrames(arguments, config, plans.front().tasks);
    if (farm == Farm::deadline_cloud) warnOfAbsolutePaths(arguments, plans);

    FarmJob job;
    job.name = fs::path(arguments.pipeline).stem().string();
    job.folder = fs::current_path().string();
    const std::string program =
        arguments.program.empty() ? fs::read_symlink("/proc/self/exe").string() : arguments.program;
    job.run = {program, "run", arguments.pipeline};
    for (const std::string& assignment : arguments.assignments) job.run.insert(job.run.end(), {"--set", assignment});
    if (!arguments.no_report) job.report = reportCommand(arguments, job, plans);
    job.sbatch_options = arguments.sbatch_options;
    job.task_seconds = arguments.minutes * 60;
    job.threads = config.run.threads;
    job.memory = taskMemory(config, plans);
    job.chunks = chunksOf(arguments, job, plans.front(), farm);
    if (arguments.chunk_size > 0) job.task_seconds = 0;
    job.longest_task_seconds = longestSeconds(plans.front().tasks, job.chunks, job.threads, arguments.minutes * 60) *
                               static_cast<double>(plans.size());
    setFiles(job, config, plans);
    return job;
}

/// What is handed to an engine: one file or, for slurm and deadline-cloud, several.
std::vector<FarmFile> filesFor(Farm farm, const FarmJob& job) {
    switch (farm) {
        case Farm::slurm:
            return slurmFiles(job);
        case Farm::openjd:
            return {{job.name + ".openjd.yaml", openJobTemplate(job)}};
        case Farm::deadline_cloud:
            return deadlineCloudBundle(job);
        case Farm::opencue:
            return {{"", openCueCommand(job)}};
        case Farm::deadline:
            return {{"", deadlineCommand(job)}};
        case Farm::tractor:
            return {{"", tractorJob(job)}};
    }
    return {};
}

/// Prints files one after the other. Comments name those after the first, so that a single script begins with #!.
void print(const std::vector<FarmFile>& files) {
    for (const FarmFile& file : files) {
        if (&file != &files.front()) std::cout << "\n# " << printable(file.name) << ":\n";
        std::cout << file.text;
    }
}

/// Where the files of an engine are written: --output, or a default; empty if they are printed or submitted.
std::string destinationOf(const SubmitArguments& arguments, Farm farm, const FarmJob& job) {
    if (arguments.print) return "";
    if (!arguments.output.empty()) return arguments.output;
    if (farm == Farm::openjd) return job.name + ".openjd.yaml";
    if (farm == Farm::deadline_cloud) return job.name + ".deadline-cloud";
    return "";
}

/// Writes several files into a folder, which is made if it is not there, a single file as `destination`.
///
/// errors  a file that exists, unless arguments.overwrite is set; nothing is written then
void write(const std::vector<FarmFile>& files, const std::string& destination, const SubmitArguments& arguments,
           bool folder) {
    DistinctFiles distinct;
    distinct.read(arguments.pipeline, "the pipeline file");
    const auto path = [&](const FarmFile& file) {
        return folder ? (fs::path(destination) / file.name).string() : destination;
    };
    for (const FarmFile& file : files) distinct.written(path(file), folder ? file.name : "the file of --output");
    for (const FarmFile& file : files) {
        std::error_code ignored;
        if (!arguments.overwrite && fs::exists(fs::symlink_status(path(file), ignored)))
            throw Error(path(file) + " already exists. Use --overwrite to replace it.");
    }
    if (folder) {
        std::error_code error;
        fs::create_directories(destination, error);
        if (!fs::is_directory(destination))
            throw Error(destination + ": this folder cannot be made" + (error ? " (" + error.message() + ')' : "") +
                        ". Give another one to --output.");
    }
    for (const FarmFile& file : files) {
        writeFile(path(file), file.text);
        logInfo("-> " + path(file));
    }
}

int submit(const SubmitArguments& arguments) {
    const Farm farm = farmNamed(arguments.farm);
    if (!arguments.sbatch_options.empty() && farm != Farm::slurm)
        throw Error("'" + arguments.sbatch_options.front() +
                    "': options after -- are for sbatch. Use them with --to slurm only.");
    const FarmJob job = farmJob(arguments, farm);
    const std::vector<FarmFile> files = filesFor(farm, job);
    if (const std::string destination = destinationOf(arguments, farm, job); !destination.empty()) {
        write(files, destination, arguments, farm == Farm::slurm || farm == Farm::deadline_cloud);
        return kAllWritten;
    }
    if (farm != Farm::slurm || arguments.print) {
        print(files);
        return kAllWritten;
    }
    const SlurmJobs submitted = submitToSlurm(job);
    std::cout << submitted.array_job << '\n';
    logInfo(std::to_string(job.chunks.size()) + " tasks: job " + submitted.array_job +
            (submitted.report_job.empty() ? "" : "; report: job " + submitted.report_job));
    return submitted.ok ? kAllWritten : kSomeFailed;
}

}  // namespace

void addSubmitCommand(CLI::App& program, int& exit_code) {
    const auto [command, arguments] =
        addCommand(program, exit_code, "submit", "Submits the frames of a pipeline file to a farm engine.", submit);
    command->footer(
        "slurm           submits a job array and, after it, a report with sbatch; prints the id of the array\n"
        "openjd          writes an Open Job Description template\n"
        "deadline-cloud  writes a job bundle of AWS Deadline Cloud, a folder\n"
        "opencue         prints the command of a layer\n"
        "deadline        prints the deadlinecommand command line that submits the job\n"
        "tractor         prints a job script for tractor-spool\n"
        "Tasks run in the current folder, which all machines must share. They skip finished frames, so the engine\n"
        "may run a task again at any time.\n"
        "Examples:\n"
        "  betamesh submit splash.yaml --to slurm -- --partition=long --time=4:00:00\n"
        "  betamesh submit splash.yaml --to opencue --frames 1-240");
    command->add_option("PIPELINE", arguments->pipeline, "The pipeline file (.yaml).")->required();
    command->add_option("--to", arguments->farm, "The farm engine.")->type_name(farmNames("|"))->required();
    command->add_flag("--print", arguments->print, "Print what would be submitted or written, and do neither.");
    command->add_flag("--dry-run", arguments->print, "The same as --print.");
    command
        ->add_option("--frames", arguments->frames,
                     "Frames to process, as for `betamesh run`. Their inputs need not exist yet. Without it, those of "
                     "the pipeline file, or all on disk.")
        ->type_name("FRAMES");
    command->add_option("--set", arguments->assignments, "Set any key, as for `betamesh run`.")
        ->type_name("KEY=VALUE")
        ->expected(1)
        ->allow_extra_args(false)  // CLI11 would take -- for the end of its values
        ->take_all();
    command
        ->add_option("--task-minutes", arguments->minutes,
                     "Intended duration of a task in minutes, estimated from the sizes of the inputs. A frame without "
                     "input yet is a task of its own.")
        ->type_name("M")
        ->capture_default_str()
        ->check(numberAboveZero());
    command->add_option("--chunk-size", arguments->chunk_size, "Frames per task, instead of --task-minutes.")
        ->type_name("N")
        ->check(wholeNumber(1, 10000000));
    command
        ->add_option("--report", arguments->report,
                     "Page of the final report. Without it, PIPELINE.html beside the meshes.")
        ->type_name("FILE.html");
    command->add_flag("--no-report", arguments->no_report, "Do not make a final report.");
    command
        ->add_option("--program", arguments->program,
                     "Path of betamesh on the machines of the farm. Without it, the path of this program.")
        ->type_name("FILE");
    command
        ->add_option("-o,--output", arguments->output,
                     "Write the files here instead of submitting or printing them: a folder for the scripts of slurm "
                     "and the bundle of deadline-cloud, a file for the others. Without it, openjd writes "
                     "PIPELINE.openjd.yaml and deadline-cloud PIPELINE.deadline-cloud in the current folder.")
        ->type_name("PATH");
    command->add_flag("--overwrite", arguments->overwrite, "Replace files of --output that already exist.");
    command->add_option("SBATCH", arguments->sbatch_options,
                        "After --: more options for sbatch, for the array and for the report.");
}

}  // namespace betamesh
