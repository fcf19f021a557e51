
#include "batch/job/job.h"

#include "base/parallel.h"
#include "batch/config/origin.h"
#include "batch/config/radius.h"
#include "batch/job/frame_input.h"
#include "batch/job/plane.h"
#include "batch/job/usd_sequence.h"
#include "batch/platform/frame_lock.h"
#include "batch/platform/machine.h"
#include "batch/platform/memory.h"
#include "batch/report/log.h"
#include "betamesh/error.h"
#include "betamesh/version.h"
#include "io/mesh_file.h"
#include "io/output_file.h"
#include "skin/pipeline.h"

#include <chrono>
#include <filesystem>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <set>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace betamesh {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr auto kFirstWait =
    std::chrono::milliseconds(200);  // before reading or writing is tried again; doubles each time
constexpr auto kLongestWait = std::chrono::milliseconds(5000);

/// Seconds since construction or the last call of lap().
class Stopwatch {
public:
    double lap() {
        const auto now = Clock::now();
        const std::chrono::duration<double> seconds = now - begin_;
        begin_ = now;
        return seconds.count();
    }

private:
    Clock::time_point begin_ = Clock::now();
};

/// State that the frames of a running job share.
struct JobState {
    SignalWatch& signals;
    std::mutex mutex{};                         // guards the following
    std::set<std::string> remarked{};           ///< kinds of remarks that the log has shown
    std::map<int, std::string> near_surface{};  ///< by frame: a line on the particles near its surface

    /// Whether a remark is the first of its kind.
    bool isFirst(const std::string& kind) {
        const std::scoped_lock lock(mutex);
        return remarked.insert(kind).second;
    }
};

/// Calls attempt(), and again after an Error, up to `retries` times with growing waits. Rethrows the last Error.
template <typename Attempt>
void retrying(int retries, const Attempt& attempt) {
    auto wait = kFirstWait;
    for (int failures = 0;; ++failures) {
        try {
            return attempt();
        } catch (const Error& error) {
            if (failures == retries) throw;
            logDetail(std::string(error.what()) + "; trying again");
        }
        std::this_thread::sleep_for(wait);
        wait = std::min<std::chrono::milliseconds>(2 * wait, kLongestWait);
        leaveIfInterrupted();
    }
}

/// Logs the first remark of each kind on the input, and records all that are warnings.
void remark(const Liquid& liquid, const Config& config, FrameReport& report, JobState& job) {
    for (const InputRemark& found : remarksOn(liquid, config)) {
        if (found.is_warning) report.warnings.push_back(found.text);
        if (job.isFirst(found.kind)) (found.is_warning ? logWarning : logInfo)(report.input + ": " + found.text);
    }
}

/// The bytes of the picture of a frame; empty if the plan has no pictures.
std::string pictureOf(const FrameTask& task, const Plan& plan, const SkinnedFrame& skinned,
                      const Particles& particles) {
    if (!plan.preview) return {};
    const RenderPlan& preview = *plan.preview;
    const bool balls = plan.config.preview.show != ShownGeometry::surface;
    const Picture picture =
        balls ? renderFrame({}, ballsAround(particles, preview.ball), preview.camera, preview.settings)
              : renderFrame(skinned.mesh, skinned.spheres, preview.camera, preview.settings);
    return encodePicture(picture, task.picture);
}

/// Compares radius and spacing with the particles. A radius that does not suit them is the same mistake in all frames:
/// it is logged once.
void checkSpacing(const Liquid& liquid, const Plan& plan, FrameReport& report, JobState& job) {
    if (liquid.near && !liquid.near->all) return;  // the particles near the surface do not tell the spacing
    const FrameSpacing frame =
        compareSpacing(liquid.particles.position, plan.skin.radius, plan.spacing, plan.config.surface.dimension);
    report.frame_spacing = frame.own.value_or(0);
    if (frame.drift) logWarning(report.input + ": " + *frame.drift);
    if (frame.scale && job.isFirst("scale")) logWarning(report.input + ": " + *frame.scale);
    for (const auto& warning : {frame.drift, frame.scale})
        if (warning) report.warnings.push_back(*warning);
}

void hintAtPlane(const Particles& particles, const Plan& plan, const FrameReport& report, JobState& job) {
    const auto plane = particles.size() > 1 ? planeOf(particles.position, plan.spacing) : std::nullopt;
    if (plane && job.isFirst("plane"))
        logInfo(report.input + ": all particles have the same " + std::string(1, "xyz"[plane->axis]) +
                ". Use --dimension 2 to get curves");
}

/// Records a written file with its size, by which a later run tells whether it is still intact.
void recordFile(const fs::path& file, const FrameTask& task, Provenance& origin) {
    const fs::path name = file.lexically_relative(fs::path(task.output).parent_path());
    origin.files[name.string()] = fileFingerprint(file.string()).bytes;
}

