#include "batch/job/frames.h"
#include "batch/job/input_frames.h"
#include "batch/job/left_out.h"
#include "batch/job/plan.h"
#include "batch/job/plane.h"
#include "batch/job/usd_sequence.h"
#include "batch/report/log.h"
#include "batch/report/printable.h"
#include "batch/report/report.h"
#include "betamesh/error.h"
#include "command.h"
#include "each_file.h"
#include "io/curve_file.h"
#include "io/extension.h"
#include "io/mesh_file.h"
#include "io/particle_file.h"
#include "job_options.h"
#include "mesh/enclosure.h"
#include "standard_streams.h"
#include "value_checks.h"

#include <cstdio>
#include <filesystem>
#include <iostream>
#include <map>
#include <optional>

namespace betamesh {
namespace {

constexpr std::size_t kMaxGeneraPrinted = 8;

struct CheckArguments {
    std::vector<std::string> meshes;
    std::string frames = "all";
    std::string particles;
    double radius = 0;
    std::string scratch;                              // deprecated, has no effect
    std::map<std::string, std::string> input_values;  // of the keys that say how particles are read
    CheckParams params;
    bool weld = false;
    bool strict = false;
    bool json = false;
};

/// Prints what was found in a mesh or in curves, one line per finding.
class Printer {
public:
    explicit Printer(const Mesh& mesh) : mesh_(mesh) {}

    static void title(const CheckReport& report) {
        std::cout << printable(FileFrame{report.file, report.frame.value_or(0), report.frame.has_value()}.text())
                  << ": ";
        if (report.faults.empty()) std::cout << "good";
        for (std::size_t i = 0; i < report.faults.size(); ++i) std::cout << (i > 0 ? ", " : "") << report.faults[i];
        std::cout << '\n';
    }
    void line(const char* name, const std::string& text) const {
        std::cout << "  " << name << std::string(22 - std::min<std::size_t>(21, std::string_view(name).size()), ' ')
                  << text << '\n';
    }
    void line(const char* name, std::size_t count) const { line(name, std::to_string(count)); }
    void vertexFound(const char* name, const FaultCount& found) const {
        if (found) line(name, counted(found, "vertex") + positionText(found.first));
    }
    void triangleFound(const char* name, const FaultCount& found) const {
        if (!found) return;
        const std::uint32_t corner = mesh_.triangles[found.first][0];
        line(name, counted(found, "triangle") + (corner < mesh_.position.size() ? positionText(corner) : ""));
    }
    static std::string text(const Vec3& p) { return "(" + text(p.x) + ", " + text(p.y) + ", " + text(p.z) + ")"; }
    static std::string text(double x) {
        char buffer[32];
        std::snprintf(buffer, sizeof buffer, "%.6g", x);
        return buffer;
    }

private:
    static std::string counted(const FaultCount& found, const char* row) {
        return std::to_string(found.count) + ", first at " + row + " " + std::to_string(found.first);
    }
    std::string positionText(std::uint32_t vertex) const { return " " + text(mesh_.position[vertex]); }

