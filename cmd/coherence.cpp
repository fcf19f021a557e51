#include "base/parallel.h"
#include "batch/config/config.h"
#include "batch/job/frames.h"
#include "batch/job/job.h"
#include "batch/job/plan.h"
#include "batch/platform/worker.h"
#include "batch/report/log.h"
#include "batch/report/plot.h"
#include "batch/report/report.h"
#include "betamesh/error.h"
#include "command.h"
#include "io/mesh_file.h"
#include "io/output_file.h"
#include "io/particle_file.h"
#include "job_options.h"
#include "mesh/jump_sites.h"
#include "skin/spacing.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <iostream>
#include <limits>
#include <memory>

namespace betamesh {
namespace {

constexpr std::size_t kNameColumns = 20;
constexpr double kRadiusInSpacings = 1.5;

struct Arguments {
    std::vector<std::string> meshes;
    std::string particles;
    std::string pipeline;
    std::vector<std::string> assignments;
    int frame = 0;
    double step = 0;
    int steps = 10;
    DistanceSampling sampling;
    std::optional<double> places_above;  ///< ways of the fastest particle
    std::size_t listed = 10;             ///< places of a pair in a table
    double max_jump = std::numeric_limits<double>::infinity();
    double max_ratio = std::numeric_limits<double>::infinity();  ///< of jumps to what is expected at their places
    std::string plot;
    std::string against;  ///< a file; empty: none
    bool json = false;
};

/// The surface at one moment, and the particles if their motion is wanted.
struct Moment {
    Mesh mesh;
    std::optional<Particles> particles;
};

/// Moments by their names; at: where they stand in a plot, ascending.
struct Sequence {
    std::vector<std::string> names;
    std::vector<double> at;
    std::string across;
    std::function<Moment(std::size_t)> moment;  ///< throws Error for one that cannot be had
    std::optional<double> radius;               ///< world units; where it is not known it is guessed from particles
    int threads = 1;
};

std::string text(double x) {
    char buffer[32];
    std::snprintf(buffer, sizeof buffer, "%.4g", x);
    return buffer;
}

std::string text(const Vec3& p) { return "(" + text(p.x) + ", " + text(p.y) + ", " + text(p.z) + ")"; }

std::string filled(const std::string& text, std::size_t columns) {
    return text.size() < columns ? text + std::string(columns - text.size(), ' ') : text + ' ';
}

void printHead(const Sequence& sequence, bool particles) {
    std::cout << filled("to", kNameColumns) << filled("max", 12) << filled("99.9 %", 12) << filled("RMS", 12)
              << (particles ? filled("particles", 12) + filled("ratio", 10) : "") << "farthest at\n"
              << sequence.names[0] << '\n';
}

std::string ratio(const CoherenceReport& report, double way) {
    const std::optional<double> in_ways = report.ratio(way);
    return in_ways ? text(*in_ways) : "-";
}

/// Where nothing opens, closes, meets or parts. Far from the other surface is only what is left behind or only what has
/// come, where a dent or a tip does one of these.
std::string shapeAt(const JumpSite& place) {
    const std::string words = "no change of topology";
    if (place.liquid == LiquidChange::both || (place.vanished > 0 && place.appeared > 0)) return words;
    const bool gained = place.liquid == LiquidChange::gained, left = place.vanished > 0;
    if (gained == left) return words + (gained ? ": dent filled" : ": dent opened");
    return words + (gained ? ": tip rose" : ": tip sank");
}

std::string eventsAt(const JumpSite& place) {
    std::string words;
    for (const auto& [event, times] : place.events) {
        if (!words.empty()) words += ", ";
        words += nameOf(event);
        if (times > 1) words += " (" + std::to_string(times) + " times)";
    }
    return words.empty() ? shapeAt(place) : words;
}

void printPlaces(const CoherenceReport& report, std::size_t listed) {
    if (report.places.empty()) return;
    std::cout << "    " << filled("jump", 12) << filled("ratio", 10) << filled("expected", 12) << filled("points", 8)
              << filled("vanished", 11) << filled("appeared", 11) << filled("liquid", 8) << filled("what happened", 36) << "at\n";
    for (std::size_t i = 0; i < std::min(listed, report.places.size()); ++i) {
        const JumpSite& place = report.places[i];
        std::cout << "    " << filled(text(place.jump), 12) << filled(ratio(report, place.jump), 10)
                  << filled(text(report.expectedAt(place)), 12) << filled(std::to_string(place.points), 8)
                  << filled(text(place.vanished), 11) << filled(text(place.appeared), 11) << filled(std::string(nameOf(place.liquid)), 8)
                  << filled(eventsAt(place), 36) << text(place.position) << '\n';
    }
    if (report.places.size() <= listed) return;
    const std::size_t more = report.places.size() - listed;
    std::cout << "    and " << more << (more == 1 ? " more place\n" : " more places\n");
}

void print(const CoherenceReport& report, bool particles, std::size_t listed) {
    std::cout << filled(report.to, kNameColumns);
    if (!report.error.empty()) {
        std::cout << "not measured\n";
        return;
    }
    const SurfaceDistance& distance = report.distance;
    std::cout << filled(text(distance.max), 12) << filled(text(distance.quantile999), 12)
              << filled(text(distance.rms), 12);
    if (particles)
        std::cout << filled(report.particles ? text(report.particles->max) : "-", 12)
                  << filled(ratio(report, distance.max), 10);
    std::cout << text(distance.worst) << '\n';
    printPlaces(report, listed);
    std::cout.flush();
}

void printLargest(const std::vector<CoherenceReport>& reports) {
    const auto largest = std::max_element(reports.begin(), reports.end(),
                                          [](const auto& a, const auto& b) { return a.distance.max < b.distance.max; });
    std::cout << "largest: " << text(largest->distance.max) << ", from " << largest->from << " to " << largest->to
              << " at " << text(largest->distance.worst) << '\n';
}

/// The largest ways that another run found, under the name of its file; as many as this run's.
PlotLine lineOf(const std::string& file, std::size_t rows) {
    PlotLine line{"max, " + std::filesystem::path(file).stem().string(), "#20262e", {}};
    for (const CoherenceReport& report : readCoherence(file)) line.value.push_back(report.distance.max);
    if (line.value.size() != rows)
        throw Error(file + ": " + std::to_string(line.value.size()) + " lines; expected one for each of the " +
                    std::to_string(rows) + " pairs that were measured here");
    return line;
}

void writePlot(const std::string& file, const Sequence& sequence, const std::vector<CoherenceReport>& reports,
               const std::optional<PlotLine>& against) {
    Plot plot{"How far the surface moves from one moment to the next", sequence.across, "world units", {}, {}, true};
    plot.lines = {
        {"max", "#c8372d", {}}, {"99.9 %", "#d98a1f", {}}, {"RMS", "#2f6fb7", {}}, {"particles", "#7b8590", {}}};
    for (std::size_t i = 0; i < reports.size(); ++i) {
        const CoherenceReport& report = reports[i];
        plot.at.push_back(sequence.at[i + 1]);
        const double values[] = {report.distance.max, report.distance.quantile999, report.distance.rms,
                                 report.particles ? report.particles->max : 0};
        for (std::size_t line = 0; line < plot.lines.size(); ++line) plot.lines[line].value.push_back(values[line]);
    }
    const auto& way = plot.lines.back().value;
    if (std::all_of(way.begin(), way.end(), [](double d) { return d == 0; })) plot.lines.pop_back();
    if (against) plot.lines.insert(plot.lines.begin(), *against);
    writeFile(file, svgOf(plot));
}

/// Files of meshes: a name with a place for the frame number stands for all of its frames on disk.
std::vector<std::string> filesOf(const std::vector<std::string>& names) {
    std::vector<std::string> files;
    for (const std::string& name : names) {
        requireMeshExtension(name);
        const FramePattern pattern = framePattern(name);
        if (!pattern.numbered) {
            files.push_back(name);
            continue;
        }
        for (const auto& [frame, file] : framesOnDisk(pattern)) files.push_back(file);
    }
    if (files.size() < 2)
        throw Error("expected two meshes or more, found " + std::to_string(files.size()) +
                    (files.empty() ? "" : ": '" + files[0] + "'"));
    return files;
}

Sequence meshFiles(const Arguments& arguments) {
    Sequence sequence;
    sequence.names = filesOf(arguments.meshes);
    sequence.across = "frame";
    for (const std::string& file : sequence.names) sequence.at.push_back(singleFrame(framePattern(file)));
    if (std::adjacent_find(sequence.at.begin(), sequence.at.end(), std::greater_equal<>()) != sequence.at.end()) {
        sequence.across = "mesh";
        for (std::size_t i = 0; i < sequence.at.size(); ++i) sequence.at[i] = static_cast<double>(i + 1);
    }
    sequence.threads = threadsOf(Config{});
    std::optional<FramePattern> particles;
    if (!arguments.particles.empty()) {
        requireParticleExtension(arguments.particles);
        particles = framePattern(arguments.particles);
        requirePlaceFor(sequence.names.size(), *particles);
    }
    sequence.moment = [names = sequence.names, particles](std::size_t i) {
        Moment moment{readMesh(names[i]), std::nullopt};
        if (particles) moment.particles = readParticles(nameForFrameOf(*particles, names[i]));
        return moment;
    };
    return sequence;
}

Sequence fineSteps(const Arguments& arguments, const Watched& watched) {
    Config config = readConfig(arguments.pipeline, keyValuesOf(arguments.assignments));
    config.frames = std::to_string(arguments.frame);
    if (config.output.path.empty()) config.output.path = "nothing.####.ply";  // nothing is written
    PlanOptions options;
    options.overwrite = true;
    options.history.unmeasured = watched.history.unmeasured;
    options.notes = watched.notes;
    if (config.surface.dimension != 3) throw Error("surface.dimension is 2; expected 3, for surfaces are measured");
    const Plan plan = planJob(config, options);
    for (const std::string& warning : plan.warnings) logWarning(warning);
    for (const std::string& note : plan.notes) logInfo(note);
    const std::string& file = plan.tasks.at(0).input;
    if (const auto lost = watched.history.lost.find(arguments.frame); lost != watched.history.lost.end())
        throw Error(file + ": " + lost->second);
    const auto start = [&] {
        const WorkerEvents::AtWork note(watched.notes, arguments.frame);
        return std::make_shared<Particles>(readParticles(file, {config.input.velocity, config.input.id}));
    }();
    if (start->size() > 0 && start->velocity.empty())
        throw Error(file + ": no velocity (v, velocity or vel); expected one that moves the particles between frames");

    Sequence sequence;
    sequence.across = "seconds after frame " + std::to_string(arguments.frame);
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
        moment.particles = moved(*start, at[i]);
        moment.mesh = skinFrame(*moment.particles, skin).mesh;
        return moment;
    };
    return sequence;
}

/// What is one place: things within a radius of each other.
double reachOf(const Particles& particles, const Sequence& sequence, const SurfaceDistance& distance) {
    if (sequence.radius) return *sequence.radius;
    const std::optional<double> between = spacing(particles.position);
    return between ? kRadiusInSpacings * *between : distance.max;
}

CoherenceReport compared(const Moment& before, const Moment& after, const Sequence& sequence,
                         const Arguments& arguments) {
    CoherenceReport report;
    DistanceSampling sampling = arguments.sampling;
    if (before.particles) {
        report.particles = particleMotion(*before.particles, *after.particles);
        if (!report.particles)
            throw Error("particles cannot be matched: expected ids in both frames, or the same number of particles");
        sampling.beyond = arguments.places_above.value_or(1) * report.particles->max;
    }
    report.distance = surfaceDistance(before.mesh, after.mesh, sampling);
    if (!report.distance.far.empty()) {
        report.radius = reachOf(*before.particles, sequence, report.distance);
        report.places = jumpSites(before.mesh, after.mesh, report.distance.far, report.radius);
    }
    report.distance.far.clear();
    return report;
}

int measure(const Sequence& sequence, const Arguments& arguments, const WorkerEvents& notes) {
    std::optional<PlotLine> against;
    if (!arguments.against.empty()) against = lineOf(arguments.against, sequence.names.size() - 1);
    std::vector<CoherenceReport> reports;
    int exit_code = kAllWritten;
    const bool particles = !arguments.particles.empty() || !arguments.pipeline.empty();
    if (!arguments.json) printHead(sequence, particles);
    std::optional<Moment> before;
    for (std::size_t i = 0; i < sequence.names.size(); ++i) {
        CoherenceReport report;
        std::optional<Moment> now;
        try {
            const WorkerEvents::AtWork note(notes, static_cast<int>(i));
            now = sequence.moment(i);
            if (before) report = compared(*before, *now, sequence, arguments);
        } catch (const Error& error) {
            report.error = error.what();
            logError(report.error);
        }
        if (i > 0) {
            if (!before && report.error.empty()) report.error = sequence.names[i - 1] + " could not be read";
            report.from = sequence.names[i - 1];
            report.to = sequence.names[i];
            if (arguments.json) {
                std::cout << coherenceJson(report) << std::endl;
            } else {
                print(report, particles, arguments.listed);
            }
            reports.push_back(report);
        }
        if (!report.error.empty() || report.distance.max > arguments.max_jump ||
            report.largestOfExpected() > arguments.max_ratio)
            exit_code = kSomeFailed;
        before = std::move(now);
    }
    if (!arguments.json) printLargest(reports);
    if (!arguments.plot.empty()) writePlot(arguments.plot, sequence, reports, against);
    return exit_code;
}

int run(const Arguments& arguments) {
    if (arguments.meshes.empty() == arguments.pipeline.empty())
        throw Error("expected either meshes, or --pipeline with --frame and --step");
    if (arguments.places_above && arguments.particles.empty() && arguments.pipeline.empty())
        throw Error("--places-above counts in ways of the fastest particle; expected --particles or --pipeline");
    if (std::isfinite(arguments.max_ratio) && arguments.particles.empty() && arguments.pipeline.empty())
        throw Error("--max-ratio compares with the way of the fastest particle; expected --particles or --pipeline");
    const Watched watched = superviseWorkers(true);
    if (!watched.working) return watched.exit_code;
    const Sequence sequence = arguments.pipeline.empty() ? meshFiles(arguments) : fineSteps(arguments, watched);
    if (!watched.history.lost.empty() && arguments.pipeline.empty()) {
        const auto& [i, why] = *watched.history.lost.begin();
        logError(sequence.names[static_cast<std::size_t>(i)] + ", or its particles: " + why);
        return watched.history.out_of_memory ? kOutOfMemory : kSomeFailed;
    }
    int exit_code = kAllWritten;
    withThreads(sequence.threads, [&] {
        exit_code = measure(sequence, arguments, arguments.pipeline.empty() ? watched.notes : WorkerEvents());
    });
    return exit_code;
}

}  // namespace

