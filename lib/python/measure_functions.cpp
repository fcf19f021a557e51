#include "python/functions.h"

#include "betamesh/check.h"
#include "betamesh/coherence.h"
#include "betamesh/error.h"
#include "mesh/enclosure.h"
#include "python/arrays.h"
#include "python/interruptible_call.h"
#include "python/objects.h"

#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace betamesh {
namespace {

constexpr const char* kCheck =
    R"(Checks that a surface of any program is closed, oriented, manifold, finite and free of self-intersections.

All decisions are exact. particles: also checks that these are inside, on the surface, or in surface.spheres; their
positions are relative to surface.origin. tolerance: world units; crossings and distances up to it are no faults.
examples: number of crossings to list. strict: triangles without area, unused vertices, several vertices at one
position, and triangles that touch are faults too.

Returns a dict with the names of `betamesh check --json`: good (bool), faults (list of names), counts, and of a mesh its
components with genus, volume and area.)";

constexpr const char* kCoherence =
    R"(How far the surface moves from one frame to the next.

Returns a dict, in world units: max (largest distance between the surfaces, in both directions; inf if one is empty),
quantile_999 (99.9 % of the area is nearer), rms, worst (where max is), samples. With the particles of both frames,
which are matched by id or by row, also particles (matched, max, farthest) and ratio: max over the largest displacement
of a particle. ignore_thinner: leaves out liquid that is thinner than this.)";

nb::dict dictOf(const FaultCount& found) {
    nb::dict dict;
    dict["count"] = found.count;
    dict["first"] = found ? nb::cast(found.first) : nb::none();
    return dict;
}

nb::dict dictOf(const ComponentCheck& component) {
    nb::dict dict;
    dict["vertices"] = component.vertices;
    dict["edges"] = component.edges;
    dict["triangles"] = component.triangles;
    dict["euler"] = component.euler;
    dict["genus"] = component.genus ? nb::cast(*component.genus) : nb::none();
    dict["closed"] = component.closed;
    dict["volume"] = component.volume;
    dict["area"] = component.area;
    return dict;
}

nb::dict dictOf(const SelfCrossing& crossing) {
    nb::dict dict;
    dict["triangles"] = nb::make_tuple(crossing.first, crossing.second);
    dict["position"] = tupleOf(crossing.position);
    dict["depth"] = crossing.depth;
    dict["coplanar"] = crossing.coplanar;
    return dict;
}

nb::dict dictOf(const EdgeCrossing& crossing) {
    nb::dict dict;
    dict["edges"] = nb::make_tuple(crossing.first, crossing.second);
    dict["position"] = tupleOf(crossing.position);
    dict["depth"] = crossing.depth;
    return dict;
}

template <typename Row>
nb::list listOf(const std::vector<Row>& rows) {
    nb::list list;
    for (const Row& row : rows) list.append(dictOf(row));
    return list;
}

void add(const MeshCheck& check, nb::dict& dict) {
    dict["vertices"] = check.vertices;
    dict["edges"] = check.edges;
    dict["triangles"] = check.triangles;
    dict["components"] = check.components.size();
    dict["euler"] = check.euler;
    dict["volume"] = check.volume;
    dict["area"] = check.area;
    dict["closed"] = check.closed();
    dict["oriented"] = check.oriented();
    dict["edge_manifold"] = check.edgeManifold();
    dict["vertex_manifold"] = check.vertexManifold();
    dict["inside_out"] = check.inside_out;
    dict["not_finite"] = dictOf(check.not_finite);
    dict["velocity_not_finite"] = dictOf(check.velocity_not_finite);
    dict["missing_vertices"] = dictOf(check.missing_vertices);
    dict["repeated_vertices"] = dictOf(check.repeated_vertices);
    dict["duplicates"] = dictOf(check.duplicates);
    dict["open_edges"] = dictOf(check.open_edges);
    dict["misoriented_edges"] = dictOf(check.misoriented_edges);
    dict["nonmanifold_edges"] = dictOf(check.nonmanifold_edges);
    dict["nonmanifold_vertices"] = dictOf(check.nonmanifold_vertices);
    dict["zero_area"] = dictOf(check.zero_area);
    dict["unused_vertices"] = dictOf(check.unused_vertices);
    dict["coincident_vertices"] = dictOf(check.coincident_vertices);
    dict["touching"] = check.touching;
    nb::dict crossings;
    crossings["count"] = check.crossings.count;
    crossings["shallow"] = check.shallow;
    crossings["deepest"] = check.deepest;
    crossings["listed"] = listOf(check.deepest_crossings);
    dict["crossings"] = crossings;
    dict["component"] = listOf(check.components);
}

