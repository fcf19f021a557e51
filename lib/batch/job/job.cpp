
#include "batch/job/job.h"

#include "base/parallel.h"
#include "batch/job/plane.h"
#include "batch/platform/frame_lock.h"
#include "batch/platform/machine.h"
#include "batch/platform/memory.h"
#include "batch/platform/scratch_memory.h"
#include "batch/report/log.h"
#include "batch/version.h"
#include "betamesh/error.h"
#include "io/mesh_file.h"
#include "io/output_file.h"
#include "io/particle_file.h"
#include "skin/near_surface.h"

#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace betamesh {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr auto kFirstWait = std::chrono::milliseconds(200);  // before an input or output is tried again; then doubled
constexpr auto kLongestWait = std::chrono::milliseconds(5000);

/// Seconds since it was made or last asked.
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

/// What the frames of a running job share.
struct JobState {
    SignalWatch& signals;
    std::atomic<bool> warned_of_velocity = false;
    std::atomic<bool> hinted_at_plane = false;
    std::mutex mutex{};                         // guards what follows
    std::map<int, std::string> near_surface{};  ///< what there is of frames of which only that was read
    std::optional<ScratchMemory> scratch{};     ///< from the first frame on that is too large

    void useScratch(const Plan& plan, const FrameTask& task) {
        const std::string& folder = plan.config.run.scratch;
        const std::scoped_lock lock(mutex);
        if (!scratch) scratch.emplace(plan.memory_budget, folder.empty() ? folderOf(task.output) : folder);
    }
};

/// Calls what() again after an Error, each time a little later; the last Error is let through.
template <typename What>
void retrying(int retries, const What& what) {
    auto wait = kFirstWait;
    for (int attempt = 0;; ++attempt) {
        try {
            return what();
        } catch (const Error& error) {
            if (attempt == retries) throw;
            logDetail(std::string(error.what()) + "; trying again");
        }
        std::this_thread::sleep_for(wait);
        wait = std::min<std::chrono::milliseconds>(2 * wait, kLongestWait);
        leaveIfInterrupted();
    }
}

void declareVelocity(Particles& particles, FrameReport& report, std::atomic<bool>& warned) {
    if (!particles.velocity.empty() || particles.size() == 0) return;
    particles.velocity.assign(particles.size(), Vec3f(0, 0, 0));
    report.warnings.push_back("no velocity in the input: zero velocities written");
    if (!warned.exchange(true)) {
        logWarning(report.input +
                   ": no velocity (v, velocity or vel): zero velocities are written, here and wherever it is missing");
    }
}

/// The file of a frame's picture; empty where none is asked for.
std::string pictureOf(const FrameTask& task, const Plan& plan, const SkinnedFrame& skinned,
                      const Particles& particles) {
    if (!plan.preview) return {};
    const PreviewPlan& preview = *plan.preview;
    const bool balls = plan.config.preview.show != ShownGeometry::surface;
    const Picture picture = balls ? renderFrame({}, ballsOf(particles, preview.ball), preview.camera, preview.settings)
                                  : renderFrame(skinned.mesh, skinned.spheres, preview.camera, preview.settings);
    return encodePicture(picture, task.picture);
}

void hintAtPlane(const Particles& particles, const FrameReport& report, std::atomic<bool>& hinted) {
    if (!isPlanar(particles) || hinted.exchange(true)) return;
    logInfo(report.input + ": all particles have the same z; --dimension 2 makes curves of them");
}

/// What there is to mesh.
struct Liquid {
    Particles particles;              ///< all of them
    std::optional<NearSurface> near;  ///< or, where they are not all to be in memory, those that this names
};

void noteNearSurface(const NearSurface& near, const FrameTask& task, JobState& job) {
    const std::size_t kept = near.particles - near.leftOut();
    const std::string found = std::to_string(kept) + " of " + std::to_string(near.particles) +
                              " particles lie near the surface and take about " +
                              std::to_string((memoryOf(static_cast<double>(kept)) >> 20) + 1) + " MiB with it";
    logDetail(task.input + ": " + found);
    const std::scoped_lock lock(job.mutex);
    job.near_surface[task.frame] = found;
}

