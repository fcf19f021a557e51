#include "batch/config/key_types.h"
#include "batch/config/local_origin.h"
#include "batch/config/radius.h"
#include "batch/job/render_frames.h"
#include "batch/report/log.h"
#include "betamesh/error.h"
#include "command.h"
#include "help.h"
#include "io/extension.h"
#include "io/particle_file.h"
#include "job_options.h"
#include "preview_options.h"
#include "render/exr_file.h"
#include "render/png_file.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <set>

namespace betamesh {
namespace {

/// The balls that show particles; of radius 0 if no frame can be read.
ParticleBalls particleBalls(const Config& config, const std::map<int, std::string>& on_disk,
                            const WorkerEvents& events) {
    std::vector<SequenceSpacing> measured;
    const auto resolved = resolveRadius(config, on_disk, events, measured);
    if (!resolved) return {};
    logInfo("particle spacing " + shortNumber(resolved->spacing) + " (" + resolved->source + ')');
    const SkinParams skin = skinParams(config);
    const Length& small = config.preview.particle_radius;
    const bool is_union = config.preview.show == ShownGeometry::union_;
    return {is_union ? resolved->radius : small.value * (small.in_spacings ? resolved->spacing : 1), resolved->spacing,
            skin.radius_attribute, skin.radius_scale};
}

/// Says which attribute could give the balls their sizes.
void hintAtSizes(const Config& config, const FileFrame& of) {
    const std::string& file = of.file;
    if (!config.surface.radius_attribute.empty() || isSpheresFile(file)) return;
    const auto attributes = attributesWithoutRows(file, inputOf(config, of.frame));
    if (!attributes) return;
    for (const Attribute& a : *attributes)
        if ((a.name == "pscale" || a.name == "radius") && a.components == 1)
            logInfo(file + ": the attribute '" + a.name +
                    "' is not used: all balls have the same radius. Use it with --radius-attribute " + a.name +
                    " (surface.radius_attribute)");
}

/// Why a key has no effect on pictures of meshes, or of particles as balls; empty if it has one.
std::string whyUnused(const std::string& key, const Config& config, bool shows_balls) {
    const Config::Preview& preview = config.preview;
    const ColourBy by = preview.colouring.by;
    const bool is_direction = key == "preview.azimuth" || key == "preview.elevation";
    if (is_direction && preview.camera_position) return "the position of the camera is given";
    if (key == "preview.colour_range" && (by == ColourBy::nothing || by == ColourBy::kind || by == ColourBy::component))
        return "these colours have no scale (--colour)";
    if (shows_balls) {
        if (key == "preview.normals" || key == "preview.wireframe") return "particles are shown as balls";
        if (key == "preview.colour" && (by == ColourBy::curvature || by == ColourBy::component))
            return "particles are shown as balls; colour them by velocity, kind or an attribute";
        if (key == "preview.particle_radius" && preview.show == ShownGeometry::union_)
            return "the balls of a union have the radius of the surface";
    } else {
        if (key == "preview.show" && preview.show != ShownGeometry::surface) return "meshes are shown as surfaces";
        if (key == "preview.particle_radius" || key.starts_with("surface.") || key.starts_with("input."))
            return "it is for particles, and these files are meshes";
    }
    for (const char* section : {"output.", "smoothing.", "features.", "perturbation.", "picture."})
        if (key.starts_with(section)) return "pictures of files do not depend on it";
    return "";
}

/// Warns of options that change nothing.
void warnOfUnused(const PreviewJob& job, bool shows_balls) {
    for (const KeyValue& given : keyValuesOf(job.options.assignments, job.options.values))
        if (const std::string why = whyUnused(given.path, job.config, shows_balls); !why.empty())
            logWarning(given.where + " has no effect: " + why);
}

bool isEmpty(const FrameGeometry& subject) { return subject.mesh.triangles.empty() && subject.spheres.size() == 0; }

/// The first frame on disk that can be read and is not empty, kept so that it is read only once.
struct FirstFrame {
    std::optional<int> frame;
    FrameGeometry subject;
    ParticleBalls balls{};  ///< of radius 0 if the files are meshes
};

FirstFrame firstFrame(const Config& config, const std::map<int, std::string>& on_disk, const WorkerEvents& events) {
    FirstFrame first;
    for (const auto& [frame, file] : on_disk) {
        const WorkerEvents::FrameInProgress at_work(events, frame, WorkerEvents::Doing::measuring);
        try {
            first.subject = readFrameGeometry({file, frame, config.input.is_one_file}, config, {});
        } catch (const Error&) {  // reported when this frame is rendered
            continue;
        }
        first.frame = frame;
        if (!isEmpty(first.subject)) break;
    }
    if (first.subject.mesh.triangles.empty() && !isEmpty(first.subject)) {
        const FileFrame file{on_disk.at(*first.frame), *first.frame, config.input.is_one_file};
        first.balls = particleBalls(config, on_disk, events);
        hintAtSizes(config, file);
        try {
            first.subject = readFrameGeometry(file, config, first.balls);
        } catch (const Error&) {  // reported when this frame is rendered
            first.frame.reset();
        }
    }
    return first;
}

int render(const PreviewJob& job, const PreviewWorker& worker) {
    Config config = job.config;
    const auto on_disk = measurableOf(job.input.files, worker.history);
    config.input.origin = resolvedLocalOrigin(config, on_disk, worker.events);
    FirstFrame first = firstFrame(config, on_disk, worker.events);
    const ParticleBalls balls = first.balls;
    if (!isEmpty(first.subject) && worker.history.last_loss.empty())
        warnOfUnused(job, first.subject.mesh.triangles.empty());
    Extent extent(config.preview);
    if (on_disk.size() > 1 && needsExtent(config)) {
        extent = sequenceExtent(on_disk, config, balls, worker.events, worker.history.last_loss.empty());
    } else {
        extent.add(first.subject);
    }
    RenderPlan plan = planRendering(config, extent, balls);
    logInfo("camera " + describe(plan));
    plan.settings.layers = std::any_of(job.tasks[0].outputs.begin(), job.tasks[0].outputs.end(), isExr);
    return writePreviews(job, worker, [&](const PreviewTask& task) {
        const FrameGeometry subject = task.frame == first.frame
                                          ? std::move(first.subject)
                                          : readFrameGeometry(fileFrame(job.input, task.frame), config, balls);
        const Picture picture = renderFrame(subject.mesh, subject.spheres, plan.camera, plan.settings);
        Rendering rendering{{}, toneMapped(picture)};
        for (const std::string& output : task.outputs)
            rendering.files.push_back(isExr(output) ? encodeExr(picture) : encodePng(rendering.image));
        return rendering;
    });
}

}  // namespace

void addRenderCommand(CLI::App& program, int& exit_code) {
    CLI::App* command =
        program.add_subcommand("render", "Renders previews of meshes or particles, one frame or a sequence.");
    command->footer(
        "Meshes are shown together with the spheres beside them. Particles are shown as small balls, or with\n"
        "--show union as the balls that the surface is built from. With --radius-attribute each has its own size.\n"
        "Examples:\n"
        "  betamesh render mesh/splash.0012.ply splash.png\n"
        "  betamesh render 'mesh/splash.####.ply' look/splash.####.exr look/splash.####.png --shutter 0.5\n"
        "  betamesh render mesh/splash.0012.ply zebra.png --shading zebra --camera-position 2,1,3 --look-at "
        "0.5,0.2,0.5");
    const auto options = std::make_shared<PreviewOptions>();
    command
        ->add_option(
            "IN", options->input,
            "Mesh or particle files (" + readableExtensions() + "). Write the frame number of a sequence as ####.")
        ->required();
    command->add_option("OUT", options->outputs, "Previews to write: .png, .exr, or one of each.")
        ->required()
        ->expected(1, 2);
    const std::set<std::string> other_keys{"frames",
                                           "run.threads",
                                           "run.timeout",
                                           "surface.radius",
                                           "surface.spacing",
                                           "surface.radius_attribute",
                                           "surface.radius_scale"};
    addPreviewOptions(*command, *options, [&](const ConfigKey& key) {
        return key.path.starts_with("preview.") || key.path.starts_with("input.") || other_keys.contains(key.path);
    });
    showInShortHelp(*command, {"--frames", "--camera-position", "--look-at", "--azimuth", "--elevation", "--width",
                               "--height", "--samples", "--colour", "--shading", "--contact-sheet", "--movie",
                               "--threads", "--overwrite", "--skip-existing"});
    command->callback([options, &exit_code] {
        for (const std::string& output : options->outputs) isExr(output);  // throws for other extensions
        const PreviewJob job = planPreviews(*options, FileKind::mesh);
        exit_code = inPreviewWorker(job, [&](const PreviewWorker& worker) { return render(job, worker); });
    });
}

}  // namespace betamesh
