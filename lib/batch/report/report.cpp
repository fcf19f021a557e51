// The only file that uses nlohmann-json.

#include "batch/report/report.h"

#include "batch/report/printable.h"
#include "betamesh/error.h"
#include "io/bytes.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <fstream>
#include <limits>

namespace betamesh {
namespace {

using Json = nlohmann::ordered_json;

/// The same without the hidden folder in any string.
Json withoutHiddenFolder(Json json) {
    if (json.is_string()) return betamesh::withoutHiddenFolder(json.get_ref<const std::string&>());
    if (json.is_structured())
        for (Json& element : json) element = withoutHiddenFolder(std::move(element));
    return json;
}

/// Bytes that are not UTF-8 become U+FFFD.
std::string oneLine(const Json& json) {
    return printableJson(withoutHiddenFolder(json).dump(-1, ' ', false, Json::error_handler_t::replace));
}

/// Ends the name of a member that has the exact bytes of a path, percent-encoded, because JSON is UTF-8. It exists only
/// if the path is not UTF-8.
constexpr const char* kEncoded = "_percent_encoded";

void addPath(Json& json, const std::string& name, const std::string& path) {
    const std::string shown = betamesh::withoutHiddenFolder(path);
    json[name] = shown;
    if (!isUtf8(shown)) json[name + kEncoded] = percentEncoded(shown);
}

/// The path that addPath() has added; empty if there is none.
std::string pathFrom(const Json& json, const std::string& name) {
    if (json.contains(name + kEncoded)) return percentDecoded(json.at(name + kEncoded).get<std::string>());
    return json.contains(name) ? json.at(name).get<std::string>() : "";
}

FrameStatus statusNamed(const std::string& name) {
    for (const FrameStatus status : {FrameStatus::ok, FrameStatus::empty, FrameStatus::skipped})
        if (name == nameOf(status)) return status;
    return FrameStatus::failed;
}

/// The provenance in the JSON of a frame.
Provenance provenanceFrom(const Json& json) {
    const Json& from = json.at("origin");
    Provenance provenance;
    from.at("version").get_to(provenance.version);
    from.at("configuration").get_to(provenance.config_hash);
    provenance.preview_hash = from.value("preview", "");
    json.at("radius").get_to(provenance.radius);
    json.at("spacing").get_to(provenance.spacing);
    if (const Json& input = from.at("input"); !input.is_null()) {
        const FileFingerprint fingerprint{input.at("bytes").get<std::uint64_t>(),
                                          input.at("modified").get<std::int64_t>()};
        provenance.input = FileIdentity{fingerprint, input.at("content").get<std::string>()};
    }
    if (const auto local = json.find("local_origin"); local != json.end())
        for (int axis = 0; axis < 3; ++axis)
            local->at(static_cast<std::size_t>(axis)).get_to(provenance.local_origin[axis]);
    if (json.value("up_axis", "y") == "z") provenance.up_axis = UpAxis::z;
    for (const auto& [name, bytes] : from.at("files").items()) provenance.files[name] = bytes.get<std::uint64_t>();
    if (const auto encoded = from.find(std::string("files") + kEncoded); encoded != from.end())
        for (const auto& [name, bytes] : encoded->items())
            provenance.files[percentDecoded(name)] = bytes.get<std::uint64_t>();
    return provenance;
}

Json provenanceJson(const Provenance& provenance) {
    Json json;
    json["version"] = provenance.version;
    json["configuration"] = provenance.config_hash;
    if (!provenance.preview_hash.empty()) json["preview"] = provenance.preview_hash;
    json["input"] = nullptr;
    if (provenance.input)
        json["input"] = {{"bytes", provenance.input->fingerprint.bytes},
                         {"modified", provenance.input->fingerprint.modified},
                         {"content", provenance.input->content_hash}};
    json["files"] = Json::object();
    for (const auto& [name, bytes] : provenance.files)
        if (isUtf8(name))
            json["files"][name] = bytes;
        else
            json[std::string("files") + kEncoded][percentEncoded(name)] = bytes;
    return json;
}

/// Name, type and use of the attributes, groups, grids and other items of an input; use is null for those that are not
/// used.
Json partsJson(const std::vector<InputPart>& parts) {
    constexpr std::array kLists{"attributes", "groups", "grids", "others"};  // as InputPart::Kind
    Json json;
    for (const char* list : kLists) json[list] = Json::array();
    for (const InputPart& part : parts) {
        const char* list = kLists[static_cast<std::size_t>(part.kind)];
        json[list].push_back(
            {{"name", part.name}, {"type", part.type}, {"use", part.use.empty() ? Json(nullptr) : Json(part.use)}});
    }
    return json;
}

void addSurface(const FrameResult& result, Json& json) {
    json["particles"] = result.skin.particles;
    json["particles_read"] = result.particles_read;
    json["particles_dropped"] = result.particles_dropped;
    json["distinct_particles"] = result.skin.distinct_particles;
    json["radius"] = result.radius;
    json["spacing"] = result.spacing;
    if (result.frame_spacing > 0) json["frame_spacing"] = result.frame_spacing;
    json["skin"] = result.skin_depth;
    json["predicates"] = result.predicates == PredicateKind::exact ? "exact" : "float";
    json["perturbation_retries"] = result.skin.perturbation_retries;
    json["alpha_vertices"] = result.skin.alpha_vertices;
    json["alpha_triangles"] = result.skin.alpha_triangles;
    json["double_sided_triangles"] = result.skin.double_sided_triangles;
    json["degenerate_edges"] = result.skin.degenerate_edges;
    json["isolated_particles"] = result.skin.isolated_particles;
    json["droplets"] = result.skin.droplets;
    json["droplet_particles"] = result.skin.droplet_particles;
    json["tendril_particles"] = result.skin.tendril_particles;
    json["bubbles_filled"] = result.skin.bubbles_filled;
    json["crossings"] = result.skin.crossings;
    json["vertices"] = result.vertices;
    json["triangles"] = result.triangles;
    json["spheres"] = result.spheres;
    json["components"] = result.measure.components;
    json["euler"] = result.measure.euler;
    json["volume"] = result.measure.volume;
    json["area"] = result.measure.area;
}

void addPlane(const FrameResult& result, const PlaneFrameResult& plane, Json& json) {
    json["particles"] = plane.skin.particles;
    json["particles_read"] = result.particles_read;
    json["particles_dropped"] = result.particles_dropped;
    json["distinct_particles"] = plane.skin.distinct_particles;
    json["radius"] = result.radius;
    json["spacing"] = result.spacing;
    if (result.frame_spacing > 0) json["frame_spacing"] = result.frame_spacing;
    json["skin"] = result.skin_depth;
    json["alpha_vertices"] = plane.skin.alpha_vertices;
    json["alpha_segments"] = plane.skin.alpha_segments;
    json["double_sided_segments"] = plane.skin.double_sided_segments;
    json["isolated_particles"] = plane.skin.isolated_particles;
    json["droplets"] = plane.skin.droplets;
    json["droplet_particles"] = plane.skin.droplet_particles;
    json["bubbles_filled"] = plane.skin.bubbles_filled;
    json["vertices"] = result.vertices;
    json["edges"] = plane.edges;
    json["spheres"] = result.spheres;
    json["curves"] = plane.measure.curves;
    json["euler"] = plane.measure.turning;
    json["area"] = plane.measure.area;
    json["length"] = plane.measure.length;
}

Json asJson(const Vec3& v) { return {v.x, v.y, v.z}; }

Json asJson(const FaultCount& found) {
    return {{"count", found.count}, {"first", found ? Json(found.first) : Json(nullptr)}};
}

void addCheck(const MeshCheck& check, Json& json) {
    json["vertices"] = check.vertices;
    json["edges"] = check.edges;
    json["triangles"] = check.triangles;
    json["components"] = check.components.size();
    json["euler"] = check.euler;
    json["volume"] = check.volume;
    json["area"] = check.area;
    json["closed"] = check.closed();
    json["oriented"] = check.oriented();
    json["edge_manifold"] = check.edgeManifold();
    json["vertex_manifold"] = check.vertexManifold();
    json["inside_out"] = check.inside_out;
    const auto add = [&](const char* name, const FaultCount& found) { json[name] = asJson(found); };
    add("not_finite", check.not_finite);
    add("velocity_not_finite", check.velocity_not_finite);
    add("missing_vertices", check.missing_vertices);
    add("repeated_vertices", check.repeated_vertices);
    add("duplicates", check.duplicates);
    add("open_edges", check.open_edges);
    add("misoriented_edges", check.misoriented_edges);
    add("nonmanifold_edges", check.nonmanifold_edges);
    add("nonmanifold_vertices", check.nonmanifold_vertices);
    add("zero_area", check.zero_area);
    add("unused_vertices", check.unused_vertices);
    add("coincident_vertices", check.coincident_vertices);
    json["touching"] = check.touching;
    json["crossings"] = {{"count", check.crossings.count}, {"shallow", check.shallow}, {"deepest", check.deepest}};
    json["crossings"]["listed"] = Json::array();
    for (const SelfCrossing& crossing : check.deepest_crossings)
        json["crossings"]["listed"].push_back({{"triangles", {crossing.first, crossing.second}},
                                               {"position", asJson(crossing.position)},
                                               {"depth", crossing.depth},
                                               {"coplanar", crossing.coplanar}});
    json["component"] = Json::array();
    for (const ComponentCheck& component : check.components)
        json["component"].push_back({{"vertices", component.vertices},
                                     {"edges", component.edges},
                                     {"triangles", component.triangles},
                                     {"euler", component.euler},
                                     {"genus", component.genus ? Json(*component.genus) : Json(nullptr)},
                                     {"closed", component.closed},
                                     {"volume", component.volume},
                                     {"area", component.area}});
}

void addCheck(const CurveCheck& check, Json& json) {
    json["dimension"] = 2;
    json["vertices"] = check.vertices;
    json["edges"] = check.edges;
    json["curves"] = check.measure.curves;
    json["euler"] = check.measure.turning;
    json["area"] = check.measure.area;
    json["length"] = check.measure.length;
    json["closed"] = !check.open_ends;
    json["inside_out"] = check.inside_out;
    const auto add = [&](const char* name, const FaultCount& found) { json[name] = asJson(found); };
    add("not_finite", check.not_finite);
    add("velocity_not_finite", check.velocity_not_finite);
    add("repeated_vertices", check.repeated_vertices);
    add("open_ends", check.open_ends);
    add("branches", check.branches);
    add("unused_vertices", check.unused_vertices);
    add("off_plane", check.off_plane);
    json["crossings"] = {{"count", check.crossings.count}, {"deepest", check.deepest}};
    json["crossings"]["listed"] = Json::array();
    for (const EdgeCrossing& crossing : check.deepest_crossings)
        json["crossings"]["listed"].push_back({{"edges", {crossing.first, crossing.second}},
                                               {"position", asJson(crossing.position)},
                                               {"depth", crossing.depth}});
}

Json finiteOrNull(double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); }

Json ratioJson(const CoherenceReport& report, double displacement) {
    const std::optional<double> ratio = report.ratio(displacement);
    return ratio ? finiteOrNull(*ratio) : Json(nullptr);
}

Json placeJson(const CoherenceReport& report, const JumpSite& place) {
    Json json;
    json["position"] = asJson(place.position);
    json["jump"] = place.jump;
    json["ratio"] = ratioJson(report, place.jump);
    json["expected"] = report.expectedAt(place);
    json["points"] = place.points;
    json["vanished_area"] = place.vanished;
    json["appeared_area"] = place.appeared;
    json["liquid"] = nameOf(place.liquid);
    json["events"] = Json::array();
    for (const auto& [event, times] : place.events)
        json["events"].push_back({{"event", nameOf(event)}, {"times", times}});
    return json;
}

}  // namespace