/// Adds up the seconds of each stage. Throws Interrupted between stages once a signal has come.
class StageWatch {
public:
    explicit StageWatch(StageSeconds& seconds) : seconds_(seconds) {}
    void operator()(Stage stage) {
        const double lap = stopwatch_.lap();
        if (stage == Stage::read) seconds_.read += lap;
        if (stage == Stage::structure) seconds_.structure += lap;
        if (stage == Stage::tessellate) seconds_.tessellate += lap;
        if (stage == Stage::smooth) seconds_.smooth += lap;
        if (stage == Stage::velocity) seconds_.velocity += lap;
        if (stage == Stage::picture) seconds_.picture += lap;
        if (stage == Stage::write) seconds_.write += lap;
        if (stage != Stage::write) leaveIfInterrupted();
    }

private:
    StageSeconds& seconds_;
    Stopwatch stopwatch_;
};

/// The output of a frame.
struct Surface {
    Spheres spheres;
    std::string picture;  ///< bytes of the picture file; empty: none
    std::function<void()> write;
};

/// The parameters of a frame. The radius of a sequence without particles is unknown, and any will do.
SkinParams skinOf(const Plan& plan) {
    SkinParams skin = plan.skin;
    if (skin.radius == 0) skin.radius = 1;
    return skin;
}

/// The mesh of a frame; empty if its input is missing.
Surface surfaceOf(const Liquid& liquid, const FrameTask& task, const Plan& plan, StageWatch& watch,
                  FrameReport& report) {
    const Particles& particles = liquid.particles;
    SkinnedFrame skinned;
    if (task.action == FrameAction::mesh)
        skinned = liquid.near ? skinFrame(particles, *liquid.near, skinOf(plan), std::ref(watch))
                              : skinFrame(particles, skinOf(plan), std::ref(watch));
    else if (plan.skin.components)
        skinned.mesh.component.emplace();
    report.skin = skinned.report;
    report.vertices = skinned.mesh.position.size();
    report.triangles = skinned.mesh.triangles.size();
    std::string picture = pictureOf(task, plan, skinned, particles);
    watch(Stage::picture);
    const auto mesh = std::make_shared<Mesh>(std::move(skinned.mesh));
    const auto write = [mesh, &task, &plan, &report] {
        std::optional<OutputFile> file;
        std::future<void> on_disk;  // waiting for the disk should occupy no worker thread
        parallelBoth(
            [&] {
                file.emplace(encodedMesh(task.output, *mesh, writeOptions(plan.config.output, task.frame)));
                on_disk = std::async([&file] { file->commit(); });  // on this thread if no other can be started
            },
            [&] { report.measure = measureMesh(*mesh); });
        on_disk.get();
    };
    return {std::move(skinned.spheres), std::move(picture), write};
}

/// The curves of a frame in two dimensions.
Surface planarSurfaceOf(const Liquid& liquid, const FrameTask& task, const Plan& plan, StageWatch& watch,
                        FrameReport& report) {
    const auto flat = std::make_shared<FlatParticles>(flattened(liquid.particles, plan.spacing));
    const auto plane = std::make_shared<SkinnedPlane>();
    if (task.action == FrameAction::mesh) *plane = skinPlane(flat->particles, skinOf(plan), std::ref(watch));
    report.plane = {plane->report, measureCurves(plane->curves), plane->curves.edges.size()};
    report.vertices = plane->curves.position.size();
    watch(Stage::measure);
    return {toSpace(plane->spheres, flat->plane), {}, [=, &task, &plan] {
                writePlane(task.output, *plane, *flat, skinOf(plan), plan.config,
                           writeOptions(plan.config.output, task.frame));
            }};
}

/// A report beside a mesh means that the frame is complete: it is removed first, and the caller writes it last.
void writeFrame(const FrameTask& task, const Surface& surface, const Config& config) {
    fs::remove(reportPath(task.output));
    surface.write();
    if (surface.spheres.size() > 0) {
        writeSpheres(spheresPath(task.output), surface.spheres, writeOptions(config.output, task.frame));
    } else {
        fs::remove(spheresPath(task.output));
    }
    if (!surface.picture.empty()) writeFile(task.picture, surface.picture);
}

