#include "preview/render_frame.h"

#include "core/parallel.h"
#include "core/vertex_normals.h"
#include "preview/colours.h"
#include "preview/ray_tracer.h"
#include "preview/shade.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace betamesh {
namespace {

constexpr int kAcross = 4, kDown = 2;     // pixels of a packet of rays
constexpr int kTile = 32;                 // pixels to a side of what one thread does at a time
constexpr double kSurfaceGap = 2e-4;      // of the scene's size: how far rays start from the surface they leave
constexpr double kOcclusionReach = 0.25;  // of the scene's size: how far the room's light looks for what hides it
constexpr float kGroundReach = 8;         // times that: how far out the ground takes shadows
constexpr float kShadowOnGround = 0.55f, kOcclusionOnGround = 0.5f;  // share of the ground's light that they take
const Vec3f kSectionColour(0.30f, 0.36f, 0.42f);                     // linear light, where the cut shows the inside
constexpr float kEdgeLight = 0.25f;                                  // of the surface's, where the wireframe is drawn
constexpr int kCalm = 2;  // pixels: how far shadows on the ground are averaged
constexpr float kFar = 1e30f;

/// In [0, 1), also after rounding to float.
float fraction(double x) { return std::min(static_cast<float>(x - std::floor(x)), 0x1.fffffep-1f); }

/// Evenly spread numbers for sample s of a pixel. Where in the pixel is the same for all of them; the rest differs
/// from one to the next in a way that hides in the picture.
/// source  Roberts 2018, "The unreasonable effectiveness of quasirandom sequences"; Jimenez 2014, interleaved gradient
///         noise
struct Spread {
    static constexpr std::size_t kCircle = 1024;  // directions

    int samples;

    static double noise(int x, int y, int kind) {
        const double u = x + 5.588238 * kind, v = y + 3.213371 * kind;
        const double inner = 0.06711056 * u + 0.00583715 * v;
        const double value = 52.9829189 * (inner - std::floor(inner));
        return value - std::floor(value);
    }
    static const std::array<std::array<float, 2>, kCircle>& circle() {
        static const auto points = [] {
            std::array<std::array<float, 2>, kCircle> made;
            for (std::size_t i = 0; i < kCircle; ++i) {
                const double angle = 2 * std::numbers::pi * (static_cast<double>(i) + 0.5) / kCircle;
                made[i] = {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))};
            }
            return made;
        }();
        return points;
    }
    std::array<float, 2> inPixel(int s) const {
        if (samples == 1) return {0.5f, 0.5f};
        return {(static_cast<float>(s) + 0.5f) / static_cast<float>(samples), fraction((s + 0.5) * std::numbers::phi)};
    }
    float inShutter(int x, int y, int s) const { return fraction(noise(x, y, 0) + s * 0.8191725134); }
    std::array<float, 2> inDisc(int x, int y, int s, int kind) const {
        const float radius = std::sqrt(fraction(noise(x, y, kind) + s * 0.7548776662));
        const float turn = fraction(noise(x, y, kind + 1) + s * 0.5698402910);
        const auto& towards = circle()[static_cast<std::size_t>(turn * kCircle)];
        return {radius * towards[0], radius * towards[1]};
    }
};

/// A frame ready to be looked at. Positions count from `origin`.
struct Studio {
    const Mesh& mesh;
    const Spheres& spheres;
    const Look& look;
    View view;
    Lights lights;
    Vec3 origin;
    Vec3f eye;
    float gap, reach;
    std::vector<Vec3f> normal;  // of the vertices; none: flat
    SurfaceColours colours;
    RayTracer tracer;
    float ground = 0;  // along lights.up
};

/// What one ray sees.
struct Seen {
    Hits::What what = Hits::kNothing;
    Vec3f position;  // from the studio's origin
    Vec3f normal;    // smoothed, towards the eye
    Vec3f facet;     // the surface's own, towards the eye
    Vec3f to_eye;
    Vec3f colour;
    Vec3f velocity;
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
    const double pixel = studio.view.pixel() * studio.view.depth(Vec3(position) + studio.origin);
    return static_cast<float>(std::clamp(studio.look.wireframe / 2 + 0.5 - distance / pixel, 0.0, 1.0));
}