NearSurface nearSurfaceOf(const std::string& file, const SkinParams& skin) {
    constexpr std::size_t kRowsAtOnce = std::size_t{1} << 20;
    NearSurfaceFinder finder(skin);
    std::vector<Vec3f> waiting;
    const auto handOver = [&] {
        finder.add(waiting);
        waiting.clear();
        leaveIfInterrupted();
    };
    forPositions(file, [&](std::span<const Vec3f> positions) {
        waiting.insert(waiting.end(), positions.begin(), positions.end());
        if (waiting.size() >= kRowsAtOnce) handOver();
    });
    handOver();
    return finder.find();
}

/// Reads twice: which particles matter to the surface is known only when all have been seen.
Liquid readNearSurface(const FrameTask& task, const AttributeNames& names, const SkinParams& skin, JobState& job) {
    Liquid liquid;
    liquid.near = nearSurfaceOf(task.input, skin);
    noteNearSurface(*liquid.near, task, job);
    liquid.particles =
        liquid.near->all ? readParticles(task.input, names) : readParticles(task.input, names, liquid.near->row);
    return liquid;
}

/// Can a frame be made from the particles near its surface alone?
bool needsOnlySurface(const Plan& plan) {
    const bool shows_particles = plan.preview && plan.config.preview.show != ShownGeometry::surface;
    return plan.config.surface.dimension == 3 && plan.skin.radius > 0 && !shows_particles;
}

/// A file that changes while it is read is one that a simulation has not finished.
Liquid readInput(const FrameTask& task, const Plan& plan, bool near_surface, Provenance& origin, JobState& job) {
    const AttributeNames names{plan.config.input.velocity, plan.config.input.id};
    const FileFingerprint before = stampOf(task.input);
    Liquid liquid;
    const auto read = [&] {
        if (near_surface && needsOnlySurface(plan))
            liquid = readNearSurface(task, names, plan.skin, job);
        else
            liquid.particles = readParticles(task.input, names);
    };
    parallelBoth(read, [&] { origin.input = identityOf(task.input); });
    if (stampOf(task.input) != before)
        throw Error(task.input + ": changed while it was read; expected a finished file");
    return liquid;
}

/// What was written: its size tells whether it is still there.
void rememberFile(const fs::path& file, const FrameTask& task, Provenance& origin) {
    const fs::path name = file.lexically_relative(fs::path(task.output).parent_path());
    origin.files[name.string()] = stampOf(file.string()).bytes;
}

/// Tells the seconds of each stage as it ends; leaves where nobody waits any more.
class StageWatch {
public:
    explicit StageWatch(StageSeconds& seconds) : seconds_(seconds) {}
    void operator()(std::string_view stage) {
        const double lap = stopwatch_.lap();
        if (stage == "read") seconds_.read += lap;
        if (stage == "structure") seconds_.structure += lap;
        if (stage == "tessellate") seconds_.tessellate += lap;
        if (stage == "smooth") seconds_.smooth += lap;
        if (stage == "velocity") seconds_.velocity += lap;
        if (stage == "picture") seconds_.picture += lap;
        if (stage == "write") seconds_.write += lap;
        if (stage != "write") leaveIfInterrupted();
    }

private:
    StageSeconds& seconds_;
    Stopwatch stopwatch_;
};

/// What there is to write of a frame.
struct Surface {
    Spheres spheres;
    std::string picture;  ///< a file; empty where none is asked for
    std::function<void()> write;
};

/// An empty mesh where there is no input.
Surface surfaceOf(const Liquid& liquid, const FrameTask& task, const Plan& plan, StageWatch& watch,
                  FrameReport& report) {
    const Particles& particles = liquid.particles;
    SkinnedFrame skinned;
    if (task.action == FrameAction::mesh)
        skinned = liquid.near ? skinFrame(particles, *liquid.near, plan.skin, std::ref(watch))
                              : skinFrame(particles, plan.skin, std::ref(watch));
    else if (plan.skin.components)
        skinned.mesh.component.emplace();
    report.skin = skinned.report;
    report.vertices = skinned.mesh.position.size();
    report.triangles = skinned.mesh.triangles.size();
    std::string picture = pictureOf(task, plan, skinned, particles);
    watch("picture");
    const auto mesh = std::make_shared<Mesh>(std::move(skinned.mesh));
    const auto write = [mesh, &task, &report] {
        std::optional<OutputFile> file;
        std::future<void> on_disk;  // for which no core need wait
        parallelBoth(
            [&] {
                file.emplace(encodedMesh(task.output, *mesh));
                on_disk = std::async([&file] { file->commit(); });  // on this thread where there can be no other
            },
            [&] { report.measure = measureMesh(*mesh); });
        on_disk.get();
    };
    return {std::move(skinned.spheres), std::move(picture), write};
}