void meshFrame(const FrameTask& task, const Plan& plan, bool near_surface, FrameReport& report, JobState& job) {
    const Config& config = plan.config;
    const bool planar = config.surface.dimension == 2;
    report.origin = {version(), plan.configuration, report.radius, report.spacing, {}, {},
                     worldOrigin(config.input, config.output.up_axis)};
    Stopwatch total;
    StageWatch watch(report.seconds);
    Liquid liquid;
    Particles& particles = liquid.particles;
    if (task.action == FrameAction::mesh) {
        const auto foundNear = [&](const std::string& line) {
            logDetail(task.input + ": " + line);
            const std::scoped_lock lock(job.mutex);
            job.near_surface[task.frame] = line;
        };
        retrying(config.run.retries, [&] {
            FileIdentity identity;
            liquid = readInput(task, plan, near_surface, identity, foundNear);
            report.origin->input = identity;
        });
        if (plan.skin.radius == 0 && particles.size() > 0)
            throw Error(task.input +
                        ": could not be read when the spacing was measured, but can be read now. Run the job again");
        report.particles_read = liquid.summary.particles_read;
        report.particles_dropped = liquid.summary.dropped;
        report.input_parts = partsOf(liquid, config);
        remark(liquid, config, report, job);
        if (particles.velocity.empty()) particles.velocity.resize(particles.size(), Vec3f(0, 0, 0));
        if (!planar) hintAtPlane(particles, plan, report, job);
        checkSpacing(liquid, plan, report, job);
        watch(Stage::read);
    } else {
        report.warnings.push_back("no input: an empty mesh is written (run.on_missing)");
    }
    const Surface surface = (planar ? planarSurfaceOf : surfaceOf)(liquid, task, plan, watch, report);
    report.spheres = surface.spheres.size();
    report.status = particles.size() > 0 ? FrameStatus::ok : FrameStatus::empty;

    const FrameLock lock(task.output, leaveIfInterrupted);
    const SignalWatch::Writing writing(job.signals);
    retrying(config.run.retries, [&] { writeFrame(task, surface, config); });
    recordFile(task.output, task, *report.origin);
    if (report.spheres > 0) recordFile(spheresPath(task.output), task, *report.origin);
    if (!surface.picture.empty()) recordFile(task.picture, task, *report.origin);
    watch(Stage::write);
    report.seconds.total = total.lap();
    report.peak_bytes = peakMemory();
    retrying(config.run.retries, [&] { writeFile(reportPath(task.output), reportJson(report) + '\n'); });
}

FrameReport reportFor(const FrameTask& task, const Plan& plan) {
    FrameReport report;
    report.frame = task.frame;
    report.input = task.input;
    report.output = task.output;
    report.radius = plan.skin.radius;
    report.spacing = plan.spacing;
    report.skin_depth = skinDepth(plan.skin, plan.config.surface.dimension);
    report.predicates = plan.skin.predicates;
    if (plan.config.surface.dimension == 2) report.plane.emplace();
    return report;
}

void fail(FrameReport& report, const std::string& why) {
    report.status = FrameStatus::failed;
    report.origin.reset();
    report.error = "frame " + std::to_string(report.frame) + ": " + why;
    logError(report.error);
}

/// Processes one frame. Interrupted and std::bad_alloc are passed on.
FrameReport frameReport(const FrameTask& task, const Plan& plan, bool near_surface, JobState& job) {
    FrameReport report = reportFor(task, plan);
    switch (task.action) {
        case FrameAction::fail_missing:
            fail(report,
                 task.input + ": no such file. Use --on-missing skip or empty (run.on_missing) to continue without it");
            break;
        case FrameAction::refuse_existing:
            fail(report, task.output + " already exists");
            break;
        case FrameAction::fail_lost:
            fail(report, task.input + ": " + task.why);
            break;
        case FrameAction::skip_missing:
            report.status = FrameStatus::skipped;
            report.warnings.push_back("no input: frame left out (run.on_missing)");
            break;
        case FrameAction::skip_existing:
            report.status = FrameStatus::skipped;
            break;
        case FrameAction::mesh:
        case FrameAction::write_empty:
            try {
                meshFrame(task, plan, near_surface, report, job);
            } catch (const std::bad_alloc&) {
                throw;
            } catch (const std::exception& error) {
                fail(report, error.what());
            }
    }
    report.peak_bytes = peakMemory();
    return report;
}

/// Whether files of the frame may be written, or may have been written by a worker that was lost.
bool writes(FrameAction action) {
    return action == FrameAction::mesh || action == FrameAction::write_empty || action == FrameAction::fail_lost;
}

/// The folders of all outputs, and whether this job writes to each.
std::map<std::string, bool> foldersOf(const std::vector<FrameTask>& tasks) {
    std::map<std::string, bool> folders;
    for (const FrameTask& task : tasks)
        for (const std::string& output : {task.output, task.picture})
            if (!output.empty()) folders[folderOf(output)] |= writes(task.action);
    return folders;
}

/// Removes temporary files and locks of jobs that were killed.
void sweep(const std::map<std::string, bool>& folders) {
    for (const auto& [folder, is_written_to] : folders) {
        sweepTemporaries(folder);
        sweepLocks(folder);
    }
}