std::string manifestJson(const FrameResult& result) {
    Json json;
    json["frame"] = result.frame;
    addPath(json, "input", result.input);
    addPath(json, "output", result.output);
    json["status"] = nameOf(result.status);
    if (result.status == FrameStatus::failed) json["error"] = result.error;
    json["dimension"] = result.plane ? 2 : 3;
    json["preset"] = result.preset;
    if (result.plane)
        addPlane(result, *result.plane, json);
    else
        addSurface(result, json);
    const StageSeconds& seconds = result.seconds;
    Json& stages = json["seconds"];
    forStages([&](Stage stage) { stages[std::string(nameOf(stage))] = seconds[stage]; });
    stages["total"] = seconds.total;
    json["peak_bytes"] = result.peak_bytes;
    json["warnings"] = result.warnings;
    json["input_contents"] = partsJson(result.input_parts);
    if (result.provenance) {
        const Vec3& local = result.provenance->local_origin;
        json["local_origin"] = {local.x, local.y, local.z};
        json["up_axis"] = result.provenance->up_axis == UpAxis::z ? "z" : "y";
        json["origin"] = provenanceJson(*result.provenance);
    }
    return oneLine(json);
}

std::string manifestWith(const Provenance& provenance, const std::filesystem::path& manifest) {
    std::ifstream in(manifest);
    Json json = Json::parse(in, nullptr, false);
    if (json.is_object()) json["origin"] = provenanceJson(provenance);
    return oneLine(json);
}

