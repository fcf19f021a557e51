
#include "batch/farm/farm.h"

#include "batch/job/frames.h"
#include "betamesh/error.h"

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <tuple>

namespace betamesh {
namespace {

constexpr double kBytesPerSecond = 140e6;         // of working memory that one thread gets through: 100,000 particles
constexpr double kSecondsOfAFrame = 0.05;         // whatever its size
constexpr std::size_t kUsualMaxArraySize = 1001;  // Slurm's, where it does not tell
constexpr int kNotifySeconds = 30;                // between SIGTERM and SIGKILL; a frame being written takes less
constexpr std::size_t kOpenJobName = 128;         // characters at most

std::string shellWord(const std::string& word) {
    const auto plain = [](unsigned char c) {
        return std::isalnum(c) != 0 ||
               std::string_view("_-./=:,+@%").find(static_cast<char>(c)) != std::string_view::npos;
    };
    if (!word.empty() && std::all_of(word.begin(), word.end(), plain)) return word;
    std::string quoted = "'";
    for (const char c : word) quoted += c == '\'' ? "'\\''" : std::string(1, c);
    return quoted + "'";
}

/// Farms start tasks wherever they like.
std::vector<std::string> inFolder(const FarmJob& job, const std::vector<std::string>& words,
                                  const std::vector<std::string>& further = {}) {
    std::vector<std::string> all{"env", "-C", job.folder};
    all.insert(all.end(), words.begin(), words.end());
    all.insert(all.end(), further.begin(), further.end());
    return all;
}

std::vector<int> allFrames(const FarmJob& job) {
    std::vector<int> frames;
    for (const auto& piece : job.pieces) frames.insert(frames.end(), piece.begin(), piece.end());
    return frames;
}

std::size_t largestPiece(const FarmJob& job) {
    std::size_t largest = 1;
    for (const auto& piece : job.pieces) largest = std::max(largest, piece.size());
    return largest;
}

std::uint64_t mebibytes(std::uint64_t bytes) { return (bytes >> 20) + 1; }

/// In double quotes, for YAML and JSON.
std::string inQuotes(const std::string& text) {
    std::string out = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') out += '\\';
        if (static_cast<unsigned char>(c) < 0x20) {
            std::array<char, 8> code{};
            std::snprintf(code.data(), code.size(), "\\u%04x", static_cast<unsigned>(c));
            out += code.data();
        } else {
            out += c;
        }
    }
    return out + '"';
}

/// A word of an Open Job Description: nothing in it is to be replaced.
std::string literal(const std::string& word) {
    if (word.find("{{") != std::string::npos)
        throw Error("'" + word + "': {{ begins a reference in an Open Job Description; expected words without it");
    return inQuotes(word);
}

std::string action(const std::string& name, const std::vector<std::string>& words, const std::string& further,
                   const std::string& indent) {
    std::string text =
        indent + name + ":\n" + indent + "  command: " + literal(words.front()) + '\n' + indent + "  args: [";
    for (std::size_t i = 1; i < words.size(); ++i) text += (i > 1 ? ", " : "") + literal(words[i]);
    text += further.empty() ? "" : ", " + further;
    return text + "]\n" + indent +
           "  cancelation: {mode: NOTIFY_THEN_TERMINATE, notifyPeriodInSeconds: " + std::to_string(kNotifySeconds) +
           "}\n";
}

struct CommandOutput {
    std::string out;
    int status = -1;  ///< exit code; -1: it did not run or a signal ended it
};

CommandOutput outputOf(const std::string& command) {
    CommandOutput result;
    std::FILE* pipe = ::popen(command.c_str(), "r");
    if (pipe == nullptr) return result;
    std::array<char, 4096> piece{};
    for (std::size_t n = 0; (n = std::fread(piece.data(), 1, piece.size(), pipe)) > 0;)
        result.out.append(piece.data(), n);
    const int status = ::pclose(pipe);
    if (WIFEXITED(status)) result.status = WEXITSTATUS(status);
    return result;
}

/// A script on disk while sbatch reads it.
class ScriptFile {
public:
    explicit ScriptFile(const std::string& text) {
        const int file = ::mkstemp(path_.data());
        std::FILE* stream = file < 0 ? nullptr : ::fdopen(file, "w");
        if (stream == nullptr) throw Error(path_ + ": a script for sbatch cannot be written");
        const bool whole = std::fwrite(text.data(), 1, text.size(), stream) == text.size();
        if (std::fclose(stream) != 0 || !whole) throw Error(path_ + ": a script for sbatch cannot be written");
    }
    ~ScriptFile() { ::unlink(path_.c_str()); }
    ScriptFile(const ScriptFile&) = delete;
    ScriptFile& operator=(const ScriptFile&) = delete;
    const std::string& path() const { return path_; }

private:
    std::string path_ = "/tmp/betamesh-sbatch-XXXXXX";
};

/// The id, and whether sbatch ended well.
std::pair<std::string, bool> sbatch(const std::string& script, const std::vector<std::string>& further) {
    const ScriptFile file(script);
    std::vector<std::string> words{"sbatch", "--parsable"};
    words.insert(words.end(), further.begin(), further.end());
    words.push_back(file.path());
    const CommandOutput result = outputOf(shellWords(words));
    const std::string id = result.out.substr(0, result.out.find_first_of(";\n"));
    if (id.empty()) throw Error("sbatch did not take the job (exit code " + std::to_string(result.status) + ")");
    return {id, result.status == 0};
}

}  // namespace

