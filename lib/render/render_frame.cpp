
#include "render/render_frame.h"

#include "base/parallel.h"
#include "mesh/vertex_normals.h"
#include "render/colours.h"
#include "render/light_filter.h"
#include "render/pixel_samples.h"
#include "render/ray_tracer.h"
#include "render/shade.h"

#include <algorithm>
#include <cmath>

namespace betamesh {
namespace {

constexpr int kAcross = 4, kDown = 2;        // pixels of a packet of rays
constexpr int kTile = 32;                    // pixels to a side of what one thread does at a time
constexpr float kRayOffset = 16 * 0x1p-24f;  // of the largest coordinate there: how far rays start off the surface
constexpr double kOcclusionReach = 0.25;     // of the bulk's size: how far the room's light looks for what hides it
constexpr float kGroundReach = 8;            // times that: how far out the ground takes shadows
constexpr float kShadowOnGround = 0.55f, kOcclusionOnGround = 0.5f;  // share of the ground's light that they take
const Vec3f kSectionColour(0.30f, 0.36f, 0.42f);                     // linear light, where the cut shows the inside
constexpr float kEdgeLight = 0.25f;                                  // of the surface's, where the wireframe is drawn
constexpr float kFar = 1e30f;

/// A frame ready to be looked at. Lengths are in scene units where nothing else is said.
struct Studio {
    const Mesh& mesh;
    const Spheres& spheres;
    const Look& look;
    View view;
    Lights lights;
    SceneSpace space;
    double near;                // world units along the camera's axis: where its rays begin, before everything
    Vec3f middle;               // of the bulk
    float reach;                // of the room's light
    double seconds;             // that the shutter is open
    std::vector<Vec3f> normal;  // of the vertices; none: flat
    SurfaceColours colours;
    RayTracer tracer;
};

/// What one ray sees.
struct Seen {
    Hits::What what = Hits::kNothing;
    Vec3f position;
    Vec3f start;   // of rays that leave the surface
    Vec3f normal;  // smoothed, towards the eye
    Vec3f facet;   // the surface's own, towards the eye
    Vec3f to_eye;
    Vec3f colour;
    Vec3f velocity{0, 0, 0};  // world units per second
};

Vec3f atRow(const std::array<Rays::Row<float>, 3>& rows, std::size_t i) { return {rows[0][i], rows[1][i], rows[2][i]}; }

void setRow(std::array<Rays::Row<float>, 3>& rows, std::size_t i, const Vec3f& v) {
    rows[0][i] = v.x, rows[1][i] = v.y, rows[2][i] = v.z;
}

template <typename T>
Vec3f mixed(const std::vector<T>& rows, const Triangle& t, float u, float v) {
    return Vec3f(rows[t[0]]) * (1 - u - v) + Vec3f(rows[t[1]]) * u + Vec3f(rows[t[2]]) * v;
}

/// How much of the edges of a triangle covers a pixel, 0 to 1.
float wire(const Studio& studio, const Triangle& t, float u, float v, const Vec3f& position) {
    const Vec3 a = studio.mesh.position[t[0]], b = studio.mesh.position[t[1]], c = studio.mesh.position[t[2]];
    const double doubled_area = cross(b - a, c - a).length();
    const double distance =
        std::min({(1.0 - static_cast<double>(u + v)) / (c - b).length(), static_cast<double>(u) / (a - c).length(),
                  static_cast<double>(v) / (b - a).length()}) *
        doubled_area;
    const double pixel = studio.view.pixel() * studio.view.depth(studio.space.toWorld(position));
    return static_cast<float>(std::clamp(studio.look.wireframe / 2 + 0.5 - distance / pixel, 0.0, 1.0));
}

double largestCoordinate(const Vec3& p) { return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}); }

/// The place in the world of row i in the moment of a ray, 0 to 1 within the shutter.
Vec3 placeAt(const Studio& studio, const std::vector<Vec3>& position, const std::vector<Vec3>& velocity,
             std::uint32_t i, float time) {
    const double later = (static_cast<double>(time) - 0.5) * studio.seconds;
    return studio.space.fromWorld(later == 0 || velocity.empty() ? position[i] : position[i] + velocity[i] * later);
}