std::string progressJson(const JobProgress& progress) {
    return oneLine({{"frames", progress.frames},
                    {"ended", progress.ended},
                    {"failed", progress.failed},
                    {"particles", progress.particles},
                    {"seconds", progress.seconds},
                    {"seconds_left", progress.seconds_left ? Json(*progress.seconds_left) : Json(nullptr)}});
}

std::string taskJson(const FrameTask& task) {
    Json json{{"frame", task.frame}};
    addPath(json, "input", task.input);
    addPath(json, "output", task.output);
    json["action"] = actionName(task.action);
    json["memory_bytes"] = task.memory;
    if (!task.why.empty()) json["why"] = task.why;
    return oneLine(json);
}

std::optional<FrameResult> readManifest(const std::filesystem::path& file) {
    requireRegularFile(file);
    std::ifstream in(file);
    if (!in) return std::nullopt;
    try {
        const Json json = Json::parse(in);
        FrameResult result;
        json.at("frame").get_to(result.frame);
        if (!json.contains("output")) return std::nullopt;
        result.output = pathFrom(json, "output");
        result.status = statusNamed(json.at("status").get<std::string>());
        const auto take = [](const Json& from, const char* name, auto& value) {
            if (from.contains(name)) from.at(name).get_to(value);
        };
        result.input = pathFrom(json, "input");
        take(json, "error", result.error);
        take(json, "preset", result.preset);
        take(json, "radius", result.radius);
        take(json, "spacing", result.spacing);
        take(json, "skin", result.skin_depth);
        take(json, "particles", result.skin.particles);
        take(json, "perturbation_retries", result.skin.perturbation_retries);
        take(json, "vertices", result.vertices);
        take(json, "triangles", result.triangles);
        take(json, "spheres", result.spheres);
        take(json, "components", result.measure.components);
        take(json, "volume", result.measure.volume);
        take(json, "area", result.measure.area);
        if (json.value("dimension", 3) == 2) {
            PlaneFrameResult& plane = result.plane.emplace();
            take(json, "particles", plane.skin.particles);
            take(json, "edges", plane.edges);
            take(json, "curves", plane.measure.curves);
            take(json, "area", plane.measure.area);
            take(json, "length", plane.measure.length);
        }
        take(json, "peak_bytes", result.peak_bytes);
        take(json, "warnings", result.warnings);
        const Json seconds = json.value("seconds", Json::object());
        forStages([&](Stage stage) { take(seconds, std::string(nameOf(stage)).c_str(), result.seconds[stage]); });
        take(seconds, "total", result.seconds.total);
        if (json.contains("origin")) result.provenance = provenanceFrom(json);
        return result;
    } catch (const Json::exception&) {
        return std::nullopt;
    }
}

