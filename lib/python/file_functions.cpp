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

UpAxis upAxis(const std::string& word) { return chosen<UpAxis>("up_axis", word, {{"y", UpAxis::y}, {"z", UpAxis::z}}); }

void requireFactor(const char* name, double factor) {
    if (factor > 0 && std::isfinite(factor)) return;
    throw Error(std::string(name) + ": '" + std::to_string(factor) + "' is not valid. Use a number above 0.");
}

WriteOptions writeOptions(const std::optional<int>& frame, double frames_per_second, const std::string& up_axis,
                          double meters_per_unit) {
    requireFactor("frames_per_second", frames_per_second);
    requireFactor("meters_per_unit", meters_per_unit);
    return {frames_per_second, frame, upAxis(up_axis), meters_per_unit};
}

/// One name, or several.
std::vector<std::string> namesFrom(nb::handle value) {
    if (nb::isinstance<nb::str>(value)) return {nb::cast<std::string>(value)};
    return nb::cast<std::vector<std::string>>(value);
}

/// errors  a frame that is not finite
std::optional<double> timeOf(const std::optional<double>& frame) {
    if (frame && !std::isfinite(*frame)) throw Error("frame is not finite. Use a number, or None.");
    return frame;
}

constexpr const char* kReadParticles =
    R"(Reads a particle file in the format of its extension: .vdb, .bgeo, .ply, .vtk, .csv and others.

The arguments are the keys `input.…` of pipeline files. velocity, id: attributes that hold them; empty: the usual names.
where, box, group, grid: which particles are chosen, as by the condition "type == 1", by the lowest x y z and the highest
x y z, or by one name or several. scale, velocity_scale, time_scale: units. up_axis: the axis of the file that becomes y.
origin: subtracted in double precision, in units of the file; "auto": zero, unless single precision would lose positions
that are stored in double precision. frame: of a .usda or .abc with time samples, the latest sample until then; None: the
frame in the name of the file, or the first.

Raises OSError if the system refuses to read the file, ValueError if it is damaged, has an unknown extension, or has a
particle that is not finite (on_bad_particle="drop" leaves those out).)";

nb::object readParticlesOf(const fs::path& path, const std::string& velocity, const std::string& id,
                           const std::string& where, const std::optional<std::array<double, 6>>& box, nb::object group,
                           nb::object grid, const std::string& on_bad_particle, double scale, double velocity_scale,
                           double time_scale, const std::string& up_axis, nb::object origin,
                           const std::optional<double>& frame) {
    ParticleInput input;
    input.velocity = velocity;
    input.id = id;
    input.where = where;
    input.box = box;
    input.group = namesFrom(group);
    input.grid = namesFrom(grid);
    input.on_bad_particle = chosen<OnBadParticle>("on_bad_particle", on_bad_particle,
                                                  {{"error", OnBadParticle::error}, {"drop", OnBadParticle::drop}});
    input.up_axis = upAxis(up_axis);
    requireFactor("scale", scale);
    requireFactor("time_scale", time_scale);
    if (!std::isfinite(velocity_scale)) throw Error("velocity_scale is not finite. Use a number.");
    input.frame = timeOf(frame);
    input.scale = scale;
    input.velocity_scale = velocity_scale;
    input.time_scale = time_scale;
    const std::optional<Vec3> given = givenOrigin(origin);
    ParticlesObject object;
    doFileWork([&] {
        input.origin = given ? *given : localOriginOf(path, frame).value_or(Vec3(0, 0, 0));
        object.particles = readParticles(path, input);
    });
    object.origin = worldOrigin(input, UpAxis::y);
    return nb::cast(std::move(object));
}

nb::object readMeshOf(const fs::path& path, const std::optional<double>& frame) {
    MeshObject object;
    doFileWork([&] { object.mesh = readMesh(path, timeOf(frame)); });
    return nb::cast(std::move(object));
}

nb::object readCurvesOf(const fs::path& path, const std::optional<double>& frame) {
    CurvesObject object;
    doFileWork([&] { object.curves = readCurves(path, timeOf(frame)); });
    return nb::cast(std::move(object));
}

void writeMeshTo(const fs::path& path, nb::handle surface, const std::optional<int>& frame, double frames_per_second,
                 const std::string& up_axis, double meters_per_unit) {
    const WriteOptions options = writeOptions(frame, frames_per_second, up_axis, meters_per_unit);
    if (nb::isinstance<CurvesObject>(surface)) {
        doFileWork([&] { writeCurves(path, nb::inst_ptr<CurvesObject>(surface)->curves, options); });
        return;
    }
    if (!nb::isinstance<MeshObject>(surface))
        throw Error("the surface is neither a betamesh.Mesh nor betamesh.Curves.");
    doFileWork([&] { writeMesh(path, nb::inst_ptr<MeshObject>(surface)->mesh, options); });
}