/// The same in two dimensions.
Surface planarSurfaceOf(const Liquid& liquid, const FrameTask& task, const Plan& plan, StageWatch& watch,
                        FrameReport& report) {
    const Particles& particles = liquid.particles;
    const auto plane = std::make_shared<SkinnedPlane>();
    if (task.action == FrameAction::mesh) *plane = skinPlane(particles, plan.skin, std::ref(watch));
    report.plane = {plane->report, measureCurves(plane->curves), plane->curves.edges.size()};
    report.vertices = plane->curves.position.size();
    watch("measure");
    return {plane->spheres, {}, [=, &particles, &task, &plan] {
                writePlane(task.output, *plane, particles.position, plan.skin, plan.config);
            }};
}

/// The report is the seal of a frame: it goes first and comes last.
void writeFrame(const FrameTask& task, const Surface& surface) {
    fs::remove(reportPath(task.output));
    surface.write();
    if (surface.spheres.size() > 0) {
        writeSpheres(spheresPath(task.output), surface.spheres);
    } else {
        fs::remove(spheresPath(task.output));
    }
    if (!surface.picture.empty()) writeFile(task.picture, surface.picture);
}

void noteMemory(FrameReport& report) {
    report.peak_bytes = peakMemory();
    report.scratch_bytes = peakScratch();
}

