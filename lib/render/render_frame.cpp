
#include "render/render_frame.h"

#include "base/parallel.h"
#include "betamesh/error.h"
#include "mesh/normals.h"
#include "render/colours.h"
#include "render/light_filter.h"
#include "render/pixel_samples.h"
#include "render/ray_tracer.h"
#include "render/shade.h"

#include <algorithm>
#include <cmath>

namespace betamesh {
namespace {

constexpr int kPacketWidth = 4, kPacketHeight = 2;  // pixels of a packet of rays
constexpr int kTile = 32;                           // side of the square of pixels that is one task, pixels
constexpr float kRayOffset = 16 * 0x1p-24f;  // start of a secondary ray above the surface, in largest coordinates
constexpr double kFarthestCamera = 1e15;     // from the scene, in scene units; Embree takes 1.8e18
constexpr double kOcclusionDistance = 0.25;  // range of ambient occlusion, in diagonals of the bulk
constexpr float kGroundRadius = 8;           // of the ground that takes shadows, in occlusion distances
constexpr float kShadowOnGround = 0.55f, kOcclusionOnGround = 0.5f;  // fraction of the ground's light that they remove
const Vec3f kSectionColour(0.30f, 0.36f, 0.42f);                     // linear light, of a section by the cutaway plane
constexpr float kEdgeBrightness = 0.25f;                             // of wireframe lines, relative to the surface
constexpr float kFar = 1e30f;

/// Everything that the rays of a frame need. Lengths are in scene units unless stated otherwise.
struct RenderScene {
    const Mesh& mesh;
    const Spheres& spheres;
    const RenderSettings& settings;
    View view;
    Lights lights;
    SceneSpace space;
    double near_depth;          // world units; in front of everything: camera rays start here
    Vec3f centre;               // of the bulk
    float occlusion_distance;   // range of ambient occlusion
    double shutter_seconds;     // exposure time
    std::vector<Vec3f> normal;  // of the vertices; empty: flat shading
    SurfaceColours colours;
    RayTracer tracer;
};

/// The surface point that a camera ray hits.
struct SurfacePoint {
    Hits::What what = Hits::kNothing;
    Vec3f position;
    Vec3f start;   // origin of secondary rays
    Vec3f normal;  // shading normal, towards the eye
    Vec3f facet;   // geometric normal, towards the eye
    Vec3f to_eye;
    Vec3f colour;
    Vec3f velocity{0, 0, 0};  // world units per second
};

Vec3f atRow(const std::array<Rays::Row<float>, 3>& rows, std::size_t i) { return {rows[0][i], rows[1][i], rows[2][i]}; }

void setRow(std::array<Rays::Row<float>, 3>& rows, std::size_t i, const Vec3f& v) {
    rows[0][i] = v.x, rows[1][i] = v.y, rows[2][i] = v.z;
}

template <typename T>
Vec3f interpolated(const std::vector<T>& rows, const Triangle& t, float u, float v) {
    return Vec3f(rows[t[0]]) * (1 - u - v) + Vec3f(rows[t[1]]) * u + Vec3f(rows[t[2]]) * v;
}

/// Fraction of a pixel that the edges of a triangle cover, 0 to 1.
float wireframeCoverage(const RenderScene& scene, const Triangle& t, float u, float v, const Vec3f& position) {
    const Vec3 a = scene.mesh.position[t[0]], b = scene.mesh.position[t[1]], c = scene.mesh.position[t[2]];
    const double doubled_area = cross(b - a, c - a).length();
    const double distance =
        std::min({(1.0 - static_cast<double>(u + v)) / (c - b).length(), static_cast<double>(u) / (a - c).length(),
                  static_cast<double>(v) / (b - a).length()}) *
        doubled_area;
    const double pixel = scene.view.pixel() * scene.view.depth(scene.space.toWorld(position));
    return static_cast<float>(std::clamp(scene.settings.wireframe / 2 + 0.5 - distance / pixel, 0.0, 1.0));
}

double largestCoordinate(const Vec3& p) { return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}); }

/// Position of row i at the time of a ray, 0 to 1 within the exposure.
Vec3 positionAt(const RenderScene& scene, const std::vector<Vec3>& position, const std::vector<Vec3>& velocity,
                std::uint32_t i, float time) {
    const double seconds = (static_cast<double>(time) - 0.5) * scene.shutter_seconds;
    return scene.space.fromWorld(seconds == 0 || velocity.empty() ? position[i] : position[i] + velocity[i] * seconds);
}