void writeSpheresTo(const fs::path& path, const SpheresObject& object, const std::optional<int>& frame,
                    double frames_per_second, const std::string& up_axis, double meters_per_unit) {
    const WriteOptions options = writeOptions(frame, frames_per_second, up_axis, meters_per_unit);
    doFileWork([&] { writeSpheres(path, object.spheres, options); });
}

void writeParticlesTo(const fs::path& path, const ParticlesObject& object, const std::optional<int>& frame,
                      double frames_per_second, const std::string& up_axis, double meters_per_unit) {
    const WriteOptions options = writeOptions(frame, frames_per_second, up_axis, meters_per_unit);
    doFileWork([&] { writeParticles(path, object.particles, options); });
}

/// Adds a function that writes its second argument, which has this name and type.
template <typename Write>
void addWriter(nb::module_& module, const char* name, const char* argument, const std::string& type, const Write& write,
               const char* text) {
    const std::string signature =
        "def " + std::string(name) + "(path: str | os.PathLike[str], " + argument + ": " + type +
        ", *, frame: int | None = None, frames_per_second: float = 24.0, up_axis: str = 'y', meters_per_unit: float = "
        "1.0) -> None";
    module.def(name, write, nb::arg("path"), nb::arg(argument), nb::kw_only(), nb::arg("frame").none() = nb::none(),
               nb::arg("frames_per_second") = 24.0, nb::arg("up_axis") = "y", nb::arg("meters_per_unit") = 1.0,
               nb::sig(signature.c_str()), text);
}

}  // namespace

void addFileFunctions(nb::module_& module) {
    module.def(
        "read_particles", readParticlesOf, nb::arg("path"), nb::kw_only(), nb::arg("velocity") = "", nb::arg("id") = "",
        nb::arg("where") = "", nb::arg("box").none() = nb::none(), nb::arg("group") = nb::make_tuple(),
        nb::arg("grid") = nb::make_tuple(), nb::arg("on_bad_particle") = "error", nb::arg("scale") = 1.0,
        nb::arg("velocity_scale") = 1.0, nb::arg("time_scale") = 1.0, nb::arg("up_axis") = "y",
        nb::arg("origin").none() = "auto", nb::arg("frame").none() = nb::none(),
        nb::sig(
            "def read_particles(path: str | os.PathLike[str], *, velocity: str = '', id: str = '', where: str = '', "
            "box: "
            "collections.abc.Sequence[float] | None = None, group: collections.abc.Sequence[str] = (), grid: "
            "collections.abc.Sequence[str] = (), on_bad_particle: str = 'error', scale: float = 1.0, velocity_scale: "
            "float = 1.0, time_scale: float = 1.0, up_axis: str = 'y', origin: str | collections.abc.Sequence[float] | "
            "None = 'auto', frame: float | None = None) -> Particles"),
        kReadParticles);
    module.def("read_mesh", readMeshOf, nb::arg("path"), nb::kw_only(), nb::arg("frame").none() = nb::none(),
               nb::sig("def read_mesh(path: str | os.PathLike[str], *, frame: float | None = None) -> Mesh"),
               "Reads a mesh of any program in the format of its extension. Polygons become fans of triangles.\n\n"
               "frame: as of read_particles(). "
               "Raises OSError if the system refuses to read the file, ValueError if it is damaged or has no mesh.");
    module.def("read_curves", readCurvesOf, nb::arg("path"), nb::kw_only(), nb::arg("frame").none() = nb::none(),
               nb::sig("def read_curves(path: str | os.PathLike[str], *, frame: float | None = None) -> Curves"),
               "Reads the edges of a .ply, open polygons of Houdini's formats, lines of .obj and of VTK's formats.\n\n"
               "frame: as of read_particles(). "
               "Raises OSError if the system refuses to read the file, ValueError if it is damaged or has no curves.");
    addWriter(
        module, "write_mesh", "surface", "Mesh | Curves", writeMeshTo,
        "Writes a mesh or curves in the format of the extension: the bytes of the program for the same settings.\n\n"
        "A file of that name is replaced; it appears when it is complete. Velocities are always written, zeros if\n"
        "there are none. Positions are relative to surface.origin, and surface.spheres are not written, see\n"
        "write_spheres(). up_axis \"z\": rotates as it writes, (x, y, z) becomes (x, -z, y). frame,\n"
        "frames_per_second and meters_per_unit are stored by formats with a place for them.\n\n"
        "Raises OSError if the system refuses to write the file, ValueError for an unknown extension.");
    addWriter(module, "write_spheres", "spheres", "Spheres", writeSpheresTo,
              "Writes points with a radius, velocity and id, in a format that holds them, such as .ply or .bgeo.\n\n"
              "The other arguments are those of write_mesh(). Raises OSError if the system refuses to write the file,\n"
              "ValueError for another extension.");
    addWriter(module, "write_particles", "particles", "Particles", writeParticlesTo,
              "Writes particles in the format of the extension. Positions are relative to particles.origin.\n\n"
              "The other arguments are those of write_mesh(). Raises OSError if the system refuses to write the file,\n"
              "ValueError for an unknown extension.");
}

}  // namespace betamesh