std::vector<CoherenceReport> readCoherence(const std::filesystem::path& file) {
    requireRegularFile(file);
    std::ifstream in(file);
    if (!in) throw Error(file.string() + ": cannot be read. Give the output of betamesh coherence --json.");
    std::vector<CoherenceReport> reports;
    for (std::string line; std::getline(in, line);) {
        try {
            const Json json = Json::parse(line);
            CoherenceReport report;
            json.at("from").get_to(report.from);
            json.at("to").get_to(report.to);
            if (json.contains("to_frame")) report.to_frame = json["to_frame"].get<int>();
            report.distance.max = json.contains("max") && json["max"].is_number()
                                      ? json["max"].get<double>()
                                      : std::numeric_limits<double>::infinity();
            reports.push_back(report);
        } catch (const Json::exception&) {
            throw Error(file.string() + ':' + std::to_string(reports.size() + 1) +
                        ": this is not a line of betamesh coherence --json.");
        }
    }
    return reports;
}

std::string infoJson(const std::string& file, std::optional<int> frame, const FileInfo& info,
                     std::optional<double> spacing) {
    Json json;
    addPath(json, "file", file);
    if (frame) json["frame"] = *frame;
    if (info.times.size() > 1) json["times"] = info.times;
    json["kind"] = !info.volumes.empty()              ? "volumes"
                   : info.kind == FileKind::particles ? "particles"
                   : info.kind == FileKind::mesh      ? "mesh"
                                                      : "curves";
    json["format"] = info.format;
    json["bytes"] = info.bytes;
    json["points"] = info.points;
    json["triangles"] = info.triangles;
    json["edges"] = info.edges;
    json["lower"] = {info.lower.x, info.lower.y, info.lower.z};
    json["upper"] = {info.upper.x, info.upper.y, info.upper.z};
    if (info.kind == FileKind::particles) json["spacing"] = spacing ? Json(*spacing) : Json(nullptr);
    if (!info.note.empty()) json["note"] = info.note;
    json["attributes"] = Json::array();
    for (const AttributeInfo& attribute : info.attributes) {
        json["attributes"].push_back({{"name", attribute.name},
                                      {"type", attribute.type},
                                      {"components", attribute.components},
                                      {"codec", attribute.codec}});
    }
    for (const VolumeInfo& volume : info.volumes)
        json["volumes"].push_back({{"name", volume.name},
                                   {"kind", volume.kind},
                                   {"type", volume.type},
                                   {"voxel", volume.voxel},
                                   {"voxels", volume.voxels},
                                   {"lower", {volume.lower.x, volume.lower.y, volume.lower.z}},
                                   {"upper", {volume.upper.x, volume.upper.y, volume.upper.z}}});
    json["groups"] = info.groups;
    json["grids"] = Json::array();
    for (const GridInfo& grid : info.grids) json["grids"].push_back({{"name", grid.name}, {"type", grid.type}});
    json["not_read"] = info.passed_over;
    return oneLine(json);
}