/// Where a triangle is hit, to the last digit, and where rays start there: as far above as it bulges between its
/// smoothed normals, lest facets shadow what is shaded as round, and off the surface by more than rounding errors.
///
/// in      side: of smoothed normals, 1 outside, -1 inside; 0: flat
/// source  Hanika 2021, "Hacking the shadow terminator" (Ray Tracing Gems II, chapter 4); Pharr, Jakob & Humphreys
///         2023, "Physically Based Rendering", section 6.8
void placeOnTriangle(const Studio& studio, const Triangle& t, float u, float v, float time, int side, Seen& seen) {
    const std::array<double, 3> weight{1 - static_cast<double>(u) - static_cast<double>(v), static_cast<double>(u),
                                       static_cast<double>(v)};
    Vec3 at(0, 0, 0), corner[3];
    double largest = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        corner[i] = placeAt(studio, studio.mesh.position, studio.mesh.velocity, t[i], time);
        at += corner[i] * weight[i];
        largest = std::max(largest, largestCoordinate(corner[i]));
    }
    seen.position = Vec3f(at);
    if (side != 0) {
        Vec3 bulge(0, 0, 0);
        for (std::size_t i = 0; i < 3; ++i) {
            const Vec3 normal = Vec3(studio.normal[t[i]]) * side;
            bulge -= normal * (std::min(0.0, dot(at - corner[i], normal)) * weight[i]);
        }
        at += bulge;
    }
    seen.start = Vec3f(at + Vec3(seen.facet) * (static_cast<double>(kRayOffset) * largest));
}

void placeOnSphere(const Studio& studio, std::uint32_t row, float time, Seen& seen) {
    const Vec3 centre = placeAt(studio, studio.spheres.position, studio.spheres.velocity, row, time);
    const double radius = static_cast<double>(studio.spheres.radius[row]) * studio.space.scale;
    const Vec3 out = (Vec3(seen.position) - centre).normalized();
    const double side = dot(out, Vec3(seen.facet)) < 0 ? -1 : 1;
    seen.position = Vec3f(centre + out * radius);
    const double gap = static_cast<double>(kRayOffset) * (largestCoordinate(centre) + radius);
    seen.start = Vec3f(centre + out * (radius + side * gap));
}

Seen seenBy(const Studio& studio, const Rays& rays, const Hits& hits, std::size_t i) {
    Seen seen;
    seen.what = hits.what[i];
    if (seen.what == Hits::kNothing) return seen;
    const Vec3f direction = atRow(rays.direction, i);
    seen.position = atRow(rays.origin, i) + direction * hits.distance[i];
    seen.to_eye = -direction.normalized();
    seen.facet = atRow(hits.normal, i).normalized();
    seen.colour = studio.colours.plain;
    const std::uint32_t row = hits.row[i];
    const bool inside = seen.facet.dot(seen.to_eye) < 0;
    if (inside) seen.facet = -seen.facet;
    seen.normal = seen.facet;
    if (seen.what == Hits::kTriangle) {
        const Triangle& t = studio.mesh.triangles[row];
        const float u = hits.u[i], v = hits.v[i];
        int side = 0;
        if (!studio.normal.empty()) {
            const Vec3f smooth = mixed(studio.normal, t, u, v) * (inside ? -1.0f : 1.0f);
            if (smooth.dot(seen.facet) > 0) {
                seen.normal = smooth.normalized();
                side = inside ? -1 : 1;
            }
        }
        placeOnTriangle(studio, t, u, v, rays.time[i], side, seen);
        if (!studio.colours.vertex.empty()) seen.colour = mixed(studio.colours.vertex, t, u, v);
        if (!studio.colours.triangle.empty()) seen.colour = studio.colours.triangle[row];
        if (!studio.mesh.velocity.empty()) seen.velocity = mixed(studio.mesh.velocity, t, u, v);
        if (studio.look.wireframe > 0) seen.colour *= 1 - (1 - kEdgeLight) * wire(studio, t, u, v, seen.position);
    } else if (seen.what == Hits::kSection) {
        seen.colour = kSectionColour;
        const auto largest = static_cast<float>(largestCoordinate(Vec3(seen.position)));
        seen.start = seen.position + seen.facet * (kRayOffset * largest);
    } else {
        placeOnSphere(studio, row, rays.time[i], seen);
        if (!studio.colours.sphere.empty()) seen.colour = studio.colours.sphere[row];
        if (!studio.spheres.velocity.empty()) seen.velocity = Vec3f(studio.spheres.velocity[row]);
    }
    const float away = seen.normal.dot(seen.to_eye);  // smoothed normals may lean back from the eye
    if (away < 0.02f) seen.normal = (seen.normal + seen.to_eye * (0.02f - away)).normalized();
    return seen;
}

