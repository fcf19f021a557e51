
#include "batch/farm/farm.h"

#include "base/nearest_word.h"
#include "batch/job/frames.h"
#include "batch/report/printable.h"
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
#include <utility>

namespace betamesh {
namespace {

constexpr double kBytesPerSecond = 140e6;           // estimated memory of a frame that one thread processes in a second
constexpr double kSecondsPerFrame = 0.05;           // overhead of a frame of any size
constexpr std::size_t kDefaultMaxArraySize = 1001;  // Slurm's default
constexpr int kNotifySeconds = 30;                  // between SIGTERM and SIGKILL, enough to finish writing a frame
constexpr std::size_t kMaxOpenJobNameLength = 128;  // characters, from the specification

constexpr std::array<std::pair<std::string_view, Farm>, 5> kFarms{{{"slurm", Farm::slurm},
                                                                   {"openjd", Farm::openjd},
                                                                   {"opencue", Farm::opencue},
                                                                   {"deadline", Farm::deadline},
                                                                   {"tractor", Farm::tractor}}};

std::string shellWord(const std::string& word) {
    const auto plain = [](unsigned char c) {
        return std::isalnum(c) != 0 ||
               std::string_view("_-./=:,+@%").find(static_cast<char>(c)) != std::string_view::npos;
    };
    if (!word.empty() && std::all_of(word.begin(), word.end(), plain)) return word;
    std::string in_quotes = "'";
    for (const char c : word) in_quotes += c == '\'' ? "'\\''" : std::string(1, c);
    return in_quotes + "'";
}

/// The command line, run in the folder of the job, because farms start tasks in folders of their own.
std::vector<std::string> inFolder(const FarmJob& job, const std::vector<std::string>& words,
                                  const std::vector<std::string>& more_words = {}) {
    std::vector<std::string> all{"env", "-C", job.folder};
    // env would take a program whose path contains = for a variable.
    if (words.front().find('=') != std::string::npos) all = {"sh", "-c", R"(cd "$0" && exec "$@")", job.folder};
    all.insert(all.end(), words.begin(), words.end());
    all.insert(all.end(), more_words.begin(), more_words.end());
    return all;
}

std::vector<int> allFrames(const FarmJob& job) {
    std::vector<int> frames;
    for (const auto& chunk : job.chunks) frames.insert(frames.end(), chunk.begin(), chunk.end());
    return frames;
}

std::size_t largestChunk(const FarmJob& job) {
    std::size_t largest = 1;
    for (const auto& chunk : job.chunks) largest = std::max(largest, chunk.size());
    return largest;
}

std::uint64_t mebibytes(std::uint64_t bytes) { return (bytes >> 20) + 1; }

/// Text in double quotes, for YAML and JSON.
std::string doubleQuoted(const std::string& text) {
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

bool isControl(char c) { return std::iscntrl(static_cast<unsigned char>(c)) != 0; }

/// A name for people: control characters become spaces.
std::string titleOf(std::string name) {
    std::replace_if(name.begin(), name.end(), isControl, ' ');
    return name;
}

/// errors  a word with a line break or another control character, which a form of submission cannot express
void requireNoControl(const std::string& word, const char* form) {
    if (std::none_of(word.begin(), word.end(), isControl)) return;
    throw Error("'" + word + "' contains a control character, such as a line break, which " + form +
                " cannot express. Use another name.");
}

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

/// A word of the arguments of Deadline's command line jobs: in quotes, with <QUOTE> for a quote, a backslash before a
/// quote that belongs to the word, and backslashes doubled where they precede a quote.
/// source  .NET, System.Diagnostics.Process: how arguments are divided; Deadline's manual, Command Line plug-in
std::string deadlineWord(const std::string& word) {
    requireNoControl(word, "Deadline");
    for (std::size_t at = word.find('<'); at != std::string::npos; at = word.find('<', at + 1))
        if (at + 1 < word.size() && std::isupper(static_cast<unsigned char>(word[at + 1])) != 0)
            throw Error("'" + word + "' contains " + word.substr(at, 2) +
                        ", with which tokens of Deadline such as <QUOTE> begin. Use another name.");
    if (shellWord(word) == word) return word;
    std::string out = "<QUOTE>";
    std::size_t backslashes = 0;  // directly before this character
    for (const char c : word) {
        if (c == '"') out += std::string(backslashes + 1, '\\') + "<QUOTE>";
        if (c != '"') out += c;
        backslashes = c == '\\' ? backslashes + 1 : 0;
    }
    return out + std::string(backslashes, '\\') + "<QUOTE>";
}

/// errors  a word that contains a token of OpenCue, such as #IFRAME#, which it would replace
const std::vector<std::string>& withoutTokens(const std::vector<std::string>& words) {
    for (const std::string& word : words) {
        for (std::size_t begin = word.find('#'); begin != std::string::npos; begin = word.find('#', begin + 1)) {
            const std::size_t end = word.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ_", begin + 1);
            if (end != std::string::npos && end > begin + 1 && word[end] == '#')
                throw Error("'" + word + "' contains " + word.substr(begin, end + 1 - begin) +
                            ", which OpenCue may replace. Use another name.");
        }
    }
    return words;
}

/// A name of at most `longest` bytes, cut between characters of UTF-8.
std::string shortened(const std::string& name, std::size_t longest) {
    std::size_t end = std::min(name.size(), longest);
    while (end > 0 && end < name.size() && (static_cast<unsigned char>(name[end]) & 0xc0U) == 0x80U) --end;
    return name.substr(0, end);
}

/// A word of an Open Job Description without references to be replaced.
std::string literal(const std::string& word) {
    requireNoControl(word, "an Open Job Description");
    if (!isUtf8(word))
        throw Error("'" + word + "' is not UTF-8, as an Open Job Description has to be. Use another name.");
    if (word.find("{{") != std::string::npos)
        throw Error("'" + word +
                    "' contains {{, which begins a reference in an Open Job Description. Use another name.");
    return doubleQuoted(word);
}

std::string action(const std::string& name, const std::vector<std::string>& words, const std::string& last_argument,
                   const std::string& indent) {
    std::string text =
        indent + name + ":\n" + indent + "  command: " + literal(words.front()) + '\n' + indent + "  args: [";
    for (std::size_t i = 1; i < words.size(); ++i) text += (i > 1 ? ", " : "") + literal(words[i]);
    text += last_argument.empty() ? "" : ", " + last_argument;
    return text + "]\n" + indent +
           "  cancelation: {mode: NOTIFY_THEN_TERMINATE, notifyPeriodInSeconds: " + std::to_string(kNotifySeconds) +
           "}\n";
}

std::string openJobParameters(const FarmJob& job) {
    std::string range = printFrames(allFrames(job));
    std::replace(range.begin(), range.end(), 'x', ':');  // steps as Open Job Description writes them
    return "parameterDefinitions:\n- {name: Frames, type: STRING, default: " + doubleQuoted(range) +
           ", description: \"Frames to mesh; write steps as in 1-10:2.\"}\n"
           "- {name: FramesPerTask, type: INT, minValue: 1, default: " +
           std::to_string(largestChunk(job)) + "}\n";
}

std::string openJobHostRequirements(const FarmJob& job) {
    if (job.threads == 0 && job.memory == 0) return "";
    std::string text = "  hostRequirements:\n    amounts:\n";
    if (job.threads > 0) text += "    - {name: amount.worker.vcpu, min: " + std::to_string(job.threads) + "}\n";
    if (job.memory > 0)
        text += "    - {name: amount.worker.memory, min: " + std::to_string(mebibytes(job.memory)) + "}\n";
    return text;
}

std::string openJobMeshStep(const FarmJob& job) {
    return "- name: Mesh\n  parameterSpace:\n    taskParameterDefinitions:\n"
           "    - name: Frame\n      type: CHUNK[INT]\n      range: \"{{Param.Frames}}\"\n      chunks: "
           "{defaultTaskCount: \"{{Param.FramesPerTask}}\", targetRuntimeSeconds: " +
           std::to_string(std::lround(std::ceil(job.task_seconds))) + ", rangeConstraint: CONTIGUOUS}\n" +
           openJobHostRequirements(job) + "  script:\n    actions:\n" +
           action("onRun", inFolder(job, job.run, {"--skip-existing", "--progress", "openjd", "--frames"}),
                  "\"{{Task.Param.Frame}}\"", "      ");
}

/// The line of a batch script with these options; empty if there are none.
std::string sbatchLine(const std::vector<std::string>& options) {
    if (options.empty()) return "";
    std::string line = "#SBATCH";
    for (const std::string& option : options) line += ' ' + sbatchWord(option);
    return line + '\n';
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
            throw Error(path_ + ": this temporary script for sbatch cannot be written. Check the space left in /tmp.");
        const bool whole = std::fwrite(text.data(), 1, text.size(), stream) == text.size();
        if (std::fclose(stream) != 0 || !whole)
            throw Error(path_ + ": this temporary script for sbatch cannot be written. Check the space left in /tmp.");
    }
    ~ScriptFile() { ::unlink(path_.c_str()); }
    ScriptFile(const ScriptFile&) = delete;
    ScriptFile& operator=(const ScriptFile&) = delete;
    const std::string& path() const { return path_; }

private:
    std::string path_ = "/tmp/betamesh-sbatch-XXXXXX";
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

Farm farmNamed(std::string_view name) {
    for (const auto& [farm_name, farm] : kFarms)
        if (farm_name == name) return farm;
    std::vector<std::string> names;
    for (const auto& entry : kFarms) names.emplace_back(entry.first);
    throw Error("'" + std::string(name) + "' is not a known farm engine. Use one of " + farmNames(", ") + '.' +
                didYouMean(name, names));
}

std::string farmNames(std::string_view separator) {
    std::string names;
    for (const auto& entry : kFarms) {
        if (!names.empty()) names += separator;
        names += entry.first;
    }
    return names;
}

std::string shellWords(const std::vector<std::string>& words) {
    std::string text;
    for (const std::string& word : words) text += (text.empty() ? "" : " ") + shellWord(word);
    return text;
}

std::vector<std::vector<int>> chunksOfEqualCost(const std::vector<FrameTask>& tasks, int threads, double seconds,
                                                std::size_t max_chunks) {
    std::vector<double> end_seconds;  // estimated time at which each frame ends if all run one after the other
    for (const FrameTask& task : tasks) {
        const double cost = static_cast<double>(task.memory) / (kBytesPerSecond * std::max(1, threads));
        end_seconds.push_back((end_seconds.empty() ? 0 : end_seconds.back()) + cost + kSecondsPerFrame);
    }
    const double wanted = std::ceil(end_seconds.back() / seconds);
    const std::size_t count =
        static_cast<std::size_t>(std::clamp(wanted, 1.0, static_cast<double>(std::min(max_chunks, tasks.size()))));
    std::vector<std::vector<int>> chunks(count);
    for (std::size_t i = 0, chunk = 0; i < tasks.size(); ++i) {
        const std::size_t frames_left = tasks.size() - i;
        const double middle = end_seconds[i] - (end_seconds[i] - (i > 0 ? end_seconds[i - 1] : 0)) / 2;
        const double chunk_end = end_seconds.back() * static_cast<double>(chunk + 1) / static_cast<double>(count);
        const bool full = !chunks[chunk].empty() && middle > chunk_end;
        if (chunk + 1 < count && (full || frames_left < count - chunk)) ++chunk;
        chunks[chunk].push_back(tasks[i].frame);
    }
    return chunks;
}

std::vector<std::vector<int>> chunksOfSize(const std::vector<FrameTask>& tasks, std::size_t frames) {
    std::vector<std::vector<int>> chunks;
    for (std::size_t i = 0; i < tasks.size(); ++i) {
        if (i % frames == 0) chunks.emplace_back();
        chunks.back().push_back(tasks[i].frame);
    }
    return chunks;
}

std::string slurmArray(const FarmJob& job) {
    std::string text = "#!/bin/bash\n#SBATCH --job-name=" + sbatchWord(titleOf(job.name)) + "\n#SBATCH --array=1-" +
                       std::to_string(job.chunks.size()) + "\n#SBATCH --requeue\n#SBATCH --open-mode=append\n";
    if (job.threads > 0) text += "#SBATCH --cpus-per-task=" + std::to_string(job.threads) + '\n';
    if (job.memory > 0) text += "#SBATCH --mem=" + std::to_string(mebibytes(job.memory)) + "M\n";
    text += sbatchLine(job.sbatch_options) + "frames=(";
    for (std::size_t i = 0; i < job.chunks.size(); ++i) text += (i > 0 ? " " : "") + printFrames(job.chunks[i]);
    return text + ")\n# exec, so that scancel and time limits signal betamesh itself\nexec " +
           shellWords(inFolder(job, job.run)) + " --frames \"${frames[SLURM_ARRAY_TASK_ID - 1]}\" --skip-existing\n";
}

std::string slurmReport(const FarmJob& job) {
    return "#!/bin/bash\n#SBATCH --job-name=" + sbatchWord(titleOf(job.name) + "-report") + "\n#SBATCH --requeue\n" +
           sbatchLine(optionsForReport(job)) + "exec " + shellWords(inFolder(job, job.report)) + '\n';
}

std::string openJobTemplate(const FarmJob& job) {
    std::string text =
        "specificationVersion: jobtemplate-2023-09\nextensions: [TASK_CHUNKING]\nname: " +
        literal(shortened(titleOf(job.name), kMaxOpenJobNameLength)) + '\n' + openJobParameters(job) +
        "jobEnvironments:\n# If the program does not start here, no frame is tried.\n- name: betamesh\n  script:\n"
        "    actions:\n" +
        action("onEnter", {job.run.front(), "--version"}, "", "      ") + "steps:\n" + openJobMeshStep(job);
    if (!job.report.empty())
        text += "- name: Report\n  dependencies: [{dependsOn: Mesh}]\n  script:\n    actions:\n" +
                action("onRun", inFolder(job, job.report), "", "      ");
    return text;
}

std::string openCueCommand(const FarmJob& job) {
    return shellWords(withoutTokens(inFolder(job, job.run, {"--skip-existing"}))) + " --frames #FRAMESPEC#\n";
}

std::string deadlineCommand(const FarmJob& job) {
    const std::vector<std::string> words = inFolder(job, job.run, {"--skip-existing"});
    std::string arguments;
    for (std::size_t i = 1; i < words.size(); ++i) arguments += deadlineWord(words[i]) + ' ';
    arguments += "--frames <STARTFRAME>-<ENDFRAME>";
    return shellWords({"deadlinecommand", "-SubmitCommandLineJob", "-executable", words.front(), "-arguments",
                       arguments, "-frames", printFrames(allFrames(job)), "-chunksize",
                       std::to_string(largestChunk(job)), "-name", titleOf(job.name)}) +
           '\n';
}

std::string tractorJob(const FarmJob& job) {
    // Tcl takes a word in braces literally, but a brace or backslash inside could end it early.
    const auto braced = [](const std::string& word) {
        if (word.find_first_of("{}\\") != std::string::npos)
            throw Error("'" + word +
                        "' contains a brace or backslash, which a Tractor job cannot express. Use another name.");
        return '{' + word + '}';
    };
    const auto command = [&](const std::vector<std::string>& words) {
        std::string text = "RemoteCmd {";
        for (const std::string& word : words) text += (text.back() == '{' ? "" : " ") + braced(word);
        return text + "} -service {betamesh}";
    };
    std::string text =
        "Job -title " + braced(titleOf(job.name)) + " -serialsubtasks 1 -subtasks {\n  Task {Mesh} -subtasks {\n";
    for (const auto& chunk : job.chunks) {
        const std::string frames = printFrames(chunk);
        text += "    Task " + braced("frames " + frames) + " -cmds {" +
                command(inFolder(job, job.run, {"--skip-existing", "--progress", "tractor", "--frames", frames})) +
                "}\n";
    }
    text += "  }\n";
    if (!job.report.empty()) text += "  Task {Report} -cmds {" + command(inFolder(job, job.report)) + "}\n";
    return text + "}\n";
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