void add(const CurveCheck& check, nb::dict& dict) {
    dict["dimension"] = 2;
    dict["vertices"] = check.vertices;
    dict["edges"] = check.edges;
    dict["curves"] = check.measure.curves;
    dict["euler"] = check.measure.turning;
    dict["area"] = check.measure.area;
    dict["length"] = check.measure.length;
    dict["closed"] = !check.open_ends;
    dict["inside_out"] = check.inside_out;
    dict["not_finite"] = dictOf(check.not_finite);
    dict["velocity_not_finite"] = dictOf(check.velocity_not_finite);
    dict["repeated_vertices"] = dictOf(check.repeated_vertices);
    dict["open_ends"] = dictOf(check.open_ends);
    dict["branches"] = dictOf(check.branches);
    dict["unused_vertices"] = dictOf(check.unused_vertices);
    dict["off_plane"] = dictOf(check.off_plane);
    nb::dict crossings;
    crossings["count"] = check.crossings.count;
    crossings["deepest"] = check.deepest;
    crossings["listed"] = listOf(check.deepest_crossings);
    dict["crossings"] = crossings;
}

/// What `particles` tells about the particles: how many are outside and how far.
nb::dict outsideOf(const std::vector<double>& distances, double tolerance, std::size_t spheres,
                   const std::vector<Vec3>& points) {
    std::size_t outside = 0, farthest = 0;
    for (std::size_t i = 0; i < distances.size(); ++i) {
        if (!(distances[i] > tolerance)) continue;
        if (outside++ == 0 || distances[i] > distances[farthest]) farthest = i;
    }
    nb::dict dict;
    dict["count"] = distances.size();
    dict["spheres"] = spheres;
    dict["outside"] = outside;
    dict["farthest"] = outside > 0 ? distances[farthest] : 0.0;
    if (outside > 0) {
        dict["farthest_particle"] = farthest;
        dict["farthest_position"] = tupleOf(points[farthest]);
    }
    return dict;
}

const ParticlesObject& particlesArgument(nb::handle value, ParticlesObject& own) {
    if (nb::isinstance<ParticlesObject>(value)) return *nb::inst_ptr<ParticlesObject>(value);
    own = particlesFrom(value, nb::none(), nb::none(), nb::none(), nb::none(), true);
    return own;
}

template <typename Object, typename Surface, typename Check>
nb::dict checked(const Object& object, const Surface& surface, const Check& checkSurface, nb::handle particles,
                 double tolerance, std::size_t examples, bool strict, const CallOptions& options) {
    if (!(tolerance >= 0))
        throw Error("tolerance: '" + std::to_string(tolerance) + "' is not valid. Use a number from 0.");
    std::vector<Vec3> points;
    if (!particles.is_none()) {
        ParticlesObject own;
        for (const Vec3f& p : particlesArgument(particles, own).particles.position) points.emplace_back(p);
    }
    decltype(checkSurface(surface, CheckParams{})) check;
    std::vector<double> distances;
    callInterruptibly(options, [&](const StageBegins&) {
        check = checkSurface(surface, {tolerance, examples});
        if (!points.empty()) distances = distancesOutside(surface, object.spheres.spheres, points);
    });
    std::vector<std::string_view> faults = faultsOf(check, strict);
    nb::dict dict;
    dict["good"] = false;
    nb::list names;
    for (const std::string_view fault : faults) names.append(nb::str(fault.data(), fault.size()));
    add(check, dict);
    if (!particles.is_none()) {
        const nb::dict outside = outsideOf(distances, tolerance, object.spheres.spheres.size(), points);
        if (nb::cast<std::size_t>(outside["outside"]) > 0) names.append("particles_outside");
        dict["particles"] = outside;
    }
    dict["faults"] = names;
    dict["good"] = nb::len(names) == 0;
    return dict;
}

nb::dict check(nb::handle surface, nb::handle particles, double tolerance, std::size_t examples, bool strict,
               nb::handle threads) {
    const CallOptions options = callOptions(threads, nb::none());
    if (nb::isinstance<CurvesObject>(surface)) {
        const auto& object = *nb::inst_ptr<CurvesObject>(surface);
        return checked(
            object, object.curves, [](const Curves& c, const CheckParams& p) { return checkCurves(c, p); }, particles,
            tolerance, examples, strict, options);
    }
    if (!nb::isinstance<MeshObject>(surface))
        throw Error("the surface is neither a betamesh.Mesh nor betamesh.Curves.");
    const auto& object = *nb::inst_ptr<MeshObject>(surface);
    return checked(
        object, object.mesh, [](const Mesh& m, const CheckParams& p) { return checkMesh(m, p); }, particles, tolerance,
        examples, strict, options);
}

