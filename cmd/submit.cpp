#include "batch/farm/farm.h"
#include "batch/job/distinct_files.h"
#include "batch/job/frames.h"
#include "batch/job/job.h"
#include "batch/job/plan.h"
#include "batch/report/log.h"
#include "betamesh/error.h"
#include "command.h"
#include "io/output_file.h"
#include "job_options.h"
#include "value_checks.h"

#include <filesystem>
#include <iostream>
#include <set>

namespace betamesh {
namespace {

namespace fs = std::filesystem;

constexpr double kMemoryMargin = 1.5;  // estimates are rough, and farms kill tasks that exceed their memory
constexpr std::uint64_t kProgramMemory = std::uint64_t{256} << 20;  // bytes without any frame

struct Arguments {
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
    bool print = false;
    std::vector<std::string> sbatch_options;
};

std::vector<int> framesOf(const std::vector<FrameTask>& tasks) {
    std::vector<int> frames;
    for (const FrameTask& task : tasks) frames.push_back(task.frame);
    return frames;
}

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

/// The command that makes the final report on the first output, in `<meshes>/<job>.html` unless --report names another
/// file.
std::vector<std::string> reportCommand(const Arguments& arguments, const FarmJob& job, const Plan& plan) {
    const fs::path page = arguments.report.empty()
                              ? fs::path(plan.config.output.path).parent_path() / (job.name + ".html")
                              : fs::path(arguments.report);
    return {job.run.front(), "report",   reportPath(plan.config.output.path), "-o",
            page.string(),   "--frames", printFrames(framesOf(plan.tasks))};
}

/// Memory to request for each task in bytes; 0 if it cannot be estimated.
std::uint64_t taskMemory(const Config& config, const std::vector<Plan>& plans) {
    if (config.run.memory_limit > 0) return config.run.memory_limit + kProgramMemory;
    std::uint64_t largest = 0;
    for (const Plan& plan : plans)
        for (const FrameTask& task : plan.tasks) largest = std::max(largest, task.memory);
    if (largest == 0) return 0;
    return static_cast<std::uint64_t>(static_cast<double>(largest) * kMemoryMargin) + kProgramMemory;
}

std::vector<std::vector<int>> chunksOf(const Arguments& arguments, const FarmJob& job, const Plan& plan, Farm farm) {
    const std::size_t max_tasks = farm == Farm::slurm ? maxSlurmTasks() : plan.tasks.size();
    if (arguments.chunk_size == 0) return chunksOfEqualCost(plan.tasks, job.threads, job.task_seconds, max_tasks);
    const auto chunks = chunksOfSize(plan.tasks, arguments.chunk_size);
    if (chunks.size() > max_tasks)
        throw Error("--chunk-size " + std::to_string(arguments.chunk_size) + " makes " + std::to_string(chunks.size()) +
                    " tasks, but Slurm accepts at most " + std::to_string(max_tasks) +
                    " in an array (MaxArraySize). Use a larger --chunk-size.");
    return chunks;
}

FarmJob farmJob(const Arguments& arguments, Farm farm) {
    Config config = readConfig(arguments.pipeline, keyValuesOf(arguments.assignments));
    if (!arguments.frames.empty()) setConfigKey(config, "frames", arguments.frames, "--frames");
    const std::vector<Plan> plans = plansOf(config);
    const Plan& plan = plans.front();

    FarmJob job;
    job.name = fs::path(arguments.pipeline).stem().string();
    job.folder = fs::current_path().string();
    const std::string program =
        arguments.program.empty() ? fs::read_symlink("/proc/self/exe").string() : arguments.program;
    job.run = {program, "run", arguments.pipeline};
    for (const std::string& assignment : arguments.assignments) job.run.insert(job.run.end(), {"--set", assignment});
    if (!arguments.no_report) job.report = reportCommand(arguments, job, plan);
    job.sbatch_options = arguments.sbatch_options;
    job.task_seconds = arguments.minutes * 60;
    job.threads = config.run.threads;
    job.memory = taskMemory(config, plans);
    job.chunks = chunksOf(arguments, job, plan, farm);
    return job;
}

std::string textFor(Farm farm, const FarmJob& job) {
    switch (farm) {
        case Farm::slurm:
            return slurmArray(job) + (job.report.empty() ? "" : "\n# After the array has ended:\n" + slurmReport(job));
        case Farm::openjd:
            return openJobTemplate(job);
        case Farm::opencue:
            return openCueCommand(job);
        case Farm::deadline:
            return deadlineCommand(job);
        case Farm::tractor:
            return tractorJob(job);
    }
    return "";
}

int submit(const Arguments& arguments) {
    const Farm farm = farmNamed(arguments.farm);
    if (!arguments.sbatch_options.empty() && farm != Farm::slurm)
        throw Error("'" + arguments.sbatch_options.front() +
                    "': options after -- are for sbatch. Use them with --to slurm only.");
    const FarmJob job = farmJob(arguments, farm);
    if (farm == Farm::slurm && !arguments.print) {
        const SlurmJobs submitted = submitToSlurm(job);
        std::cout << submitted.array_job << '\n';
        logInfo(std::to_string(job.chunks.size()) + " tasks: job " + submitted.array_job +
                (submitted.report_job.empty() ? "" : "; report: job " + submitted.report_job));
        return submitted.ok ? kAllWritten : kSomeFailed;
    }
    if (farm == Farm::openjd && !arguments.print) {
        const std::string file = arguments.output.empty() ? job.name + ".openjd.yaml" : arguments.output;
        DistinctFiles files;
        files.read(arguments.pipeline, "the pipeline file");
        files.written(file, "the template");
        writeFile(file, openJobTemplate(job));
        logInfo("job template -> " + file);
        return kAllWritten;
    }
    std::cout << textFor(farm, job);
    return kAllWritten;
}

}  // namespace

void addSubmitCommand(CLI::App& program, int& exit_code) {
    const auto [command, arguments] =
        addCommand(program, exit_code, "submit", "Submits the frames of a pipeline file to a farm engine.", submit);
    command->footer(
        "slurm      submits a job array and, after it, a report with sbatch; prints the id of the array\n"
        "openjd     writes an Open Job Description template\n"
        "opencue    prints the command of a layer\n"
        "deadline   prints the deadlinecommand command line that submits the job\n"
        "tractor    prints a job script for tractor-spool\n"
        "Tasks run in the current folder, which all machines must share. They skip finished frames, so the engine\n"
        "may run a task again at any time.\n"
        "Examples:\n"
        "  betamesh submit splash.yaml --to slurm -- --partition=long --time=4:00:00\n"
        "  betamesh submit splash.yaml --to opencue --frames 1-240");
    command->add_option("PIPELINE", arguments->pipeline, "The pipeline file (.yaml).")->required();
    command->add_option("--to", arguments->farm, "The farm engine.")->type_name(farmNames("|"))->required();
    command->add_flag("--print", arguments->print, "Print what would be submitted or written, and do neither.");
    command->add_option("--frames", arguments->frames, "Frames to process, as for `betamesh run`.")
        ->type_name("FRAMES");
    command->add_option("--set", arguments->assignments, "Set any key, as for `betamesh run`.")
        ->type_name("KEY=VALUE")
        ->expected(1)
        ->take_all();
    command
        ->add_option("--task-minutes", arguments->minutes,
                     "Intended duration of a task in minutes, estimated from the sizes of the inputs.")
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
                     "For openjd: the template to write. Without it, PIPELINE.openjd.yaml in the current folder.")
        ->type_name("FILE");
    command->add_option("SBATCH", arguments->sbatch_options,
                        "After --: more options for sbatch, for the array and for the report.");
}

}  // namespace betamesh
