#include "batch/job/process_frame.h"

#include "base/parallel.h"
#include "batch/config/local_origin.h"
#include "batch/config/radius.h"
#include "batch/job/empty_frames.h"
#include "batch/job/frame_input.h"
#include "batch/job/frames.h"
#include "batch/job/input_frames.h"
#include "batch/job/plane.h"
#include "batch/job/render_frames.h"
#include "batch/job/resume.h"
#include "batch/job/retrying.h"
#include "batch/job/shared_frame.h"
#include "batch/job/stage_watch.h"
#include "batch/platform/frame_lock.h"
#include "batch/platform/machine.h"
#include "batch/platform/memory.h"
#include "batch/report/log.h"
#include "betamesh/error.h"
#include "betamesh/version.h"
#include "io/mesh_file.h"
#include "io/output_file.h"
#include "io/particle_file.h"
#include "skin/surface_attributes.h"

#include <algorithm>
#include <array>
#include <exception>
#include <filesystem>
#include <functional>
#include <future>
#include <memory>
#include <new>
#include <optional>
#include <utility>

namespace betamesh {
namespace {

namespace fs = std::filesystem;
void warnOf(const std::string& warning, const std::string& file, FrameResult& result) {
    result.warnings.push_back(warning);
    logWarning(file + ": " + warning);
}

/// Logs the first remark of each kind on the input, and records all that are warnings.
void remark(const FrameInput& liquid, const Plan& plan, FrameResult& result, JobState& job) {
    for (const InputRemark& found : remarksOn(liquid, plan)) {
        if (found.is_warning) result.warnings.push_back(found.text);
        if (found.kind == kNoVelocity) job.noteNoVelocity(result.frame);
        if (job.isFirst(found.kind)) (found.is_warning ? logWarning : logInfo)(result.input + ": " + found.text);
    }
}

bool showsParticles(const Plan& plan) { return plan.config.preview.show != ShownGeometry::surface; }

/// The bytes of the preview of a frame. The plan has one.
std::string previewOf(const FrameTask& task, const Plan& plan, const Mesh& mesh, const Spheres& spheres,
                      const Particles& particles) {
    const RenderPlan& preview = plan.preview.value();
    const Picture picture =
        showsParticles(plan) ? renderFrame({}, ballsAround(particles, preview.balls), preview.camera, preview.settings)
                             : renderFrame(mesh, spheres, preview.camera, preview.settings);
    return encodePicture(picture, task.preview);
}

/// Compares radius and spacing with the particles. A radius that does not suit them is the same mistake in all frames:
/// it is logged once.
void checkSpacing(const FrameInput& liquid, const Plan& plan, FrameResult& result, JobState& job) {
    if (liquid.near && !liquid.near->all) return;  // the particles near the surface do not tell the spacing
    const FrameSpacing frame = compareSpacing(liquid.particles, plan.skin, plan.config.surface.dimension);
    result.frame_spacing = frame.own.value_or(0);
    if (frame.drift) logWarning(result.input + ": " + *frame.drift);
    if (frame.scale && job.isFirst("scale")) logWarning(result.input + ": " + *frame.scale);
    for (const auto& warning : {frame.drift, frame.scale})
        if (warning) result.warnings.push_back(*warning);
}

/// Warns of walls that most particles are beyond, by more than the half spacing within which the surface is laid flat.
void checkWalls(const FrameInput& liquid, const Plan& plan, FrameResult& result, JobState& job) {
    const std::vector<Vec3f>& position = liquid.particles.position;
    for (std::size_t i = 0; i < plan.skin.walls.size(); ++i) {
        const Wall& wall = plan.skin.walls[i];
        const auto beyond = std::ranges::count_if(
            position, [&](const Vec3f& p) { return dot(wall.normal, Vec3(p)) > wall.offset + 0.5 * plan.spacing; });
        if (static_cast<std::size_t>(beyond) <= position.size() / 2) continue;
        const std::string& text = plan.config.surface.walls[i];
        const std::string warning = std::to_string(beyond) + " of " + std::to_string(position.size()) +
                                    " particles are beyond the wall " + text +
                                    " (surface.walls), which names the side with the liquid";
        result.warnings.push_back(warning);
        if (job.isFirst("wall " + text)) logWarning(result.input + ": " + warning);
    }
}

void hintAtPlane(const Particles& particles, const Plan& plan, const FrameResult& result, JobState& job) {
    const auto plane = particles.size() > 1 ? planeOf(particles.position, plan.spacing) : std::nullopt;
    if (plane && job.isFirst("plane"))
        logInfo(result.input + ": all particles have the same " + std::string(1, "xyz"[plane->axis]) +
                ". Use --dimension 2 to get curves");
}

/// Records a written file with its size, by which a later run tells whether it is still intact.
void recordFile(const fs::path& file, const FrameTask& task, Provenance& provenance) {
    provenance.files[listedName(file.string(), task.output)] = fileFingerprint(file.string()).bytes;
}

/// What is written for an output.
struct Surface {
    Spheres spheres;
    std::function<void()> write;
    std::function<std::string()> draw;  ///< the bytes of the preview file
};

/// The mesh of no particles.
Surface emptySurface(const FrameTask& task, const Plan& plan, Mesh mesh, JobState& job) {
    if (plan.skin.components) mesh.component.emplace();
    putFirst(job.columnsOf(plan), mesh.attributes);
    return {{},
            [empty = std::make_shared<Mesh>(std::move(mesh)), &task, &plan] {
                writeMesh(task.output, *empty, writeOptions(plan.config.output, task.frame));
            },
            [&task, &plan] { return previewOf(task, plan, {}, {}, {}); }};
}

/// A mesh; empty if the input is missing.
Surface surfaceOf(SharedFrame& frame, const FrameInput& liquid, const FrameTask& task, const Plan& plan,
                  StageWatch& watch, FrameResult& result, JobState& job) {
    if (task.action != FrameAction::mesh)
        return emptySurface(task, plan, {{}, {}, {}, emptyColumns(plan.skin.surface_attributes), {}}, job);
    const SkinnedFrame& skinned = frame.skinned(plan, watch);
    result.skin = skinned.report;
    result.vertices = skinned.mesh.position.size();
    result.triangles = skinned.mesh.triangles.size();
    if (liquid.particles.size() == 0) {
        result.measure = frame.measure(skinned.mesh);
        return emptySurface(task, plan, skinned.mesh, job);
    }
    if (skinned.mesh.triangles.empty() && plan.skin.box)
        warnOf("the mesh is empty: no part of the surface is inside surface.box (--surface-box)", task.output, result);
    if (skinned.report.crossings > 0)
        warnOf("the surface crosses itself at " + std::to_string(skinned.report.crossings) +
                   " pairs of triangles (check lists them): so many particles lie so near each other that single "
                   "precision cannot tell them apart. Is the spacing right?",
               task.output, result);
    const auto write = [&frame, &mesh = skinned.mesh, &task, &plan, &result] {
        std::optional<OutputFile> file;
        std::future<void> on_disk;  // waiting for the disk should occupy no worker thread
        std::string warned;
        parallelBoth(
            [&] {
                WriteOptions options = writeOptions(plan.config.output, task.frame);
                const WarningHandler warn = [&](const std::string& warning) { warned = warning; };
                options.warn = &warn;
                file.emplace(encodedMesh(task.output, mesh, options));
                on_disk = std::async([&file] { file->commit(); });  // on this thread if no other can be started
            },
            [&] { result.measure = frame.measure(mesh); });
        on_disk.get();
        if (!warned.empty()) warnOf(warned, task.output, result);
    };
    const auto draw = [&skinned, &liquid, &task, &plan] {
        return previewOf(task, plan, skinned.mesh, skinned.spheres, liquid.particles);
    };
    return {skinned.spheres, write, draw};
}

/// Curves in two dimensions.
Surface planarSurfaceOf(const FrameInput& liquid, const FrameTask& task, const Plan& plan, StageWatch& watch,
                        FrameResult& result, JobState& job) {
    const auto flat = std::make_shared<FlatParticles>(flattened(liquid.particles, plan.spacing));
    const auto plane = std::make_shared<SkinnedPlane>();
    if (task.action == FrameAction::mesh) *plane = skinPlane(flat->particles, skinOf(plan), std::ref(watch));
    if (liquid.particles.size() == 0) putFirst(job.columnsOf(plan), plane->curves.attributes);
    result.plane = {plane->report, measureCurves(plane->curves), plane->curves.edges.size()};
    result.vertices = plane->curves.position.size();
    watch(Stage::measure);
    const auto write = [=, &task, &plan] {
        writePlane(task.output, *plane, *flat, skinOf(plan), plan.config, writeOptions(plan.config.output, task.frame));
    };
    return {toSpace(plane->spheres, flat->plane), write, {}};  // there are no previews in two dimensions
}

/// A manifest beside a mesh means that the frame is complete: it is removed first, and the caller writes it last.
void writeFrame(const FrameTask& task, const Surface& surface, const Config& config, FrameResult& result) {
    const std::string file = spheresPath(task.output);
    if (surface.spheres.size() == 0 && isListed(file, task.output)) fs::remove(file);  // while the manifest tells whose
    fs::remove(manifestPath(task.output));
    if (surface.spheres.size() > 0) {  // before the mesh: what the format cannot hold leaves no mesh alone
        WriteOptions options = writeOptions(config.output, task.frame);
        const WarningHandler warn = [&](const std::string& warning) { warnOf(warning, file, result); };
        options.warn = &warn;
        writeSpheres(file, surface.spheres, options);
    }
    surface.write();
    if (surface.spheres.size() == 0 && fs::exists(file))
        warnOf(
            "is kept, as no earlier run of this output wrote it, although render and check take it for the spheres of "
            "this mesh. Move it",
            file, result);
}

void writeManifest(const FrameTask& task, const Config& config, const std::string& json) {
    retrying(config.run.retries, [&] { writeFile(manifestPath(task.output), json + '\n'); });
}

/// Draws and writes the preview of a mesh that is complete, and records it in the provenance.
///
/// errors  what keeps the preview from being made; the message names its file
void writePreview(const FrameTask& task, const Plan& plan, const std::function<std::string()>& draw, StageWatch& watch,
                  Provenance& provenance, JobState& job) {
    try {
        const std::string picture = draw();
        watch(Stage::picture);
        const SignalWatch::Writing writing(job.signals);
        retrying(plan.config.run.retries, [&] { writeFile(task.preview, picture); });
        recordFile(task.preview, task, provenance);
        provenance.preview_hash = plan.preview_hash;
        watch(Stage::write);
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& error) {
        std::string why = error.what();
        if (why.find(task.preview) == std::string::npos) why = task.preview + ": " + why;
        if (why.ends_with('.')) why.pop_back();
        throw Error(why + ". The mesh " + task.output + " is complete; --skip-existing makes the preview alone");
    }
}

/// Makes an output of a frame: the mesh, its spheres, its manifest; then its preview, whose failure leaves the others.
void meshOutput(SharedFrame& frame, const FrameTask& task, const Plan& plan, FrameResult& result, JobState& job) {
    const Config& config = plan.config;
    const bool planar = config.surface.dimension == 2;
    result.provenance = {version(),
                         plan.config_hash,
                         {},
                         result.radius,
                         result.spacing,
                         {},
                         {},
                         worldOrigin(config.input, config.output.up_axis),
                         config.output.up_axis};
    Stopwatch total;
    StageWatch watch(result.seconds);
    const FrameInput nothing;
    const FrameInput* liquid = &nothing;
    if (task.action == FrameAction::mesh) {
        liquid = &frame.liquid(task, plan);
        result.provenance->input = frame.identity();
        if (plan.skin.radius == 0 && liquid->particles.size() > 0)
            throw Error(task.input +
                        ": could not be read when the spacing was measured, but can be read now. Run the job again");
        result.particles_read = liquid->summary.particles_read;
        result.particles_dropped = liquid->summary.dropped;
        result.input_parts = partsOf(*liquid, config);
        remark(*liquid, plan, result, job);
        requireAttributes(*liquid, config);
        if (!planar) hintAtPlane(liquid->particles, plan, result, job);
        checkSpacing(*liquid, plan, result, job);
        checkWalls(*liquid, plan, result, job);
        watch(Stage::read);
    } else {
        result.warnings.push_back("no input: an empty mesh is written (run.on_missing)");
    }
    const Surface surface = planar ? planarSurfaceOf(*liquid, task, plan, watch, result, job)
                                   : surfaceOf(frame, *liquid, task, plan, watch, result, job);
    result.spheres = surface.spheres.size();
    result.status = liquid->particles.size() > 0 ? FrameStatus::ok : FrameStatus::empty;

    const FrameLock lock(task.output, leaveIfInterrupted);
    {
        const SignalWatch::Writing writing(job.signals);
        retrying(config.run.retries, [&] { writeFrame(task, surface, config, result); });
        recordFile(task.output, task, *result.provenance);
        if (result.spheres > 0) recordFile(spheresPath(task.output), task, *result.provenance);
        watch(Stage::write);
        result.seconds.total = total.lap();
        result.peak_bytes = peakMemory();
        writeManifest(task, config, manifestJson(result));
    }
    if (!plan.preview || task.preview.empty()) return;
    writePreview(task, plan, surface.draw, watch, *result.provenance, job);
    result.seconds.total += total.lap();
    result.peak_bytes = peakMemory();
    writeManifest(task, config, manifestJson(result));
}

/// Makes the preview of a mesh on disk.
void drawOutput(SharedFrame& frame, const FrameTask& task, const Plan& plan, FrameResult& result, JobState& job) {
    const auto manifest = readManifest(manifestPath(task.output));
    if (!manifest || !manifest->provenance)
        throw Error(manifestPath(task.output) + ": no longer exists. Run the job again");
    result.skin = manifest->skin;
    Provenance provenance = *manifest->provenance;
    Stopwatch total;
    StageWatch watch(result.seconds);
    FrameGeometry geometry;
    const Particles* particles = nullptr;
    if (showsParticles(plan)) {
        particles = &frame.liquid(task, plan).particles;
        result.vertices = manifest->vertices;
        result.triangles = manifest->triangles;
        result.spheres = manifest->spheres;
    } else {
        retrying(plan.config.run.retries, [&] {
            geometry = readFrameGeometry({task.output, task.frame}, plan.config, {});
        });
        result.vertices = geometry.mesh.position.size();
        result.triangles = geometry.mesh.triangles.size();
        result.spheres = geometry.spheres.size();
    }
    watch(Stage::read);
    const FrameLock lock(task.output, leaveIfInterrupted);
    const auto draw = [&] {
        return previewOf(task, plan, geometry.mesh, geometry.spheres, particles != nullptr ? *particles : Particles{});
    };
    writePreview(task, plan, draw, watch, provenance, job);
    writeManifest(task, plan.config, manifestWith(provenance, manifestPath(task.output)));
    result.seconds.total = total.lap();
}

FrameResult emptyResult(const FrameTask& task, const Plan& plan) {
    FrameResult result;
    result.frame = task.frame;
    result.input = task.input;
    result.output = task.output;
    result.preset = plan.config.preset;
    result.radius = plan.skin.radius;
    result.spacing = plan.spacing;
    result.skin_depth = skinDepth(plan.skin, plan.config.surface.dimension);
    result.predicates = plan.skin.predicates;
    if (plan.config.surface.dimension == 2) result.plane.emplace();
    return result;
}

void fail(FrameResult& result, const std::string& why) {
    result.status = FrameStatus::failed;
    result.provenance.reset();
    result.error = "frame " + std::to_string(result.frame) + ": " + why;
    logError(result.error);
}

/// An error that names a file of the frame: its input unless it names another one.
std::string withFile(const std::string& error, const FrameTask& task) {
    const std::array files{task.input, task.output, spheresPath(task.output), task.preview};
    const bool names_file = std::ranges::any_of(
        files, [&](const std::string& file) { return !file.empty() && error.find(file) != std::string::npos; });
    return (names_file ? "" : task.input + ": ") + error;
}

/// Processes one output of a frame. Interrupted and std::bad_alloc are passed on.
FrameResult resultOfOutput(SharedFrame& frame, const FrameTask& task, const Plan& plan, bool is_one_of_several,
                           JobState& job) {
    FrameResult result = emptyResult(task, plan);
    const std::string prefix = is_one_of_several ? task.output + ": " : "";
    switch (task.action) {
        case FrameAction::fail_missing:
            fail(result,
                 (plan.config.input.is_one_file ? noTimeSample(task.input, task.frame) + '.'
                                                : task.input + ": no such file.") +
                     (plan.tasks.size() > 1 ? " Use --on-missing skip or empty (run.on_missing) to continue without it"
                                            : adviceOnStars(task.input)));
            break;
        case FrameAction::refuse_existing:
            fail(result, task.output + " already exists");
            break;
        case FrameAction::fail_lost:
            fail(result, task.input + ": " + task.why);
            break;
        case FrameAction::skip_missing:
            result.status = FrameStatus::skipped;
            result.input_missing = true;
            result.warnings.push_back("no input: frame left out (run.on_missing)");
            break;
        case FrameAction::skip_existing:
            result.status = FrameStatus::skipped;
            break;
        case FrameAction::mesh:
        case FrameAction::draw:
        case FrameAction::write_empty:
            try {
                if (task.action == FrameAction::draw)
                    drawOutput(frame, task, plan, result, job);
                else
                    meshOutput(frame, task, plan, result, job);
            } catch (const std::bad_alloc&) {
                throw;
            } catch (const MemoryError& error) {
                const std::scoped_lock lock(job.mutex);
                job.memory_error[task.frame] = error.what();
                throw std::bad_alloc();
            } catch (const ParticleError& error) {
                fail(result,
                     prefix + task.input + ": " + withRowInFile(error, task.input, inputOf(plan.config, task.frame)));
            } catch (const std::exception& error) {
                fail(result, prefix + withFile(error.what(), task));
            }
    }
    result.peak_bytes = peakMemory();
    return result;
}

/// The outputs in the order in which they are made: those that share a surface, then those that share particles,
/// follow each other.
std::vector<std::size_t> sharingOrder(std::span<const Plan> outputs) {
    std::vector<std::size_t> order;
    const auto add = [&](std::size_t i) {
        if (std::find(order.begin(), order.end(), i) == order.end()) order.push_back(i);
    };
    for (std::size_t i = 0; i < outputs.size(); ++i)
        for (std::size_t j = i; j < outputs.size(); ++j) {
            if (!readTheSame(outputs[i], outputs[j], false)) continue;
            for (std::size_t k = j; k < outputs.size(); ++k)
                if (skinTheSame(outputs[j], outputs[k])) add(k);
        }
    return order;
}

}  // namespace

void processFrame(std::span<const Plan> outputs, std::size_t row, bool near_surface, JobState& job,
                  std::vector<FrameResult>& results) {
    const std::vector<std::size_t> order = sharingOrder(outputs);
    SharedFrame frame(job, near_surface);
    while (results.size() < order.size()) {
        const Plan& plan = outputs[order[results.size()]];
        results.push_back(resultOfOutput(frame, plan.tasks[row], plan, outputs.size() > 1, job));
    }
}

void failFrame(std::span<const Plan> outputs, std::size_t row, const std::string& why,
               std::vector<FrameResult>& results) {
    const std::vector<std::size_t> order = sharingOrder(outputs);
    while (results.size() < order.size()) {
        const Plan& plan = outputs[order[results.size()]];
        fail(results.emplace_back(emptyResult(plan.tasks[row], plan)), why);
    }
}

}  // namespace betamesh