nb::dict measure(const MeshObject& object, nb::handle threads) {
    MeshMeasure result;
    callInterruptibly(callOptions(threads, nb::none()), [&](const StageBegins&) { result = measureMesh(object.mesh); });
    nb::dict dict;
    dict["components"] = result.components;
    dict["euler"] = result.euler;
    dict["volume"] = result.volume;
    dict["area"] = result.area;
    dict["closed"] = result.unpaired_edges == 0;
    return dict;
}

/// The second surface relative to the origin of the first one.
Mesh relativeTo(const Vec3& origin, const MeshObject& object) {
    Mesh mesh;
    mesh.triangles = object.mesh.triangles;
    mesh.position = object.mesh.position;
    for (Vec3& p : mesh.position) p += object.origin - origin;
    return mesh;
}

nb::dict coherence(const MeshObject& before, const MeshObject& after, nb::handle particles_before,
                   nb::handle particles_after, double ignore_thinner, nb::handle threads) {
    if (!(ignore_thinner >= 0))
        throw Error("ignore_thinner: '" + std::to_string(ignore_thinner) + "' is not valid. Use a number from 0.");
    if (particles_before.is_none() != particles_after.is_none())
        throw Error(
            "coherence() needs the particles of both frames or of none. Give particles_before and particles_after.");
    ParticlesObject own_before, own_after;
    const ParticlesObject *from = nullptr, *to = nullptr;
    if (!particles_before.is_none()) {
        from = &particlesArgument(particles_before, own_before);
        to = &particlesArgument(particles_after, own_after);
        if (from->origin != to->origin)
            throw Error("the particles of the two frames have different origins. Read both with the same origin.");
    }
    SurfaceDistance distance;
    std::optional<ParticleMotion> motion;
    callInterruptibly(callOptions(threads, nb::none()), [&](const StageBegins&) {
        DistanceSampling sampling;
        sampling.thinner = ignore_thinner;
        const bool same_origin = before.origin == after.origin;
        distance = surfaceDistance(before.mesh, same_origin ? after.mesh : relativeTo(before.origin, after), sampling);
        if (from == nullptr) return;
        motion = particleMotion(from->particles, to->particles);
        if (!motion)
            throw Error(
                "the particles of the two frames cannot be matched: they have no ids, and their numbers differ. "
                "Give particles with ids.");
    });
    nb::dict dict;
    dict["max"] = distance.max;
    dict["quantile_999"] = distance.quantile999;
    dict["rms"] = distance.rms;
    dict["worst"] = tupleOf(distance.worst);
    dict["samples"] = distance.samples;
    if (motion) {
        nb::dict particles;
        particles["matched"] = motion->matched;
        particles["max"] = motion->max;
        particles["farthest"] = tupleOf(motion->farthest);
        dict["particles"] = particles;
        dict["ratio"] = motion->max > 0 ? nb::cast(distance.max / motion->max) : nb::none();
    }
    return dict;
}

}  // namespace

void addMeasureFunctions(nb::module_& module) {
    module.def(
        "check", check, nb::arg("surface"), nb::arg("particles").none() = nb::none(), nb::kw_only(),
        nb::arg("tolerance") = 0.0, nb::arg("examples") = 8, nb::arg("strict") = false,
        nb::arg("threads").none() = nb::none(),
        nb::sig("def check(surface: Mesh | Curves, particles: Particles | numpy.typing.ArrayLike | None = None, *, "
                "tolerance: float = 0.0, examples: int = 8, strict: bool = False, threads: int | None = None) -> "
                "dict[str, typing.Any]"),
        kCheck);
    module.def(
        "measure", measure, nb::arg("mesh"), nb::kw_only(), nb::arg("threads").none() = nb::none(),
        nb::sig("def measure(mesh: Mesh, *, threads: int | None = None) -> dict[str, typing.Any]"),
        "Size of a mesh: components, euler, volume (world units cubed), area (squared) and closed. Much faster than\n"
        "check().");
    module.def(
        "coherence", coherence, nb::arg("before"), nb::arg("after"), nb::arg("particles_before").none() = nb::none(),
        nb::arg("particles_after").none() = nb::none(), nb::kw_only(), nb::arg("ignore_thinner") = 0.0,
        nb::arg("threads").none() = nb::none(),
        nb::sig("def coherence(before: Mesh, after: Mesh, particles_before: Particles | numpy.typing.ArrayLike | "
                "None = None, particles_after: Particles | numpy.typing.ArrayLike | None = None, *, ignore_thinner: "
                "float = 0.0, threads: int | None = None) -> dict[str, typing.Any]"),
        kCoherence);
}

}  // namespace betamesh