    const Mesh& mesh_;
};

void printParticles(const Printer& out, const ParticleCheck& particles) {
    out.line("particles",
             std::to_string(particles.particles) + ", " + std::to_string(particles.outside.count) + " outside");
    if (!particles.outside) return;
    std::string distance = Printer::text(particles.farthest);
    if (particles.radius > 0) distance += " (" + Printer::text(particles.farthest / particles.radius) + " radii)";
    out.line("farthest outside", distance + ", particle " + std::to_string(particles.farthest_row) + " " +
                                     Printer::text(particles.farthest_position));
}

/// ": 51 of genus 0, 1 of genus 14, 3 not a closed manifold", in ascending order of genus.
std::string genera(const std::vector<ComponentCheck>& components) {
    std::map<std::int64_t, std::size_t> count;
    std::size_t without_genus = 0;
    for (const ComponentCheck& component : components) ++(component.genus ? count[*component.genus] : without_genus);
    std::string text;
    std::size_t printed = 0;
    for (const auto& [genus, components_of_it] : count) {
        if (++printed > kMaxGeneraPrinted) return text + ", ...";
        text += (text.empty() ? ": " : ", ") + std::to_string(components_of_it) + " of genus " + std::to_string(genus);
    }
    if (without_genus > 0)
        text += (text.empty() ? ": " : ", ") + std::to_string(without_genus) + " not a closed manifold";
    return text;
}

void print(const Mesh& mesh, const CheckReport& report) {
    const MeshCheck& check = report.check;
    const Printer out(mesh);
    out.title(report);
    out.line("vertices", check.vertices);
    out.line("triangles", check.triangles);
    out.line("components", std::to_string(check.components.size()) + genera(check.components));
    out.line("Euler characteristic", std::to_string(check.euler));
    out.line("volume", Printer::text(check.volume));
    out.line("area", Printer::text(check.area));
    out.vertexFound("positions not finite", check.not_finite);
    out.vertexFound("velocity not finite", check.velocity_not_finite);
    out.triangleFound("missing vertices", check.missing_vertices);
    out.triangleFound("repeated vertices", check.repeated_vertices);
    out.triangleFound("duplicate triangles", check.duplicates);
    out.vertexFound("open edges", check.open_edges);
    out.vertexFound("misoriented edges", check.misoriented_edges);
    if (check.inside_out) out.line("inside out", "the triangles face inwards");
    out.vertexFound("non-manifold edges", check.nonmanifold_edges);
    out.vertexFound("non-manifold vertices", check.nonmanifold_vertices);
    if (check.crossings) {
        out.line("crossings",
                 std::to_string(check.crossings.count) + ", up to " + Printer::text(check.deepest) + " deep");
        for (const SelfCrossing& crossing : check.deepest_crossings)
            std::cout << "    triangles " << crossing.first << " and " << crossing.second << " at "
                      << Printer::text(crossing.position)
                      << (crossing.coplanar ? ", in one plane" : ", " + Printer::text(crossing.depth) + " deep")
                      << '\n';
    }
    if (check.shallow > 0) out.line("shallow crossings", std::to_string(check.shallow) + ", below the tolerance");
    if (check.touching > 0) out.line("touching triangles", std::to_string(check.touching) + " pairs");
    out.triangleFound("zero-area triangles", check.zero_area);
    out.vertexFound("unused vertices", check.unused_vertices);
    out.vertexFound("coincident vertices", check.coincident_vertices);
    if (report.particles) printParticles(out, *report.particles);
    if (check.coincident_vertices && check.open_edges)
        std::cout << "  hint: several vertices share a position; --weld joins them before the check\n";
}

void print(const Curves& curves, const CheckReport& report) {
    const CurveCheck& check = *report.curves;
    Mesh vertices;
    vertices.position = curves.position;
    const Printer out(vertices);
    out.title(report);
    out.line("vertices", check.vertices);
    out.line("edges", check.edges);
    out.line("curves", check.measure.curves);
    out.line("Euler characteristic", std::to_string(check.measure.turning));
    out.line("area", Printer::text(check.measure.area));
    out.line("length", Printer::text(check.measure.length));
    out.vertexFound("positions not finite", check.not_finite);
    out.vertexFound("velocity not finite", check.velocity_not_finite);
    if (check.repeated_vertices) out.line("repeated vertices", check.repeated_vertices.count);
    out.vertexFound("open ends", check.open_ends);
    if (check.inside_out) out.line("inside out", "the curves run clockwise");
    if (check.crossings) {
        out.line("crossings",
                 std::to_string(check.crossings.count) + ", up to " + Printer::text(check.deepest) + " deep");
        for (const EdgeCrossing& crossing : check.deepest_crossings)
            std::cout << "    edges " << crossing.first << " and " << crossing.second << " at "
                      << Printer::text(crossing.position) << ", " << Printer::text(crossing.depth) << " deep\n";
    }
    out.vertexFound("not in one plane", check.off_plane);
    out.vertexFound("branches", check.branches);
    out.vertexFound("unused vertices", check.unused_vertices);
    if (report.particles) printParticles(out, *report.particles);
}

Spheres spheresBeside(const std::string& mesh) {
    Spheres spheres;
    const std::string file = spheresPath(mesh);
    if (!std::filesystem::exists(file)) return spheres;
    const Particles found = readParticles(file);
    for (const Attribute& attribute : found.attributes)
        if (attribute.name == "radius" || attribute.name == "pscale") spheres.radius = attribute.real;
    spheres.position.assign(found.position.begin(), found.position.end());
    if (spheres.radius.size() != spheres.position.size())
        throw Error(file + ": the spheres have no radius. Each needs the attribute radius (.ply) or pscale (.bgeo).");
    return spheres;
}

/// A mesh, and the particles that it is checked with.
struct CheckTask {
    FileFrame mesh;
    const InputFrames* particles = nullptr;  ///< null: none

