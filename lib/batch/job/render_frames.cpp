
#include "batch/job/render_frames.h"

#include "base/lower_case.h"
#include "base/parallel.h"
#include "batch/job/frame_task.h"
#include "betamesh/error.h"
#include "io/extension.h"
#include "io/file_info.h"
#include "io/mesh_file.h"
#include "io/particle_file.h"
#include "render/exr_file.h"
#include "render/png_file.h"
#include "skin/attributes.h"
#include "skin/particle_sizes.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <utility>
#include <vector>

namespace betamesh {
namespace {

constexpr double kColourScaleEnd = 2.5;  // root mean square speeds
constexpr double kGroundGap = 1e-3;      // below the lowest point, as a fraction of the diagonal of the bounds

bool hasExtension(const std::string& path, const std::string& extension) {
    return lowerCase(std::filesystem::path(path).extension().string()) == extension;
}

/// Spheres whose radius is the attribute `radius` or `pscale`; that of `balls` if there is none.
Spheres spheresOf(const Particles& points, const ParticleBalls& balls) {
    const bool has_colour =
        std::ranges::find(points.attributes, balls.colour, &Attribute::name) != points.attributes.end();
    Spheres spheres = ballsAround(points, {.radius = balls.radius, .colour = has_colour ? balls.colour : ""});
    for (const Attribute& attribute : points.attributes)
        if ((attribute.name == "radius" || attribute.name == "pscale") && attribute.components == 1 &&
            !attribute.real.empty())
            spheres.radius = attribute.real;
    return spheres;
}

/// The vertices of a mesh as particles.
Particles verticesOf(Mesh mesh) {
    Particles particles;
    particles.position.assign(mesh.position.begin(), mesh.position.end());
    particles.velocity.assign(mesh.velocity.begin(), mesh.velocity.end());
    particles.attributes = std::move(mesh.attributes);
    return particles;
}

bool containsParticles(const FileFrame& of) {
    try {
        return inspectFile(of.file, nullptr, of.sample()).kind == FileKind::particles;
    } catch (const Error&) {
        return false;
    }
}

Vec3 upOf(const Config::Preview& preview) { return preview.up == UpAxis::z ? Vec3(0, 0, 1) : Vec3(0, 1, 0); }

Vec3 vectorOf(const std::array<double, 3>& numbers) { return {numbers[0], numbers[1], numbers[2]}; }

}  // namespace

bool isSpheresFile(const std::string& file) { return splitExtension(file).first.ends_with(".spheres"); }

Spheres ballsAround(const Particles& particles, const ParticleBalls& balls) {
    SkinParams params;
    params.radius = balls.radius;
    params.spacing = balls.spacing;
    params.radius_attribute = balls.attribute;
    params.radius_scale = balls.scale;
    const std::vector<double> radii = particleSizes(particles, params).radius;
    Spheres spheres;
    spheres.position.assign(particles.position.begin(), particles.position.end());
    spheres.velocity.assign(particles.velocity.begin(), particles.velocity.end());
    spheres.radius.assign(particles.size(), static_cast<float>(balls.radius));
    std::transform(radii.begin(), radii.end(), spheres.radius.begin(), [](double r) { return static_cast<float>(r); });
    if (!balls.colour.empty())
        if (const Attribute* attribute = attributeOf(particles, balls.colour)) spheres.attributes = {*attribute};
    return spheres;
}

FrameGeometry readFrameGeometry(const FileFrame& of, const Config& config, ParticleBalls balls) {
    balls.colour = config.preview.colouring.attribute;
    const std::string& file = of.file;
    ParticleInput input = config.input;
    const bool as_in_file = input == ParticleInput{};
    input.frame = of.sample();
    const bool may_be_mesh = canHold(file, FileKind::mesh, Access::read);
    FrameGeometry subject;
    bool is_read = false;
    if (may_be_mesh) {
        try {
            subject.mesh = readMesh(file, input.frame);
            is_read = true;
        } catch (const Error&) {  // perhaps because of particles that are not chosen, or not finite
            if (as_in_file && !containsParticles(of)) throw;
        }
        if (!subject.mesh.triangles.empty()) {
            const std::string beside = spheresPath(file);
            if (std::filesystem::exists(beside)) subject.spheres = spheresOf(readParticles(beside), balls);
            return subject;
        }
    }
    const Particles particles =
        is_read && as_in_file ? verticesOf(std::exchange(subject.mesh, {})) : readParticles(file, input);
    subject.mesh = {};
    try {
        subject.spheres = isSpheresFile(file) ? spheresOf(particles, balls) : ballsAround(particles, balls);
    } catch (const ParticleError& error) {
        throw Error(file + ": " + withRowInFile(error, file, input));
    } catch (const Error& error) {
        throw Error(file + ": " + error.what());
    }
    return subject;
}

Extent::Extent(const Config::Preview& preview)
    : finder({upOf(preview), preview.azimuth, preview.elevation, preview.fov},
             static_cast<double>(preview.width) / preview.height),
      cut(preview.cut) {}

void Extent::add(const FrameGeometry& subject) {
    visitBulk(subject.mesh, subject.spheres, cut, [&](const Vec3& p, double radius) {
        bounds.add(p, radius);
        finder.add(p, radius);
    });
    for (const auto* velocities : {&subject.mesh.velocity, &subject.spheres.velocity})
        for (const Vec3& v : *velocities)
            if (std::isfinite(v.length2())) squares += v.length2(), ++speeds;
}

void Extent::add(const Extent& other) {
    bounds.add(other.bounds);
    finder.add(other.finder);
    squares += other.squares;
    speeds += other.speeds;
}

double Extent::speed() const { return speeds > 0 ? std::sqrt(squares / static_cast<double>(speeds)) : 0; }

Extent sequenceExtent(const std::map<int, std::string>& files, const Config& config, const ParticleBalls& balls,
                      const WorkerEvents& events, bool several_at_once) {
    const std::vector<std::pair<int, std::string>> rows(files.begin(), files.end());
    std::vector<Extent> extents(rows.size(), Extent(config.preview));
    parallelFor(rows.size(), several_at_once ? 1 : rows.size(), [&](std::size_t i) {
        const WorkerEvents::FrameInProgress in_progress(events, rows[i].first, WorkerEvents::Doing::measuring);
        try {
            extents[i].add(readFrameGeometry({rows[i].second, rows[i].first, config.input.is_one_file}, config, balls));
        } catch (const Error&) {  // reported when this frame is meshed
        }
    });
    Extent all(config.preview);
    for (const Extent& extent : extents) all.add(extent);
    return all;
}

bool needsExtent(const Config& config) {
    const Config::Preview& preview = config.preview;
    return !preview.camera_position || !preview.look_at || preview.ground == Config::Preview::Ground::automatic ||
           (preview.colouring.by == ColourBy::velocity && !(preview.colour_range[1] > preview.colour_range[0]));
}

RenderPlan planRendering(const Config& config, const Extent& extent, const ParticleBalls& balls) {
    const Config::Preview& preview = config.preview;
    RenderPlan plan;
    plan.balls = balls;
    plan.balls.colour = preview.colouring.attribute;
    RenderSettings& settings = plan.settings;
    settings.width = preview.width;
    settings.height = preview.height;
    settings.samples = preview.samples;
    settings.shading = preview.shading;
    settings.flat = preview.normals == PreviewNormals::flat;
    settings.cutaway = preview.cut;
    settings.wireframe = preview.wireframe;
    settings.shutter = preview.shutter;
    settings.fps = preview.fps;
    settings.colouring = preview.colouring;
    settings.colouring.low = preview.colour_range[0];
    settings.colouring.high = preview.colour_range[1];
    if (settings.colouring.by == ColourBy::velocity && !(settings.colouring.high > settings.colouring.low))
        settings.colouring.low = 0, settings.colouring.high = kColourScaleEnd * extent.speed();

    plan.camera = extent.finder.camera();
    if (preview.camera_position) plan.camera.position = vectorOf(*preview.camera_position);
    if (preview.camera_position) plan.camera.look_at = extent.bounds.centre();
    if (preview.look_at) plan.camera.look_at = vectorOf(*preview.look_at);
    if (preview.ground == Config::Preview::Ground::given) settings.ground = preview.ground_height;
    if (preview.ground == Config::Preview::Ground::automatic && !extent.bounds.empty())
        settings.ground = dot(extent.bounds.low, upOf(preview)) - kGroundGap * extent.bounds.diagonal();
    return plan;
}

std::string describe(const RenderPlan& plan) {
    const Camera& camera = plan.camera;
    const double distance = (camera.look_at - camera.position).length();
    // Enough digits for a thousandth of a pixel at any distance from the origin.
    const double step = distance > 0 ? std::pow(10, std::floor(std::log10(distance)) - 6) : 1;
    const auto rounded = [&](double x) {
        char text[40];
        const double whole = std::round(x / step);
        const int digits = std::clamp(static_cast<int>(std::log10(std::max(std::abs(whole), 1.0))) + 1, 1, 17);
        std::snprintf(text, sizeof text, "%.*g", digits, x);
        return std::string(text);
    };
    const auto coordinates = [&](const Vec3& p) { return rounded(p.x) + ',' + rounded(p.y) + ',' + rounded(p.z); };
    char fov[40];
    std::snprintf(fov, sizeof fov, "%.6g", camera.fov);
    return "--camera-position " + coordinates(camera.position) + " --look-at " + coordinates(camera.look_at) +
           " --fov " + fov + " --ground " + (plan.settings.ground ? rounded(*plan.settings.ground) : "none");
}

bool isExr(const std::string& path) {
    if (hasExtension(path, ".exr")) return true;
    if (hasExtension(path, ".png")) return false;
    throw Error(path + ": unknown format of previews. Use a name that ends in .png or .exr");
}

std::string encodePicture(const Picture& picture, const std::string& path) {
    return isExr(path) ? encodeExr(picture) : encodePng(toneMapped(picture));
}

}  // namespace betamesh
