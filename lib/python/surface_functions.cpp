#include "python/functions.h"

#include "batch/config/key_tables.h"
#include "batch/config/surface_params.h"
#include "batch/job/plane.h"
#include "betamesh/error.h"
#include "betamesh/simplify.h"
#include "betamesh/skin.h"
#include "python/arrays.h"
#include "python/interruptible_call.h"
#include "python/objects.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace betamesh {
namespace {

constexpr const char* kSimplify =
    R"(The mesh with fewer triangles where it is flat.

tolerance: world units; no point of either surface is farther from the other one. The vertices that are left keep their
position, velocity and attributes. The topology is the same, and no triangles cross that did not before.)";

constexpr const char* kSpacing =
    R"(The particle spacing dx, world units: the most frequent distance between neighbours, in all frames together.

frames: positions of shape (n, 3) or (n, 2), or betamesh.Particles; the first, a middle and the last frame of a sequence
are enough. dimension: 3, or 2 for particles in a plane. Returns None if no frame has seven distinct particles.)";

/// The keys of pipeline files that shape a surface.
const std::vector<ConfigKey>& surfaceKeys() {
    static const std::vector<ConfigKey> keys = [] {
        std::vector<ConfigKey> all;
        for (const auto& add :
             {addSurfaceKeys, addPerturbationKeys, addSmoothingKeys, addFeaturesKeys, addSurfaceOutputKeys})
            add(all);
        return all;
    }();
    return keys;
}

/// An argument: its name in Python, the key that it sets, and the value as text.
struct Setting {
    std::string argument, key, value;
};

std::vector<Setting> settingsFrom(const nb::list& rows) {
    std::vector<Setting> settings;
    for (const nb::handle row : rows)
        settings.push_back(
            {nb::cast<std::string>(row[0]), nb::cast<std::string>(row[1]), nb::cast<std::string>(row[2])});
    return settings;
}

Config configFrom(const std::vector<Setting>& settings) {
    Config config;
    for (const Setting& setting : settings) {
        const auto& keys = surfaceKeys();
        const auto key =
            std::find_if(keys.begin(), keys.end(), [&](const ConfigKey& k) { return k.path == setting.key; });
        try {
            key->set(config, setting.value);
        } catch (const Error& error) {
            throw Error(setting.argument + ": " + error.what());
        }
    }
    return config;
}

/// Everything that a surface is computed from.
struct SurfaceCall {
    ParticlesObject own;                 ///< of arrays
    const ParticlesObject* particles{};  ///< `own`, or an object of Python
    Config config;
    std::vector<std::string> warnings{};
};

/// The names in a list, for Particles; or the keys of a dict, for arrays.
std::vector<std::string> namesIn(nb::handle attributes) {
    std::vector<std::string> names;
    if (attributes.is_none()) return names;
    if (nb::isinstance<nb::str>(attributes))
        throw Error("attributes is text. Use a dict of arrays, or with betamesh.Particles a list of names.");
    for (const nb::handle name : nb::borrow<nb::iterable>(attributes)) {
        if (!nb::isinstance<nb::str>(name)) throw Error("attributes: a name is no text. Use a list of names.");
        names.push_back(nb::cast<std::string>(name));
    }
    return names;
}

void setParticles(nb::handle positions, nb::handle velocities, nb::handle ids, nb::handle attributes, nb::handle origin,
                  SurfaceCall& call) {
    const bool in_plane = call.config.surface.dimension == 2;
    if (!nb::isinstance<ParticlesObject>(positions)) {
        call.own = particlesFrom(positions, velocities, ids, attributes, origin, in_plane);
        call.particles = &call.own;
        return;
    }
    const bool is_auto = nb::isinstance<nb::str>(origin) && nb::cast<std::string>(origin) == "auto";
    if (!velocities.is_none() || !ids.is_none() || !is_auto || nb::isinstance<nb::dict>(attributes))
        throw Error(
            "betamesh.Particles have their own velocities, ids, attributes and origin. Leave these arguments out; "
            "attributes may be a list of names.");
    call.particles = nb::inst_ptr<ParticlesObject>(positions);
}

void warn(const std::vector<std::string>& warnings) {
    for (const std::string& warning : warnings)
        if (PyErr_WarnEx(PyExc_UserWarning, warning.c_str(), 2) != 0) throw nb::python_error();
}

