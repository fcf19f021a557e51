#include "python/functions.h"

#include "base/nearest_word.h"
#include "betamesh/error.h"
#include "betamesh/io.h"
#include "io/particle_file.h"
#include "io/particle_input.h"
#include "python/arrays.h"
#include "python/interruptible_call.h"
#include "python/objects.h"

#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace betamesh {
namespace {

namespace fs = std::filesystem;

/// Reads or writes in another thread, so that Python goes on.
template <typename Work>
void doFileWork(const Work& work) {
    callInterruptibly({}, [&](const StageBegins&) { work(); });
}

template <typename Choice>
Choice chosen(const char* name, const std::string& word, const std::vector<std::pair<std::string, Choice>>& choices) {
    std::string words;
    std::vector<std::string> names;
    for (const auto& [choice, value] : choices) {
        if (choice == word) return value;
        words += (words.empty() ? "" : ", ") + choice;
        names.push_back(choice);
    }
    throw Error(std::string(name) + ": '" + word + "' is not valid. Use one of " + words + "." +
                didYouMean(word, names));
}

nb::object readParticlesOf(const fs::path& path, const std::string& velocity, const std::string& id,
                           const std::string& where, const std::optional<std::array<double, 6>>& box,
                           const std::vector<std::string>& group, const std::vector<std::string>& grid,
                           const std::string& on_bad_particle, double scale, double velocity_scale, double time_scale,
                           const std::string& up_axis, nb::object origin) {
    ParticleInput input;
    input.velocity = velocity;
    input.id = id;
    input.where = where;
    input.box = box;
    input.group = group;
    input.grid = grid;
    input.on_bad_particle = chosen<OnBadParticle>("on_bad_particle", on_bad_particle,
                                                  {{"error", OnBadParticle::error}, {"drop", OnBadParticle::drop}});
    input.up_axis = chosen<UpAxis>("up_axis", up_axis, {{"y", UpAxis::y}, {"z", UpAxis::z}});
    for (const auto& [name, factor] : {std::pair("scale", scale), std::pair("time_scale", time_scale)})
        if (!(factor > 0) || !std::isfinite(factor))
            throw Error(std::string(name) + ": '" + std::to_string(factor) + "' is not valid. Use a number above 0.");
    if (!std::isfinite(velocity_scale)) throw Error("velocity_scale is not finite. Use a number.");
    input.scale = scale;
    input.velocity_scale = velocity_scale;
    input.time_scale = time_scale;
    const std::optional<Vec3> given = givenOrigin(origin);
    ParticlesObject object;
    doFileWork([&] {
        input.origin = given ? *given : localOriginOf(path).value_or(Vec3(0, 0, 0));
        object.particles = readParticles(path, input);
    });
    object.origin = worldOrigin(input);
    return nb::cast(std::move(object));
}

nb::object readMeshOf(const fs::path& path) {
    MeshObject object;
    doFileWork([&] { object.mesh = readMesh(path); });
    return nb::cast(std::move(object));
}

nb::object readCurvesOf(const fs::path& path) {
    CurvesObject object;
    doFileWork([&] { object.curves = readCurves(path); });
    return nb::cast(std::move(object));
}

void writeMeshTo(const fs::path& path, nb::handle surface) {
    if (nb::isinstance<CurvesObject>(surface)) {
        doFileWork([&] { writeCurves(path, nb::inst_ptr<CurvesObject>(surface)->curves); });
        return;
    }
    if (!nb::isinstance<MeshObject>(surface))
        throw Error("the surface is neither a betamesh.Mesh nor betamesh.Curves.");
    doFileWork([&] { writeMesh(path, nb::inst_ptr<MeshObject>(surface)->mesh); });
}

}  // namespace

