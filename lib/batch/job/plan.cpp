
#include "batch/job/plan.h"

#include "base/parallel.h"
#include "batch/config/key_types.h"
#include "batch/config/local_origin.h"
#include "batch/config/radius.h"
#include "batch/config/surface_params.h"
#include "batch/job/input_frames.h"
#include "batch/job/left_out.h"
#include "batch/job/output_files.h"
#include "batch/job/plane.h"
#include "batch/job/provenance.h"
#include "batch/job/resume.h"
#include "batch/platform/machine.h"
#include "batch/platform/memory.h"
#include "betamesh/error.h"
#include "io/extension.h"
#include "io/level_set.h"
#include "io/mesh_file.h"

#include <algorithm>
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

/// Warns of files or frames of a file that are not meshed, and of gaps.
///
/// errors  sub-frames among all frames on disk
void noteLeftOut(const InputFrames& input, const std::vector<int>& frames, std::vector<std::string>& warnings) {
    for (std::string& warning : leftOutOfFile(input, frames)) warnings.push_back(std::move(warning));
    if (const auto subframes = otherNumbersOnDisk(input.pattern).subframes; !subframes.empty())
        throw Error(
            "'" + input.pattern.text +
            "': beside the frames there are sub-frames, which are not meshed in a sequence: " + firstNames(subframes) +
            ". Choose whole frames with --frames, and mesh sub-frames one by one with --spacing");
    for (std::string& warning :
         leftOutOnDisk(input.pattern, frames,
                       ". Give the range with --frames to make them errors, or empty meshes with "
                       "--on-missing empty (run.on_missing)"))
        warnings.push_back(std::move(warning));
}

/// Warns of what the format of the output cannot hold, and that .bgeo is not the format that it was.
void noteOutputFormat(Plan& plan) {
    const Config::Output& output = plan.config.output;
    const FileKind kind = plan.config.surface.dimension == 2 ? FileKind::curves : FileKind::mesh;
    const FileFormat& format = formatOf(output.path, kind, Access::write);
    const std::string extension = splitExtension(output.path).second;
    const bool has_measured =
        !output.surface_attributes.empty() || (output.normals.value_or(false) && extension != ".obj");
    const std::string lost =
        lossesOf(output.path, kind, {true, !output.attributes.empty() || has_measured, output.components}, output);
    if (!lost.empty())
        plan.warnings.push_back(extension + " files are written without " + lost + ", which they cannot hold. Use " +
                                (format.is_volume ? "--velocity-grid for velocities, and " : "") +
                                ".bgeo, .ply, .vtp, .usda or .abc to keep what is missing");
    if (const std::string renamed = renamingsIn(output.path, kind, output.attributes); !renamed.empty())
        plan.warnings.push_back(extension + " files cannot hold some names of attributes: " + renamed);
    if (extension == ".bgeo" || extension == ".bgeo.gz")
        plan.warnings.push_back(extension +
                                " is written as Houdini 12 and later read it. For programs that read only the format "
                                "of Houdini 11 and earlier, write .bhclassic");
    if (!output.attributes.empty() && (format.is_drawing || format.is_volume || !format.holds_attributes))
        plan.warnings.push_back(output.path +
                                ": this format cannot store attributes; output.attributes is written to spheres alone");
}

void planLocalOrigin(Plan& plan, const std::map<int, std::string>& on_disk, const PlanOptions& options) {
    ParticleInput& input = plan.config.input;
    input.origin = resolvedLocalOrigin(plan.config, on_disk, options.events);
    const Vec3 origin = worldOrigin(input, plan.config.output.up_axis);
    if (origin == Vec3(0, 0, 0)) return;
    const auto coordinates = [](const Vec3& p) { return textOf(p.x) + ',' + textOf(p.y) + ',' + textOf(p.z); };
    const std::string text = coordinates(origin);
    if (plan.config.input.given_origin) {
        plan.notes.push_back("local origin " + text);
        return;
    }
    plan.notes.push_back("to mesh files of this sequence one by one relative to the same origin, use --origin " +
                         coordinates(input.origin));
    plan.warnings.push_back("'" + plan.config.input.path +
                            "': single precision loses these coordinates. Meshes are written relative to the local "
                            "origin " +
                            text + ", which has to be added to their positions (input.origin)");
}

