// Open Job Description templates, and job bundles of AWS Deadline Cloud, which contain one.

#include "batch/farm/command_words.h"
#include "batch/farm/farm.h"
#include "batch/job/frames.h"
#include "batch/report/printable.h"
#include "betamesh/error.h"

#include <algorithm>
#include <cmath>

namespace betamesh {
namespace {

constexpr int kNotifySeconds = 30;                  // between SIGTERM and SIGKILL, enough to finish writing a frame
constexpr std::size_t kMaxOpenJobNameLength = 128;  // characters, from the specification
constexpr std::size_t kMaxParameterLength = 1024;   // characters, from the specification

/// Text in double quotes, for YAML. in: no control characters of ASCII.
std::string doubleQuoted(const std::string& text) {
    std::string out = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') out += '\\';
        out += c;
    }
    return printableJson(out + '"');  // YAML takes U+2028 and U+2029 for line breaks
}

/// Whether a text in UTF-8 contains one of the control characters U+0080 to U+009F.
bool hasSecondaryControl(const std::string& text) {
    for (std::size_t at = text.find('\xc2'); at != std::string::npos; at = text.find('\xc2', at + 1))
        if (static_cast<unsigned char>(text[at + 1]) < 0xa0) return true;
    return false;
}

/// A word of an Open Job Description without references to be replaced.
std::string literal(const std::string& word) {
    requireNoControl(word, "an Open Job Description");
    if (!isUtf8(word))
        throw Error("'" + word + "' is not UTF-8, as an Open Job Description has to be. Use another name.");
    if (hasSecondaryControl(word))
        throw Error("'" + word +
                    "' contains a control character (U+0080 to U+009F), which an Open Job Description cannot express. "
                    "Use another name.");
    if (word.find("{{") != std::string::npos)
        throw Error("'" + word +
                    "' contains {{, which begins a reference in an Open Job Description. Use another name.");
    return doubleQuoted(word);
}

using Words = std::vector<std::string>;

/// Words of a command as YAML. Those that are the folder of the job become `folder`, which is YAML, too.
Words literals(const Words& words, const FarmJob& job, const std::string& folder) {
    Words quoted;
    for (const std::string& word : words) quoted.push_back(word == job.folder ? folder : literal(word));
    return quoted;
}

/// An action of a template. in: words as YAML.
std::string action(const std::string& name, const Words& words, const std::string& indent) {
    std::string text = indent + name + ":\n" + indent + "  command: " + words.front() + '\n' + indent + "  args: [";
    for (std::size_t i = 1; i < words.size(); ++i) text += (i > 1 ? ", " : "") + words[i];
    return text + "]\n" + indent +
           "  cancelation: {mode: NOTIFY_THEN_TERMINATE, notifyPeriodInSeconds: " + std::to_string(kNotifySeconds) +
           "}\n";
}

/// All frames as Open Job Description writes them.
/// errors  more characters than a parameter may have
std::string frameRange(const FarmJob& job) {
    std::string range = printFrames(allFrames(job));
    if (range.size() > kMaxParameterLength)
        throw Error("The frames " + shortened(range, 20) + " ... need " + std::to_string(range.size()) +
                    " characters, because there are many gaps between them, but a parameter of an Open Job Description "
                    "has at most " +
                    std::to_string(kMaxParameterLength) + ". Submit fewer frames at a time with --frames.");
    std::replace(range.begin(), range.end(), 'x', ':');
    return doubleQuoted(range);
}

std::string parameters(const FarmJob& job) {
    return "- {name: Frames, type: STRING, default: " + frameRange(job) +
           ", description: \"Frames to mesh; write steps as in 1-10:2.\"}\n"
           "- {name: FramesPerTask, type: INT, minValue: 1, default: " +
           std::to_string(largestChunk(job)) + "}\n";
}

std::string hostRequirements(const FarmJob& job) {
    if (job.threads == 0 && job.memory == 0) return "";
    std::string text = "  hostRequirements:\n    amounts:\n";
    if (job.threads > 0) text += "    - {name: amount.worker.vcpu, min: " + std::to_string(job.threads) + "}\n";
    if (job.memory > 0)
        text += "    - {name: amount.worker.memory, min: " + std::to_string(mebibytes(job.memory)) + "}\n";
    return text;
}

std::string meshStep(const FarmJob& job, const std::string& folder) {
    std::string chunks = "{defaultTaskCount: \"{{Param.FramesPerTask}}\", ";
    if (job.task_seconds > 0)  // allows the engine to change the number of frames per task
        chunks += "targetRuntimeSeconds: " + std::to_string(std::lround(std::ceil(job.task_seconds))) + ", ";
    Words words =
        literals(inFolder(job, job.run, {"--skip-existing", "--progress", "openjd", "--frames"}), job, folder);
    words.emplace_back("\"{{Task.Param.Frame}}\"");
    return "- name: Mesh\n  parameterSpace:\n    taskParameterDefinitions:\n"
           "    - name: Frame\n      type: CHUNK[INT]\n      range: \"{{Param.Frames}}\"\n      chunks: " +
           chunks + "rangeConstraint: CONTIGUOUS}\n" + hostRequirements(job) + "  script:\n    actions:\n" +
           action("onRun", words, "      ");
}

/// The report expects the frames of the parameter, whose steps it reads in the notation of this program.
std::string reportStep(const FarmJob& job, const std::string& folder) {
    constexpr const char* kScript =
        R"sh(cd "$0" && frames=$1 && shift && exec "$@" --frames "$(echo "$frames" | tr : x)")sh";
    Words words{doubleQuoted("sh"), doubleQuoted("-c"), doubleQuoted(kScript), folder, "\"{{Param.Frames}}\""};
    const Words report = literals(job.report, job, folder);
    words.insert(words.end(), report.begin(), report.end());
    return "- name: Report\n  dependencies: [{dependsOn: Mesh}]\n  script:\n    actions:\n" +
           action("onRun", words, "      ");
}

/// in      folder: that of the job, as YAML
///         folder_parameter: its definition if it is a parameter
std::string templateOf(const FarmJob& job, const std::string& folder, const std::string& folder_parameter) {
    return "specificationVersion: jobtemplate-2023-09\nextensions: [TASK_CHUNKING]\nname: " +
           literal(shortened(titleOf(job.name), kMaxOpenJobNameLength)) + "\nparameterDefinitions:\n" +
           parameters(job) + folder_parameter +
           "jobEnvironments:\n# If the program does not start here, no frame is tried.\n- name: betamesh\n  script:\n"
           "    actions:\n" +
           action("onEnter", literals({job.run.front(), "--version"}, job, folder), "      ") + "steps:\n" +
           meshStep(job, folder) + (job.report.empty() ? "" : reportStep(job, folder));
}

/// A list of YAML, one entry per line; [] if it is empty.
std::string yamlList(const Words& entries, const std::string& indent) {
    if (entries.empty()) return " []\n";
    std::string text = "\n";
    for (const std::string& entry : entries) text += indent + "- " + literal(entry) + '\n';
    return text;
}

}  // namespace

std::string openJobTemplate(const FarmJob& job) { return templateOf(job, literal(job.folder), ""); }

std::vector<FarmFile> deadlineCloudBundle(const FarmJob& job) {
    const std::string text = templateOf(job, "\"{{Param.Folder}}\"",
                                        "- {name: Folder, type: PATH, objectType: DIRECTORY, dataFlow: NONE, "
                                        "description: \"Folder from which paths in the pipeline file start.\"}\n");
    return {{"template.yaml", text},
            {"parameter_values.yaml", "parameterValues:\n- {name: Frames, value: " + frameRange(job) +
                                          "}\n- {name: FramesPerTask, value: " + std::to_string(largestChunk(job)) +
                                          "}\n- {name: Folder, value: " + literal(job.folder) + "}\n"},
            {"asset_references.yaml",
             "assetReferences:\n  inputs:\n    filenames:" + yamlList(job.input_files, "    ") +
                 "    directories: []\n  outputs:\n" + "    directories:" + yamlList(job.output_folders, "    ") +
                 "  referencedPaths: []\n"}};
}

}  // namespace betamesh
