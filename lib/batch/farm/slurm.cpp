// Job scripts for Slurm, and their submission with sbatch.

#include "batch/farm/command_words.h"
#include "batch/farm/farm.h"
#include "batch/job/frames.h"
#include "betamesh/error.h"

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <tuple>
#include <utility>

namespace betamesh {
namespace {

constexpr std::size_t kDefaultMaxArraySize = 1001;  // Slurm's default
constexpr std::size_t kMaxFileNameLength = 200;     // bytes of a job's name in those of its files
constexpr double kTimeMargin = 12;                  // times the estimate, which knows neither the disks nor the machine
constexpr double kMinTimeMinutes = 60;              // of the time limit
constexpr int kReportMebibytes = 1024;              // enough for the manifests of a hundred thousand frames

/// A word in a line #SBATCH, where a backslash escapes the next character, even in quotes, and # begins a comment.
/// source  Slurm, src/sbatch/opt.c
std::string sbatchWord(const std::string& word) {
    requireNoControl(word, "a line #SBATCH");
    std::string out;
    for (const char c : word) {
        if (std::string_view(" \\\"'#").find(c) != std::string_view::npos) out += '\\';
        out += c;
    }
    return out;
}

/// The line of a batch script with these options; empty if there are none.
std::string sbatchLine(const std::vector<std::string>& options) {
    if (options.empty()) return "";
    std::string line = "#SBATCH";
    for (const std::string& option : options) line += ' ' + sbatchWord(option);
    return line + '\n';
}

/// The name of the job's files: no folder, no character that Slurm replaces in the name of a log.
std::string fileNameOf(const FarmJob& job) {
    std::string name = shortened(titleOf(job.name), kMaxFileNameLength);
    std::replace_if(
        name.begin(), name.end(), [](char c) { return c == '/' || c == '%' || c == '\\'; }, '_');
    return name;
}

/// The first lines of a batch script: the defaults that the options of the user do not replace, then these options.
/// --mem-per-cpu replaces --mem, too, because Slurm refuses both together.
std::string batchHead(const std::string& title, const std::vector<std::string>& defaults,
                      const std::vector<std::string>& options) {
    std::string text = "#!/bin/bash\n#SBATCH --job-name=" + sbatchWord(title) + '\n';
    for (const std::string& line : defaults) {
        const std::string name = line.substr(0, line.find('='));
        if (std::none_of(options.begin(), options.end(), [&](const auto& option) { return option.starts_with(name); }))
            text += sbatchLine({line});
    }
    return text + "#SBATCH --requeue\n#SBATCH --open-mode=append\n" + sbatchLine(options);
}

/// The report is a single task.
std::vector<std::string> optionsForReport(const FarmJob& job) {
    std::vector<std::string> options = job.sbatch_options;
    std::erase_if(options, [](const std::string& option) { return option.starts_with("--array="); });
    return options;
}

struct CommandOutput {
    std::string out;
    int status = -1;  ///< exit code; -1: the command did not run or was ended by a signal
};

CommandOutput outputOf(const std::string& command) {
    CommandOutput result;
    std::FILE* pipe = ::popen(command.c_str(), "r");
    if (pipe == nullptr) return result;
    std::array<char, 4096> block{};
    for (std::size_t n = 0; (n = std::fread(block.data(), 1, block.size(), pipe)) > 0;)
        result.out.append(block.data(), n);
    const int status = ::pclose(pipe);
    if (WIFEXITED(status)) result.status = WEXITSTATUS(status);
    return result;
}

/// A temporary script file for sbatch, deleted with this object.
class ScriptFile {
public:
    explicit ScriptFile(const std::string& text) {
        const int file = ::mkstemp(path_.data());
        std::FILE* stream = file < 0 ? nullptr : ::fdopen(file, "w");
        if (stream == nullptr)
            throw Error(path_ + ": this temporary script for sbatch cannot be written. Check the space left there.");
        const bool whole = std::fwrite(text.data(), 1, text.size(), stream) == text.size();
        if (std::fclose(stream) != 0 || !whole)
            throw Error(path_ + ": this temporary script for sbatch cannot be written. Check the space left there.");
    }
    ~ScriptFile() { ::unlink(path_.c_str()); }
    ScriptFile(const ScriptFile&) = delete;
    ScriptFile& operator=(const ScriptFile&) = delete;
    const std::string& path() const { return path_; }

private:
    static std::string pathToFill() {
        std::error_code failure;
        const std::filesystem::path folder = std::filesystem::temp_directory_path(failure);
        if (failure) throw Error("the folder for temporary files, TMPDIR, does not exist. Set it to one that does.");
        return (folder / "betamesh-sbatch-XXXXXX").string();
    }