Seen seenBy(const Studio& studio, const Rays& rays, const Hits& hits, std::size_t i) {
    Seen seen;
    seen.what = hits.what[i];
    if (seen.what == Hits::kNothing) return seen;
    const Vec3f direction = atRow(rays.direction, i);
    seen.position = atRow(rays.origin, i) + direction * hits.distance[i];
    seen.to_eye = -direction.normalized();
    seen.facet = atRow(hits.normal, i).normalized();
    seen.normal = seen.facet;
    seen.colour = studio.colours.plain;
    const std::uint32_t row = hits.row[i];
    if (seen.what == Hits::kTriangle) {
        const Triangle& t = studio.mesh.triangles[row];
        const float u = hits.u[i], v = hits.v[i];
        if (!studio.normal.empty()) {
            const Vec3f smooth = mixed(studio.normal, t, u, v);
            if (smooth.dot(seen.facet) > 0) seen.normal = smooth.normalized();
        }
        if (!studio.colours.vertex.empty()) seen.colour = mixed(studio.colours.vertex, t, u, v);
        if (!studio.colours.triangle.empty()) seen.colour = studio.colours.triangle[row];
        if (!studio.mesh.velocity.empty()) seen.velocity = mixed(studio.mesh.velocity, t, u, v);
        if (studio.look.wireframe > 0) seen.colour *= 1 - (1 - kEdgeLight) * wire(studio, t, u, v, seen.position);
    } else if (seen.what == Hits::kSection) {
        seen.colour = kSectionColour;
    } else {
        if (!studio.colours.sphere.empty()) seen.colour = studio.colours.sphere[row];
        if (!studio.spheres.velocity.empty()) seen.velocity = Vec3f(studio.spheres.velocity[row]);
    }
    if (seen.facet.dot(seen.to_eye) < 0) {  // the inside
        seen.facet = -seen.facet;
        seen.normal = -seen.normal;
    }
    const float away = seen.normal.dot(seen.to_eye);  // smoothed normals may lean back from the eye
    if (away < 0.02f) seen.normal = (seen.normal + seen.to_eye * (0.02f - away)).normalized();
    return seen;
}

/// Shares of the light that reach eight points.
struct Arriving {
    Rays::Row<std::uint8_t> key_blocked{}, sky_blocked{};
};

/// Casts one ray at the key light and one anywhere above each point.
Arriving lightArriving(const Studio& studio, const Rays::Row<Vec3f>& position, const Rays::Row<Vec3f>& facet,
                       const Rays::Row<Vec3f>& normal, const Rays& eye_rays, const Rays::Row<int>& active, int left,
                       int top, int s) {
    const Spread spread{studio.look.samples};
    Rays key, sky;
    key.active = sky.active = active;
    key.time = sky.time = eye_rays.time;
    for (std::size_t i = 0; i < Rays::kCount; ++i) {
        if (active[i] == 0) continue;
        const int x = left + static_cast<int>(i) % kAcross, y = top + static_cast<int>(i) / kAcross;
        const Vec3f start = position[i] + facet[i] * studio.gap;
        const auto on_key = spread.inDisc(x, y, s, 1), on_sky = spread.inDisc(x, y, s, 3);
        setRow(key.origin, i, start);
        setRow(key.direction, i,
               studio.lights.key + studio.lights.key_across[0] * on_key[0] + studio.lights.key_across[1] * on_key[1]);
        key.most[i] = kFar;
        if (normal[i].dot(studio.lights.key) <= 0) key.active[i] = 0;
        const Vec3f& n = normal[i];
        const Vec3f side = n.cross(std::abs(n.x) < 0.6f ? Vec3f(1, 0, 0) : Vec3f(0, 1, 0)).normalized();
        const float rise = std::sqrt(std::max(0.0f, 1 - on_sky[0] * on_sky[0] - on_sky[1] * on_sky[1]));
        setRow(sky.origin, i, start);
        setRow(sky.direction, i, side * on_sky[0] + n.cross(side) * on_sky[1] + n * rise);
        sky.most[i] = studio.reach;
    }
    return {studio.tracer.blocked(key), studio.tracer.blocked(sky)};
}