/// Sets the position of a hit on a triangle, accurate to rounding, and the origin of secondary rays. That origin is
/// raised to the curved surface that the vertex normals describe, because the flat facets would otherwise cast shadows
/// on a surface that is shaded as smooth, and further by more than the rounding error.
///
/// in      side: 1 where the outside is visible, -1 where the inside is; 0: flat shading
/// source  Hanika 2021, "Hacking the shadow terminator" (Ray Tracing Gems II, chapter 4); Pharr, Jakob & Humphreys
///         2023, "Physically Based Rendering", section 6.8
void placeOnTriangle(const RenderScene& scene, const Triangle& t, float u, float v, float time, int side,
                     SurfacePoint& point) {
    const std::array<double, 3> weight{1 - static_cast<double>(u) - static_cast<double>(v), static_cast<double>(u),
                                       static_cast<double>(v)};
    Vec3 at(0, 0, 0), corner[3];
    double largest = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        corner[i] = positionAt(scene, scene.mesh.position, scene.mesh.velocity, t[i], time);
        at += corner[i] * weight[i];
        largest = std::max(largest, largestCoordinate(corner[i]));
    }
    point.position = Vec3f(at);
    if (side != 0) {
        Vec3 bulge(0, 0, 0);
        for (std::size_t i = 0; i < 3; ++i) {
            const Vec3 normal = Vec3(scene.normal[t[i]]) * side;
            bulge -= normal * (std::min(0.0, dot(at - corner[i], normal)) * weight[i]);
        }
        at += bulge;
    }
    point.start = Vec3f(at + Vec3(point.facet) * (static_cast<double>(kRayOffset) * largest));
}

void placeOnSphere(const RenderScene& scene, std::uint32_t row, float time, SurfacePoint& point) {
    const Vec3 centre = positionAt(scene, scene.spheres.position, scene.spheres.velocity, row, time);
    const double radius = static_cast<double>(scene.spheres.radius[row]) * scene.space.scale;
    const Vec3 out = (Vec3(point.position) - centre).normalized();
    const double side = dot(out, Vec3(point.facet)) < 0 ? -1 : 1;
    point.position = Vec3f(centre + out * radius);
    const double gap = static_cast<double>(kRayOffset) * (largestCoordinate(centre) + radius);
    point.start = Vec3f(centre + out * (radius + side * gap));
}

SurfacePoint surfacePoint(const RenderScene& scene, const Rays& rays, const Hits& hits, std::size_t i) {
    SurfacePoint point;
    point.what = hits.what[i];
    if (point.what == Hits::kNothing) return point;
    const Vec3f direction = atRow(rays.direction, i);
    point.position = atRow(rays.origin, i) + direction * hits.distance[i];
    point.to_eye = -direction.normalized();
    point.facet = atRow(hits.normal, i).normalized();
    point.colour = scene.colours.plain;
    const std::uint32_t row = hits.row[i];
    const bool inside = point.facet.dot(point.to_eye) < 0;
    if (inside) point.facet = -point.facet;
    point.normal = point.facet;
    if (point.what == Hits::kTriangle) {
        const Triangle& t = scene.mesh.triangles[row];
        const float u = hits.u[i], v = hits.v[i];
        int side = 0;
        if (!scene.normal.empty()) {
            const Vec3f smooth = interpolated(scene.normal, t, u, v) * (inside ? -1.0f : 1.0f);
            if (smooth.dot(point.facet) > 0) {
                point.normal = smooth.normalized();
                side = inside ? -1 : 1;
            }
        }
        placeOnTriangle(scene, t, u, v, rays.time[i], side, point);
        if (!scene.colours.vertex.empty()) point.colour = interpolated(scene.colours.vertex, t, u, v);
        if (!scene.colours.triangle.empty()) point.colour = scene.colours.triangle[row];
        if (!scene.mesh.velocity.empty()) point.velocity = interpolated(scene.mesh.velocity, t, u, v);
        if (scene.settings.wireframe > 0)
            point.colour *= 1 - (1 - kEdgeBrightness) * wireframeCoverage(scene, t, u, v, point.position);
    } else if (point.what == Hits::kSection) {
        point.colour = kSectionColour;
        const auto largest = static_cast<float>(largestCoordinate(Vec3(point.position)));
        point.start = point.position + point.facet * (kRayOffset * largest);
    } else {
        placeOnSphere(scene, row, rays.time[i], point);
        if (!scene.colours.sphere.empty()) point.colour = scene.colours.sphere[row];
        if (!scene.spheres.velocity.empty()) point.velocity = Vec3f(scene.spheres.velocity[row]);
    }
    const float facing = point.normal.dot(point.to_eye);  // an interpolated normal may point away from the eye
    if (facing < 0.02f) point.normal = (point.normal + point.to_eye * (0.02f - facing)).normalized();
    return point;
}