/// Eight pixels side by side.
struct Packet {
    Rays::Row<int> x{}, y{};
    Rays::Row<int> inside{};  // -1 where the picture has a pixel

    Packet(int left, int top, const Look& look) {
        for (std::size_t i = 0; i < Rays::kCount; ++i) {
            x[i] = left + static_cast<int>(i) % kAcross, y[i] = top + static_cast<int>(i) / kAcross;
            inside[i] = x[i] < look.width && y[i] < look.height ? -1 : 0;
        }
    }
};
static_assert(Rays::kCount == PixelSamples::kPixels);

/// Rays from the eye through the picture, which begin where everything is still beyond.
void setEyeRay(const Studio& studio, double x, double y, std::size_t i, Rays& rays) {
    const Vec3 direction = studio.view.direction(x, y);
    setRow(rays.origin, i, Vec3f(studio.space.fromWorld(studio.view.position() + direction * studio.near)));
    setRow(rays.direction, i, Vec3f(direction));
}

/// Shares of the light that reach eight points, each 0 or 1.
struct Arriving {
    Rays::Row<float> key{}, sky{};
};

/// Casts one ray at the key light and one anywhere above each point.
Arriving lightArriving(const Studio& studio, const PixelSamples& samples, const Rays::Row<Seen>& seen,
                       const Rays::Row<float>& time, const Rays::Row<int>& lit, int s) {
    Rays key, sky;
    key.active = sky.active = lit;
    key.time = sky.time = time;
    Arriving arriving;
    const PixelSamples::Pairs on_key = samples.inDisc(PixelSamples::Use::key_light, s),
                              on_sky = samples.inDisc(PixelSamples::Use::sky, s);
    for (std::size_t i = 0; i < Rays::kCount; ++i) {
        if (lit[i] == 0) continue;
        const Vec3f &n = seen[i].normal, &facet = seen[i].facet;
        const Vec3f to_key =
            studio.lights.key + studio.lights.key_across[0] * on_key.x[i] + studio.lights.key_across[1] * on_key.y[i];
        setRow(key.origin, i, seen[i].start);
        setRow(key.direction, i, to_key);
        key.most[i] = kFar;
        if (n.dot(to_key) <= 0) key.active[i] = 0;  // hidden by the surface itself, were it as round as it is shaded
        const Vec3f side = n.cross(std::abs(n.x) < 0.6f ? Vec3f(1, 0, 0) : Vec3f(0, 1, 0)).normalized();
        const float rise = std::sqrt(std::max(0.0f, 1 - on_sky.x[i] * on_sky.x[i] - on_sky.y[i] * on_sky.y[i]));
        Vec3f to_sky = side * on_sky.x[i] + n.cross(side) * on_sky.y[i] + n * rise;
        const float below = to_sky.dot(facet);
        if (below < 0) to_sky -= facet * (2 * below);  // the facet leans further than the surface it stands for
        setRow(sky.origin, i, seen[i].start);
        setRow(sky.direction, i, to_sky);
        sky.most[i] = studio.reach;
    }
    const auto key_blocked = studio.tracer.blocked(key), sky_blocked = studio.tracer.blocked(sky);
    for (std::size_t i = 0; i < Rays::kCount; ++i) {
        arriving.key[i] = key.active[i] != 0 && key_blocked[i] == 0 ? 1.0f : 0.0f;
        arriving.sky[i] = sky_blocked[i] == 0 ? 1.0f : 0.0f;
    }
    return arriving;
}