void meshFrame(const FrameTask& task, const Plan& plan, bool near_surface, FrameReport& report, JobState& job) {
    const Config& config = plan.config;
    const bool planar = config.surface.dimension == 2;
    report.origin = {version(), plan.configuration, report.radius, report.spacing, {}, {}};
    Stopwatch total;
    StageWatch watch(report.seconds);
    Liquid liquid;
    Particles& particles = liquid.particles;
    if (task.action == FrameAction::mesh) {
        retrying(config.run.retries, [&] { liquid = readInput(task, plan, near_surface, *report.origin, job); });
        if (plan.skin.radius == 0)
            throw Error(task.input + ": could not be read when the spacing was measured, but can be now");
        declareVelocity(particles, report, job.warned_of_velocity);
        if (!planar) hintAtPlane(particles, report, job.hinted_at_plane);
        watch("read");
    } else {
        report.warnings.push_back("no input: an empty mesh written, as run.on_missing says");
    }
    const Surface surface = (planar ? planarSurfaceOf : surfaceOf)(liquid, task, plan, watch, report);
    report.spheres = surface.spheres.size();
    report.status = particles.size() > 0 ? FrameStatus::ok : FrameStatus::empty;

    const FrameLock lock(task.output, leaveIfInterrupted);
    const SignalWatch::Writing writing(job.signals);
    retrying(config.run.retries, [&] { writeFrame(task, surface); });
    rememberFile(task.output, task, *report.origin);
    if (report.spheres > 0) rememberFile(spheresPath(task.output), task, *report.origin);
    if (!surface.picture.empty()) rememberFile(task.picture, task, *report.origin);
    watch("write");
    report.seconds.total = total.lap();
    noteMemory(report);
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

/// What became of one frame; Interrupted and bad_alloc go through.
FrameReport frameReport(const FrameTask& task, const Plan& plan, bool near_surface, JobState& job) {
    FrameReport report = reportFor(task, plan);
    switch (task.action) {
        case FrameAction::fail_missing:
            fail(report, task.input + ": no such file; expected it, or run.on_missing (--on-missing) skip or empty");
            break;
        case FrameAction::refuse_existing:
            fail(report, task.output + " exists");
            break;
        case FrameAction::fail_lost:
            fail(report, task.input + ": " + task.why);
            break;
        case FrameAction::skip_missing:
            report.status = FrameStatus::skipped;
            report.warnings.push_back("no input: frame left out, as run.on_missing says");
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
    noteMemory(report);
    return report;
}

/// May it write something? What ended the process that worked on it may have written before.
bool writes(FrameAction action) {
    return action == FrameAction::mesh || action == FrameAction::write_empty || action == FrameAction::fail_lost;
}

/// Those of what is written, and of what is there already; tells which are written to.
std::map<std::string, bool> foldersOf(const std::vector<FrameTask>& tasks) {
    std::map<std::string, bool> folders;
    for (const FrameTask& task : tasks)
        for (const std::string& output : {task.output, task.picture})
            if (!output.empty()) folders[folderOf(output)] |= writes(task.action);
    return folders;
}

/// Clears what dead jobs left; one that died after the last seal leaves a lock beside frames that are all there.
void sweep(const std::map<std::string, bool>& folders) {
    for (const auto& [folder, is_written_to] : folders) {
        sweepTemporaries(folder);
        sweepLocks(folder);
    }
}

/// Calls doFrame(i, alone) for the tasks in order, some at once; it returns false where memory ran out. How many fit
/// shows only on the way, so they go in rounds, each with as many in flight as fit by what is known then. What ran out
/// of memory is done again alone, with outOfMemory(i) where that is of no use either.
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
        const auto goOn = [&] {
            if (caughtSignal() != 0) return false;
            const std::uint64_t estimate = tasks[next].memory;
            const bool other_round = anyAgain() || fitting(next) > in_flight + in_flight / 2;
            if (next > first && (other_round || !memory.hasRoomFor(estimate))) return false;
            memory.begins(estimate);
            ++next;
            return true;
        };
        parallelInFlight(tasks.size() - first, in_flight, goOn, [&](std::size_t i) {
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
    return failed > 0 ? kSomeFailed : kAllWritten;
}

JobResult runJob(const Plan& plan, SignalWatch& signals, const WorkerEvents& notes, const FrameEnded& frameEnded) {
    const std::map<std::string, bool> folders = foldersOf(plan.tasks);
    for (const auto& [folder, is_written_to] : folders) {
        std::error_code error;
        if (is_written_to) fs::create_directories(folder, error);
        if (error) throw Error("'" + folder + "': cannot make the folder: " + error.message());
    }
    sweep(folders);
    JobResult result;
    std::mutex mutex;  // guards result and frameEnded
    JobState job{signals};

    const auto tell = [&](const FrameReport& report) {
        const std::scoped_lock lock(mutex);
        if (report.status == FrameStatus::failed) {
            ++result.failed;
        } else if (report.status == FrameStatus::skipped) {
            ++result.skipped;
        } else {
            ++result.written;
        }
        frameEnded(report);
        notes.ended(report.frame, report.status);
    };
    const auto doFrame = [&](std::size_t i, bool alone) {
        const FrameTask& task = plan.tasks[i];
        const WorkerEvents::AtWork note(notes, task.frame);
        try {
            if ((alone || task.near_surface) && task.action == FrameAction::mesh) job.useScratch(plan, task);
            tell(frameReport(task, plan, alone || task.near_surface, job));
        } catch (const Interrupted&) {
        } catch (const std::bad_alloc&) {
            return false;
        }
        return true;
    };
    const auto outOfMemory = [&](std::size_t i) {
        result.out_of_memory = true;
        FrameReport report = reportFor(plan.tasks[i], plan);
        const std::uint64_t on_disk = peakScratch();
        const std::string& near = job.near_surface[plan.tasks[i].frame];
        fail(report, "out of memory, with no other frame at work; expected " +
                         std::to_string((plan.memory_budget >> 20) + 1) + " MiB (run.memory_limit) to be enough" +
                         (near.empty() ? "" : "; " + near) +
                         (on_disk > 0 ? "; " + std::to_string((on_disk >> 20) + 1) + " MiB lay on disk" : ""));
        tell(report);
    };
    withThreads(plan.threads, [&] {
        runInRounds(plan, doFrame, outOfMemory);
        releaseFreeMemory();  // at its end the system would take a process's pages back on one thread
    });

    sweep(folders);  // once more: who died shortly before the job began, or during it, may have held files till then
    if (result.written + result.skipped + result.failed < plan.tasks.size()) result.signal = caughtSignal();
    return result;
}

}  // namespace betamesh