void planRadius(Plan& plan, const std::map<int, std::string>& on_disk, const PlanOptions& options,
                std::vector<SequenceSpacing>& measured) {
    const auto resolved = resolveRadius(plan.config, on_disk, options.events, measured);
    if (!resolved) return;
    plan.spacing = resolved->spacing;
    plan.skin = withLengths(plan.skin, plan.config, *resolved);
    const auto inWorldUnits = [&](const Length& length) {
        return length.value * (length.in_spacings ? resolved->spacing : 1);
    };
    plan.config.output.level_set.voxel = inWorldUnits(plan.config.output.voxel);
    plan.simplify = inWorldUnits(plan.config.output.simplify);
    const double skin = skinDepth(plan.skin, plan.config.surface.dimension);
    const std::string& attribute = plan.skin.radius_attribute;
    const double unit = attribute.empty() ? 1 : resolved->spacing / plan.skin.radius_scale;
    const std::string times = attribute.empty() ? "" : " times " + attribute;
    plan.notes.push_back("radius " + shortNumber(resolved->radius / unit) + times +
                         (skin > 0 ? ", skin " + shortNumber(skin / unit) + times : std::string()) + ", spacing " +
                         shortNumber(resolved->spacing) + " (" + resolved->source + ')');
    if (!givenRadius(plan.config))
        plan.notes.push_back("to mesh files of this sequence one by one with the same spacing, use --spacing " +
                             textOf(resolved->spacing));
    plan.notes.insert(plan.notes.end(), resolved->advice.begin(), resolved->advice.end());
    plan.warnings.insert(plan.warnings.end(), resolved->warnings.begin(), resolved->warnings.end());
}

/// The camera is derived from all frames on disk, so that it does not depend on which of them are meshed by this job.
void planPreview(Plan& plan, const std::map<int, std::string>& on_disk, const PlanOptions& options) {
    const Config::Preview& preview = plan.config.preview;
    if (preview.path.empty()) return;
    const SkinParams& skin = plan.skin;
    ParticleBalls balls{skin.radius, plan.spacing, skin.radius_attribute, skin.radius_scale};
    Extent extent(plan.config.preview);
    if (needsExtent(plan.config))
        extent = sequenceExtent(on_disk, plan.config, balls, options.events, options.history.last_loss.empty());
    if (preview.show == ShownGeometry::particles)
        balls.radius = preview.particle_radius.value * (preview.particle_radius.in_spacings ? plan.spacing : 1);
    plan.preview = planRendering(plan.config, extent, balls);
    plan.preview->settings.layers = isExr(preview.path);
    plan.notes.push_back("camera " + describe(*plan.preview));
}

double framesPerFile(const InputFrames& input) {
    return input.is_one_file ? static_cast<double>(input.files.size()) : 1;
}

/// The memory of a frame of the input. A file that holds several frames may be in memory as a whole.
std::uint64_t memoryOfFrame(const std::string& file, const InputFrames& input) {
    if (!input.is_one_file) return workingMemory(file);
    std::error_code error;
    const std::uintmax_t bytes = fs::file_size(file, error);
    return error ? 0 : memoryOf(estimatedParticles(file) / framesPerFile(input)) + bytes;
}

bool isLevelSet(const Config& config) {
    return config.surface.dimension == 3 && formatOf(config.output.path, FileKind::mesh, Access::write).is_volume;
}

/// Adds the memory of level sets to the estimates. A voxel in world units needs the spacing.
void addLevelSets(Plan& plan, const InputFrames& input) {
    const Length& voxel = plan.config.output.voxel;
    if (!isLevelSet(plan.config) || (!voxel.in_spacings && plan.spacing == 0)) return;
    LevelSetOptions in_spacings = plan.config.output.level_set;
    in_spacings.voxel = voxel.in_spacings ? voxel.value : voxel.value / plan.spacing;
    constexpr double kMost = 0x1p62;  // bytes
    for (FrameTask& task : plan.tasks) {
        if (task.action != FrameAction::mesh) continue;
        const double bytes =
            levelSetMemory(estimatedArea(estimatedParticles(task.input) / framesPerFile(input)), in_spacings);
        task.memory += static_cast<std::uint64_t>(bytes < kMost ? bytes : kMost);
    }
}