/// A block of eight adjacent pixels.
struct Packet {
    Rays::Row<int> x{}, y{};
    Rays::Row<int> inside{};  // -1: inside the picture; 0: outside

    Packet(int left, int top, const RenderSettings& settings) {
        for (std::size_t i = 0; i < Rays::kCount; ++i) {
            x[i] = left + static_cast<int>(i) % kPacketWidth, y[i] = top + static_cast<int>(i) / kPacketWidth;
            inside[i] = x[i] < settings.width && y[i] < settings.height ? -1 : 0;
        }
    }
};
static_assert(Rays::kCount == PixelSamples::kPixels);

/// Sets ray i to the camera ray through (x, y) of the picture. It starts at the near depth.
void setEyeRay(const RenderScene& scene, double x, double y, std::size_t i, Rays& rays) {
    const Vec3 direction = scene.view.direction(x, y);
    setRow(rays.origin, i, Vec3f(scene.space.fromWorld(scene.view.position() + direction * scene.near_depth)));
    setRow(rays.direction, i, Vec3f(direction));
}

/// For eight points: 1 where a sample of the light is visible from the point, 0 where it is occluded.
struct LightVisibility {
    Rays::Row<float> key{}, sky{};
};

/// Casts one ray to the key light and one into the hemisphere above each point. lit: -1 for the points to be lit.
LightVisibility lightVisibility(const RenderScene& scene, const PixelSamples& samples,
                                const Rays::Row<SurfacePoint>& point, const Rays::Row<float>& time,
                                const Rays::Row<int>& lit, int s) {
    Rays key, sky;
    key.active = sky.active = lit;
    key.time = sky.time = time;
    LightVisibility visibility;
    const PixelSamples::Pairs on_key = samples.inDisc(PixelSamples::Use::key_light, s),
                              on_sky = samples.inDisc(PixelSamples::Use::sky, s);
    for (std::size_t i = 0; i < Rays::kCount; ++i) {
        if (lit[i] == 0) continue;
        const Vec3f &n = point[i].normal, &facet = point[i].facet;
        const Vec3f to_key =
            scene.lights.key + scene.lights.key_across[0] * on_key.x[i] + scene.lights.key_across[1] * on_key.y[i];
        setRow(key.origin, i, point[i].start);
        setRow(key.direction, i, to_key);
        key.t_max[i] = kFar;
        if (n.dot(to_key) <= 0) key.active[i] = 0;  // below the horizon of the shading normal
        const Vec3f side = n.cross(std::abs(n.x) < 0.6f ? Vec3f(1, 0, 0) : Vec3f(0, 1, 0)).normalized();
        const float rise = std::sqrt(std::max(0.0f, 1 - on_sky.x[i] * on_sky.x[i] - on_sky.y[i] * on_sky.y[i]));
        Vec3f to_sky = side * on_sky.x[i] + n.cross(side) * on_sky.y[i] + n * rise;
        const float below = to_sky.dot(facet);
        if (below < 0) to_sky -= facet * (2 * below);  // mirror directions below the facet to above it
        setRow(sky.origin, i, point[i].start);
        setRow(sky.direction, i, to_sky);
        sky.t_max[i] = scene.occlusion_distance;
    }
    const auto key_blocked = scene.tracer.blocked(key), sky_blocked = scene.tracer.blocked(sky);
    for (std::size_t i = 0; i < Rays::kCount; ++i) {
        visibility.key[i] = key.active[i] != 0 && key_blocked[i] == 0 ? 1.0f : 0.0f;
        visibility.sky[i] = sky_blocked[i] == 0 ? 1.0f : 0.0f;
    }
    return visibility;
}

