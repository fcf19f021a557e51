
#include "batch/farm/farm.h"

#include "base/nearest_word.h"
#include "batch/farm/command_words.h"
#include "batch/job/frames.h"
#include "betamesh/error.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <utility>

namespace betamesh {
namespace {

constexpr double kBytesPerSecond = 140e6;  // estimated memory of a frame that one thread processes in a second
constexpr double kSecondsPerFrame = 0.05;  // overhead of a frame of any size

constexpr std::array<std::pair<std::string_view, Farm>, 6> kFarms{{{"slurm", Farm::slurm},
                                                                   {"openjd", Farm::openjd},
                                                                   {"deadline-cloud", Farm::deadline_cloud},
                                                                   {"opencue", Farm::opencue},
                                                                   {"deadline", Farm::deadline},
                                                                   {"tractor", Farm::tractor}}};

bool hasNoInput(const FrameTask& task) {
    return task.action == FrameAction::fail_missing || task.action == FrameAction::skip_missing ||
           task.action == FrameAction::write_empty;
}

/// The estimated duration of a frame; `unknown` if its input does not exist yet.
double secondsOf(const FrameTask& task, int threads, double unknown) {
    if (hasNoInput(task)) return unknown;
    return static_cast<double>(task.memory) / (kBytesPerSecond * std::max(1, threads)) + kSecondsPerFrame;
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
    if (shellWords({word}) == word) return word;
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

std::vector<std::vector<int>> chunksOfEqualCost(const std::vector<FrameTask>& tasks, int threads, double seconds,
                                                std::size_t max_chunks) {
    std::vector<double> end_seconds;  // estimated time at which each frame ends if all run one after the other
    for (const FrameTask& task : tasks)
        end_seconds.push_back((end_seconds.empty() ? 0 : end_seconds.back()) + secondsOf(task, threads, seconds));
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

std::size_t withoutInput(const std::vector<FrameTask>& tasks) {
    return static_cast<std::size_t>(std::count_if(tasks.begin(), tasks.end(), hasNoInput));
}

double longestSeconds(const std::vector<FrameTask>& tasks, const std::vector<std::vector<int>>& chunks, int threads,
                      double seconds) {
    double longest = 0;
    auto task = tasks.begin();
    for (const auto& chunk : chunks) {
        double of_chunk = 0;
        for (std::size_t i = 0; i < chunk.size(); ++i) of_chunk += secondsOf(*task++, threads, seconds);
        longest = std::max(longest, of_chunk);
    }
    return longest;
}

std::vector<std::vector<int>> chunksOfSize(const std::vector<FrameTask>& tasks, std::size_t frames) {
    std::vector<std::vector<int>> chunks;
    for (std::size_t i = 0; i < tasks.size(); ++i) {
        if (i % frames == 0) chunks.emplace_back();
        chunks.back().push_back(tasks[i].frame);
    }
    return chunks;
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
    if (!job.report.empty()) text += "  Task {Report} -cmds {" + command(inFolder(job, reportWords(job))) + "}\n";
    return text + "}\n";
}

}  // namespace betamesh