void planMachine(Plan& plan) {
    const Config::Run& run = plan.config.run;
    plan.threads = threadsOf(plan.config);
    if (run.threads > plan.threads)
        plan.notes.push_back("run.threads is " + std::to_string(run.threads) + ", but this process may use " +
                             std::to_string(availableThreads()) + " processors: " + std::to_string(plan.threads) +
                             " threads are used");
    if (!run.scratch.empty())
        plan.warnings.push_back(
            "run.scratch has no effect any more: data that does not fit into memory is no longer kept on disk");
    plan.frames_in_flight = static_cast<std::size_t>(run.frames_in_flight > 0 ? run.frames_in_flight : plan.threads);
    plan.memory_budget = memoryBudget(plan.config);
    plan.config.output.level_set.memory_limit = plan.memory_budget;
}

/// The plan of one output as far as its configuration alone tells, without tasks.
Plan withParams(const Config& config) {
    if (!config.preview.path.empty() && config.surface.dimension == 2)
        throw Error("preview.path: previews need surface.dimension 3. In two dimensions write an .svg (output.path)");
    Plan plan;
    plan.config = config;
    reconcileSurface(plan.config, plan.warnings);
    plan.config_hash = configHash(plan.config);
    plan.preview_hash = previewHash(plan.config);
    plan.skin = skinParams(plan.config);
    checkSkin(plan.config, plan.warnings);
    if (!config.output.path.empty()) {
        requireDimension(plan.config, plan.skin);
        noteOutputFormat(plan);
    }
    planMachine(plan);
    return plan;
}

/// Where the files of an output are.
struct OutputPatterns {
    explicit OutputPatterns(const Config& config)
        : mesh(framePattern(config.output.path)), preview(framePattern(config.preview.path)) {}

    /// Whether there is a file for one frame only.
    bool areSingle() const { return !mesh.numbered || !(preview.text.empty() || preview.numbered); }
    /// errors  several frames but no placeholder
    void requirePlaceholders(std::size_t frames) const {
        requirePlaceholder(frames, mesh);
        if (!preview.text.empty()) requirePlaceholder(frames, preview);
    }
    /// The task of a frame, whose action is still open.
    FrameTask task(int frame, const std::string& input) const {
        FrameTask task{frame, input, frameName(mesh, frame), FrameAction::mesh, {}};
        if (!preview.text.empty()) task.preview = frameName(preview, frame);
        return task;
    }

    FramePattern mesh, preview;
};

/// The plan of one output up to its tasks, whose actions are still open.
///
/// in      frames: chosenFrames()
Plan withTasks(const Config& config, const InputFrames& input, const std::vector<int>& frames,
               const PlanOptions& options) {
    const OutputPatterns patterns(config);
    Plan plan = withParams(config);
    plan.config.input.is_one_file = input.is_one_file;
    patterns.requirePlaceholders(frames.size());
    if (config.frames == "all") noteLeftOut(input, frames, plan.warnings);
    if (!input.files.empty() && std::ranges::none_of(frames, [&](int frame) { return input.isThere(frame); }))
        plan.warnings.push_back("'" + input.pattern.text + "': none of the frames " + printFrames(frames) +
                                " is there, only " + printFrames(numbersOf(input)));
    for (const int frame : chunkOf(frames, options.chunk)) {
        if (options.history.ended.contains(frame)) continue;
        plan.tasks.push_back(patterns.task(frame, fileOfFrame(input.pattern, input.files, frame)));
    }
    for (const auto& [frame, why] : options.history.unmeasured)
        plan.warnings.push_back("not used to measure spacing and camera: " + frameName(input.pattern, frame) + ": " +
                                why);
    return plan;
}

/// Fills in the plans of the outputs of a job one step at a time.
class Planner {
public:
    Planner(const InputFrames& input, const PlanOptions& options)
        : input_(input), measurable_(measurableOf(input.files, options.history)), options_(options) {}

    void planActions(Plan& plan) {
        for (FrameTask& task : plan.tasks) {
            const bool input_exists = input_.isThere(task.frame);
            std::error_code ignored;
            if (options_.skip_existing && fs::exists(task.output, ignored)) planLengths(plan);
            chooseAction(task, input_exists, plan, options_);
            const bool draws_particles =
                task.action == FrameAction::draw && plan.config.preview.show != ShownGeometry::surface;
            if (task.action == FrameAction::mesh || draws_particles) task.memory = memoryOfFrame(task.input, input_);
            task.near_surface = task.memory > plan.memory_budget || options_.history.kills > 0;
        }
    }