/// The ground where a ray from the eye meets it, if it takes shadows there.
bool meetsGround(const Studio& studio, double x, double y, Seen& seen) {
    if (!studio.look.ground) return false;
    const Vec3 direction = studio.view.direction(x, y), up(studio.lights.up);
    const double falling = -dot(direction, up), height = dot(studio.view.position(), up) - *studio.look.ground;
    if (falling <= 0 || height <= 0) return false;
    seen.start = Vec3f(studio.space.fromWorld(studio.view.position() + direction * (height / falling)));
    seen.facet = seen.normal = studio.lights.up;
    return (seen.start - studio.middle).length() < studio.reach * kGroundReach;
}

/// Of the samples of a pixel that see one smooth surface.
struct SurfaceSums {
    float count = 0;
    float key = 0, sky = 0;                      // how many of them each light reaches
    Vec3f from_key{0, 0, 0}, from_sky{0, 0, 0};  // as ShadedLight
    Vec3f position{0, 0, 0}, normal{0, 0, 0};    // of the first
};

/// Of the samples of a pixel.
struct Sums {
    Vec3f light{0, 0, 0};
    float alpha = 0, shadow = 0;
    SurfaceSums first, second;  // the second surface: all that is not the first
};

float depthOf(const Studio& studio, const Vec3f& position) {
    return static_cast<float>(studio.view.depth(studio.space.toWorld(position)) * studio.space.scale);
}

/// Whether the surface that a sample meets goes on from the one that others of its pixel met.
bool goesOn(const Studio& studio, const SurfaceSums& surface, const Seen& seen) {
    if ((seen.normal - surface.normal).length2() >= LitSurfaces::kNormalsApart) return false;
    const float pixel = static_cast<float>(studio.view.pixel()) * depthOf(studio, surface.position);
    return std::abs((seen.position - surface.position).dot(surface.normal)) < LitSurfaces::kOffPlane * pixel;
}

