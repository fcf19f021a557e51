#include "python/objects.h"

#include "base/box.h"
#include "base/local_origin.h"
#include "betamesh/error.h"
#include "mesh/normals.h"
#include "python/arrays.h"

#include <array>
#include <cmath>
#include <string>

namespace betamesh {
namespace {

std::string counted(std::size_t n, const char* what) { return std::to_string(n) + ' ' + what; }

/// A read-only property that is given the object as Python knows it, which owns the arrays.
template <typename Object, typename Get>
void addProperty(nb::class_<Object>& type, const char* name, const char* signature, const char* text, const Get& get) {
    type.def_prop_ro(
        name, [get](nb::handle_t<Object> self) -> nb::object { return get(*nb::inst_ptr<Object>(self), self); },
        nb::sig(signature), text);
}

nb::object orNone(bool is_there, const nb::object& value) { return is_there ? value : nb::none(); }

nb::object idsOrNone(const std::vector<std::uint64_t>& ids, nb::handle owner) {
    return ids.empty() ? nb::none() : arrayOf(std::span(ids), owner);
}

std::span<const std::uint32_t> numbersOf(const std::vector<Triangle>& triangles) {
    return {triangles.empty() ? nullptr : triangles[0].data(), 3 * triangles.size()};
}
std::span<const std::uint32_t> numbersOf(const std::vector<Edge>& edges) {
    return {edges.empty() ? nullptr : edges[0].data(), 2 * edges.size()};
}

Vec3 originFor(const std::vector<Vec3f>& positions) {
    Box box;
    std::size_t finite = 0;
    for (const Vec3f& p : positions) {
        if (!isFinite(p)) continue;
        box.extendBy(Vec3(p));
        ++finite;
    }
    return finite > 0 ? localOrigin(box, finite) : Vec3(0, 0, 0);
}

void requireRows(const char* name, std::size_t rows, std::size_t n, const char* of_what) {
    if (rows == n) return;
    throw Error(std::string(name) + " has " + counted(rows, "rows") + ", but there are " + counted(n, of_what) + '.');
}

/// What all surfaces of particles report.
template <typename Object>
nb::dict lengthsOf(const Object& surface) {
    nb::dict dict;
    dict["particles"] = surface.counts->particles;
    dict["distinct_particles"] = surface.counts->distinct_particles;
    dict["radius"] = surface.lengths.radius;
    dict["spacing"] = surface.lengths.spacing;
    dict["skin"] = surface.lengths.skin;
    dict["alpha_vertices"] = surface.counts->alpha_vertices;
    dict["isolated_particles"] = surface.counts->isolated_particles;
    dict["droplets"] = surface.counts->droplets;
    dict["droplet_particles"] = surface.counts->droplet_particles;
    dict["bubbles_filled"] = surface.counts->bubbles_filled;
    dict["spheres"] = surface.spheres.spheres.size();
    return dict;
}

nb::object reportOf(const MeshObject& object) {
    if (!object.counts) return nb::none();
    const SkinReport& counts = *object.counts;
    nb::dict dict = lengthsOf(object);
    dict["perturbation_retries"] = counts.perturbation_retries;
    dict["alpha_triangles"] = counts.alpha_triangles;
    dict["double_sided_triangles"] = counts.double_sided_triangles;
    dict["degenerate_edges"] = counts.degenerate_edges;
    dict["tendril_particles"] = counts.tendril_particles;
    dict["crossings"] = counts.crossings;
    dict["vertices"] = object.mesh.position.size();
    dict["triangles"] = object.mesh.triangles.size();
    return dict;
}

nb::object reportOf(const CurvesObject& object) {
    if (!object.counts) return nb::none();
    nb::dict dict = lengthsOf(object);
    dict["alpha_segments"] = object.counts->alpha_segments;
    dict["double_sided_segments"] = object.counts->double_sided_segments;
    dict["vertices"] = object.curves.position.size();
    dict["edges"] = object.curves.edges.size();
    return dict;
}

void initMesh(MeshObject* self, nb::handle vertices, nb::handle triangles, nb::handle velocities,
              nb::handle attributes) {
    Mesh mesh;
    mesh.position = doubleVectorsFrom("vertices", vertices);
    const std::size_t n = mesh.position.size();
    const std::vector<std::uint32_t> corners = indicesFrom("triangles", triangles, 3, n);
    mesh.triangles.resize(corners.size() / 3);
    for (std::size_t i = 0; i < corners.size(); ++i) mesh.triangles[i / 3][i % 3] = corners[i];
    if (!velocities.is_none()) {
        mesh.velocity = doubleVectorsFrom("velocities", velocities);
        requireRows("velocities", mesh.velocity.size(), n, "vertices");
    }
    mesh.attributes = attributesFrom(attributes, n);
    new (self) MeshObject{std::move(mesh)};
}

void addParticles(nb::module_& module) {
    nb::class_<ParticlesObject> type(module, "Particles",
                                     "Particles of one frame. All arrays are read-only and have n rows.");
    type.def(
        "__init__",
        [](ParticlesObject* self, nb::object positions, nb::object velocities, nb::object ids, nb::object attributes,
           nb::object origin) {
            new (self) ParticlesObject(particlesFrom(positions, velocities, ids, attributes, origin));
        },
        nb::arg("positions"), nb::arg("velocities").none() = nb::none(), nb::kw_only(),
        nb::arg("ids").none() = nb::none(), nb::arg("attributes").none() = nb::none(),
        nb::arg("origin").none() = "auto",
        nb::sig(
            "def __init__(self, positions: numpy.typing.ArrayLike, velocities: numpy.typing.ArrayLike | None = None, "
            "*, ids: numpy.typing.ArrayLike | None = None, attributes: "
            "collections.abc.Mapping[str, numpy.typing.ArrayLike] | None = None, origin: "
            "str | collections.abc.Sequence[float] | None = 'auto') -> None"),
        "Copies arrays. Their types and shapes are those of betamesh.skin().");
    type.def("__len__", [](const ParticlesObject& self) { return self.particles.size(); });
    type.def("__repr__", [](const ParticlesObject& self) {
        return "<betamesh.Particles: " + counted(self.particles.size(), "particles>");
    });
    addProperty(
        type, "positions", "def positions(self) -> numpy.typing.NDArray[numpy.float32]",
        "Centres, float32 of shape (n, 3), world units, relative to origin.",
        [](const ParticlesObject& o, nb::handle self) { return arrayOf(std::span(o.particles.position), self); });
    addProperty(type, "velocities", "def velocities(self) -> numpy.typing.NDArray[numpy.float32] | None",
                "World units per second, float32 of shape (n, 3); None if unknown.",
                [](const ParticlesObject& o, nb::handle self) {
                    return orNone(!o.particles.velocity.empty() || o.particles.size() == 0,
                                  arrayOf(std::span(o.particles.velocity), self));
                });
    addProperty(type, "ids", "def ids(self) -> numpy.typing.NDArray[numpy.uint64] | None",
                "The same particle has the same id in every frame, uint64 of shape (n,); None if unknown.",
                [](const ParticlesObject& o, nb::handle self) { return idsOrNone(o.particles.id, self); });
    addProperty(type, "attributes", "def attributes(self) -> dict[str, numpy.typing.NDArray[typing.Any]]",
                "All other attributes by name, float32 or int32 of shape (n,) or (n, components).",
                [](const ParticlesObject& o, nb::handle self) { return dictOf(o.particles.attributes, self); });
    addProperty(type, "origin", "def origin(self) -> tuple[float, float, float]",
                "What was subtracted from the positions in double precision, world units. positions + origin are the "
                "coordinates of the input.",
                [](const ParticlesObject& o, nb::handle) { return tupleOf(o.origin); });
}

void addSpheres(nb::module_& module) {
    nb::class_<SpheresObject> type(module, "Spheres",
                                   "Particles that are not part of a surface: what droplets=\"points\" and "
                                   "tendrils=\"points\" leave out of it, and with the paper's tessellation isolated "
                                   "particles and ends of threads. All arrays are read-only and have n rows.");
    type.def("__len__", [](const SpheresObject& self) { return self.spheres.size(); });
    type.def("__repr__", [](const SpheresObject& self) {
        return "<betamesh.Spheres: " + counted(self.spheres.size(), "spheres>");
    });
    addProperty(type, "positions", "def positions(self) -> numpy.typing.NDArray[numpy.float32]",
                "Centres, float32 of shape (n, 3), world units.", [](SpheresObject& o, nb::handle self) {
                    return arrayOf(std::span(o.position.of(o.spheres.position)), self);
                });
    addProperty(type, "radii", "def radii(self) -> numpy.typing.NDArray[numpy.float32]",
                "World units, float32 of shape (n,).",
                [](const SpheresObject& o, nb::handle self) { return arrayOf(std::span(o.spheres.radius), 1, self); });
    addProperty(type, "velocities", "def velocities(self) -> numpy.typing.NDArray[numpy.float32] | None",
                "World units per second, float32 of shape (n, 3); None if the particles have none.",
                [](SpheresObject& o, nb::handle self) {
                    return orNone(!o.spheres.velocity.empty(),
                                  arrayOf(std::span(o.velocity.of(o.spheres.velocity)), self));
                });
    addProperty(type, "ids", "def ids(self) -> numpy.typing.NDArray[numpy.uint64] | None",
                "Ids of the particles, uint64 of shape (n,); None if they have none.",
                [](const SpheresObject& o, nb::handle self) { return idsOrNone(o.spheres.id, self); });
    addProperty(
        type, "particles", "def particles(self) -> numpy.typing.NDArray[numpy.uint32]",
        "Row of each particle in the input, uint32 of shape (n,).",
        [](const SpheresObject& o, nb::handle self) { return arrayOf(std::span(o.spheres.particle), 1, self); });
    addProperty(type, "attributes", "def attributes(self) -> dict[str, numpy.typing.NDArray[typing.Any]]",
                "Attributes of the particles by name, float32 or int32 of shape (n,) or (n, components).",
                [](const SpheresObject& o, nb::handle self) { return dictOf(o.spheres.attributes, self); });
}

/// Properties that meshes and curves share. surfaceOf(object): its Mesh or Curves.
template <typename Object, typename SurfaceOf>
void addSurfaceProperties(nb::class_<Object>& type, const SurfaceOf& surfaceOf) {
    addProperty(
        type, "vertices", "def vertices(self) -> numpy.typing.NDArray[numpy.float32]",
        "Positions, float32 of shape (n, 3), world units, relative to origin; rounded as in files.",
        [=](Object& o, nb::handle self) { return arrayOf(std::span(o.position.of(surfaceOf(o).position)), self); });
    addProperty(type, "velocities", "def velocities(self) -> numpy.typing.NDArray[numpy.float32] | None",
                "World units per second, float32 of shape (n, 3); None if the particles have none.",
                [=](Object& o, nb::handle self) {
                    const auto& surface = surfaceOf(o);
                    return orNone(!surface.velocity.empty(), arrayOf(std::span(o.velocity.of(surface.velocity)), self));
                });
    addProperty(type, "attributes", "def attributes(self) -> dict[str, numpy.typing.NDArray[typing.Any]]",
                "Attributes of vertices by name, float32 or int32 of shape (n,) or (n, components).",
                [=](Object& o, nb::handle self) { return dictOf(surfaceOf(o).attributes, self); });
    type.def_prop_ro(
        "spheres", [](Object& o) -> SpheresObject& { return o.spheres; }, nb::rv_policy::reference_internal,
        "Particles that are not part of the surface.");
    addProperty(type, "origin", "def origin(self) -> tuple[float, float, float]",
                "World units. vertices + origin, in double precision, are in the coordinates of the input.",
                [](const Object& o, nb::handle) { return tupleOf(o.origin); });
    addProperty(
        type, "report", "def report(self) -> dict[str, float] | None",
        "Counts and lengths by name, as in the manifest beside a mesh: particles, radius, spacing, skin, droplets "
        "and so on. None unless the surface was made by this module.",
        [](const Object& o, nb::handle) { return reportOf(o); });
}

void addMesh(nb::module_& module) {
    nb::class_<MeshObject> type(
        module, "Mesh",
        "A triangle mesh of n vertices and m triangles. All arrays are read-only and stay valid "
        "when the mesh is gone.");
    type.def("__init__", initMesh, nb::arg("vertices"), nb::arg("triangles"), nb::arg("velocities").none() = nb::none(),
             nb::arg("attributes").none() = nb::none(),
             nb::sig("def __init__(self, vertices: numpy.typing.ArrayLike, triangles: numpy.typing.ArrayLike, "
                     "velocities: numpy.typing.ArrayLike | None = None, attributes: "
                     "collections.abc.Mapping[str, numpy.typing.ArrayLike] | None = None) -> None"),
             "A mesh of any origin, to be checked or written. Arrays are copied.");
    type.def("__repr__", [](const MeshObject& self) {
        return "<betamesh.Mesh: " + counted(self.mesh.position.size(), "vertices, ") +
               counted(self.mesh.triangles.size(), "triangles>");
    });
    addSurfaceProperties(type, [](MeshObject& o) -> Mesh& { return o.mesh; });
    addProperty(type, "triangles", "def triangles(self) -> numpy.typing.NDArray[numpy.uint32]",
                "Vertices of each triangle, counter-clockwise seen from outside, uint32 of shape (m, 3).",
                [](const MeshObject& o, nb::handle self) { return arrayOf(numbersOf(o.mesh.triangles), 3, self); });
    addProperty(type, "normals", "def normals(self) -> numpy.typing.NDArray[numpy.float32]",
                "Unit normals of vertices, outwards, float32 of shape (n, 3): those fitted to the "
                "surface if the mesh has the attribute N, else means over the triangles, weighted by their "
                "angles, and zero at vertices without triangles. Computed on first use.",
                [](MeshObject& o, nb::handle self) {
                    if (!o.normals) o.normals = rounded(normalsOf(o.mesh));
                    return arrayOf(std::span(*o.normals), self);
                });
    addProperty(type, "components", "def components(self) -> numpy.typing.NDArray[numpy.int32] | None",
                "Connected component of each triangle, the largest first, int32 of shape (m,); None unless asked for.",
                [](const MeshObject& o, nb::handle self) {
                    return o.mesh.component ? arrayOf(std::span(*o.mesh.component), 1, self) : nb::none();
                });
}

void addCurves(nb::module_& module) {
    nb::class_<CurvesObject> type(
        module, "Curves",
        "Closed curves of n vertices and m edges in a plane. All arrays are read-only and stay "
        "valid when the curves are gone.");
    type.def("__repr__", [](const CurvesObject& self) {
        return "<betamesh.Curves: " + counted(self.curves.position.size(), "vertices, ") +
               counted(self.curves.edges.size(), "edges>");
    });
    addSurfaceProperties(type, [](CurvesObject& o) -> Curves& { return o.curves; });
    addProperty(type, "edges", "def edges(self) -> numpy.typing.NDArray[numpy.uint32]",
                "Both vertices of each edge, with the liquid on the left, uint32 of shape (m, 2).",
                [](const CurvesObject& o, nb::handle self) { return arrayOf(numbersOf(o.curves.edges), 2, self); });
}

}  // namespace

const std::vector<Vec3f>& RoundedVectors::of(const std::vector<Vec3>& vectors) {
    if (!rounded_) rounded_ = rounded(vectors);
    return *rounded_;
}

void addTypes(nb::module_& module) {
    addParticles(module);
    addSpheres(module);
    addMesh(module);
    addCurves(module);
}

std::optional<Vec3> givenOrigin(nb::handle origin) {
    if (nb::isinstance<nb::str>(origin) && nb::cast<std::string>(origin) == "auto") return std::nullopt;
    if (origin.is_none()) return Vec3(0, 0, 0);
    std::array<double, 3> xyz{};
    if (!nb::try_cast(nb::borrow(origin), xyz) || !std::isfinite(xyz[0] + xyz[1] + xyz[2]))
        throw Error("origin: '" + textOf(origin) + "' is not valid. Use \"auto\", None or three numbers.");
    return Vec3(xyz[0], xyz[1], xyz[2]);
}

ParticlesObject particlesFrom(nb::handle positions, nb::handle velocities, nb::handle ids, nb::handle attributes,
                              nb::handle origin, bool in_plane) {
    ParticlesObject object;
    Particles& particles = object.particles;
    const std::optional<Vec3> given = givenOrigin(origin);
    object.origin = given.value_or(Vec3(0, 0, 0));
    particles.position = vectorsFrom("positions", positions, object.origin, in_plane);
    if (!given && isDouble(positions)) {
        object.origin = originFor(particles.position);
        if (object.origin != Vec3(0, 0, 0))
            particles.position = vectorsFrom("positions", positions, object.origin, in_plane);
    }
    const std::size_t n = particles.size();
    if (!velocities.is_none()) {
        particles.velocity = vectorsFrom("velocities", velocities, {0, 0, 0}, in_plane);
        requireRows("velocities", particles.velocity.size(), n, "positions");
    }
    if (!ids.is_none()) {
        particles.id = idsFrom("ids", ids);
        requireRows("ids", particles.id.size(), n, "positions");
    }
    particles.attributes = attributesFrom(attributes, n);
    validate(particles);
    return object;
}

}  // namespace betamesh