    void planMeasures(Plan& plan) {
        const bool any = std::any_of(plan.tasks.begin(), plan.tasks.end(), [](const FrameTask& task) {
            return task.action == FrameAction::mesh || task.action == FrameAction::draw ||
                   (task.action == FrameAction::write_empty && !task.preview.empty());
        });
        if (!any) return;
        if (options_.measure || (isLevelSet(plan.config) && !plan.config.output.voxel.in_spacings)) planLengths(plan);
        addLevelSets(plan, input_);
        if (!options_.measure) return;
        if (!options_.dry_run)  // the camera has no influence on what can be done
            withThreads(plan.threads, [&] { planPreview(plan, measurable_, options_); });
    }

private:
    void planLengths(Plan& plan) {
        if (!have_lengths_.insert(&plan).second) return;
        withThreads(plan.threads, [&] {
            planLocalOrigin(plan, measurable_, options_);
            planRadius(plan, measurable_, options_, measured_);
        });
    }

    const InputFrames& input_;
    std::map<int, std::string> measurable_;
    const PlanOptions& options_;
    std::vector<SequenceSpacing> measured_;
    std::set<const Plan*> have_lengths_;
};

}  // namespace

std::uint64_t memoryBudget(const Config& config) {
    const std::uint64_t memory = config.run.memory_limit > 0 ? config.run.memory_limit : availableMemory();
    return memory / 5 * 4;
}

int threadsOf(const Config& config) {
    return config.run.threads > 0 ? std::min(config.run.threads, mostThreads()) : availableThreads();
}

void checkConfig(const Config& config) {
    const FramePattern input = framePattern(config.input.path);
    const auto frames = config.frames == "all" ? std::vector<int>{1} : parseFrames(config.frames);
    std::vector<Plan> outputs;
    for (const Config& output : outputConfigs(config)) {
        Plan& plan = outputs.emplace_back(withParams(output));
        if (const auto given = givenRadius(plan.config)) withLengths(plan.skin, plan.config, *given);
        if (input.text.empty() || output.output.path.empty()) continue;
        const OutputPatterns patterns(output);
        patterns.requirePlaceholders(frames.size());
        plan.tasks = {patterns.task(frames.front(), frameName(input, frames.front()))};  // stands for all frames
    }
    requireDistinctFiles(outputs, {});
}

std::vector<Plan> planOutputs(const Config& config, const PlanOptions& options) {
    if (config.input.path.empty()) throw Error("no input. Set input.path, as in sim/splash.####.vdb");
    if (options.overwrite && options.skip_existing)
        throw Error("--overwrite and --skip-existing cannot be used together");
    const InputFrames input = inputFrames(config.input);
    formatOf(input.pattern.text, FileKind::particles, Access::read);
    const std::vector<Config> configs = outputConfigs(config);
    for (const Config& output : configs)
        if (output.output.path.empty()) throw Error("no output. Set output.path, as in mesh/splash.####.ply");
    const bool one_output =
        std::ranges::any_of(configs, [](const Config& output) { return OutputPatterns(output).areSingle(); });
    const std::vector<int> frames = chosenFrames(config.frames, input, one_output);
    std::vector<Plan> outputs;
    for (const Config& output : configs) outputs.push_back(withTasks(output, input, frames, options));
    requireDistinctFiles(outputs, input.files);
    Planner planner(input, options);
    for (Plan& plan : outputs) planner.planActions(plan);
    if (!options.dry_run) refuseExisting(outputs);
    requireWritableFolders(outputs);
    for (Plan& plan : outputs) planner.planMeasures(plan);
    return outputs;
}

std::string taskLine(const FrameTask& task) {
    std::string line = "frame " + std::to_string(task.frame) + ": " + task.input + " -> " + task.output + ": " +
                       actionName(task.action);
    if (!task.why.empty()) line += " (" + task.why + ')';
    if (task.memory > 0) line += ", about " + std::to_string((task.memory >> 20) + 1) + " MiB";
    return line;
}

}  // namespace betamesh