    std::string path_ = pathToFill();
};

/// Submits a script. Returns the job id and whether sbatch succeeded.
std::pair<std::string, bool> sbatch(const std::string& script, const std::vector<std::string>& options) {
    const ScriptFile file(script);
    std::vector<std::string> words{"sbatch", "--parsable"};
    words.insert(words.end(), options.begin(), options.end());
    words.push_back(file.path());
    const CommandOutput result = outputOf(shellWords(words));
    const std::string id = result.out.substr(0, result.out.find_first_of(";\n"));
    if (id.empty())
        throw Error("sbatch did not accept the job (exit code " + std::to_string(result.status) +
                    "). Its message is above.");
    return {id, result.status == 0};
}

}  // namespace

std::string slurmArray(const FarmJob& job) {
    const double minutes = std::max(kMinTimeMinutes, std::ceil(job.longest_task_seconds * kTimeMargin / 60));
    std::vector<std::string> defaults{"--array=1-" + std::to_string(job.chunks.size()),
                                      "--time=" + std::to_string(std::lround(minutes)),
                                      "--output=" + fileNameOf(job) + ".%A_%a.log"};
    if (job.threads > 0) defaults.push_back("--cpus-per-task=" + std::to_string(job.threads));
    if (job.memory > 0) defaults.push_back("--mem=" + std::to_string(mebibytes(job.memory)) + 'M');
    std::string text = batchHead(titleOf(job.name), defaults, job.sbatch_options) + "frames=(";
    for (std::size_t i = 0; i < job.chunks.size(); ++i) text += (i > 0 ? " " : "") + printFrames(job.chunks[i]);
    return text + ")\n# exec, so that scancel and time limits signal betamesh itself\nexec " +
           shellWords(inFolder(job, job.run)) + " --frames \"${frames[SLURM_ARRAY_TASK_ID - 1]}\" --skip-existing\n";
}

std::string slurmReport(const FarmJob& job) {
    const std::vector<std::string> defaults{"--time=" + std::to_string(std::lround(kMinTimeMinutes)),
                                            "--output=" + fileNameOf(job) + ".report.%j.log", "--cpus-per-task=1",
                                            "--mem=" + std::to_string(kReportMebibytes) + 'M'};
    return batchHead(titleOf(job.name) + "-report", defaults, optionsForReport(job)) + "exec " +
           shellWords(inFolder(job, reportWords(job))) + '\n';
}

std::vector<FarmFile> slurmFiles(const FarmJob& job) {
    const std::string name = fileNameOf(job);
    std::vector<FarmFile> files{{name + ".array.sh", slurmArray(job)}};
    if (job.report.empty()) return files;
    files.push_back({name + ".report.sh", slurmReport(job)});
    files.push_back({name + ".submit.sh",
                     "#!/bin/bash\n# Submits the array, then the report, which starts when the array has ended, also "
                     "after tasks that failed.\nscripts=$(cd \"$(dirname \"$0\")\" && pwd) && cd " +
                         shellWords({job.folder}) + " || exit\narray=$(sbatch --parsable \"$scripts\"/" +
                         shellWords({files[0].name}) +
                         ") || exit\nsbatch --dependency=afterany:\"${array%%;*}\" \"$scripts\"/" +
                         shellWords({files[1].name}) + '\n'});
    return files;
}

std::size_t maxSlurmTasks() {
    const std::string settings = outputOf("scontrol show config 2>/dev/null").out;
    const std::size_t at = settings.find("MaxArraySize");
    const std::size_t number = at == std::string::npos ? at : settings.find_first_of("0123456789", at);
    const std::size_t size =
        number == std::string::npos ? kDefaultMaxArraySize : std::strtoul(settings.c_str() + number, nullptr, 10);
    return std::max<std::size_t>(2, size) - 1;  // indices are below MaxArraySize, and ours begin at 1
}

SlurmJobs submitToSlurm(const FarmJob& job) {
    SlurmJobs submitted;
    std::tie(submitted.array_job, submitted.ok) = sbatch(slurmArray(job), job.sbatch_options);
    if (job.report.empty()) return submitted;
    // afterany: the report also runs after tasks that failed, because it shows which.
    std::vector<std::string> options = optionsForReport(job);
    options.push_back("--dependency=afterany:" + submitted.array_job);
    const auto [report, ok] = sbatch(slurmReport(job), options);
    submitted.report_job = report;
    submitted.ok = submitted.ok && ok;
    return submitted;
}

}  // namespace betamesh