/// Finds the point where a camera ray hits the shadow-catching ground. Returns whether it does.
bool hitsGround(const RenderScene& scene, double x, double y, SurfacePoint& point) {
    if (!scene.settings.ground) return false;
    const Vec3 direction = scene.view.direction(x, y), up(scene.lights.up);
    const double descent = -dot(direction, up), height = dot(scene.view.position(), up) - *scene.settings.ground;
    if (descent <= 0 || height <= 0) return false;
    point.start = Vec3f(scene.space.fromWorld(scene.view.position() + direction * (height / descent)));
    point.facet = point.normal = scene.lights.up;
    return (point.start - scene.centre).length() < scene.occlusion_distance * kGroundRadius;
}

/// Sums over the samples of a pixel that hit the same smooth surface.
struct SurfaceSums {
    float count = 0;
    float key = 0, sky = 0;                      // number of samples that each light reaches
    Vec3f from_key{0, 0, 0}, from_sky{0, 0, 0};  // ShadedLight::key and ::sky, unoccluded
    Vec3f position{0, 0, 0}, normal{0, 0, 0};    // of the first sample
};

/// Sums over all samples of a pixel.
struct Sums {
    Vec3f light{0, 0, 0};
    float alpha = 0, shadow = 0;
    SurfaceSums first, second;  // second: samples that did not hit the first surface
};

float depthOf(const RenderScene& scene, const Vec3f& position) {
    return static_cast<float>(scene.view.depth(scene.space.toWorld(position)) * scene.space.scale);
}

/// Whether a sample hit the same smooth surface as earlier samples of its pixel.
bool isSameSurface(const RenderScene& scene, const SurfaceSums& surface, const SurfacePoint& point) {
    if ((point.normal - surface.normal).length2() >= LitSurfaces::kMaxNormalDistance2) return false;
    const float pixel = static_cast<float>(scene.view.pixel()) * depthOf(scene, surface.position);
    return std::abs((point.position - surface.position).dot(surface.normal)) < LitSurfaces::kMaxPlaneDistance * pixel;
}

/// Traces and shades sample s of each pixel of a packet.
void addSample(const RenderScene& scene, const Packet& packet, const PixelSamples& samples, int s,
               Rays::Row<Sums>& sums) {
    Rays rays;
    rays.active = packet.inside;
    rays.t_max.fill(kFar);
    std::array<std::array<double, 2>, Rays::kCount> at{};
    PixelSamples::Pairs in_pixel = samples.inSquare(PixelSamples::Use::pixel, s), in_shutter{};
    if (scene.settings.samples == 1) in_pixel.x.fill(0.5f), in_pixel.y.fill(0.5f);
    in_shutter.x.fill(0.5f);
    if (scene.shutter_seconds > 0) in_shutter = samples.inSquare(PixelSamples::Use::shutter, s);
    for (std::size_t i = 0; i < Rays::kCount; ++i) {
        at[i] = {packet.x[i] + static_cast<double>(in_pixel.x[i]), packet.y[i] + static_cast<double>(in_pixel.y[i])};
        setEyeRay(scene, at[i][0], at[i][1], i, rays);
        rays.time[i] = in_shutter.x[i];
    }
    const Hits hits = scene.tracer.nearest(rays);
    Rays::Row<SurfacePoint> point;
    Rays::Row<int> lit{};
    for (std::size_t i = 0; i < Rays::kCount; ++i) {
        if (packet.inside[i] == 0) continue;
        point[i] = surfacePoint(scene, rays, hits, i);
        lit[i] = point[i].what != Hits::kNothing || hitsGround(scene, at[i][0], at[i][1], point[i]) ? -1 : 0;
    }
    if (std::none_of(lit.begin(), lit.end(), [](int active) { return active != 0; })) return;
    const LightVisibility visibility = lightVisibility(scene, samples, point, rays.time, lit, s);
    for (std::size_t i = 0; i < Rays::kCount; ++i) {
        if (lit[i] == 0) continue;
        const float key = visibility.key[i], sky = visibility.sky[i];
        Sums& sum = sums[i];
        if (point[i].what == Hits::kNothing) {
            sum.shadow += 1 - (1 - kShadowOnGround * (1 - key)) * (1 - kOcclusionOnGround * (1 - sky));
            continue;
        }
        const ShadedLight light =
            shadedLight(point[i].normal, point[i].to_eye, point[i].colour, scene.lights, scene.settings.shading);
        sum.light += light.always + light.key * key + light.sky * sky;
        sum.alpha += 1;
        SurfaceSums& surface =
            sum.first.count == 0 || isSameSurface(scene, sum.first, point[i]) ? sum.first : sum.second;
        if (surface.count == 0) surface.position = point[i].position, surface.normal = point[i].normal;
        surface.count += 1;
        surface.key += key;
        surface.sky += sky;
        surface.from_key += light.key;
        surface.from_sky += light.sky;
    }
}