struct Sums {
    Vec3f light{0, 0, 0};
    float alpha = 0, shadow = 0;
};

/// Sample s of the packet of pixels whose top left one is (left, top).
void addSample(const Studio& studio, int left, int top, int s, const Rays::Row<int>& inside, Rays::Row<Sums>& sums) {
    const Spread spread{studio.look.samples};
    const auto in_pixel = spread.inPixel(s);
    Rays rays;
    rays.active = inside;
    rays.most.fill(kFar);
    for (std::size_t i = 0; i < Rays::kCount; ++i) {
        const int x = left + static_cast<int>(i) % kAcross, y = top + static_cast<int>(i) / kAcross;
        setRow(rays.origin, i, studio.eye);
        setRow(
            rays.direction, i,
            Vec3f(studio.view.direction(x + static_cast<double>(in_pixel[0]), y + static_cast<double>(in_pixel[1]))));
        rays.time[i] = spread.inShutter(x, y, s);
    }
    const Hits hits = studio.tracer.nearest(rays);
    Rays::Row<Seen> seen;
    Rays::Row<Vec3f> position{}, facet{}, normal{};
    Rays::Row<int> lit{};
    const Vec3f& up = studio.lights.up;
    for (std::size_t i = 0; i < Rays::kCount; ++i) {
        if (inside[i] == 0) continue;
        seen[i] = seenBy(studio, rays, hits, i);
        position[i] = seen[i].position, facet[i] = seen[i].facet, normal[i] = seen[i].normal;
        lit[i] = seen[i].what != Hits::kNothing ? -1 : 0;
        if (lit[i] != 0 || !studio.look.ground) continue;
        const Vec3f direction = atRow(rays.direction, i);
        const float falling = -direction.dot(up), height = studio.eye.dot(up) - studio.ground;
        if (falling <= 0 || height <= 0) continue;
        position[i] = studio.eye + direction * (height / falling);
        facet[i] = normal[i] = up;
        lit[i] = position[i].length() < studio.reach * kGroundReach ? -1 : 0;
    }
    const Arriving arriving = lightArriving(studio, position, facet, normal, rays, lit, left, top, s);
    for (std::size_t i = 0; i < Rays::kCount; ++i) {
        if (lit[i] == 0) continue;
        if (seen[i].what == Hits::kNothing) {
            sums[i].shadow += 1 - (1 - kShadowOnGround * arriving.key_blocked[i]) *
                                      (1 - kOcclusionOnGround * arriving.sky_blocked[i]);
            continue;
        }
        const Shaded point{seen[i].normal, seen[i].to_eye, seen[i].colour, static_cast<float>(!arriving.key_blocked[i]),
                           static_cast<float>(!arriving.sky_blocked[i])};
        sums[i].light += shaded(point, studio.lights, studio.look.shading);
        sums[i].alpha += 1;
    }
}

/// The planes that are neither blurred nor averaged.
void fillLayers(const Studio& studio, int left, int top, const Rays::Row<int>& inside, Picture& picture) {
    Rays rays;
    rays.active = inside;
    rays.most.fill(kFar);
    rays.time.fill(0.5f);
    for (std::size_t i = 0; i < Rays::kCount; ++i) {
        const int x = left + static_cast<int>(i) % kAcross, y = top + static_cast<int>(i) / kAcross;
        setRow(rays.origin, i, studio.eye);
        setRow(rays.direction, i, Vec3f(studio.view.direction(x + 0.5, y + 0.5)));
    }
    const Hits hits = studio.tracer.nearest(rays);
    for (std::size_t i = 0; i < Rays::kCount; ++i) {
        if (inside[i] == 0) continue;
        const int x = left + static_cast<int>(i) % kAcross, y = top + static_cast<int>(i) / kAcross;
        const std::size_t pixel =
            static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) + static_cast<std::size_t>(x);
        const Seen seen = seenBy(studio, rays, hits, i);
        picture.depth[pixel] = Picture::kFarAway;
        if (seen.what == Hits::kNothing) continue;
        picture.id[pixel] = seen.what == Hits::kSphere ? Picture::kSphere : Picture::kMesh;
        picture.depth[pixel] = hits.distance[i];  // directions are as long as makes this the depth
        const Vec3 position = Vec3(seen.position) + studio.origin;
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

/// Rays leave grain in the soft shadows on the ground: averages them with their neighbours that see ground too.
void calmShadows(Picture& picture) {
    const Plane grainy = picture.shadow;
    const int width = picture.width, height = picture.height;
    parallelFor(static_cast<std::size_t>(height), 16, [&](std::size_t row) {
        const int y = static_cast<int>(row);
        for (int x = 0; x < width; ++x) {
            float sum = 0, count = 0;
            for (int v = std::max(0, y - kCalm); v <= std::min(height - 1, y + kCalm); ++v)
                for (int u = std::max(0, x - kCalm); u <= std::min(width - 1, x + kCalm); ++u) {
                    const auto i =
                        static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u);
                    if (picture.alpha[i] >= 1) continue;
                    sum += grainy[i], count += 1;
                }
            if (count > 0)
                picture.shadow[row * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)] = sum / count;
        }
    });
}