Farm farmOf(std::string_view word) {
    if (word == "slurm") return Farm::slurm;
    if (word == "openjd") return Farm::openjd;
    if (word == "opencue") return Farm::opencue;
    if (word == "deadline") return Farm::deadline;
    if (word == "tractor") return Farm::tractor;
    throw Error("farm '" + std::string(word) + "': expected one of slurm openjd opencue deadline tractor");
}

std::string shellWords(const std::vector<std::string>& words) {
    std::string text;
    for (const std::string& word : words) text += (text.empty() ? "" : " ") + shellWord(word);
    return text;
}

std::vector<std::vector<int>> piecesOfEqualCost(const std::vector<FrameTask>& tasks, int threads, double seconds,
                                                std::size_t most) {
    std::vector<double> until;  // seconds of all frames up to each
    for (const FrameTask& task : tasks) {
        const double cost = static_cast<double>(task.memory) / (kBytesPerSecond * std::max(1, threads));
        until.push_back((until.empty() ? 0 : until.back()) + cost + kSecondsOfAFrame);
    }
    const double wanted = std::ceil(until.back() / seconds);
    const std::size_t count =
        static_cast<std::size_t>(std::clamp(wanted, 1.0, static_cast<double>(std::min(most, tasks.size()))));
    std::vector<std::vector<int>> pieces(count);
    for (std::size_t i = 0, piece = 0; i < tasks.size(); ++i) {
        const std::size_t left = tasks.size() - i;
        const double middle = until[i] - (until[i] - (i > 0 ? until[i - 1] : 0)) / 2;
        const double end = until.back() * static_cast<double>(piece + 1) / static_cast<double>(count);
        const bool full = !pieces[piece].empty() && middle > end;
        if (piece + 1 < count && (full || left < count - piece)) ++piece;
        pieces[piece].push_back(tasks[i].frame);
    }
    return pieces;
}

std::vector<std::vector<int>> piecesOfFrames(const std::vector<FrameTask>& tasks, std::size_t frames) {
    std::vector<std::vector<int>> pieces;
    for (std::size_t i = 0; i < tasks.size(); ++i) {
        if (i % frames == 0) pieces.emplace_back();
        pieces.back().push_back(tasks[i].frame);
    }
    return pieces;
}

std::string slurmArray(const FarmJob& job) {
    std::string text = "#!/bin/bash\n#SBATCH --job-name=" + shellWord(job.name) + "\n#SBATCH --array=1-" +
                       std::to_string(job.pieces.size()) + "\n#SBATCH --requeue\n#SBATCH --open-mode=append\n";
    if (job.threads > 0) text += "#SBATCH --cpus-per-task=" + std::to_string(job.threads) + '\n';
    if (job.memory > 0) text += "#SBATCH --mem=" + std::to_string(mebibytes(job.memory)) + "M\n";
    text += "frames=(";
    for (std::size_t i = 0; i < job.pieces.size(); ++i) text += (i > 0 ? " " : "") + printFrames(job.pieces[i]);
    return text + ")\n# exec: scancel and time limits signal this process\nexec " + shellWords(inFolder(job, job.run)) +
           " --frames \"${frames[SLURM_ARRAY_TASK_ID - 1]}\" --skip-existing\n";
}

std::string slurmReport(const FarmJob& job) {
    return "#!/bin/bash\n#SBATCH --job-name=" + shellWord(job.name + "-report") + "\n#SBATCH --requeue\nexec " +
           shellWords(inFolder(job, job.report)) + '\n';
}

