
#include "batch/job/plan.h"

#include "base/parallel.h"
#include "batch/config/key_types.h"
#include "batch/config/origin.h"
#include "batch/config/radius.h"
#include "batch/job/distinct_files.h"
#include "batch/job/plane.h"
#include "batch/job/provenance.h"
#include "batch/job/usd_sequence.h"
#include "batch/platform/machine.h"
#include "batch/platform/memory.h"
#include "batch/report/log.h"
#include "batch/report/report.h"
#include "betamesh/error.h"
#include "betamesh/version.h"
#include "io/extension.h"
#include "io/mesh_file.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <system_error>
#include <utility>

namespace betamesh {
namespace {

namespace fs = std::filesystem;

bool exists(const std::string& path) {
    std::error_code ignored;
    return fs::exists(fs::symlink_status(path, ignored));
}

/// Warns of gaps in the frames on disk, which may come from a simulation that failed, unless the step is constant.
void noteGaps(const Config& config, const std::vector<int>& frames, std::vector<std::string>& warnings) {
    if (config.frames != "all" || frames.size() < 3) return;
    std::int64_t step = std::int64_t{frames[1]} - frames[0];
    for (std::size_t i = 2; i < frames.size(); ++i) step = std::min(step, std::int64_t{frames[i]} - frames[i - 1]);
    for (std::size_t i = 1; i < frames.size(); ++i) {
        if (std::int64_t{frames[i]} - frames[i - 1] != step) {
            warnings.push_back("'" + config.input.path + "': the frames on disk have gaps (" + printFrames(frames) +
                               "). Use --frames to choose what happens to missing frames (run.on_missing)");
            return;
        }
    }
}

/// Warns of files that look like frames but are not meshed.
///
/// errors  sub-frames among all frames on disk
void noteOtherNumbers(const Config& config, const FramePattern& input, std::vector<std::string>& warnings) {
    if (config.frames != "all") return;
    const OtherNumbers others = otherNumbersOnDisk(input);
    if (!others.subframes.empty())
        throw Error("'" + input.text +
                    "': beside the frames there are sub-frames, which are not meshed in a sequence: " +
                    firstNames(others.subframes) +
                    ". Choose whole frames with --frames, and mesh sub-frames one by one with --spacing");
    if (!others.padded.empty())
        warnings.push_back("'" + input.text +
                           "': not meshed because their numbers are padded otherwise: " + firstNames(others.padded));
}

/// Why an existing output has to be made again; empty if it is up to date.
std::string whyAgain(const FrameTask& task, bool input_exists, const Plan& plan) {
    const auto report = readReport(reportPath(task.output));
    if (!report || !report->origin) return "no manifest";
    const Provenance* origin = &*report->origin;
    if (origin->version != version()) return "made by version " + origin->version;
    if (origin->configuration != plan.configuration) return "other configuration";
    const bool resolved = plan.skin.radius > 0;  // false if no input is left
    if (resolved && (origin->radius != plan.skin.radius || origin->spacing != plan.spacing)) return "other radius";
    if (origin->local_origin != worldOrigin(plan.config.input, plan.config.output.up_axis)) return "other local origin";
    for (const auto& [name, bytes] : origin->files) {
        std::error_code error;
        if (fs::file_size(fs::path(task.output).parent_path() / name, error) != bytes || error)
            return name + " is missing or was changed";
    }
    if (input_exists && !(origin->input && isSame(task.input, *origin->input))) return "other input";
    return "";
}

FrameAction actionFor(const FrameTask& task, bool input_exists, const Config& config, const PlanOptions& options) {
    const bool output_exists = exists(task.output);
    if (output_exists && options.skip_existing && task.why.empty()) return FrameAction::skip_existing;
    const bool any_exists = output_exists || (!task.picture.empty() && exists(task.picture));
    if (!input_exists && config.run.on_missing == OnMissing::skip) return FrameAction::skip_missing;
    if (!input_exists && config.run.on_missing == OnMissing::error) return FrameAction::fail_missing;
    const bool may_replace = options.skip_existing || options.overwrite || options.history.begun.contains(task.frame);
    if (any_exists && !may_replace) return FrameAction::refuse_existing;
    return input_exists ? FrameAction::mesh : FrameAction::write_empty;
}

void refuseExisting(const std::vector<FrameTask>& tasks) {
    const auto refused = [](const FrameTask& task) { return task.action == FrameAction::refuse_existing; };
    const auto count = std::count_if(tasks.begin(), tasks.end(), refused);
    if (count == 0) return;
    throw Error(std::find_if(tasks.begin(), tasks.end(), refused)->output +
                (count > 1
                     ? " and " + std::to_string(count - 1) + " more outputs already exist. Use --overwrite to replace "
                     : " already exists. Use --overwrite to replace ") +
                (count > 1 ? "them" : "it") + " or --skip-existing to resume.");
}

/// The paper's smoothing needs its tessellation.
void agreeOnTessellation(Plan& plan) {
    if (plan.config.smoothing.method != SmoothingMethod::paper || plan.config.surface.kind != SurfaceKind::beta ||
        plan.config.surface.tessellation == Tessellation::paper)
        return;
    plan.config.surface.tessellation = Tessellation::paper;
    plan.warnings.push_back(
        "smoothing.method paper needs surface.tessellation paper, which is used instead of the given one");
}

void agreeOnBubbles(Plan& plan) {
    const Config::Surface& surface = plan.config.surface;
    std::optional<Bubbles>& bubbles = plan.config.features.bubbles;
    const bool can_fill = surface.kind == SurfaceKind::beta && surface.tessellation == Tessellation::complete;
    if (bubbles == Bubbles::fill && !can_fill)
        plan.warnings.push_back("features.bubbles fill needs surface.tessellation complete: bubbles are not filled");
    bubbles = can_fill ? bubbles.value_or(Bubbles::fill) : Bubbles::mesh;
}

double worldLength(const Length& length, double spacing) { return length.value * (length.in_spacings ? spacing : 1); }

/// surface.skin, or the deprecated surface.inset; nullopt for auto.
const std::optional<Length>& skinText(const Config::Surface& surface) {
    return surface.inset ? surface.inset : surface.skin;
}

/// The parameters with these lengths, in world units.
SkinParams withLengths(SkinParams params, const Config::Surface& surface, double radius, double spacing) {
    params.radius = radius;
    params.spacing = spacing;
    const std::optional<Length>& given = skinText(surface);
    if (!given) return params;
    const std::string key = surface.inset ? "surface.inset" : "surface.skin";
    const double length = worldLength(*given, spacing);
    if (length > 0 && length >= radius) {
        const bool same_unit = given->in_spacings == surface.radius.in_spacings;
        throw Error(key + " is " + textOf(*given) + ", but must be less than surface.radius, which is " +
                    textOf(surface.radius) +
                    (same_unit ? "" : " (" + shortNumber(length) + " and " + shortNumber(radius) + " in world units)"));
    }
    params.skin = surface.inset && length > 0 ? radius - length : length;
    try {
        requireSkin(params);
    } catch (const Error& error) {
        throw Error(key + " is " + textOf(*given) + ": " + error.what());
    }
    return params;
}

/// The skin that replaces an inset, for a warning.
std::string skinForInset(const Length& inset, const Length& radius) {
    if (inset.value == 0) return "none";
    std::string rule = "the radius less the inset";
    if (inset.in_spacings != radius.in_spacings) return rule;
    return rule + ", " + shortNumber(radius.value - inset.value) + (radius.in_spacings ? "dx" : "");
}

/// Checks the skin as far as possible before the spacing is measured.
void agreeOnSkin(Plan& plan) {
    const Config::Surface& surface = plan.config.surface;
    if (surface.inset && surface.skin)
        throw Error("surface.skin and surface.inset are both set. Use surface.skin alone; surface.inset is deprecated");
    if (surface.inset)
        plan.warnings.push_back("surface.inset (--inset) is deprecated. Use surface.skin (--skin) instead: " +
                                skinForInset(*surface.inset, surface.radius));
    const std::optional<Length>& length = skinText(surface);
    if (!length) return;
    if (const auto given = givenRadius(plan.config)) {
        withLengths(plan.skin, surface, given->radius, given->spacing);
    } else {
        const double large_enough = 2 * length->value;  // stands for a radius that is given in the other unit
        withLengths(plan.skin, surface, length->in_spacings ? surface.radius.value : large_enough, 1);
    }
}

/// Warns of what the format of the output cannot hold, and that .bgeo is not the format that it was.
void noteOutputFormat(Plan& plan) {
    const Config::Output& output = plan.config.output;
    const FileKind kind = plan.config.surface.dimension == 2 ? FileKind::curves : FileKind::mesh;
    const std::string lost = lossesOf(output.path, kind, {true, !output.attributes.empty(), output.components});
    const std::string extension = splitExtension(output.path).second;
    if (!lost.empty())
        plan.warnings.push_back(extension + " files are written without " + lost +
                                ", which they cannot hold. Use .bgeo, .ply or .vtp to keep what is missing");
    if (extension == ".bgeo" || extension == ".bgeo.gz")
        plan.warnings.push_back(extension +
                                " is written as Houdini 12 and later read it. For programs that read only the format "
                                "of Houdini 11 and earlier, write .bhclassic");
}

SkinParams skinParams(const Config& config) {
    SkinParams params;
    params.surface = config.surface.kind;
    params.tessellation = config.surface.tessellation;
    params.predicates = config.surface.predicates;
    params.retries = config.perturbation.retries;
    params.tolerance = config.perturbation.tolerance;
    params.arc_subdivisions = config.surface.arc_subdivisions;
    params.smoothing = config.smoothing.method;
    params.passes = config.smoothing.passes;
    params.resolve_intersections = config.surface.resolve_intersections;
    params.attributes = config.output.attributes;
    params.features.droplets = config.features.droplets;
    params.features.droplet_particles = config.features.droplet_particles;
    params.features.tendrils = config.features.tendrils;
    params.features.bubbles = config.features.bubbles.value_or(Bubbles::mesh);
    params.components = config.output.components;
    return params;
}

/// errors  a length above 0, in world units, that 32-bit floats cannot store
void requireFloatLength(const std::string& key, double length) {
    if (length == 0 || isFloatAboveZero(length)) return;
    throw Error(key + " is " + shortNumber(length) +
                " in world units, but files store 32-bit floats, which range from 1.2e-38 to 3.4e38. Choose another "
                "unit of length");
}

void planOrigin(Plan& plan, const std::map<int, std::string>& on_disk, const PlanOptions& options) {
    ParticleInput& input = plan.config.input;
    input.origin = resolveOrigin(plan.config, on_disk, options.notes);
    const Vec3 origin = worldOrigin(input, plan.config.output.up_axis);
    if (origin == Vec3(0, 0, 0)) return;
    const std::string text = textOf(origin.x) + ',' + textOf(origin.y) + ',' + textOf(origin.z);
    if (plan.config.input.given_origin)
        plan.notes.push_back("local origin " + text);
    else
        plan.warnings.push_back("'" + plan.config.input.path +
                                "': single precision loses these coordinates. Meshes are written relative to the local "
                                "origin " +
                                text + ", which has to be added to their positions (input.origin)");
}

void planRadius(Plan& plan, const std::map<int, std::string>& on_disk, const PlanOptions& options) {
    const auto resolved = resolveRadius(plan.config, on_disk, options.notes);
    if (!resolved) return;
    plan.spacing = resolved->spacing;
    plan.skin = withLengths(plan.skin, plan.config.surface, resolved->radius, resolved->spacing);
    requireScale(plan.skin);
    plan.skin.smoothing_width = worldLength(plan.config.smoothing.width, resolved->spacing);
    const Config::Features& features = plan.config.features;
    if (features.bubble_volume > 0)
        plan.skin.features.bubble_volume =
            features.bubble_volume * std::pow(resolved->spacing, plan.config.surface.dimension);
    else
        plan.skin.features.bubble_gap = worldLength(features.bubble_gap, resolved->spacing);
    requireFloatLength("surface.spacing", resolved->spacing);
    requireFloatLength("surface.radius", resolved->radius);
    requireFloatLength("surface.skin", plan.skin.skin.value_or(0));
    requireFloatLength("smoothing.width", plan.skin.smoothing_width);
    requireFloatLength("features.bubble_gap", plan.skin.features.bubble_gap);
    const double skin = skinDepth(plan.skin, plan.config.surface.dimension);
    plan.notes.push_back("radius " + shortNumber(resolved->radius) +
                         (skin > 0 ? ", skin " + shortNumber(skin) : std::string()) + ", spacing " +
                         shortNumber(resolved->spacing) + " (" + resolved->origin + ')');
    if (!givenRadius(plan.config))
        plan.notes.push_back("to mesh files of this sequence one by one with the same spacing, use --spacing " +
                             textOf(resolved->spacing));
    plan.warnings.insert(plan.warnings.end(), resolved->warnings.begin(), resolved->warnings.end());
}

/// The camera is derived from all frames on disk, so that it does not depend on which of them are meshed by this job.
void planPictures(Plan& plan, const std::map<int, std::string>& on_disk, const PlanOptions& options) {
    const Config::Preview& preview = plan.config.preview;
    if (preview.path.empty()) return;
    const double small = preview.particle_radius.value * (preview.particle_radius.in_spacings ? plan.spacing : 1);
    Extent extent(plan.config.preview);
    if (needsExtent(plan.config))
        extent =
            sequenceExtent(on_disk, plan.config, plan.skin.radius, options.notes, options.history.last_loss.empty());
    plan.preview =
        planRendering(plan.config, extent, preview.show == ShownGeometry::particles ? small : plan.skin.radius);
    plan.preview->settings.layers = isExr(preview.path);
    plan.notes.push_back("camera " + describe(*plan.preview));
}

std::string ofFrame(const char* what, int frame) { return std::string(what) + " of frame " + std::to_string(frame); }

/// errors  a file that would be both read and written, or written twice
void requireDistinctFiles(const std::vector<FrameTask>& tasks, const std::map<int, std::string>& on_disk,
                          const std::string& layer) {
    DistinctFiles files;
    if (!layer.empty()) files.written(layer, "the layer that plays the sequence");
    for (const auto& [frame, file] : on_disk) files.read(file, ofFrame("the input", frame));
    for (const FrameTask& task : tasks) {
        files.read(task.input, ofFrame("the input", task.frame));
        files.written(task.output, ofFrame("the output", task.frame));
        files.written(reportPath(task.output), ofFrame("the manifest", task.frame));
        files.written(spheresPath(task.output), ofFrame("the file of spheres", task.frame));
        if (!task.picture.empty()) files.written(task.picture, ofFrame("the picture", task.frame));
    }
}

/// Whether files of the frame may be written, or may have been written by a worker that was lost.
bool mayWrite(const FrameTask& task) {
    return task.action == FrameAction::mesh || task.action == FrameAction::write_empty;
}

/// errors  an output folder, or the folder in which it has to be created, that cannot be written to
void requireWritableFolders(const std::vector<FrameTask>& tasks) {
    std::set<std::string> folders;
    for (const FrameTask& task : tasks)
        for (const std::string& file : {task.output, task.picture})
            if (mayWrite(task) && !file.empty()) folders.insert(folderOf(file));
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

/// Whether the format of an output cannot store attributes of vertices.
bool hasNoAttributes(const std::string& output) {
    std::string extension = splitExtension(output).second;
    for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return extension == ".obj" || extension == ".svg";
}

}  // namespace

std::uint64_t memoryBudget(const Config& config) {
    const std::uint64_t memory = config.run.memory_limit > 0 ? config.run.memory_limit : availableMemory();
    return memory / 5 * 4;
}

int threadsOf(const Config& config) {
    return config.run.threads > 0 ? std::min(config.run.threads, mostThreads()) : availableThreads();
}

Plan planJob(const Config& config, const PlanOptions& options) {
    if (config.input.path.empty()) throw Error("no input. Set input.path, as in sim/splash.####.vdb");
    if (config.output.path.empty()) throw Error("no output. Set output.path, as in mesh/splash.####.ply");
    if (options.overwrite && options.skip_existing)
        throw Error("--overwrite and --skip-existing cannot be used together");
    const FramePattern input = inputPattern(config.input.path);
    formatOf(input.text, FileKind::particles, Access::read);
    const FramePattern output = framePattern(config.output.path);
    const FramePattern picture = framePattern(config.preview.path);
    if (!config.preview.path.empty() && config.surface.dimension == 2)
        throw Error("preview.path: pictures need surface.dimension 3. In two dimensions write an .svg (output.path)");

    Plan plan;
    plan.config = config;
    agreeOnTessellation(plan);
    agreeOnBubbles(plan);
    plan.configuration = fingerprintOf(plan.config);
    plan.skin = skinParams(plan.config);
    agreeOnSkin(plan);
    requireDimension(plan.config, plan.skin);
    noteOutputFormat(plan);
    plan.threads = threadsOf(config);
    if (config.run.threads > plan.threads)
        plan.notes.push_back("run.threads is " + std::to_string(config.run.threads) + ", but this process may use " +
                             std::to_string(availableThreads()) + " processors: " + std::to_string(plan.threads) +
                             " threads are used");
    if (!config.run.scratch.empty())
        plan.warnings.push_back(
            "run.scratch has no effect any more: data that does not fit into memory is no longer kept on disk");

    if (!config.output.attributes.empty() && hasNoAttributes(config.output.path))
        plan.warnings.push_back(config.output.path +
                                ": this format cannot store attributes; output.attributes is written to spheres alone");

    const auto on_disk = framesOnDisk(input);
    const std::vector<int> frames = chosenFrames(config.frames, input, on_disk);
    requirePlaceholder(frames.size(), output);
    if (!config.preview.path.empty()) requirePlaceholder(frames.size(), picture);
    noteGaps(config, frames, plan.warnings);
    noteOtherNumbers(config, input, plan.warnings);
    for (const int frame : chunkOf(frames, options.chunk)) {
        if (options.history.ended.contains(frame)) continue;
        FrameTask task{frame, fileOfFrame(input, on_disk, frame), frameName(output, frame), FrameAction::mesh, {}};
        if (!config.preview.path.empty()) task.picture = frameName(picture, frame);
        plan.tasks.push_back(std::move(task));
    }
    requireDistinctFiles(plan.tasks, on_disk, sequenceLayer(output));
    requireOwnSequenceLayer(output);
    const auto measurable = measurableOf(on_disk, options.history);
    for (const auto& [frame, why] : options.history.unmeasured)
        plan.warnings.push_back("not used to measure spacing and camera: " + frameName(input, frame) + ": " + why);
    bool radius_planned = false;
    const auto planRadiusOnce = [&] {
        if (!std::exchange(radius_planned, true))
            withThreads(plan.threads, [&] {
                planOrigin(plan, measurable, options);
                planRadius(plan, measurable, options);
            });
    };
    for (FrameTask& task : plan.tasks) {
        const bool input_exists = input.numbered ? on_disk.contains(task.frame) : !on_disk.empty();
        if (options.skip_existing && exists(task.output)) {
            planRadiusOnce();
            task.why = whyAgain(task, input_exists, plan);
        }
        task.action = actionFor(task, input_exists, config, options);
        if (task.action == FrameAction::mesh) task.memory = workingMemory(task.input);
        const auto lost = options.history.lost.find(task.frame);
        if (lost == options.history.lost.end()) continue;
        task.action = FrameAction::fail_lost;
        task.why = lost->second;
    }
    if (!options.dry_run) refuseExisting(plan.tasks);
    requireWritableFolders(plan.tasks);
    plan.frames_in_flight = static_cast<std::size_t>(
        plan.config.run.frames_in_flight > 0 ? plan.config.run.frames_in_flight : plan.threads);
    plan.memory_budget = memoryBudget(plan.config);
    for (FrameTask& task : plan.tasks)
        task.near_surface = task.memory > plan.memory_budget || options.history.kills > 0;
    const bool any_mesh = std::any_of(plan.tasks.begin(), plan.tasks.end(),
                                      [](const FrameTask& task) { return task.action == FrameAction::mesh; });
    if (any_mesh && options.measure) {
        planRadiusOnce();
        if (options.dry_run) return plan;  // the camera has no influence on what can be done
        withThreads(plan.threads, [&] { planPictures(plan, measurable, options); });
    }
    return plan;
}

void requireDistinctLog(const std::string& log_file, const std::string& pipeline, const Config& config) {
    const auto refuse = [](const std::string& name, const std::string& what) {
        throw Error(name + " is both the log file (--log-file) and " + what + ". Choose another log file");
    };
    std::vector<std::string> names{log_file};
    for (std::size_t i = 1; i <= kOldLogFiles; ++i) names.push_back(oldLogFile(log_file, i));
    const std::string& output = config.output.path;
    for (const std::string& name : names) {
        std::error_code ignored;
        if (!pipeline.empty() && (name == pipeline || fs::equivalent(name, pipeline, ignored)))
            refuse(name, "the pipeline file");
        if (isFrameOf(inputPattern(config.input.path), name)) refuse(name, "an input");
        for (const auto& [frame, file] : framesOnDisk(inputPattern(config.input.path)))
            if (fs::equivalent(name, file, ignored)) refuse(name, "the input " + file);
        for (const std::string& file : {output, reportPath(output), spheresPath(output), config.preview.path,
                                        sequenceLayer(framePattern(output))})
            if (!file.empty() && isFrameOf(framePattern(file), name)) refuse(name, "an output");
    }
}

std::string taskLine(const FrameTask& task) {
    std::string line = "frame " + std::to_string(task.frame) + ": " + task.input + " -> " + task.output + ": " +
                       actionName(task.action);
    if (!task.why.empty()) line += " (" + task.why + ')';
    if (task.memory > 0) line += ", about " + std::to_string((task.memory >> 20) + 1) + " MiB";
    return line;
}

}  // namespace betamesh
