#include "batch/farm/farm.h"
#include "batch/job/frames.h"
#include "batch/job/job.h"
#include "batch/report/log.h"
#include "betamesh/error.h"
#include "command.h"
#include "io/output_file.h"
#include "job_options.h"

#include <filesystem>
#include <iostream>

namespace betamesh {
namespace {

namespace fs = std::filesystem;

constexpr double kMemorySpare = 1.5;  // estimates are rough, and a farm kills without a word
constexpr std::uint64_t kMemoryOfProgram = std::uint64_t{256} << 20;  // without any frame

struct Arguments {
    std::string pipeline;
    std::string farm;
    std::string frames;
    std::vector<std::string> assignments;
    std::size_t chunk_size = 0;  ///< frames; 0: by cost
    double minutes = 5;
    std::string report;
    bool no_report = false;
    std::string program;
    std::string output;
    bool print = false;
    std::vector<std::string> further;
};

std::vector<int> framesOf(const std::vector<FrameTask>& tasks) {
    std::vector<int> frames;
    for (const FrameTask& task : tasks) frames.push_back(task.frame);
    return frames;
}

FarmJob farmJob(const Arguments& arguments, Farm farm) {
    Config config = readConfig(arguments.pipeline, keyValuesOf(arguments.assignments));
    if (!arguments.frames.empty()) setConfigKey(config, "frames", arguments.frames, "--frames");
    PlanOptions options;
    options.dry_run = options.overwrite = true;
    const Plan plan = planJob(config, options);
    for (const std::string& warning : plan.warnings) logWarning(warning);

    FarmJob job;
    job.name = fs::path(arguments.pipeline).stem().string();
    job.folder = fs::current_path().string();
    const std::string program =
        arguments.program.empty() ? fs::read_symlink("/proc/self/exe").string() : arguments.program;
    job.run = {program, "run", arguments.pipeline};
    for (const std::string& assignment : arguments.assignments) job.run.insert(job.run.end(), {"--set", assignment});
    const fs::path page = arguments.report.empty() ? fs::path(config.output.path).parent_path() / (job.name + ".html")
                                                   : fs::path(arguments.report);
    if (!arguments.no_report)
        job.report = {program,       "report",   reportPath(config.output.path),   "-o",
                      page.string(), "--frames", printFrames(framesOf(plan.tasks))};
    job.task_seconds = arguments.minutes * 60;
    job.threads = config.run.threads;
    std::uint64_t largest = 0;
    for (const FrameTask& task : plan.tasks) largest = std::max(largest, task.memory);
    job.memory = config.run.memory_limit > 0 ? config.run.memory_limit + kMemoryOfProgram
                 : largest > 0
                     ? static_cast<std::uint64_t>(static_cast<double>(largest) * kMemorySpare) + kMemoryOfProgram
                     : 0;
    const std::size_t most = farm == Farm::slurm ? slurmMostTasks() : plan.tasks.size();
    job.pieces = arguments.chunk_size > 0 ? piecesOfFrames(plan.tasks, arguments.chunk_size)
                                          : piecesOfEqualCost(plan.tasks, job.threads, job.task_seconds, most);
    if (job.pieces.size() > most)
        throw Error("--chunk-size " + std::to_string(arguments.chunk_size) + " makes " +
                    std::to_string(job.pieces.size()) + " tasks; expected at most " + std::to_string(most) +
                    ", what Slurm takes in an array (MaxArraySize)");
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
    const Farm farm = farmOf(arguments.farm);
    if (!arguments.further.empty() && farm != Farm::slurm)
        throw Error("'" + arguments.further.front() + "': words after -- are for sbatch; expected --to slurm");
    const FarmJob job = farmJob(arguments, farm);
    if (farm == Farm::slurm && !arguments.print) {
        const Submitted submitted = submitToSlurm(job, arguments.further);
        std::cout << submitted.array_job << '\n';
        logInfo(std::to_string(job.pieces.size()) + " tasks: job " + submitted.array_job +
                (submitted.report_job.empty() ? "" : "; report: job " + submitted.report_job));
        return submitted.ok ? kAllWritten : kSomeFailed;
    }
    if (farm == Farm::openjd && !arguments.print) {
        const std::string file = arguments.output.empty() ? job.name + ".openjd.yaml" : arguments.output;
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
        addCommand(program, exit_code, "submit", "Hands the frames of a pipeline to a farm engine.", submit);
    command->footer(
        "slurm      submits a job array with sbatch, and a report that follows it; prints the array's id\n"
        "openjd     writes an Open Job Description template\n"
        "opencue    prints the command of a layer\n"
        "deadline   prints the deadlinecommand that submits the job\n"
        "tractor    prints a job script for tractor-spool\n"
        "Tasks start in this folder and see the same files; they skip what is finished, so a task may run again.\n"
        "Examples:\n"
        "  betamesh submit splash.yaml --to slurm -- --partition=long --time=4:00:00\n"
        "  betamesh submit splash.yaml --to opencue --frames 1-240");
    command->add_option("PIPELINE", arguments->pipeline, "The pipeline file (.yaml).")->required();
    command->add_option("--to", arguments->farm, "The engine.")
        ->type_name("slurm|openjd|opencue|deadline|tractor")
        ->required();
    command->add_flag("--print", arguments->print, "Show what would be submitted or written, and do neither.");
    command->add_option("--frames", arguments->frames, "As for `run`.")->type_name("FRAMES");
    command->add_option("--set", arguments->assignments, "As for `run`.")
        ->type_name("KEY=VALUE")
        ->expected(1)
        ->take_all();
    command
        ->add_option("--task-minutes", arguments->minutes,
                     "About how long a task takes, guessed from the sizes of the inputs (default 5).")
        ->type_name("M")
        ->check(CLI::PositiveNumber);
    command->add_option("--chunk-size", arguments->chunk_size, "So many frames a task instead.")
        ->type_name("N")
        ->check(CLI::Range(std::size_t{1}, std::size_t{10000000}));
    command
        ->add_option("--report", arguments->report,
                     "The page of the final report; default PIPELINE.html beside the meshes.")
        ->type_name("FILE.html");
    command->add_flag("--no-report", arguments->no_report, "No final report.");
    command->add_option("--program", arguments->program, "betamesh on the farm's machines; default: this one.")
        ->type_name("FILE");
    command->add_option("-o,--output", arguments->output, "openjd: the template; default PIPELINE.openjd.yaml here.")
        ->type_name("FILE");
    command->add_option("SBATCH", arguments->further, "Behind --: further words for sbatch.");
}

}  // namespace betamesh