/// Sample s of a packet of pixels.
void addSample(const Studio& studio, const Packet& packet, const PixelSamples& samples, int s,
               Rays::Row<Sums>& sums) {
    Rays rays;
    rays.active = packet.inside;
    rays.most.fill(kFar);
    std::array<std::array<double, 2>, Rays::kCount> at{};
    PixelSamples::Pairs in_pixel = samples.inSquare(PixelSamples::Use::pixel, s), in_shutter{};
    if (studio.look.samples == 1) in_pixel.x.fill(0.5f), in_pixel.y.fill(0.5f);
    in_shutter.x.fill(0.5f);
    if (studio.seconds > 0) in_shutter = samples.inSquare(PixelSamples::Use::shutter, s);
    for (std::size_t i = 0; i < Rays::kCount; ++i) {
        at[i] = {packet.x[i] + static_cast<double>(in_pixel.x[i]), packet.y[i] + static_cast<double>(in_pixel.y[i])};
        setEyeRay(studio, at[i][0], at[i][1], i, rays);
        rays.time[i] = in_shutter.x[i];
    }
    const Hits hits = studio.tracer.nearest(rays);
    Rays::Row<Seen> seen;
    Rays::Row<int> lit{};
    for (std::size_t i = 0; i < Rays::kCount; ++i) {
        if (packet.inside[i] == 0) continue;
        seen[i] = seenBy(studio, rays, hits, i);
        lit[i] = seen[i].what != Hits::kNothing || meetsGround(studio, at[i][0], at[i][1], seen[i]) ? -1 : 0;
    }
    if (std::none_of(lit.begin(), lit.end(), [](int active) { return active != 0; })) return;
    const Arriving arriving = lightArriving(studio, samples, seen, rays.time, lit, s);
    for (std::size_t i = 0; i < Rays::kCount; ++i) {
        if (lit[i] == 0) continue;
        const float key = arriving.key[i], sky = arriving.sky[i];
        Sums& sum = sums[i];
        if (seen[i].what == Hits::kNothing) {
            sum.shadow += 1 - (1 - kShadowOnGround * (1 - key)) * (1 - kOcclusionOnGround * (1 - sky));
            continue;
        }
        const ShadedLight light =
            shadedLight(seen[i].normal, seen[i].to_eye, seen[i].colour, studio.lights, studio.look.shading);
        sum.light += light.always + light.key * key + light.sky * sky;
        sum.alpha += 1;
        SurfaceSums& surface = sum.first.count == 0 || goesOn(studio, sum.first, seen[i]) ? sum.first : sum.second;
        if (surface.count == 0) surface.position = seen[i].position, surface.normal = seen[i].normal;
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

/// The planes that are neither blurred nor averaged.
void fillLayers(const Studio& studio, const Packet& packet, Picture& picture) {
    Rays rays;
    rays.active = packet.inside;
    rays.most.fill(kFar);
    rays.time.fill(0.5f);
    for (std::size_t i = 0; i < Rays::kCount; ++i) setEyeRay(studio, packet.x[i] + 0.5, packet.y[i] + 0.5, i, rays);
    const Hits hits = studio.tracer.nearest(rays);
    for (std::size_t i = 0; i < Rays::kCount; ++i) {
        if (packet.inside[i] == 0) continue;
        const std::size_t pixel = rowOf(picture, packet.x[i], packet.y[i]);
        const Seen seen = seenBy(studio, rays, hits, i);
        picture.depth[pixel] = Picture::kFarAway;
        if (seen.what == Hits::kNothing) continue;
        picture.id[pixel] = seen.what == Hits::kSphere ? Picture::kSphere : Picture::kMesh;
        const Vec3 position = studio.space.toWorld(seen.position);
        picture.depth[pixel] = static_cast<float>(studio.view.depth(position));
        const auto now = studio.view.seen(position),
                   then = studio.view.seen(position + Vec3(seen.velocity) / studio.look.fps);
        for (int axis = 0; axis < 3; ++axis) {
            const auto a = static_cast<std::size_t>(axis);
            picture.normal[a][pixel] = seen.normal[axis];
            picture.position[a][pixel] = static_cast<float>(position[axis]);
        }
        picture.motion[0][pixel] = static_cast<float>(then[0] - now[0]);
        picture.motion[1][pixel] = static_cast<float>(now[1] - then[1]);
    }
}

Picture emptyPicture(const Look& look) {
    Picture picture;
    picture.width = look.width;
    picture.height = look.height;
    for (Plane* plane : {&picture.red, &picture.green, &picture.blue, &picture.alpha, &picture.shadow})
        plane->resize(picture.size());
    if (!look.layers) return picture;
    picture.depth.resize(picture.size());
    for (Plane& plane : picture.normal) plane.resize(picture.size());
    for (Plane& plane : picture.position) plane.resize(picture.size());
    for (Plane& plane : picture.motion) plane.resize(picture.size());
    picture.id.resize(picture.size());
    return picture;
}

SurfaceSample meanOf(const Studio& studio, const SurfaceSums& sum) {
    const float share = 1 / static_cast<float>(studio.look.samples);
    return {sum.key / sum.count, sum.sky / sum.count, sum.count * share, sum.from_key * share, sum.from_sky * share,
            sum.normal,          depthOf(studio, sum.position)};
}

void setPixel(const Sums& sum, int samples, std::size_t pixel, Picture& picture) {
    const float share = 1 / static_cast<float>(samples), open = static_cast<float>(samples) - sum.alpha;
    picture.red[pixel] = sum.light.x * share;
    picture.green[pixel] = sum.light.y * share;
    picture.blue[pixel] = sum.light.z * share;
    picture.alpha[pixel] = sum.alpha * share;
    picture.shadow[pixel] = open > 0 ? sum.shadow / open : 0;
}

Picture photographed(const Studio& studio) {
    const Look& look = studio.look;
    Picture picture = emptyPicture(look);
    const int columns = (look.width + kTile - 1) / kTile, rows = (look.height + kTile - 1) / kTile;
    LitSurfaces surfaces(picture.size(), static_cast<std::size_t>(columns * rows));
    parallelFor(static_cast<std::size_t>(columns * rows), 1, [&](std::size_t tile) {
        const int x0 = static_cast<int>(tile) % columns * kTile, y0 = static_cast<int>(tile) / columns * kTile;
        for (int top = y0; top < std::min(y0 + kTile, look.height); top += kDown)
            for (int left = x0; left < std::min(x0 + kTile, look.width); left += kAcross) {
                const Packet packet(left, top, look);
                const PixelSamples samples(packet.x, packet.y, look.samples);
                Rays::Row<Sums> sums;
                for (int s = 0; s < look.samples; ++s) addSample(studio, packet, samples, s, sums);
                for (std::size_t i = 0; i < Rays::kCount; ++i) {
                    if (packet.inside[i] == 0) continue;
                    const std::size_t pixel = rowOf(picture, packet.x[i], packet.y[i]);
                    setPixel(sums[i], look.samples, pixel, picture);
                    if (sums[i].first.count > 0) surfaces.set(pixel, meanOf(studio, sums[i].first));
                    if (sums[i].second.count > 0)
                        surfaces.second[tile].push_back({packet.x[i], packet.y[i], meanOf(studio, sums[i].second)});
                }
                if (look.layers) fillLayers(studio, packet, picture);
            }
    });
    filterLight(surfaces, studio.view, look.samples, picture);
    return picture;
}

std::optional<CutPlane> planeOf(const std::optional<Cut>& cut, const SceneSpace& space) {
    if (!cut) return std::nullopt;
    const double side = cut->below ? 1 : -1;
    CutPlane plane{{0, 0, 0}, static_cast<float>(side * (cut->at - space.origin[cut->axis]) * space.scale)};
    plane.normal[cut->axis] = static_cast<float>(side);
    return plane;
}

double largestSpeed(const std::vector<Vec3>& velocity) {
    double squared = 0;
    for (const Vec3& v : velocity) squared = std::max(squared, v.length2());
    return std::sqrt(squared);
}

/// Where the camera looks, or what is nearest to that: there digits are needed most.
SceneSpace spaceOf(const Bounds& bounds, const Camera& camera) {
    SceneSpace space;
    if (bounds.empty()) return space;
    for (int axis = 0; axis < 3; ++axis)
        space.origin[axis] = std::clamp(camera.look_at[axis], bounds.low[axis], bounds.high[axis]);
    const double size = bounds.diagonal();
    if (size > 0) space.scale = std::ldexp(1.0, -std::ilogb(size));
    return space;
}

}  // namespace

Picture renderFrame(const Mesh& mesh, const Spheres& spheres, const Camera& camera, const Look& look) {
    const Bounds all = boundsOf(mesh, spheres), bulk = boundsOfBulk(mesh, spheres, {});
    const View view(camera, look.width, look.height);
    const SceneSpace space = spaceOf(all, camera);
    const double seconds = look.shutter / look.fps;
    const double way = seconds / 2 * std::max(largestSpeed(mesh.velocity), largestSpeed(spheres.velocity));
    const double near = view.depth(all.centre()) - (all.diagonal() / 2 + way) * (1 + 1e-6);

    std::vector<Vec3> normal;
    if (!look.flat || look.colouring.by == ColourBy::curvature)
        normal = vertexNormals(mesh.position.size(), mesh.triangles,
                               [&](std::uint32_t v) -> const Vec3& { return mesh.position[v]; });
    SurfaceColours colours = surfaceColours(mesh, spheres, normal, look.colouring);
    std::vector<Vec3f> rounded(look.flat ? 0 : normal.size());
    parallelFor(rounded.size(), 65536, [&](std::size_t i) { rounded[i] = Vec3f(normal[i]); });
    const Studio studio{mesh,
                        spheres,
                        look,
                        view,
                        studioLights(view, camera.up),
                        space,
                        std::max(0.0, near),
                        Vec3f(space.fromWorld(bulk.centre())),
                        static_cast<float>(bulk.diagonal() * kOcclusionReach * space.scale),
                        seconds,
                        std::move(rounded),
                        std::move(colours),
                        {mesh, spheres, space, seconds, planeOf(look.cut, space)}};
    return photographed(studio);
}

}  // namespace betamesh