void addCoherenceCommand(CLI::App& program, int& exit_code) {
    const auto [command, arguments] = addCommand(
        program, exit_code, "coherence", "Measures how far the surface moves, or jumps, from frame to frame.", run);
    command->footer(
        "For each two neighbours: the largest way from a point of either surface to the other one, what 99.9 % of\n"
        "the area stays below, the root of the mean square; all in world units.\n"
        "At each place with a jump, `expected` is the way of the fastest particle; where pieces join or part, or a "
        "neck, a\n"
        "hole or a void opens or closes, the root of this way times the radius, for surfaces that meet do so as the "
        "root\n"
        "of time.\n"
        "Exit codes: 0 measured; 1 a way beyond --max-jump or --max-ratio, or a mesh that cannot be read; 2 wrong "
        "usage,\n"
        "or a pipeline whose frame cannot be read.\n"
        "Examples:\n"
        "  betamesh coherence 'mesh/splash.####.ply' --particles 'sim/splash.####.vdb' --plot splash.svg\n"
        "  betamesh coherence --pipeline splash.yaml --frame 40 --step 1e-5 --steps 60 --max-jump 1e-4");
    command->add_option("MESH", arguments->meshes,
                        "Meshes in the order of time, of this program or of others: .ply .bgeo .bgeo.gz .obj. A place "
                        "for the frame number (####) stands for every frame on disk.");
    command
        ->add_option(
            "--particles", arguments->particles,
            "Tells, too, how far the fastest particle went between the two, by id or, without ids, by row. Has "
            "a place for the frame number, which is that of each mesh.")
        ->type_name("IN");
    CLI::Option* pipeline =
        command
            ->add_option("--pipeline", arguments->pipeline,
                         "No meshes on disk: the particles of one frame, moved on by their velocity in fine steps and "
                         "skinned as this pipeline file says. Nothing is written.")
            ->type_name("FILE");
    CLI::Option* frame =
        command->add_option("--frame", arguments->frame, "The frame to start from.")->type_name("F")->needs(pipeline);
    CLI::Option* step = command->add_option("--step", arguments->step, "The time between two surfaces, seconds.")
                            ->type_name("DT")
                            ->check(CLI::PositiveNumber)
                            ->needs(pipeline);
    pipeline->needs(frame)->needs(step);
    command->add_option("--steps", arguments->steps, "How many (default 10).")
        ->type_name("N")
        ->check(CLI::Range(1, 1000000))
        ->needs(pipeline);
    command
        ->add_option("--set", arguments->assignments,
                     "Any key of the pipeline file, as in --set smoothing.method=none.")
        ->type_name("KEY=VALUE")
        ->expected(1)
        ->take_all()
        ->needs(pipeline);
    command
        ->add_option("--places-above", arguments->places_above,
                     "Lists the places where the surface went farther than so many ways of the fastest particle, and "
                     "what happened there (default 1; with --particles or --pipeline).")
        ->type_name("X")
        ->check(CLI::NonNegativeNumber);
    command
        ->add_option("--places", arguments->listed,
                     "So many of them in the table of each pair, the largest jumps (default 10; --json tells all).")
        ->type_name("N");
    command->add_option("--max-jump", arguments->max_jump, "World units: a way beyond this is a fault.")
        ->type_name("D")
        ->check(CLI::NonNegativeNumber);
    command
        ->add_option("--max-ratio", arguments->max_ratio,
                     "A place whose jump is more than so many times what is expected there is a fault (with "
                     "--particles or --pipeline).")
        ->type_name("R")
        ->check(CLI::NonNegativeNumber);
    command
        ->add_option("--ignore-thinner", arguments->sampling.thinner,
                     "World units: leaves out of account where the liquid is thinner than this, such as films and "
                     "small drops.")
        ->type_name("D")
        ->check(CLI::NonNegativeNumber);
    command
        ->add_option("--sample-spacing", arguments->sampling.spacing,
                     "World units: how far apart the points inside a triangle are at most, but for 64 to a side "
                     "(default: twice the mean side of all triangles).")
        ->type_name("D")
        ->check(CLI::PositiveNumber);
    CLI::Option* plot = command->add_option("--plot", arguments->plot, "Writes the same over time, as an .svg picture.")
                            ->type_name("FILE.svg");
    command
        ->add_option("--against", arguments->against,
                     "Lines that --json wrote of another run, such as one with another smoothing: their largest ways "
                     "are in the plot too, under the name of the file.")
        ->type_name("FILE")
        ->needs(plot);
    command->add_flag("--json", arguments->json, "One JSON object per pair on stdout.");
}

}  // namespace betamesh