    std::string text() const {
        if (particles == nullptr) return mesh.file;
        try {
            return mesh.file + ", " + particlesBeside(mesh, *particles).file;
        } catch (const Error&) {  // the error of the check
            return mesh.file;
        }
    }
};

/// Checks that all particles are inside a mesh or curves, or in the spheres beside it. plane: of curves, whose
/// positions are in its coordinates.
template <typename Surface>
ParticleCheck checkParticles(const Surface& surface, const AxisPlane& plane, const CheckTask& task,
                             const CheckArguments& arguments) {
    ParticleCheck check;
    const FileFrame file = particlesBeside(task.mesh, *task.particles);
    check.file = file.file;
    check.radius = arguments.radius;
    const Particles particles = particlesOf(task.mesh.file, file, arguments.input_values);
    Spheres spheres = spheresBeside(task.mesh.file);
    for (Vec3& p : spheres.position) p = plane.toPlane(p);
    check.particles = particles.size();
    check.spheres = spheres.size();
    std::vector<Vec3> points;
    for (const Vec3f& p : particles.position) points.push_back(plane.toPlane(Vec3(p)));
    const std::vector<double> distances = distancesOutside(surface, spheres, points);
    for (std::size_t i = 0; i < distances.size(); ++i) {
        if (!(distances[i] > arguments.params.tolerance)) continue;
        if (check.outside.count++ == 0) check.outside.first = static_cast<std::uint32_t>(i);
        if (distances[i] <= check.farthest) continue;
        check.farthest = distances[i];
        check.farthest_row = i;
        check.farthest_position = points[i];
    }
    if (check.outside) {
        ParticleInput input = readConfig("", keyValuesOf({}, arguments.input_values)).input;
        input.frame = file.sample();
        check.farthest_row = rowInFile(check.file, input, check.farthest_row);
    }
    return check;
}

/// Adds the faults to the report and prints it. Returns whether there are none. `surface` is a mesh or curves.
template <typename Surface, typename Check>
bool finish(const Surface& surface, const AxisPlane& plane, const Check& check, CheckReport& report,
            const CheckTask& task, const CheckArguments& arguments) {
    for (const std::string_view fault : faultsOf(check, arguments.strict)) report.faults.emplace_back(fault);
    if (task.particles != nullptr) {
        report.particles = checkParticles(surface, plane, task, arguments);
        if (report.particles->outside) report.faults.emplace_back("particles_outside");
    }
    if (arguments.json) {
        std::cout << checkJson(report) << '\n';
    } else {
        print(surface, report);
    }
    return report.faults.empty();
}

/// The report of a mesh that is still to be checked.
CheckReport reportOf(const FileFrame& mesh) {
    CheckReport report;
    report.file = mesh.file;
    report.frame = mesh.number();
    return report;
}

/// Checks the mesh or the curves in a file. Returns whether they have no fault.
bool checkFile(const CheckTask& task, const CheckArguments& arguments) {
    CheckReport report = reportOf(task.mesh);
    const std::string& file = task.mesh.file;
    const std::optional<double> sample = task.mesh.sample();
    Mesh mesh = readUncheckedMesh(file, sample);
    if (mesh.triangles.empty() && inspectFile(file, nullptr, sample).kind == FileKind::curves) {
        Curves curves = readUncheckedCurves(file, sample);
        const std::vector<Vec3f> positions(curves.position.begin(), curves.position.end());
        const AxisPlane plane = planeOf(positions, 0).value_or(AxisPlane{});
        for (auto* rows : {&curves.position, &curves.velocity})
            for (Vec3& v : *rows) v = plane.toPlane(v);
        report.curves = checkCurves(curves, arguments.params);
        return finish(curves, plane, *report.curves, report, task, arguments);
    }
    if (mesh.triangles.empty() && !mesh.position.empty() &&
        inspectFile(file, nullptr, sample).kind == FileKind::particles)
        throw Error(file +
                    ": contains particles, but no triangles and no curves. Give meshes, and the particles that "
                    "they were made from with --particles.");
    if (arguments.weld) mesh = weldVertices(mesh);
    report.check = checkMesh(mesh, arguments.params);
    return finish(mesh, {}, report.check, report, task, arguments);
}

int checkFiles(const CheckArguments& arguments) {
    if (!arguments.scratch.empty()) logWarning("--scratch has no effect any more: meshes are checked in memory alone");
    StandardStreams streams;
    std::vector<std::string> meshes = withoutSequenceLayers(withoutManifests(filesNamed(arguments.meshes)));
    if (arguments.frames == "all") warnOfLeftOut(arguments.meshes);
    for (std::string& mesh : meshes)
        if (mesh == kStandardStream) mesh = streams.fileOfStdin();
    for (const std::string& mesh : meshes) formatOf(mesh, FileKind::mesh, Access::read);
    std::optional<InputFrames> particles;
    if (!arguments.particles.empty()) particles = particleFrames(arguments.particles, arguments.input_values);
    std::vector<CheckTask> tasks;
    for (FileFrame& mesh : framesIn(meshes, arguments.frames, FileKind::mesh, false))
        tasks.push_back({std::move(mesh), particles ? &*particles : nullptr});
    return forEachFile(
        tasks.size(),
        [&](std::size_t i) {
            return NamedFile{tasks[i].text(), tasks[i].mesh.number()};
        },
        [&](std::size_t i) { return checkFile(tasks[i], arguments); },
        [&](std::size_t i, const std::string& error) {
            CheckReport report = reportOf(tasks[i].mesh);
            report.error = error;
            if (arguments.json) std::cout << checkJson(report) << '\n';
        });
}

}  // namespace

void addCheckCommand(CLI::App& program, int& exit_code) {
    const auto [command, arguments] =
        addCommand(program, exit_code, "check",
                   "Checks that meshes of any program are closed, manifold and free of crossings.", checkFiles);
    command->footer(
        "Faults of meshes: not_finite, velocity_not_finite, repeated_vertices, duplicates, open_edges,\n"
        "misoriented_edges, inside_out, nonmanifold_edges, nonmanifold_vertices, crossings, particles_outside;\n"
        "with --strict also zero_area, unused_vertices, coincident_vertices and touching.\n"
        "Faults of curves: also open_ends; with --strict off_plane and branches.\n"
        "Exit codes: 0 no faults; 1 a fault, or a file that cannot be read; 2 wrong usage.\n"
        "Example:\n"
        "  betamesh check mesh/splash.????.ply --particles 'sim/splash.####.vdb' --radius 0.03");
    command
        ->add_option("MESH", arguments->meshes,
                     "Files with meshes or planar curves (" + extensionsFor(FileKind::mesh, Access::read) +
                         "). Polygons are triangulated. A pattern with a frame number (####) stands for every frame on "
                         "disk, a file with time samples for all of them, - for stdin.")
        ->required();
    addFramesOption(*command, arguments->frames);
    command->add_flag("--json", arguments->json, "Print one JSON object per mesh on stdout, with all components.");
    command->add_flag(
        "--strict", arguments->strict,
        "Also count as faults: triangles without area, unused vertices, several vertices at one position, "
        "and triangles that touch. Without it, these are only reported.");
    command->add_flag("--weld", arguments->weld, "Join vertices at identical positions before the check.");
    command
        ->add_option("--tolerance", arguments->params.tolerance,
                     "Accept crossings that are no deeper than D, and particles no farther outside, in world units.")
        ->type_name("D")
        ->capture_default_str()
        ->check(numberFromZero());
    command->add_option("--examples", arguments->params.examples, "Number of crossings to list, the deepest first.")
        ->type_name("N")
        ->capture_default_str()
        ->check(wholeNumber(0));
    CLI::Option* particles =
        command
            ->add_option("--particles", arguments->particles,
                         "Also check that all these particles are inside the mesh, on it, or in the spheres beside it. "
                         "A frame number (####) in the name is replaced by that of each mesh, which also chooses among "
                         "time samples.")
            ->type_name("IN");
    command
        ->add_option("--radius", arguments->radius,
                     "Ball radius in world units. With it, distances of particles are also given in radii.")
        ->type_name("R")
        ->check(numberAboveZero())
        ->needs(particles);
    addParticleOptions(*command, arguments->input_values);
    addMeshAxisOption(*command, arguments->input_values);
    command->add_option("--scratch", arguments->scratch, "Deprecated, has no effect.")->type_name("FOLDER");
}

}  // namespace betamesh
