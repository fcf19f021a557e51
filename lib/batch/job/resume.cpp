#include "batch/job/resume.h"

#include "batch/config/local_origin.h"
#include "batch/job/provenance.h"
#include "batch/report/report.h"
#include "betamesh/error.h"
#include "betamesh/version.h"
#include "io/extension.h"

#include <cstdint>
#include <filesystem>
#include <system_error>

namespace betamesh {
namespace {

namespace fs = std::filesystem;

bool exists(const std::string& path) {
    std::error_code ignored;
    return fs::exists(fs::symlink_status(path, ignored));
}

/// The first file on disk that the frame would replace and that is not left of an earlier run whose mesh was removed;
/// empty: none.
std::string existingFile(const FrameTask& task) {
    const std::string manifest = manifestPath(task.output), spheres = spheresPath(task.output);
    for (const std::string& file : {task.output, task.preview})
        if (!file.empty() && exists(file)) return file;
    if (exists(manifest) && !isListed(task.output, task.output)) return manifest;
    if (exists(spheres) && !isListed(spheres, task.output)) return spheres;
    return "";
}

/// Whether the preview can be rendered without making the mesh again: from the particles, or from the files of the
/// frame, if they hold all that it shows.
bool canRedraw(const FrameTask& task, bool input_exists, const Config& config) {
    if (config.preview.show != ShownGeometry::surface) return input_exists;
    return config.output.up_axis == UpAxis::y && canHold(task.output, FileKind::mesh, Access::read) &&
           lossesOf(task.output, FileKind::mesh, {true, true, false}).empty();
}

/// Whether a file that a manifest lists has its size.
bool isIntact(const fs::path& folder, const std::string& name, std::uint64_t bytes) {
    std::error_code error;
    return fs::file_size(folder / name, error) == bytes && !error;
}

/// Why the preview of a frame whose mesh is up to date is not; empty: it is, or there is to be none.
std::string whyRedraw(const FrameTask& task, const Provenance& provenance, const Plan& plan) {
    if (task.preview.empty()) return "";
    const std::string name = listedName(task.preview, task.output);
    const auto listed = provenance.files.find(name);
    if (listed == provenance.files.end() || !isIntact(fs::path(task.output).parent_path(), name, listed->second))
        return name + " is missing or was changed";
    return provenance.preview_hash == plan.preview_hash ? "" : "other settings of previews";
}

}  // namespace

bool isListed(const std::string& file, const std::string& output) {
    const auto manifest = readManifest(manifestPath(output));
    return manifest && manifest->provenance && manifest->provenance->files.contains(fs::path(file).filename().string());
}

Staleness stalenessOf(const FrameTask& task, bool input_exists, const Plan& plan) {
    const auto manifest = readManifest(manifestPath(task.output));
    if (!manifest || !manifest->provenance) return {"no manifest"};
    const Provenance& provenance = *manifest->provenance;
    if (provenance.version != version()) return {"made by version " + provenance.version};
    if (provenance.config_hash != plan.config_hash) return {"other configuration"};
    const bool resolved = plan.skin.radius > 0;  // false if no input is left
    if (resolved && (provenance.radius != plan.skin.radius || provenance.spacing != plan.spacing))
        return {"other radius"};
    if (provenance.local_origin != worldOrigin(plan.config.input, plan.config.output.up_axis))
        return {"other local origin"};
    const fs::path folder = fs::path(task.output).parent_path();
    for (const auto& [name, bytes] : provenance.files) {
        const bool is_of_mesh = name == fs::path(task.output).filename().string() ||
                                name == fs::path(spheresPath(task.output)).filename().string();
        if (is_of_mesh && !isIntact(folder, name, bytes)) return {name + " is missing or was changed"};
    }
    if (plan.config.input.is_one_file && manifest->frame != task.frame) return {"other frame"};
    if (input_exists && !(provenance.input && isSame(task.input, *provenance.input))) return {"other input"};
    const std::string why = whyRedraw(task, provenance, plan);
    return {why, !why.empty()};
}

void chooseAction(FrameTask& task, bool input_exists, const Plan& plan, const PlanOptions& options) {
    const auto lost = options.history.lost.find(task.frame);
    if (lost != options.history.lost.end()) {
        task.action = FrameAction::fail_lost;
        task.why = lost->second;
        return;
    }
    const Config& config = plan.config;
    const bool output_exists = exists(task.output);
    if (output_exists && options.skip_existing) {
        const Staleness stale = stalenessOf(task, input_exists, plan);
        task.why = stale.why;
        const bool redraw = stale.only_preview && canRedraw(task, input_exists, config);
        task.action = redraw ? FrameAction::draw : FrameAction::skip_existing;
        if (stale.why.empty() || redraw) return;
    }
    const bool may_replace = options.skip_existing || options.overwrite || options.history.begun.contains(task.frame);
    if (!input_exists && config.run.on_missing == OnMissing::skip)
        task.action = FrameAction::skip_missing;
    else if (!input_exists && config.run.on_missing == OnMissing::error)
        task.action = FrameAction::fail_missing;
    else if (!may_replace && !existingFile(task).empty())
        task.action = FrameAction::refuse_existing;
    else
        task.action = input_exists ? FrameAction::mesh : FrameAction::write_empty;
}

void refuseExisting(std::span<const Plan> outputs) {
    std::size_t count = 0;
    const FrameTask* first = nullptr;
    for (const Plan& plan : outputs) {
        for (const FrameTask& task : plan.tasks) {
            if (task.action != FrameAction::refuse_existing) continue;
            if (count++ == 0) first = &task;
        }
    }
    if (first == nullptr) return;
    throw Error(existingFile(*first) +
                (count > 1
                     ? " and " + std::to_string(count - 1) + " more outputs already exist. Use --overwrite to replace "
                     : " already exists. Use --overwrite to replace ") +
                (count > 1 ? "them" : "it") + " or --skip-existing to resume.");
}

}  // namespace betamesh