std::size_t rowOf(const Picture& picture, int x, int y) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) + static_cast<std::size_t>(x);
}

/// Fills depth, normal, position, motion and id from one ray through each pixel's centre.
void fillLayers(const RenderScene& scene, const Packet& packet, Picture& picture) {
    Rays rays;
    rays.active = packet.inside;
    rays.t_max.fill(kFar);
    rays.time.fill(0.5f);
    for (std::size_t i = 0; i < Rays::kCount; ++i) setEyeRay(scene, packet.x[i] + 0.5, packet.y[i] + 0.5, i, rays);
    const Hits hits = scene.tracer.nearest(rays);
    for (std::size_t i = 0; i < Rays::kCount; ++i) {
        if (packet.inside[i] == 0) continue;
        const std::size_t pixel = rowOf(picture, packet.x[i], packet.y[i]);
        const SurfacePoint point = surfacePoint(scene, rays, hits, i);
        picture.depth[pixel] = Picture::kFarAway;
        if (point.what == Hits::kNothing) continue;
        picture.id[pixel] = point.what == Hits::kSphere ? Picture::kSphere : Picture::kMesh;
        const Vec3 position = scene.space.toWorld(point.position);
        picture.depth[pixel] = static_cast<float>(scene.view.depth(position));
        const auto now = scene.view.projected(position),
                   then = scene.view.projected(position + Vec3(point.velocity) / scene.settings.fps);
        for (int axis = 0; axis < 3; ++axis) {
            const auto a = static_cast<std::size_t>(axis);
            picture.normal[a][pixel] = point.normal[axis];
            picture.position[a][pixel] = static_cast<float>(position[axis]);
        }
        picture.motion[0][pixel] = static_cast<float>(then[0] - now[0]);
        picture.motion[1][pixel] = static_cast<float>(now[1] - then[1]);
    }
}

Picture emptyPicture(const RenderSettings& settings) {
    Picture picture;
    picture.width = settings.width;
    picture.height = settings.height;
    for (Plane* plane : {&picture.red, &picture.green, &picture.blue, &picture.alpha, &picture.shadow})
        plane->resize(picture.size());
    if (!settings.layers) return picture;
    picture.depth.resize(picture.size());
    for (Plane& plane : picture.normal) plane.resize(picture.size());
    for (Plane& plane : picture.position) plane.resize(picture.size());
    for (Plane& plane : picture.motion) plane.resize(picture.size());
    picture.id.resize(picture.size());
    return picture;
}

SurfaceSample meanOf(const RenderScene& scene, const SurfaceSums& sum) {
    const float share = 1 / static_cast<float>(scene.settings.samples);
    return {sum.key / sum.count,  sum.sky / sum.count, sum.count * share,           sum.from_key * share,
            sum.from_sky * share, sum.normal,          depthOf(scene, sum.position)};
}

void setPixel(const Sums& sum, int samples, std::size_t pixel, Picture& picture) {
    const float share = 1 / static_cast<float>(samples), open = static_cast<float>(samples) - sum.alpha;
    picture.red[pixel] = sum.light.x * share;
    picture.green[pixel] = sum.light.y * share;
    picture.blue[pixel] = sum.light.z * share;
    picture.alpha[pixel] = sum.alpha * share;
    picture.shadow[pixel] = open > 0 ? sum.shadow / open : 0;
}

Picture renderedPicture(const RenderScene& scene) {
    const RenderSettings& settings = scene.settings;
    Picture picture = emptyPicture(settings);
    const int columns = (settings.width + kTile - 1) / kTile, rows = (settings.height + kTile - 1) / kTile;
    LitSurfaces surfaces(picture.size(), static_cast<std::size_t>(columns * rows));
    parallelFor(static_cast<std::size_t>(columns * rows), 1, [&](std::size_t tile) {
        const int x0 = static_cast<int>(tile) % columns * kTile, y0 = static_cast<int>(tile) / columns * kTile;
        for (int top = y0; top < std::min(y0 + kTile, settings.height); top += kPacketHeight)
            for (int left = x0; left < std::min(x0 + kTile, settings.width); left += kPacketWidth) {
                const Packet packet(left, top, settings);
                const PixelSamples samples(packet.x, packet.y, settings.samples);
                Rays::Row<Sums> sums;
                for (int s = 0; s < settings.samples; ++s) addSample(scene, packet, samples, s, sums);
                for (std::size_t i = 0; i < Rays::kCount; ++i) {
                    if (packet.inside[i] == 0) continue;
                    const std::size_t pixel = rowOf(picture, packet.x[i], packet.y[i]);
                    setPixel(sums[i], settings.samples, pixel, picture);
                    if (sums[i].first.count > 0) surfaces.set(pixel, meanOf(scene, sums[i].first));
                    if (sums[i].second.count > 0)
                        surfaces.second[tile].push_back({packet.x[i], packet.y[i], meanOf(scene, sums[i].second)});
                }
                if (settings.layers) fillLayers(scene, packet, picture);
            }
    });
    filterLight(surfaces, scene.view, settings.samples, picture);
    return picture;
}