std::string openJobTemplate(const FarmJob& job) {
    std::string range = printFrames(allFrames(job));
    std::replace(range.begin(), range.end(), 'x', ':');
    const std::vector<std::string> check{job.run.front(), "--version"};
    std::string text =
        "specificationVersion: jobtemplate-2023-09\nextensions: [TASK_CHUNKING]\nname: " +
        literal(job.name.substr(0, kOpenJobName)) +
        "\nparameterDefinitions:\n- {name: Frames, type: STRING, default: " + inQuotes(range) +
        ", description: \"Which frames; steps as in 1-10:2.\"}\n"
        "- {name: FramesPerTask, type: INT, minValue: 1, default: " +
        std::to_string(largestPiece(job)) +
        "}\njobEnvironments:\n# Where the program does not start, no frame is tried.\n- name: betamesh\n  script:\n"
        "    actions:\n" +
        action("onEnter", check, "", "      ") +
        "steps:\n- name: Mesh\n  parameterSpace:\n    taskParameterDefinitions:\n"
        "    - name: Frame\n      type: CHUNK[INT]\n      range: \"{{Param.Frames}}\"\n      chunks: "
        "{defaultTaskCount: "
        "\"{{Param.FramesPerTask}}\", targetRuntimeSeconds: " +
        std::to_string(std::lround(std::ceil(job.task_seconds))) + ", rangeConstraint: CONTIGUOUS}\n";
    if (job.threads > 0 || job.memory > 0) {
        text += "  hostRequirements:\n    amounts:\n";
        if (job.threads > 0) text += "    - {name: amount.worker.vcpu, min: " + std::to_string(job.threads) + "}\n";
        if (job.memory > 0)
            text += "    - {name: amount.worker.memory, min: " + std::to_string(mebibytes(job.memory)) + "}\n";
    }
    text += "  script:\n    actions:\n" +
            action("onRun", inFolder(job, job.run, {"--skip-existing", "--progress", "openjd", "--frames"}),
                   "\"{{Task.Param.Frame}}\"", "      ");
    if (!job.report.empty())
        text += "- name: Report\n  dependencies: [{dependsOn: Mesh}]\n  script:\n    actions:\n" +
                action("onRun", inFolder(job, job.report), "", "      ");
    return text;
}

std::string openCueCommand(const FarmJob& job) {
    return shellWords(inFolder(job, job.run, {"--skip-existing"})) + " --frames #FRAMESPEC#\n";
}

std::string deadlineCommand(const FarmJob& job) {
    const std::vector<std::string> words = inFolder(job, job.run, {"--skip-existing"});
    std::string arguments;
    for (std::size_t i = 1; i < words.size(); ++i)
        arguments += (shellWord(words[i]) == words[i] ? words[i] : "<QUOTE>" + words[i] + "<QUOTE>") + ' ';
    arguments += "--frames <STARTFRAME>-<ENDFRAME>";
    return shellWords({"deadlinecommand", "-SubmitCommandLineJob", "-executable", words.front(), "-arguments",
                       arguments, "-frames", printFrames(allFrames(job)), "-chunksize",
                       std::to_string(largestPiece(job)), "-name", job.name}) +
           '\n';
}

std::string tractorJob(const FarmJob& job) {
    // Words in braces are taken as they are, as long as braces in them pair.
    const auto braced = [](const std::string& word) {
        if (word.find_first_of("{}\\") != std::string::npos)
            throw Error("'" + word + "': a word with a brace or backslash; expected none in a Tractor job");
        return '{' + word + '}';
    };
    const auto command = [&](const std::vector<std::string>& words) {
        std::string text = "RemoteCmd {";
        for (const std::string& word : words) text += (text.back() == '{' ? "" : " ") + braced(word);
        return text + "} -service {betamesh}";
    };
    std::string text = "Job -title " + braced(job.name) + " -serialsubtasks 1 -subtasks {\n  Task {Mesh} -subtasks {\n";
    for (const auto& piece : job.pieces) {
        const std::string frames = printFrames(piece);
        text += "    Task " + braced("frames " + frames) + " -cmds {" +
                command(inFolder(job, job.run, {"--skip-existing", "--progress", "tractor", "--frames", frames})) +
                "}\n";
    }
    text += "  }\n";
    if (!job.report.empty()) text += "  Task {Report} -cmds {" + command(inFolder(job, job.report)) + "}\n";
    return text + "}\n";
}

std::size_t slurmMostTasks() {
    const std::string settings = outputOf("scontrol show config 2>/dev/null").out;
    const std::size_t at = settings.find("MaxArraySize");
    const std::size_t number = at == std::string::npos ? at : settings.find_first_of("0123456789", at);
    const std::size_t size =
        number == std::string::npos ? kUsualMaxArraySize : std::strtoul(settings.c_str() + number, nullptr, 10);
    return std::max<std::size_t>(2, size) - 1;  // the largest index is one less, and the first is 1
}

Submitted submitToSlurm(const FarmJob& job, const std::vector<std::string>& further) {
    Submitted submitted;
    std::tie(submitted.array_job, submitted.ok) = sbatch(slurmArray(job), further);
    if (job.report.empty()) return submitted;
    // Also after tasks that failed: the report is where one looks then.
    const auto [report, ok] = sbatch(slurmReport(job), {"--dependency=afterany:" + submitted.array_job});
    submitted.report_job = report;
    submitted.ok = submitted.ok && ok;
    return submitted;
}

}  // namespace betamesh