std::string checkJson(const CheckReport& report) {
    Json json;
    addPath(json, "file", report.file);
    if (report.frame) json["frame"] = *report.frame;
    json["good"] = report.error.empty() && report.faults.empty();
    if (!report.error.empty()) {
        json["error"] = report.error;
        return oneLine(json);
    }
    json["faults"] = report.faults;
    if (report.curves)
        addCheck(*report.curves, json);
    else
        addCheck(report.check, json);
    if (report.particles) {
        const ParticleCheck& particles = *report.particles;
        json["particles"] = {{"file", particles.file},
                             {"count", particles.particles},
                             {"spheres", particles.spheres},
                             {"outside", particles.outside.count},
                             {"farthest", particles.farthest}};
        if (particles.radius > 0) json["particles"]["farthest_radii"] = particles.farthest / particles.radius;
        if (particles.outside) {
            json["particles"]["farthest_particle"] = particles.farthest_row;
            json["particles"]["farthest_position"] = asJson(particles.farthest_position);
        }
    }
    return oneLine(json);
}

std::string coherenceJson(const CoherenceReport& report) {
    Json json;
    addPath(json, "from", report.from);
    addPath(json, "to", report.to);
    if (report.from_frame) json["from_frame"] = *report.from_frame;
    if (report.to_frame) json["to_frame"] = *report.to_frame;
    if (!report.error.empty()) {
        json["error"] = report.error;
        return oneLine(json);
    }
    json["max"] = finiteOrNull(report.distance.max);
    json["quantile_999"] = finiteOrNull(report.distance.quantile999);
    json["rms"] = finiteOrNull(report.distance.rms);
    json["worst"] = asJson(report.distance.worst);
    json["samples"] = report.distance.samples;
    if (report.particles) {
        json["particles"] = {{"matched", report.particles->matched},
                             {"max", report.particles->max},
                             {"farthest", asJson(report.particles->farthest)}};
        json["ratio"] = ratioJson(report, report.distance.max);
        json["places"] = Json::array();
        for (const JumpSite& place : report.places) json["places"].push_back(placeJson(report, place));
    }
    return oneLine(json);
}

}  // namespace betamesh
