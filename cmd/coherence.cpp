#include "base/parallel.h"
#include "batch/config/config.h"
#include "batch/job/distinct_files.h"
#include "batch/job/frames.h"
#include "batch/job/input_frames.h"
#include "batch/job/job.h"
#include "batch/job/left_out.h"
#include "batch/job/output_files.h"
#include "batch/job/plan.h"
#include "batch/job/usd_sequence.h"
#include "batch/platform/worker.h"
#include "batch/report/log.h"
#include "batch/report/plot.h"
#include "batch/report/report.h"
#include "betamesh/error.h"
#include "coherence_table.h"
#include "command.h"
#include "io/extension.h"
#include "io/file_info.h"
#include "io/mesh_file.h"
#include "io/output_file.h"
#include "io/particle_file.h"
#include "job_options.h"
#include "mesh/jump_sites.h"
#include "skin/spacing.h"
#include "value_checks.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <iostream>
#include <limits>
#include <map>
#include <memory>
#include <utility>

namespace betamesh {
namespace {

constexpr double kDefaultPlacesAbove = 1;

struct CoherenceArguments {
    std::vector<std::string> meshes;
    std::string frames = "all";
    std::string particles;
    std::string pipeline;
    std::vector<std::string> assignments;
    std::map<std::string, std::string> input_values;  // of the options that say how particles are read
    int frame = 0;
    double step = 0;
    int steps = 10;
    DistanceSampling sampling;
    std::optional<double> places_above;  ///< multiple of the displacement of the fastest particle
    std::size_t max_places = 10;         ///< per pair in the table
    double max_jump = std::numeric_limits<double>::infinity();
    double max_ratio = std::numeric_limits<double>::infinity();  ///< of a jump to the displacement expected there
    std::string plot;
    std::string against;  ///< file with the JSON lines of another run; empty: none
    bool json = false;
};

/// The surface at one moment, and the particles if their motion is measured.
struct Moment {
    Mesh mesh;
    std::optional<Particles> particles;
};

/// The moments to compare.
struct Sequence {
    std::vector<std::string> names;
    std::vector<FileFrame> files;               ///< of meshes on disk; else empty
    std::vector<double> at;                     ///< position of each moment on the horizontal axis of a plot, ascending
    std::string axis_label;                     ///< of that axis
    std::function<Moment(std::size_t)> moment;  ///< throws Error if moment i cannot be made
    std::optional<double> radius;               ///< ball radius, world units; nullopt: estimated from the particles
    int threads = 1;
};

/// The largest distances of another run, from its JSON lines, named after the file.
/// errors  the number of lines is not `rows`
PlotLine lineOf(const std::string& file, std::size_t rows) {
    PlotLine line{"max, " + std::filesystem::path(file).stem().string(), "#20262e", {}};
    for (const CoherenceReport& report : readCoherence(file)) line.value.push_back(report.distance.max);
    if (line.value.size() != rows)
        throw Error(file + " has " + std::to_string(line.value.size()) + " lines, but " + std::to_string(rows) +
                    " pairs are measured here. Use the --json output of a run over the same frames.");
    return line;
}

void writePlot(const std::string& file, const Sequence& sequence, const std::vector<CoherenceReport>& reports,
               const std::optional<PlotLine>& against) {
    Plot plot{"Distance between consecutive surfaces", sequence.axis_label, "world units", {}, {}, true};
    plot.whole_at = sequence.axis_label == "frame";
    plot.lines = {
        {"max", "#c8372d", {}}, {"99.9 %", "#d98a1f", {}}, {"RMS", "#2f6fb7", {}}, {"particles", "#7b8590", {}}};
    for (std::size_t i = 0; i < reports.size(); ++i) {
        const CoherenceReport& report = reports[i];
        plot.at.push_back(sequence.at[i + 1]);
        const double values[] = {report.distance.max, report.distance.quantile999, report.distance.rms,
                                 report.particles ? report.particles->max : 0};
        for (std::size_t line = 0; line < plot.lines.size(); ++line) plot.lines[line].value.push_back(values[line]);
    }
    const auto& particles = plot.lines.back().value;
    if (std::all_of(particles.begin(), particles.end(), [](double d) { return d == 0; })) plot.lines.pop_back();
    if (against) plot.lines.insert(plot.lines.begin(), *against);
    writeFile(file, svgOf(plot));
}

/// The meshes of the given names. A name with a frame number (####) stands for all of its frames on disk, a file with
/// time samples for these.
std::vector<FileFrame> meshesOf(const CoherenceArguments& arguments) {
    const std::vector<std::string> files = withoutSequenceLayers(withoutManifests(filesNamed(arguments.meshes)));
    for (const std::string& file : files) formatOf(file, FileKind::mesh, Access::read);
    std::vector<FileFrame> meshes = framesIn(files, arguments.frames, FileKind::mesh, false);
    if (meshes.size() < 2)
        throw Error(std::string("at least two meshes are needed to measure a movement, but there is ") +
                    (meshes.empty() ? "none" : "only " + meshes[0].text()) +
                    ". Give more files or a pattern such as m.####.ply.");
    return meshes;
}

/// errors  a file of particles or curves; one that is empty is a frame without liquid
Mesh readSurface(const FileFrame& file) {
    Mesh mesh = readMesh(file.file, file.sample());
    if (!mesh.triangles.empty() || mesh.position.empty()) return mesh;
    const FileKind kind = inspectFile(file.file, nullptr, file.sample()).kind;
    throw Error(file.text() + ": contains " +
                (kind == FileKind::particles ? "particles"
                 : kind == FileKind::curves  ? "curves"
                                             : "vertices") +
                ", but no triangles. Give surfaces, and the particles that they were made from with --particles.");
}

Sequence meshFiles(const CoherenceArguments& arguments) {
    Sequence sequence;
    sequence.files = meshesOf(arguments);
    sequence.axis_label = "frame";
    for (const FileFrame& file : sequence.files) {
        sequence.names.push_back(file.text());
        sequence.at.push_back(file.frame);
    }
    if (std::adjacent_find(sequence.at.begin(), sequence.at.end(), std::greater_equal<>()) != sequence.at.end()) {
        sequence.axis_label = "mesh";
        for (std::size_t i = 0; i < sequence.at.size(); ++i) sequence.at[i] = static_cast<double>(i + 1);
    }
    sequence.threads = threadsOf(Config{});
    std::optional<InputFrames> particles;
    if (!arguments.particles.empty()) {
        particles = particleFrames(arguments.particles, arguments.input_values);
        if (!particles->is_one_file) requirePlaceholder(sequence.names.size(), particles->pattern);
    }
    sequence.moment = [files = sequence.files, particles, values = arguments.input_values](std::size_t i) {
        Moment moment{readSurface(files[i]), std::nullopt};
        if (particles) moment.particles = particlesOf(files[i].file, particlesBeside(files[i], *particles), values);
        return moment;
    };
    return sequence;
}

/// The particles of the frame of a pipeline from which the steps start.
std::shared_ptr<const Particles> startingParticles(const std::string& file, const Config& config, int frame,
                                                   const WorkerEvents& events) {
    const WorkerEvents::FrameInProgress at_work(events, frame);
    auto particles = std::make_shared<Particles>(readParticles(file, inputOf(config, frame)));
    if (particles->size() > 0 && particles->velocity.empty())
        throw Error(file + ": the particles have no velocity (v, velocity or vel), so they cannot be moved in steps. " +
                    "Name the attribute with --set input.velocity=NAME.");
    return particles;
}

/// The particles of one frame, moved along their velocities in small steps and meshed at each.
Sequence fineSteps(const CoherenceArguments& arguments, const Supervision& watched) {
    Config config =
        outputConfigs(readConfig(arguments.pipeline, keyValuesOf(arguments.assignments, arguments.input_values)))
            .front();
    config.frames = std::to_string(arguments.frame);
    if (config.output.path.empty())
        config.output.path = "nothing.####.ply";  // planning needs a path; no file is written
    PlanOptions options;
    options.overwrite = true;
    options.history.unmeasured = watched.history.unmeasured;
    options.events = watched.events;
    if (config.surface.dimension != 3) throw Error("surface.dimension is 2, but only surfaces can be measured. Use 3.");
    const Plan plan = planOutputs(config, options).front();
    for (const std::string& warning : plan.warnings) logWarning(warning);
    for (const std::string& note : plan.notes) logInfo(note);
    const std::string& file = plan.tasks.at(0).input;
    if (const auto lost = watched.history.lost.find(arguments.frame); lost != watched.history.lost.end())
        throw Error(file + ": " + lost->second);
    const auto start = startingParticles(file, plan.config, arguments.frame, watched.events);

    Sequence sequence;
    sequence.axis_label = "seconds after frame " + std::to_string(arguments.frame);
    sequence.threads = plan.threads;
    sequence.radius = plan.skin.radius;
    for (int i = 0; i <= arguments.steps; ++i) {
        sequence.at.push_back(arguments.step * i);
        char name[32];
        std::snprintf(name, sizeof name, "%.9g s", sequence.at.back());
        sequence.names.emplace_back(name);
    }
    sequence.moment = [start, skin = plan.skin, at = sequence.at](std::size_t i) {
        Moment moment;
        moment.particles = advected(*start, at[i]);
        moment.mesh = skinFrame(*moment.particles, skin).mesh;
        return moment;
    };
    return sequence;
}

/// Jumps within this distance of each other belong to one place: the ball radius, known or estimated. World units.
double placeRadius(const Particles& particles, const Sequence& sequence, const SurfaceDistance& distance) {
    if (sequence.radius) return *sequence.radius;
    const auto estimate = spacingOf(particles.position);
    return estimate ? kDefaultRadiusSpacings * estimate->spacing : distance.max;
}

CoherenceReport compared(const Moment& before, const Moment& after, const Sequence& sequence,
                         const CoherenceArguments& arguments) {
    CoherenceReport report;
    DistanceSampling sampling = arguments.sampling;
    if (before.particles) {
        report.particles = particleMotion(*before.particles, *after.particles);
        if (!report.particles)
            throw Error(
                "the particles of the two frames cannot be matched: they have no ids, and their numbers differ. Give "
                "particles with ids.");
        sampling.beyond = arguments.places_above.value_or(kDefaultPlacesAbove) * report.particles->max;
    }
    report.distance = surfaceDistance(before.mesh, after.mesh, sampling);
    if (!report.distance.far.empty()) {
        report.radius = placeRadius(*before.particles, sequence, report.distance);
        report.places = jumpSites(before.mesh, after.mesh, report.distance.far, report.radius);
    }
    report.distance.far.clear();
    return report;
}

bool isBeyondLimits(const CoherenceReport& report, const CoherenceArguments& arguments) {
    return report.distance.max > arguments.max_jump || report.largestExpectedRatio() > arguments.max_ratio;
}

/// Names the files of moments i - 1 and i as scripts need them: with the frames of time samples beside them.
void nameFiles(const Sequence& sequence, std::size_t i, CoherenceReport& report) {
    if (sequence.files.empty()) return;
    const FileFrame &from = sequence.files[i - 1], &to = sequence.files[i];
    report.from = from.file;
    report.to = to.file;
    report.from_frame = from.number();
    report.to_frame = to.number();
}

int measure(const Sequence& sequence, const CoherenceArguments& arguments, const WorkerEvents& events) {
    std::optional<PlotLine> against;
    if (!arguments.against.empty()) against = lineOf(arguments.against, sequence.names.size() - 1);
    const bool with_particles = !arguments.particles.empty() || !arguments.pipeline.empty();
    if (!arguments.json) printTableHead(sequence.names[0], with_particles);
    std::vector<CoherenceReport> reports;
    bool failed = false, told_of_ids = false;
    std::optional<Moment> before;
    for (std::size_t i = 0; i < sequence.names.size(); ++i) {
        CoherenceReport report;
        std::optional<Moment> after;
        try {
            const WorkerEvents::FrameInProgress at_work(events, static_cast<int>(i));
            after = sequence.moment(i);
            if (before) report = compared(*before, *after, sequence, arguments);
            if (report.particles && report.particles->repeated_id && !std::exchange(told_of_ids, true))
                logWarning("particles of " + sequence.names[i - 1] + " and " + sequence.names[i] +
                           ": several have the id " +
                           std::to_string(static_cast<std::int64_t>(*report.particles->repeated_id)) +
                           ". Those of one id are matched in the order of the files, so displacements may be wrong");
        } catch (const Error& error) {
            const bool is_sample = !sequence.files.empty() && sequence.files[i].is_one_of_several;
            report.error = (is_sample ? "frame " + std::to_string(sequence.files[i].frame) + ": " : "") + error.what();
            logError(report.error);
        }
        if (i > 0) {
            if (!before && report.error.empty()) report.error = sequence.names[i - 1] + " could not be read";
            report.from = sequence.names[i - 1];
            report.to = sequence.names[i];
            if (arguments.json) {
                nameFiles(sequence, i, report);
                std::cout << coherenceJson(report) << std::endl;
            } else {
                printTableRow(report, with_particles, arguments.max_places);
            }
            reports.push_back(report);
        }
        failed = failed || !report.error.empty() || isBeyondLimits(report, arguments);
        before = std::move(after);
    }
    if (!arguments.json) printLargest(reports);
    if (!arguments.plot.empty()) writePlot(arguments.plot, sequence, reports, against);
    return failed ? kSomeFailed : kAllWritten;
}

/// Refuses options that contradict each other or lack what they refer to.
void checkUsage(const CoherenceArguments& arguments) {
    if (arguments.meshes.empty() == arguments.pipeline.empty())
        throw Error("Give either mesh files, or --pipeline with --frame and --step.");
    if (!arguments.plot.empty() && splitExtension(arguments.plot).second != ".svg")
        throw Error("--plot: " + arguments.plot + " does not end in .svg, the format of the plot. Give a FILE.svg.");
    if (!arguments.particles.empty() || !arguments.pipeline.empty()) return;
    if (arguments.places_above)
        throw Error("--places-above compares with the fastest particle. Add --particles or use --pipeline.");
    if (std::isfinite(arguments.max_ratio))
        throw Error("--max-ratio compares with the fastest particle. Add --particles or use --pipeline.");
}

/// errors  the plot is a file that is read
void requireDistinctFiles(const CoherenceArguments& arguments) {
    if (arguments.plot.empty()) return;
    DistinctFiles files;
    for (const std::string& file : filesNamed(arguments.meshes)) {
        files.read(file, "a mesh");
        if (!arguments.particles.empty())
            files.read(nameForFrameOf(inputPattern(arguments.particles), file), "the particles of a mesh");
    }
    for (const std::string& file : {arguments.pipeline, arguments.against})
        if (!file.empty()) files.read(file, file == arguments.pipeline ? "the pipeline file" : "the file of --against");
    files.written(arguments.plot, "the plot");
}

int measureFrames(const CoherenceArguments& arguments) {
    checkUsage(arguments);
    requireDistinctFiles(arguments);
    if (!arguments.plot.empty()) {
        const std::string folder = folderOf(arguments.plot);
        if (!std::filesystem::is_directory(folder))
            throw Error("--plot " + arguments.plot + ": there is no folder '" + folder +
                        "'. Make it, or choose another one");
        requireWritableFolders({folder});
    }
    if (arguments.frames == "all") warnOfLeftOut(arguments.meshes);
    const Supervision watched = superviseWorkers(true);
    if (!watched.is_worker) return watched.exit_code;
    const Sequence sequence = arguments.pipeline.empty() ? meshFiles(arguments) : fineSteps(arguments, watched);
    if (!watched.history.lost.empty() && arguments.pipeline.empty()) {
        const auto& [i, reason] = *watched.history.lost.begin();
        logError(sequence.names[static_cast<std::size_t>(i)] + ", or its particles: " + reason);
        return watched.history.out_of_memory ? kOutOfMemory : kSomeFailed;
    }
    int exit_code = kAllWritten;
    withThreads(sequence.threads, [&] {
        exit_code = measure(sequence, arguments, arguments.pipeline.empty() ? watched.events : WorkerEvents());
    });
    return exit_code;
}

}  // namespace

void addCoherenceCommand(CLI::App& program, int& exit_code) {
    const auto [command, arguments] = addCommand(
        program, exit_code, "coherence", "Measures how far the surface moves or jumps between frames.", measureFrames);
    command->footer(
        "For every two consecutive meshes the table shows distances between the two surfaces in world units: the\n"
        "largest distance (Hausdorff), the distance below which 99.9 % of the area lies, and the root mean square.\n"
        "Below a pair it lists the places where the surface moved farther than the particles. `expected` is the\n"
        "displacement of the fastest particle; where liquid merges or separates, or a neck, hole or void opens or\n"
        "closes, it is the square root of that displacement times the radius, because surfaces that meet approach\n"
        "each other as the square root of time.\n"
        "Exit codes: 0 measured; 1 a distance beyond --max-jump or --max-ratio, or a mesh that cannot be read;\n"
        "2 wrong usage, or a pipeline whose frame cannot be read.\n"
        "Examples:\n"
        "  betamesh coherence 'mesh/splash.####.ply' --particles 'sim/splash.####.vdb' --plot splash.svg\n"
        "  betamesh coherence --pipeline splash.yaml --frame 40 --step 1e-5 --steps 60 --max-jump 1e-4");
    command->add_option("MESH", arguments->meshes,
                        "Mesh files of any program in the order of time (" +
                            extensionsFor(FileKind::mesh, Access::read) +
                            "). A pattern with a frame number (####) stands for every frame on disk, a file with time "
                            "samples for all of them.");
    addFramesOption(*command, arguments->frames);
    command
        ->add_option("--particles", arguments->particles,
                     "Also measure how far the fastest particle moved. Particles are matched by id or, without ids, by "
                     "row. Give a pattern with a frame number (####), which is that of each mesh.")
        ->type_name("IN");
    CLI::Option* pipeline =
        command
            ->add_option("--pipeline", arguments->pipeline,
                         "Instead of meshes on disk, take the particles of one frame, move them along their velocities "
                         "in small time steps, and mesh each step as this pipeline file says. Nothing is written.")
            ->type_name("FILE");
    CLI::Option* frame = command->add_option("--frame", arguments->frame, "With --pipeline: the frame to start from.")
                             ->type_name("F")
                             ->check(wholeNumber(std::numeric_limits<int>::min(), std::numeric_limits<int>::max()))
                             ->needs(pipeline);
    CLI::Option* step = command->add_option("--step", arguments->step, "With --pipeline: the time step in seconds.")
                            ->type_name("DT")
                            ->check(numberAboveZero())
                            ->needs(pipeline);
    pipeline->needs(frame)->needs(step);
    command->add_option("--steps", arguments->steps, "With --pipeline: the number of time steps.")
        ->type_name("N")
        ->capture_default_str()
        ->check(wholeNumber(1, 1000000))
        ->needs(pipeline);
    command
        ->add_option("--set", arguments->assignments,
                     "With --pipeline: set any key, as in --set smoothing.method=none.")
        ->type_name("KEY=VALUE")
        ->expected(1)
        ->take_all()
        ->needs(pipeline);
    command
        ->add_option("--places-above", arguments->places_above,
                     "List the places where the surface moved more than X times as far as the fastest particle, and "
                     "what happened there. Requires --particles or --pipeline.")
        ->type_name("X")
        ->default_str(shortText(kDefaultPlacesAbove))
        ->check(numberFromZero());
    command
        ->add_option("--places", arguments->max_places,
                     "Number of places listed for each pair in the table, the largest jumps first; --json lists all.")
        ->type_name("N")
        ->capture_default_str()
        ->check(wholeNumber(0));
    command
        ->add_option("--max-jump", arguments->max_jump,
                     "Exit with 1 if a surface moves farther than this, in world units.")
        ->type_name("D")
        ->check(numberFromZero());
    command
        ->add_option("--max-ratio", arguments->max_ratio,
                     "Exit with 1 if a jump is more than R times the displacement expected at its place. Requires "
                     "--particles or --pipeline.")
        ->type_name("R")
        ->check(numberFromZero());
    command
        ->add_option("--ignore-thinner", arguments->sampling.thinner,
                     "Ignore the surface where the liquid is thinner than D world units, as in films and small drops.")
        ->type_name("D")
        ->check(numberFromZero());
    command
        ->add_option("--sample-spacing", arguments->sampling.spacing,
                     "Largest distance between sample points inside a triangle in world units, with at most 64 points "
                     "along a side. Without it, twice the mean side of all triangles.")
        ->type_name("D")
        ->check(numberAboveZero());
    CLI::Option* plot =
        command->add_option("--plot", arguments->plot, "Also write the distances over time as an .svg plot.")
            ->type_name("FILE.svg");
    command
        ->add_option("--against", arguments->against,
                     "With --plot: also plot the largest distances of another run, such as one with other smoothing. "
                     "FILE contains the --json output of that run; its name appears in the plot.")
        ->type_name("FILE")
        ->needs(plot);
    addParticleOptions(*command, arguments->input_values);
    addMeshAxisOption(*command, arguments->input_values);
    command->add_flag("--json", arguments->json, "Print one JSON object per pair on stdout.");
}

}  // namespace betamesh