/// The radius and spacing of the settings, measured in these particles if necessary.
ResolvedRadius resolvedRadius(const SurfaceCall& call) {
    const std::vector<Vec3f>& positions = call.particles->particles.position;
    MeasuredSpacing measured{std::nullopt, positions.size(), "these particles"};
    if (call.config.surface.spacing == 0) measured.estimate = spacingOf(positions, call.config.surface.dimension);
    if (const auto found = measuredRadius(call.config, measured)) return *found;
    if (positions.empty()) return {1, 1, "", {}};  // any will do
    throw Error(
        "the particle spacing cannot be measured because fewer than seven particles are distinct. Give spacing, or "
        "radius in world units, as in radius=0.02.");
}

/// Parameters with all lengths. Adds warnings of lengths that do not suit the particles.
SkinParams resolvedParams(SurfaceCall& call, SurfaceLengths& lengths) {
    const ResolvedRadius resolved = resolvedRadius(call);
    const int dimension = call.config.surface.dimension;
    SkinParams params = withLengths(skinParams(call.config), call.config, resolved);
    lengths = {resolved.radius, resolved.spacing, skinDepth(params, dimension)};
    const FrameSpacing frame = compareSpacing(call.particles->particles, params, dimension);
    for (const auto& warning : {frame.drift, frame.scale})
        if (warning) call.warnings.push_back(*warning);
    return params;
}

/// Announces the stage after each one that ends.
Watch announcing(const StageBegins& begins) {
    return [&begins](Stage ended) {
        if (ended < Stage::velocity) begins(nameOf(static_cast<Stage>(static_cast<int>(ended) + 1)));
    };
}

SurfaceCall surfaceCall(nb::handle positions, nb::handle velocities, nb::handle ids, nb::handle attributes,
                        nb::handle origin, const nb::list& settings) {
    SurfaceCall call;
    call.config = configFrom(settingsFrom(settings));
    call.config.output.attributes = namesIn(attributes);
    reconcileSurface(call.config, call.warnings);
    checkSkin(call.config, call.warnings);
    setParticles(positions, velocities, ids, attributes, origin, call);
    const Vec3& local = call.config.input.origin = call.particles->origin;
    if (nb::isinstance<nb::str>(origin) && call.particles == &call.own && local != Vec3(0, 0, 0))
        call.warnings.push_back(
            "single precision loses these coordinates. The surface is relative to the local origin " +
            textOf(tupleOf(local)) + ", which has to be added to its vertices (origin)");
    return call;
}

nb::object skin(nb::object positions, nb::object velocities, nb::object ids, nb::object attributes, nb::object origin,
                const nb::list& settings, bool components, nb::object threads, nb::object progress) {
    const CallOptions options = callOptions(threads, progress);
    SurfaceCall call = surfaceCall(positions, velocities, ids, attributes, origin, settings);
    call.config.output.components = components;
    MeshObject object;
    callInterruptibly(options, [&](const StageBegins& begins) {
        begins("spacing");
        const SkinParams params = resolvedParams(call, object.lengths);
        begins(nameOf(Stage::structure));
        SkinnedFrame frame = skinFrame(call.particles->particles, params, announcing(begins));
        object.mesh = std::move(frame.mesh);
        object.spheres.spheres = std::move(frame.spheres);
        object.counts = frame.report;
    });
    object.origin = call.particles->origin;
    warn(call.warnings);
    return nb::cast(std::move(object));
}

nb::object skinPlaneOf(nb::object positions, nb::object velocities, nb::object ids, nb::object attributes,
                       nb::object origin, nb::list settings, nb::object threads, nb::object progress) {
    const CallOptions options = callOptions(threads, progress);
    settings.append(nb::make_tuple("dimension", "surface.dimension", "2"));
    SurfaceCall call = surfaceCall(positions, velocities, ids, attributes, origin, settings);
    requirePlanar(skinParams(call.config));
    CurvesObject object;
    callInterruptibly(options, [&](const StageBegins& begins) {
        begins("spacing");
        const SkinParams params = resolvedParams(call, object.lengths);
        begins(nameOf(Stage::structure));
        const FlatParticles flat = flattened(call.particles->particles, object.lengths.spacing);
        SkinnedPlane plane = skinPlane(flat.particles, params, announcing(begins));
        object.curves = toSpace(std::move(plane.curves), flat.plane);
        object.spheres.spheres = toSpace(std::move(plane.spheres), flat.plane);
        object.counts = plane.report;
    });
    object.origin = call.particles->origin;
    warn(call.warnings);
    return nb::cast(std::move(object));
}

