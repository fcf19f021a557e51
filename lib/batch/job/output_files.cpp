#include "batch/job/output_files.h"

#include "batch/job/distinct_files.h"
#include "batch/job/usd_sequence.h"
#include "batch/report/log.h"
#include "betamesh/error.h"
#include "io/output_file.h"

#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <set>
#include <system_error>
#include <vector>

namespace betamesh {
namespace {

namespace fs = std::filesystem;

std::string ofFrame(const char* what, int frame) { return std::string(what) + " of frame " + std::to_string(frame); }

/// Whether parts of the liquid may be spheres beside the mesh. If not, a job removes an old file of spheres.
bool mayHaveSpheres(const SkinParams& skin) {
    return skin.features.droplets == Droplets::points || skin.features.tendrils == Tendrils::points ||
           skin.tessellation == Tessellation::paper || skin.surface != SurfaceKind::beta;
}

}  // namespace

void requireDistinctFiles(std::span<const Plan> outputs, const std::map<int, std::string>& on_disk) {
    DistinctFiles files;
    for (const auto& [frame, file] : on_disk) files.read(file, ofFrame("the input", frame));
    for (std::size_t i = 0; i < outputs.size(); ++i) {
        const std::string which = outputs.size() > 1 ? " in output " + std::to_string(i + 1) : "";
        const FramePattern output = framePattern(outputs[i].config.output.path);
        if (const std::string layer = sequenceLayer(output); !layer.empty())
            files.written(layer, "the layer that plays the sequence" + which);
        requireOwnSequenceLayer(output);
        for (const FrameTask& task : outputs[i].tasks) {
            files.read(task.input, ofFrame("the input", task.frame));
            files.written(task.output, ofFrame("the mesh", task.frame) + which);
            files.written(manifestPath(task.output), ofFrame("the manifest", task.frame) + which);
            files.written(spheresPath(task.output),
                          ofFrame("the file of spheres", task.frame) + (mayHaveSpheres(outputs[i].skin) ? which : ""));
            if (!task.preview.empty()) files.written(task.preview, ofFrame("the preview", task.frame) + which);
        }
    }
}

void requireWritableFolders(std::span<const Plan> outputs) {
    std::set<std::string> folders;
    for (const Plan& plan : outputs)
        for (const FrameTask& task : plan.tasks)
            for (const std::string& file : {task.output, task.preview})
                if (isWritten(task.action) && !file.empty()) folders.insert(folderOf(file));
    requireWritableFolders(folders);
}

void requireWritableFolders(const std::set<std::string>& folders) {
    for (const std::string& folder : folders) {
        fs::path existing = fs::absolute(folder);
        std::error_code ignored;
        while (!fs::exists(existing, ignored) && existing.has_relative_path()) existing = existing.parent_path();
        const bool is_folder = fs::is_directory(existing, ignored);
        if (is_folder && ::access(existing.c_str(), W_OK | X_OK) == 0) continue;
        const int error_number = is_folder ? errno : ENOTDIR;
        throw Error("'" + folder +
                    "': no files can be written in this folder: " + std::generic_category().message(error_number) +
                    (existing == fs::absolute(folder) ? "" : " (" + existing.string() + ')') +
                    ". Choose another output path or change the permissions");
    }
}

void requireDistinctLog(const std::string& log_file, const std::string& pipeline, const Config& config) {
    const auto refuse = [](const std::string& name, const std::string& what) {
        throw Error(name + " is both the log file (--log-file) and " + what + ". Choose another log file");
    };
    std::vector<std::string> names{log_file};
    for (std::size_t i = 1; i <= kOldLogFiles; ++i) names.push_back(oldLogFile(log_file, i));
    const std::vector<Config> outputs = outputConfigs(config);
    for (const std::string& name : names) {
        std::error_code ignored;
        if (!pipeline.empty() && (name == pipeline || fs::equivalent(name, pipeline, ignored)))
            refuse(name, "the pipeline file");
        if (isFrameOf(inputPattern(config.input.path), name)) refuse(name, "an input");
        for (const auto& [frame, file] : framesOnDisk(inputPattern(config.input.path)))
            if (fs::equivalent(name, file, ignored)) refuse(name, "the input " + file);
        for (const Config& each : outputs) {
            const std::string& output = each.output.path;
            for (const std::string& file : {output, manifestPath(output), spheresPath(output), each.preview.path,
                                            sequenceLayer(framePattern(output))})
                if (!file.empty() && isFrameOf(framePattern(file), name)) refuse(name, "an output");
        }
    }
}

}  // namespace betamesh