/// Calls doFrame(i, alone) for all tasks in order, several at once; it returns false if memory ran out. How many frames
/// fit into memory is learnt from those that have ended, so tasks run in rounds: each round has as many in flight as
/// the estimates allow when it begins. A frame that ran out of memory is repeated alone; outOfMemory(i) is called if
/// that fails as well.
template <typename DoFrame, typename OutOfMemory>
void runInRounds(const Plan& plan, const DoFrame& doFrame, const OutOfMemory& outOfMemory) {
    const std::vector<FrameTask>& tasks = plan.tasks;
    MemoryWatch memory(plan.memory_budget);
    std::size_t most = plan.frames_in_flight;
    const auto fitting = [&](std::size_t first) {
        std::uint64_t largest = 0;
        for (std::size_t i = first; i < std::min(tasks.size(), first + 2 * most); ++i)
            largest = std::max(largest, tasks[i].memory);
        return std::min(most, memory.fitting(largest));
    };
    std::mutex mutex;  // guards again
    std::vector<std::size_t> again;
    const auto anyAgain = [&] {
        const std::scoped_lock lock(mutex);
        return !again.empty();
    };
    for (std::size_t next = 0; next < tasks.size() && caughtSignal() == 0;) {
        const std::size_t first = next, in_flight = fitting(first);
        const auto mayBegin = [&] {
            if (caughtSignal() != 0) return false;
            const std::uint64_t estimate = tasks[next].memory;
            const bool next_round = anyAgain() || fitting(next) > in_flight + in_flight / 2;
            if (next > first && (next_round || !memory.hasRoomFor(estimate))) return false;
            memory.begins(estimate);
            ++next;
            return true;
        };
        parallelInFlight(tasks.size() - first, in_flight, mayBegin, [&](std::size_t i) {
            if (!doFrame(first + i, false)) {
                const std::scoped_lock lock(mutex);
                again.push_back(first + i);
            }
            memory.ends(tasks[first + i].memory);
        });
        if (again.empty()) continue;
        most = std::max<std::size_t>(1, in_flight / 2);
        for (const std::size_t i : std::exchange(again, {})) {
            releaseFreeMemory();
            if (caughtSignal() == 0 && !doFrame(i, true)) outOfMemory(i);
        }
    }
}

}  // namespace

int JobResult::exitCode() const {
    if (signal != 0) return kSignalBase + signal;
    if (out_of_memory) return kOutOfMemory;
    return failed > 0 || layer_failed ? kSomeFailed : kAllWritten;
}

JobResult runJob(const Plan& plan, SignalWatch& signals, const WorkerEvents& events, const FrameEnded& frameEnded) {
    const std::map<std::string, bool> folders = foldersOf(plan.tasks);
    for (const auto& [folder, is_written_to] : folders) {
        std::error_code error;
        if (is_written_to) fs::create_directories(folder, error);
        if (error) throw Error("'" + folder + "': the folder cannot be created: " + error.message());
    }
    sweep(folders);
    JobResult result;
    std::mutex mutex;  // guards result and frameEnded
    JobState job{signals};

    const auto finish = [&](const FrameReport& report) {
        const std::scoped_lock lock(mutex);
        if (report.status == FrameStatus::failed) {
            ++result.failed;
        } else if (report.status == FrameStatus::skipped) {
            ++result.skipped;
        } else {
            ++result.written;
        }
        frameEnded(report);
        events.ended(report.frame, report.status);
    };
    const auto doFrame = [&](std::size_t i, bool alone) {
        const FrameTask& task = plan.tasks[i];
        const WorkerEvents::FrameInProgress in_progress(events, task.frame);
        try {
            finish(frameReport(task, plan, alone || task.near_surface, job));
        } catch (const Interrupted&) {
        } catch (const std::bad_alloc&) {
            return false;
        }
        return true;
    };
    const auto outOfMemory = [&](std::size_t i) {
        result.out_of_memory = true;
        FrameReport report = reportFor(plan.tasks[i], plan);
        const std::string& near = job.near_surface[plan.tasks[i].frame];
        fail(report, "out of memory, although no other frame was in progress; " +
                         std::to_string((plan.memory_budget >> 20) + 1) + " MiB are not enough (run.memory_limit)" +
                         (near.empty() ? "" : "; " + near));
        finish(report);
    };
    withThreads(plan.threads, [&] { runInRounds(plan, doFrame, outOfMemory); });

    try {
        retrying(plan.config.run.retries, [&] {
            writeSequenceLayer(framePattern(plan.config.output.path), plan.config.output);
        });
    } catch (const Error& error) {
        logError(std::string("the layer that plays the sequence: ") + error.what());
        result.layer_failed = true;
    } catch (const Interrupted&) {
    }
    sweep(folders);  // again: jobs killed since the first time have left files, too
    if (result.written + result.skipped + result.failed < plan.tasks.size()) result.signal = caughtSignal();
    return result;
}

}  // namespace betamesh