Picture photographed(const Studio& studio) {
    const Look& look = studio.look;
    Picture picture = emptyPicture(look);
    const auto share = 1 / static_cast<float>(look.samples);
    const int columns = (look.width + kTile - 1) / kTile, rows = (look.height + kTile - 1) / kTile;
    parallelFor(static_cast<std::size_t>(columns * rows), 1, [&](std::size_t tile) {
        const int x0 = static_cast<int>(tile) % columns * kTile, y0 = static_cast<int>(tile) / columns * kTile;
        for (int top = y0; top < std::min(y0 + kTile, look.height); top += kDown)
            for (int left = x0; left < std::min(x0 + kTile, look.width); left += kAcross) {
                Rays::Row<int> inside{};
                for (int i = 0; i < kAcross * kDown; ++i)
                    inside[static_cast<std::size_t>(i)] =
                        left + i % kAcross < look.width && top + i / kAcross < look.height ? -1 : 0;
                Rays::Row<Sums> sums;
                for (int s = 0; s < look.samples; ++s) addSample(studio, left, top, s, inside, sums);
                for (std::size_t i = 0; i < Rays::kCount; ++i) {
                    if (inside[i] == 0) continue;
                    const auto pixel = static_cast<std::size_t>(top + static_cast<int>(i) / kAcross) *
                                           static_cast<std::size_t>(look.width) +
                                       static_cast<std::size_t>(left + static_cast<int>(i) % kAcross);
                    picture.red[pixel] = sums[i].light.x * share;
                    picture.green[pixel] = sums[i].light.y * share;
                    picture.blue[pixel] = sums[i].light.z * share;
                    picture.alpha[pixel] = sums[i].alpha * share;
                    const float open = static_cast<float>(look.samples) - sums[i].alpha;
                    picture.shadow[pixel] = open > 0 ? sums[i].shadow / open : 0;
                }
                if (look.layers) fillLayers(studio, left, top, inside, picture);
            }
    });
    if (look.ground) calmShadows(picture);
    return picture;
}

std::optional<CutPlane> planeOf(const std::optional<Cut>& cut, const Vec3& origin) {
    if (!cut) return std::nullopt;
    const double side = cut->below ? 1 : -1;
    CutPlane plane{{0, 0, 0}, static_cast<float>(side * (cut->at - origin[cut->axis]))};
    plane.normal[cut->axis] = static_cast<float>(side);
    return plane;
}

}  // namespace

Picture renderFrame(const Mesh& mesh, const Spheres& spheres, const Camera& camera, const Look& look) {
    const Bounds bounds = boundsOf(mesh, spheres);
    const View view(camera, look.width, look.height);
    const Vec3 origin = bounds.centre();
    const double size = bounds.empty() ? 1 : std::max(bounds.diagonal(), 1e-30);

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
                        origin,
                        Vec3f(camera.position - origin),
                        static_cast<float>(size * kSurfaceGap),
                        static_cast<float>(size * kOcclusionReach),
                        std::move(rounded),
                        std::move(colours),
                        {mesh, spheres, origin, look.shutter / look.fps, planeOf(look.cut, origin)},
                        look.ground ? static_cast<float>(*look.ground - dot(origin, camera.up)) : 0};
    return photographed(studio);
}

}  // namespace betamesh