nb::object simplify(const MeshObject& object, double tolerance, nb::handle threads) {
    MeshObject result{{}, object.origin, object.spheres, object.counts, object.lengths};
    callInterruptibly(callOptions(threads, nb::none()),
                      [&](const StageBegins&) { result.mesh = simplified(object.mesh, tolerance); });
    return nb::cast(std::move(result));
}

/// The positions of one frame: those of Particles, or an array.
std::vector<Vec3f> positionsOf(nb::handle frame) {
    if (nb::isinstance<ParticlesObject>(frame)) return nb::inst_ptr<ParticlesObject>(frame)->particles.position;
    return particlesFrom(frame, nb::none(), nb::none(), nb::none(), nb::str("auto"), true).particles.position;
}

nb::object spacing(const nb::args& frames, int dimension, nb::object threads) {
    if (frames.size() == 0) throw Error("spacing() needs the positions of at least one frame");
    if (dimension != 2 && dimension != 3)
        throw Error("dimension: '" + std::to_string(dimension) + "' is not valid. Use 2 or 3.");
    const CallOptions options = callOptions(threads, nb::none());
    SpacingEstimator estimator(dimension);
    for (const nb::handle frame : frames) {
        std::vector<Vec3f> positions = positionsOf(frame);
        callInterruptibly(options, [&](const StageBegins&) { estimator.add(std::move(positions)); });
    }
    const auto estimate = estimator.estimate();
    return estimate ? nb::cast(estimate->spacing) : nb::none();
}

/// Of each key that shapes a surface: its path in pipeline files, default, valid values and help.
nb::list settingsTable() {
    nb::list rows;
    const Config defaults;
    for (const ConfigKey& key : surfaceKeys())
        if (key.replaced_by.empty()) rows.append(nb::make_tuple(key.path, key.get(defaults), key.accepts, key.help));
    return rows;
}

}  // namespace

void addSurfaceFunctions(nb::module_& module) {
    module.def(
        "skin", skin, nb::arg("positions").none(), nb::arg("velocities").none(), nb::arg("ids").none(),
        nb::arg("attributes").none(), nb::arg("origin").none(), nb::arg("settings"), nb::arg("components"),
        nb::arg("threads").none(), nb::arg("progress").none(),
        nb::sig("def skin(positions: object, velocities: object, ids: object, attributes: object, origin: object, "
                "settings: list[tuple[str, str, str]], components: bool, threads: int | None, progress: "
                "object) -> Mesh"),
        "betamesh.skin() with settings as text: name of the argument, key, value.");
    module.def(
        "skin_plane", skinPlaneOf, nb::arg("positions").none(), nb::arg("velocities").none(), nb::arg("ids").none(),
        nb::arg("attributes").none(), nb::arg("origin").none(), nb::arg("settings"), nb::arg("threads").none(),
        nb::arg("progress").none(),
        nb::sig("def skin_plane(positions: object, velocities: object, ids: object, attributes: object, origin: "
                "object, settings: list[tuple[str, str, str]], threads: int | None, progress: object) -> Curves"),
        "betamesh.skin_plane() with settings as text: name of the argument, key, value.");
    module.def("simplify", simplify, nb::arg("mesh"), nb::arg("tolerance"), nb::kw_only(),
               nb::arg("threads").none() = nb::none(),
               nb::sig("def simplify(mesh: Mesh, tolerance: float, *, threads: int | None = None) -> Mesh"), kSimplify);
    module.def("spacing", spacing, nb::arg("frames"), nb::arg("dimension") = 3, nb::arg("threads").none() = nb::none(),
               nb::sig("def spacing(*frames: object, dimension: int = 3, threads: int | None = None) -> float | None"),
               kSpacing);
    module.def("settings", settingsTable, nb::sig("def settings() -> list[tuple[str, str, str, str]]"),
               "Of each key that shapes a surface: its path in pipeline files, default, valid values and help.");
}

}  // namespace betamesh