void addFileFunctions(nb::module_& module) {
    module.def(
        "read_particles", readParticlesOf, nb::arg("path"), nb::kw_only(), nb::arg("velocity") = "", nb::arg("id") = "",
        nb::arg("where") = "", nb::arg("box").none() = nb::none(), nb::arg("group") = nb::make_tuple(),
        nb::arg("grid") = nb::make_tuple(), nb::arg("on_bad_particle") = "error", nb::arg("scale") = 1.0,
        nb::arg("velocity_scale") = 1.0, nb::arg("time_scale") = 1.0, nb::arg("up_axis") = "y",
        nb::arg("origin").none() = "auto",
        nb::sig(
            "def read_particles(path: str | os.PathLike[str], *, velocity: str = '', id: str = '', where: str = '', "
            "box: "
            "collections.abc.Sequence[float] | None = None, group: collections.abc.Sequence[str] = (), grid: "
            "collections.abc.Sequence[str] = (), on_bad_particle: str = 'error', scale: float = 1.0, velocity_scale: "
            "float = 1.0, time_scale: float = 1.0, up_axis: str = 'y', origin: str | collections.abc.Sequence[float] | "
            "None = 'auto') -> Particles"),
        "Reads a particle file in the format of its extension: .vdb, .bgeo, .ply, .vtk, .csv and others.\n\n"
        "The arguments are the keys `input.…` of pipeline files: attributes that hold velocity and id (empty: the "
        "usual\n"
        "names), which particles are chosen (where: a condition such as \"type == 1\"; box: lowest x y z and highest x "
        "y z;\n"
        "group; grid), units, and the axis of the file that becomes y. origin: subtracted in double precision, units "
        "of the\n"
        "file; \"auto\": zero, unless single precision would lose positions that are stored in double precision.\n\n"
        "Raises OSError if the system refuses to read the file, ValueError if it is damaged, has an unknown extension, "
        "or\n"
        "has a particle that is not finite (on_bad_particle=\"drop\" leaves those out).");
    module.def("read_mesh", readMeshOf, nb::arg("path"), nb::sig("def read_mesh(path: str | os.PathLike[str]) -> Mesh"),
               "Reads a mesh of any program in the format of its extension. Polygons become fans of triangles.\n\n"
               "Raises OSError if the system refuses to read the file, ValueError if it is damaged or has no mesh.");
    module.def("read_curves", readCurvesOf, nb::arg("path"),
               nb::sig("def read_curves(path: str | os.PathLike[str]) -> Curves"),
               "Reads the edges of a .ply, open polygons of Houdini's formats, lines of .obj and of VTK's formats.\n\n"
               "Raises OSError if the system refuses to read the file, ValueError if it is damaged or has no curves.");
    module.def(
        "write_mesh", writeMeshTo, nb::arg("path"), nb::arg("surface"),
        nb::sig("def write_mesh(path: str | os.PathLike[str], surface: Mesh | Curves) -> None"),
        "Writes a mesh or curves in the format of the extension: the same bytes as the program for the same "
        "settings.\n\n"
        "A file of that name is replaced; it appears when it is complete. Velocities are always written, zeros if "
        "there are\n"
        "none. Positions are relative to surface.origin, and surface.spheres are not written, see write_spheres().\n\n"
        "Raises OSError if the system refuses to write the file, ValueError for an unknown extension.");
    module.def(
        "write_spheres",
        [](const fs::path& path, const SpheresObject& object) {
            doFileWork([&] { writeSpheres(path, object.spheres); });
        },
        nb::arg("path"), nb::arg("spheres"),
        nb::sig("def write_spheres(path: str | os.PathLike[str], spheres: Spheres) -> None"),
        "Writes points with a radius, velocity and id, in a format that holds them, such as .ply or .bgeo.\n\n"
        "Raises OSError if the system refuses to write the file, ValueError for another extension.");
    module.def(
        "write_particles",
        [](const fs::path& path, const ParticlesObject& object) {
            doFileWork([&] { writeParticles(path, object.particles); });
        },
        nb::arg("path"), nb::arg("particles"),
        nb::sig("def write_particles(path: str | os.PathLike[str], particles: Particles) -> None"),
        "Writes particles in the format of the extension. Positions are relative to particles.origin.\n\n"
        "Raises OSError if the system refuses to write the file, ValueError for an unknown extension.");
}

}  // namespace betamesh