std::optional<ClipPlane> clipPlane(const std::optional<CutawayPlane>& cutaway, const SceneSpace& space) {
    if (!cutaway) return std::nullopt;
    const double side = cutaway->below ? 1 : -1;
    ClipPlane plane{{0, 0, 0}, static_cast<float>(side * (cutaway->at - space.origin[cutaway->axis]) * space.scale)};
    plane.normal[cutaway->axis] = static_cast<float>(side);
    return plane;
}

/// The origin is the camera's target or the point of the bounds nearest to it: precision matters most there.
SceneSpace spaceOf(const Bounds& bounds, const Camera& camera) {
    SceneSpace space;
    if (bounds.empty()) return space;
    for (int axis = 0; axis < 3; ++axis)
        space.origin[axis] = std::clamp(camera.look_at[axis], bounds.low[axis], bounds.high[axis]);
    const double size = bounds.diagonal();
    if (size > 0) space.scale = std::ldexp(1.0, -std::ilogb(size));
    return space;
}

/// errors  a camera so far away that Embree would not take its rays
void requireNear(const Camera& camera, const SceneSpace& space) {
    if (space.fromWorld(camera.position).length() < kFarthestCamera) return;
    throw Error(
        "the camera is more than 1e15 times as far away as what it shows is large. Give another --camera-position "
        "(preview.camera_position)");
}

/// Unit vectors: the attribute `N` where the mesh has it, or else vertexNormals().
std::vector<Vec3> shadingNormals(const Mesh& mesh) {
    std::vector<Vec3> normal = normalsOf(mesh);
    if (normalsIn(mesh.attributes) == nullptr) return normal;
    parallelFor(normal.size(), 8192, [&](std::size_t v) {
        const double length = normal[v].length();
        normal[v] = length > 0 && std::isfinite(length) ? normal[v] / length : Vec3(0);
    });
    return normal;
}

}  // namespace

Picture renderFrame(const Mesh& mesh, const Spheres& spheres, const Camera& camera, const RenderSettings& settings) {
    const Bounds all = boundsOf(mesh, spheres), bulk = boundsOfBulk(mesh, spheres, {});
    const View view(camera, settings.width, settings.height);
    const SceneSpace space = spaceOf(all, camera);
    requireNear(camera, space);
    const double shutter_seconds = settings.shutter / settings.fps;
    const double displacement =
        shutter_seconds / 2 * std::max(largestLength(mesh.velocity), largestLength(spheres.velocity));
    const double near_depth = view.depth(all.centre()) - (all.diagonal() / 2 + displacement) * (1 + 1e-6);

    std::vector<Vec3> normal;
    if (!settings.flat || settings.colouring.by == ColourBy::curvature) normal = shadingNormals(mesh);
    SurfaceColours colours = surfaceColours(mesh, spheres, normal, settings.colouring);
    std::vector<Vec3f> normal_floats(settings.flat ? 0 : normal.size());
    parallelFor(normal_floats.size(), 65536, [&](std::size_t i) { normal_floats[i] = Vec3f(normal[i]); });
    const RenderScene scene{mesh,
                            spheres,
                            settings,
                            view,
                            studioLights(view, camera.up),
                            space,
                            std::max(0.0, near_depth),
                            Vec3f(space.fromWorld(bulk.centre())),
                            static_cast<float>(bulk.diagonal() * kOcclusionDistance * space.scale),
                            shutter_seconds,
                            std::move(normal_floats),
                            std::move(colours),
                            {mesh, spheres, space, shutter_seconds, clipPlane(settings.cutaway, space)}};
    return renderedPicture(scene);
}

}  // namespace betamesh
