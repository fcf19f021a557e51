// Rendered pictures, compared with what geometry predicts.

#include "base/icosphere.h"
#include "base/parallel.h"
#include "base/random.h"
#include "render/colours.h"
#include "render/exr_file.h"
#include "render/png_file.h"
#include "render/render_frame.h"
#include "render/shade.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace betamesh {
namespace {

Spheres ballAt(const Vec3& centre, const Vec3& velocity = {0, 0, 0}) {
    Spheres ball;
    ball.position = {centre};
    ball.velocity = {velocity};
    ball.radius = {1};
    return ball;
}

Mesh sphereMesh(const Vec3& centre, const Vec3& velocity = {0, 0, 0}) {
    const Icosphere sphere = icosphere(40);
    Mesh mesh;
    for (const Vec3& p : sphere.position) mesh.position.push_back(p + centre);
    mesh.velocity.assign(mesh.position.size(), velocity);
    mesh.triangles = sphere.triangles;
    return mesh;
}

/// A scene that is difficult to trace: intersecting triangles of all sizes, some duplicated, and balls, all of them
/// moving.
std::pair<Mesh, Spheres> heap() {
    Random random(1);
    Mesh mesh;
    Spheres spheres;
    for (int i = 0; i < 3000; ++i) {
        const Vec3 centre = random.cube(), velocity = random.cube() * 3;
        const double size = std::pow(10, random.between(-3, -0.5));
        const auto first = static_cast<std::uint32_t>(mesh.position.size());
        for (int corner = 0; corner < 3; ++corner) {
            mesh.position.push_back(centre + random.cube() * size);
            mesh.velocity.push_back(velocity + random.cube() * size);
        }
        mesh.triangles.push_back({first, first + 1, first + 2});
        if (i % 3 == 0) mesh.triangles.push_back({first, first + 2, first + 1});
        if (i % 5 != 0) continue;
        spheres.position.push_back(random.cube());
        spheres.velocity.push_back(velocity);
        spheres.radius.push_back(static_cast<float>(size / 2));
    }
    return {mesh, spheres};
}

constexpr double kDistance = 12, kFov = 20;

Camera facing(const Vec3& target) { return {target + Vec3(0, 0, kDistance), target, {0, 1, 0}, kFov}; }

RenderSettings smallSettings() {
    RenderSettings settings;
    settings.width = 320;
    settings.height = 240;
    settings.samples = 16;
    settings.layers = true;
    return settings;
}

/// Pixels per world unit at a distance in front of the camera.
double pixelsPerUnit(const RenderSettings& settings, double distance) {
    return settings.height / 2.0 / std::tan(kFov / 2 * std::numbers::pi / 180) / distance;
}

/// Coordinate of a unit sphere's surface along the axis of a camera at kDistance, averaged over its picture.
double meanHeightOfSphere() {
    const double edge = std::tan(std::asin(1 / kDistance));  // radius of the picture at unit distance
    double total = 0;
    constexpr int kRings = 100000;
    for (int i = 0; i < kRings; ++i) {
        const double slope = edge * std::sqrt((i + 0.5) / kRings), square = 1 + slope * slope;  // rings of equal area
        // The ray (0, 0, d) + t (slope, 0, -1) hits the sphere first at this t.
        const double t = (kDistance - std::sqrt(kDistance * kDistance - square * (kDistance * kDistance - 1))) / square;
        total += (kDistance - t) / kRings;
    }
    return total;
}

double sum(const Plane& plane) { return std::accumulate(plane.begin(), plane.end(), 0.0); }

struct Moments {
    double mass = 0, mean = 0, variance = 0;
};

/// Moments of alpha along x, pixels.
Moments across(const Picture& picture) {
    Moments m;
    for (int pass = 0; pass < 2; ++pass)
        for (std::size_t i = 0; i < picture.size(); ++i) {
            const double x = static_cast<double>(i % static_cast<std::size_t>(picture.width)) + 0.5,
                         a = static_cast<double>(picture.alpha[i]);
            if (pass == 0)
                m.mass += a, m.mean += a * x;
            else
                m.variance += a * (x - m.mean / m.mass) * (x - m.mean / m.mass) / m.mass;
        }
    m.mean /= m.mass;
    return m;
}

TEST(Preview, ASphereCoversTheExpectedDisc) {
    const RenderSettings settings = smallSettings();
    // The tangent cone of a unit sphere intersects the plane at unit distance in a circle of this radius.
    const double radius = pixelsPerUnit(settings, 1) * std::tan(std::asin(1 / kDistance));
    const double area = std::numbers::pi * radius * radius;
    EXPECT_NEAR(sum(renderFrame({}, ballAt({0, 0, 0}), facing({0, 0, 0}), settings).alpha), area, 0.002 * area);
    EXPECT_NEAR(sum(renderFrame(sphereMesh({0, 0, 0}), {}, facing({0, 0, 0}), settings).alpha), area, 0.003 * area);
}

TEST(Preview, NormalsDepthsAndPositionsEqualThoseOfTheSphere) {
    const RenderSettings settings = smallSettings();
    const Vec3 centre(3, -2, 1);
    for (const bool as_mesh : {false, true}) {
        const Picture picture = as_mesh ? renderFrame(sphereMesh(centre), {}, facing(centre), settings)
                                        : renderFrame({}, ballAt(centre), facing(centre), settings);
        Vec3 mean(0, 0, 0);
        double seen = 0, nearest = 1e9, farthest = 0;
        for (std::size_t i = 0; i < picture.size(); ++i) {
            if (picture.id[i] == Picture::kNothing) {
                EXPECT_EQ(picture.depth[i], Picture::kFarAway);
                continue;
            }
            EXPECT_EQ(picture.id[i], as_mesh ? Picture::kMesh : Picture::kSphere);
            const Vec3 n(picture.normal[0][i], picture.normal[1][i], picture.normal[2][i]);
            const Vec3 p(picture.position[0][i], picture.position[1][i], picture.position[2][i]);
            EXPECT_NEAR(n.length(), 1, 1e-3);
            EXPECT_NEAR((p - centre).length(), 1, 2e-3);
            EXPECT_LT((n - (p - centre)).length(), 0.03);
            EXPECT_NEAR(kDistance - (p.z - centre.z), static_cast<double>(picture.depth[i]), 1e-4);
            mean += n;
            seen += 1;
            nearest = std::min(nearest, static_cast<double>(picture.depth[i]));
            farthest = std::max(farthest, static_cast<double>(picture.depth[i]));
        }
        mean /= seen;
        EXPECT_NEAR(mean.x, 0, 0.01);
        EXPECT_NEAR(mean.y, 0, 0.01);
        EXPECT_NEAR(mean.z, meanHeightOfSphere(), 0.003);
        EXPECT_NEAR(nearest, kDistance - 1, 1e-3);
        EXPECT_NEAR(farthest, kDistance - 1 / kDistance, 0.1);  // where the eye's cone touches; it falls off steeply
    }
}

/// Number of pixels that show the section, and how many of them are wrong.
struct SectionSeen {
    double pixels = 0, wrong = 0;
};
template <typename Inside>
SectionSeen sectionSeen(const Picture& picture, double at, const Inside& inside) {
    SectionSeen seen;
    for (std::size_t i = 0; i < picture.size(); ++i) {
        const Vec3 p(picture.position[0][i], picture.position[1][i], picture.position[2][i]);
        if (picture.id[i] == Picture::kNothing || std::abs(p.z - at) > 1e-5) continue;
        EXPECT_NEAR(picture.normal[2][i], 1, 1e-5);
        seen.pixels += 1;
        seen.wrong += !inside(p);
    }
    return seen;
}

TEST(Preview, ACutawayPlaneShowsTheExpectedSection) {
    RenderSettings settings = smallSettings();
    const double at = 0.3,
                 area = std::numbers::pi * (1 - at * at) * std::pow(pixelsPerUnit(settings, kDistance - at), 2);
    settings.cutaway = CutawayPlane{2, true, at};
    for (const bool as_mesh : {false, true}) {
        const Picture picture = as_mesh ? renderFrame(sphereMesh({0, 0, 0}), {}, facing({0, 0, 0}), settings)
                                        : renderFrame({}, ballAt({0, 0, 0}), facing({0, 0, 0}), settings);
        const SectionSeen seen =
            sectionSeen(picture, at, [&](const Vec3& p) { return p.x * p.x + p.y * p.y <= 1.001 - at * at; });
        EXPECT_NEAR(seen.pixels, area, 0.01 * area);
        EXPECT_EQ(seen.wrong, 0);
    }
    // The opposite half hides the section. A plane in front of or behind everything hides all or nothing.
    settings.cutaway = CutawayPlane{2, false, at};
    EXPECT_LT(sum(renderFrame({}, ballAt({0, 0, 0}), facing({0, 0, 0}), settings).alpha), area * 1.01);
    settings.cutaway = CutawayPlane{2, true, -2};
    EXPECT_EQ(sum(renderFrame({}, ballAt({0, 0, 0}), facing({0, 0, 0}), settings).alpha), 0);
    settings.cutaway = CutawayPlane{2, true, 2};
    const Picture whole = renderFrame({}, ballAt({0, 0, 0}), facing({0, 0, 0}), settings);
    settings.cutaway.reset();
    EXPECT_EQ(encodeExr(whole), encodeExr(renderFrame({}, ballAt({0, 0, 0}), facing({0, 0, 0}), settings)));
}

TEST(Preview, ACutawayPlaneThroughManyBallsShowsTheirUnion) {
    Random random(1);
    Spheres balls;
    for (int i = 0; i < 400; ++i) {
        balls.position.push_back(random.cube() * 0.9);
        balls.radius.push_back(static_cast<float>(random.between(0.05, 0.3)));
    }
    RenderSettings settings = smallSettings();
    settings.cutaway = CutawayPlane{2, true, 0.1};
    const double slack = 1e-3;  // of a ball's edge
    const auto inOne = [&](const Vec3& p, double more) {
        for (std::size_t i = 0; i < balls.size(); ++i)
            if ((balls.position[i] - p).length() < static_cast<double>(balls.radius[i]) + more) return true;
        return false;
    };
    const Picture picture = renderFrame({}, balls, facing({0, 0, 0}), settings);
    const SectionSeen seen = sectionSeen(picture, 0.1, [&](const Vec3& p) { return inOne(p, slack); });
    EXPECT_EQ(seen.wrong, 0);
    double inside = 0;
    const View view(facing({0, 0, 0}), settings.width, settings.height);
    for (int y = 0; y < settings.height; ++y)
        for (int x = 0; x < settings.width; ++x)
            inside += inOne(view.position() + view.direction(x + 0.5, y + 0.5) * (kDistance - 0.1), -slack);
    EXPECT_GT(inside, 1000);
    EXPECT_GE(seen.pixels, inside);
}

TEST(Preview, ObjectsAtRestAreNotBlurred) {
    RenderSettings settings = smallSettings();
    const Picture sharp = renderFrame(sphereMesh({0, 0, 0}), ballAt({1, 1, 0}), facing({0, 0, 0}), settings);
    settings.shutter = 1;
    const Picture blurred = renderFrame(sphereMesh({0, 0, 0}), ballAt({1, 1, 0}), facing({0, 0, 0}), settings);
    EXPECT_EQ(encodeExr(sharp), encodeExr(blurred));
}

TEST(Preview, MotionBlurIsAsLongAsVelocityTimesExposure) {
    RenderSettings settings = smallSettings();
    settings.samples = 64;
    settings.fps = 25;
    const double speed = 30;
    for (const bool as_mesh : {false, true}) {
        const auto renderScene = [&](double shutter) {
            settings.shutter = shutter;
            const Vec3 velocity(speed, 0, 0);
            return as_mesh ? renderFrame(sphereMesh({0, 0, 0}, velocity), {}, facing({0, 0, 0}), settings)
                           : renderFrame({}, ballAt({0, 0, 0}, velocity), facing({0, 0, 0}), settings);
        };
        const Moments sharp = across(renderScene(0));
        for (const double shutter : {0.5, 1.0}) {
            const double blur_length = speed * shutter / settings.fps * pixelsPerUnit(settings, kDistance);
            const Moments blurred = across(renderScene(shutter));
            EXPECT_NEAR(blurred.mass, sharp.mass, 0.01 * sharp.mass);  // smeared, not grown
            EXPECT_NEAR(blurred.mean, sharp.mean, 0.1);                // centred on the frame
            EXPECT_NEAR(std::sqrt(12 * (blurred.variance - sharp.variance)), blur_length, 0.01 * blur_length);
        }
    }
}

TEST(Preview, MotionVectorsAreInPixelsPerFrame) {
    const RenderSettings settings = smallSettings();
    const Picture picture = renderFrame({}, ballAt({0, 0, 0}, {2.4, 1.2, 0}), facing({0, 0, 0}), settings);
    const std::size_t middle =
        static_cast<std::size_t>(settings.height) / 2 * static_cast<std::size_t>(settings.width) +
        static_cast<std::size_t>(settings.width) / 2;
    const double scale = pixelsPerUnit(settings, kDistance - 1);
    EXPECT_NEAR(static_cast<double>(picture.motion[0][middle]), 2.4 / settings.fps * scale, 1e-3);
    EXPECT_NEAR(static_cast<double>(picture.motion[1][middle]), 1.2 / settings.fps * scale, 1e-3);
}

TEST(Preview, PixelsDoNotDependOnTheThreadCount) {
    const auto [mesh, spheres] = heap();
    RenderSettings settings = smallSettings();
    settings.samples = 3;
    settings.wireframe = 1;
    settings.ground = -1.1;
    const Camera camera{{2, 2, 6}, {0, 0, 0}, {0, 1, 0}, kFov};
    for (const double shutter : {0.0, 0.5}) {
        settings.shutter = shutter;
        std::string first;
        for (const int threads : {1, 2, 3, 8}) {
            std::string bytes;
            withThreads(threads, [&] { bytes = encodeExr(renderFrame(mesh, spheres, camera, settings)); });
            if (first.empty()) first = bytes;
            EXPECT_TRUE(bytes == first) << threads << " threads, shutter " << shutter;
        }
    }
}

TEST(Preview, PicturesDoNotDependOnTheDistanceFromTheOrigin) {
    const RenderSettings settings = smallSettings();
    const Vec3 away(3e5, -2e5, 1e5);
    const Picture here = renderFrame(sphereMesh({0, 0, 0}), {}, facing({0, 0, 0}), settings);
    const Picture there = renderFrame(sphereMesh(away), {}, facing(away), settings);
    EXPECT_NEAR(sum(there.alpha), sum(here.alpha), 1);
    EXPECT_NEAR(sum(there.green), sum(here.green), 0.001 * sum(here.green));
}

/// A plane, a sphere that casts a shadow on it, and a corner with ambient occlusion.
std::pair<Mesh, Spheres> partlyShadowed() {
    Mesh mesh;
    mesh.position = {{-3, -1, -3}, {3, -1, -3}, {3, -1, 3}, {-3, -1, 3}, {-3, 2, -3}, {3, 2, -3}};
    mesh.triangles = {{0, 2, 1}, {0, 3, 2}, {0, 1, 5}, {0, 5, 4}};
    return {mesh, ballAt({0, 0, 0})};
}

const Camera kFromAbove{{4, 7, 10}, {0, -0.3, 0}, {0, 1, 0}, 30};

/// Difference of the green channels of two pictures.
std::vector<double> difference(const Picture& a, const Picture& b) {
    std::vector<double> less(a.size());
    for (std::size_t i = 0; i < less.size(); ++i)
        less[i] = static_cast<double>(a.green[i]) - static_cast<double>(b.green[i]);
    return less;
}

double rootMeanSquare(const std::vector<double>& values) {
    double squares = 0;
    for (const double x : values) squares += x * x;
    return std::sqrt(squares / static_cast<double>(values.size()));
}

/// Autocorrelation of a picture at a shift in pixels, -1 to 1.
double likeness(const std::vector<double>& values, int width, int across, int down) {
    double products = 0, squares = 0;
    const int height = static_cast<int>(values.size()) / width;
    for (int y = 0; y + down < height; ++y)
        for (int x = std::max(0, -across); x < std::min(width, width - across); ++x) {
            const double a = values[static_cast<std::size_t>(y * width + x)],
                         b = values[static_cast<std::size_t>((y + down) * width + x + across)];
            products += a * b;
            squares += (a * a + b * b) / 2;
        }
    return squares > 0 ? products / squares : 0;
}

TEST(Preview, ErrorsOfFewSamplesAreSmallAndUncorrelated) {
    const auto [mesh, spheres] = partlyShadowed();
    RenderSettings settings = smallSettings();
    settings.layers = false;
    settings.samples = 512;
    const Picture exact = renderFrame(mesh, spheres, kFromAbove, settings);
    double last = 1;
    for (const int samples : {4, 8, 32, 128}) {
        SCOPED_TRACE(samples);
        settings.samples = samples;
        const std::vector<double> wrong = difference(renderFrame(mesh, spheres, kFromAbove, settings), exact);
        const double error = rootMeanSquare(wrong);
        EXPECT_LT(error, 0.7 * last) << "more samples are better";
        last = error;
        // Errors are uncorrelated beyond the radius of the filter and of the means by which it compares pixels.
        double most = 0;
        for (int down = 0; down <= 24; ++down)
            for (int across = -24; across <= 24; ++across)
                if (std::max(std::abs(across), down) > 8)
                    most = std::max(most, std::abs(likeness(wrong, settings.width, across, down)));
        EXPECT_LT(most, 0.1);
        if (samples == 8) {
            EXPECT_LT(error, 0.004);  // a step of an 8-bit picture
        }
    }
    EXPECT_LT(last, 0.001);
}

TEST(Preview, PlanesAreEvenlyLitAtGrazingAngles) {
    RenderSettings settings = smallSettings();
    settings.layers = false;
    settings.samples = 4;
    for (int turn = 0; turn < 12; ++turn) {
        SCOPED_TRACE(turn);
        // Rotated about the camera's axis: the key light comes from the upper left and grazes some of these planes.
        Random random(static_cast<std::uint64_t>(turn));
        const double angle = turn * std::numbers::pi / 6;
        const Vec3 n = Vec3(std::cos(angle), std::sin(angle), 0.3).normalized(),
                   a = cross(n, Vec3(0, 0, 1)).normalized(), b = cross(n, a), away(1234.5, -777.25, 31.125);
        Mesh mesh;
        for (int y = 0; y <= 20; ++y)
            for (int x = 0; x <= 20; ++x)
                mesh.position.push_back(away + a * (x - 10 + random.between(-0.3, 0.3)) +
                                        b * (y - 10 + random.between(-0.3, 0.3)));
        for (std::uint32_t y = 0; y < 20; ++y)
            for (std::uint32_t x = 0; x < 20; ++x) {
                const std::uint32_t first = 21 * y + x;
                mesh.triangles.push_back({first, first + 1, first + 22});
                mesh.triangles.push_back({first, first + 22, first + 21});
            }
        const Picture picture = renderFrame(mesh, {}, facing(away), settings);
        double steepest = 0;
        for (std::size_t i = 1; i < picture.size(); ++i)
            if (i % static_cast<std::size_t>(settings.width) > 0 && picture.alpha[i - 1] == 1 && picture.alpha[i] == 1)
                steepest = std::max(steepest, static_cast<double>(std::abs(picture.green[i] - picture.green[i - 1])));
        EXPECT_LT(steepest, 0.02);
    }
}

TEST(Preview, TheNormalsOfAMeshAreUsed) {
    const Vec3 tilt(0, 0.2, 0);
    Mesh mesh = sphereMesh({0, 0, 0});
    Attribute normals{"N", 3, {}, {}};
    for (const Vec3& p : mesh.position)
        for (int k = 0; k < 3; ++k)
            normals.real.push_back(static_cast<float>(3 * (p + tilt)[k]));  // any length will do
    mesh.attributes = {normals};
    const Picture picture = renderFrame(mesh, {}, facing({0, 0, 0}), smallSettings());
    std::size_t seen = 0;
    for (std::size_t i = 0; i < picture.size(); ++i) {
        const Vec3 p(picture.position[0][i], picture.position[1][i], picture.position[2][i]);
        if (picture.alpha[i] < 1 || p.z < 0.7) continue;  // nearer to the rim normals may point away from the camera
        ++seen;
        const Vec3 n(picture.normal[0][i], picture.normal[1][i], picture.normal[2][i]);
        EXPECT_LT((n - (p + tilt).normalized()).length(), 0.03);
    }
    EXPECT_GT(seen, 1000U);
}

TEST(Preview, ACoarseSphereIsShadedLikeARoundOne) {
    Mesh coarse;
    const Icosphere sphere = icosphere(4);
    coarse.position = sphere.position, coarse.triangles = sphere.triangles;
    RenderSettings settings = smallSettings();
    settings.samples = 64;
    const Picture facets = renderFrame(coarse, {}, facing({0, 0, 0}), settings),
                  round = renderFrame({}, ballAt({0, 0, 0}), facing({0, 0, 0}), settings);
    const std::vector<double> wrong = difference(facets, round);
    const Vec3f key = studioLights(View(facing({0, 0, 0}), settings.width, settings.height), {0, 1, 0}).key;
    double worst = 0, seen = 0;
    for (std::size_t i = 0; i < facets.size(); ++i) {
        const Vec3f n(round.normal[0][i], round.normal[1][i], round.normal[2][i]);
        if (round.alpha[i] < 1 || n.z < 0.6f) continue;  // near the rim they are of different sizes
        if (n.dot(key) > 0.3f) continue;                 // near the terminator facets would show
        worst = std::max(worst, std::abs(wrong[i]));
        seen += 1;
    }
    EXPECT_GT(seen, 2000);
    EXPECT_LT(worst, 0.006);
}

TEST(Preview, PicturesDoNotDependOnTheScaleOfTheScene) {
    const auto renderScene = [](double scale, double shift) {
        auto [mesh, spheres] = partlyShadowed();
        spheres.position.push_back({1.5, -0.2, 1});
        spheres.velocity = {{0, 0, 0}, {3, 0, 0}};
        spheres.radius.push_back(0.25f);
        const Vec3 away(shift, shift, -shift);
        for (auto* rows : {&mesh.position, &spheres.position, &spheres.velocity})
            for (Vec3& row : *rows) row *= scale;
        for (auto* rows : {&mesh.position, &spheres.position})
            for (Vec3& row : *rows) row += away;
        for (float& radius : spheres.radius) radius = static_cast<float>(static_cast<double>(radius) * scale);
        RenderSettings settings = smallSettings();
        settings.shutter = 0.5;
        settings.wireframe = 1;
        settings.ground = -1.1 * scale + shift;
        CameraFinder finder({}, static_cast<double>(settings.width) / settings.height);
        visitBulk(mesh, spheres, {}, [&](const Vec3& p, double radius) { finder.add(p, radius); });
        return renderFrame(mesh, spheres, finder.camera(), settings);
    };
    const Picture reference = renderScene(1, 0);
    EXPECT_GT(sum(reference.alpha), 0.2 * static_cast<double>(reference.size()));
    for (const int power : {-40, -30, 53, 64}) {  // so that scaling rounds nothing
        SCOPED_TRACE(power);
        const Picture other = renderScene(std::ldexp(1.0, power), 0);
        EXPECT_EQ(other.alpha, reference.alpha);
        EXPECT_EQ(other.green, reference.green);
        EXPECT_EQ(other.shadow, reference.shadow);
        EXPECT_EQ(other.normal, reference.normal);
        EXPECT_EQ(other.id, reference.id);
    }
    for (const double scale : {1e-9, 1e-3, 1e3, 1e16, 3e19}) {
        SCOPED_TRACE(scale);
        EXPECT_LT(rootMeanSquare(difference(renderScene(scale, 0), reference)), 0.005);
    }
    for (const double shift : {1e3, 1e6, 1e9}) {
        SCOPED_TRACE(shift);
        EXPECT_LT(rootMeanSquare(difference(renderScene(1, shift), reference)), 0.005);
    }
}

TEST(Preview, DistantDropsAreOutliersButConnectedJetsAreNot) {
    Random random(1);
    Spheres drops;
    for (int i = 0; i < 1000; ++i) {
        drops.position.push_back(random.ball());
        drops.radius.push_back(0.05f);
    }
    const Bounds near = boundsOfBulk({}, drops, {});
    EXPECT_EQ(near.low, boundsOf({}, drops).low);
    EXPECT_EQ(near.high, boundsOf({}, drops).high);
    for (const Vec3& far : {Vec3(1e6, 0, 0), Vec3(0, -7, 0), Vec3(0, 0, 30)}) {
        drops.position.push_back(far);
        drops.radius.push_back(0.05f);
    }
    EXPECT_EQ(boundsOfBulk({}, drops, {}).low, near.low);
    EXPECT_EQ(boundsOfBulk({}, drops, {}).high, near.high);

    Mesh mesh = sphereMesh({0, 0, 0});
    const auto first = static_cast<std::uint32_t>(mesh.position.size());
    mesh.position.insert(mesh.position.end(), {{0, 20, 0}, {0.01, 20, 0}});
    mesh.triangles.push_back({0, first, first + 1});
    EXPECT_EQ(boundsOfBulk(mesh, {}, {}).high.y, 20);
    mesh.position.push_back({0, 19, 0});
    mesh.triangles.back()[0] = first + 2;  // torn off
    EXPECT_LT(boundsOfBulk(mesh, {}, {}).high.y, 1.1);
    // If there are only a few scattered drops, none is an outlier.
    drops.position = {{0, 0, 0}, {100, 0, 0}, {0, 3, 0}};
    drops.radius = {1, 1, 1};
    EXPECT_EQ(boundsOfBulk({}, drops, {}).high.x, 101);
}

TEST(Preview, TheAutomaticCameraFitsEverythingTightly) {
    Random random(1);
    for (int trial = 0; trial < 200; ++trial) {
        SCOPED_TRACE(trial);
        const Framing framing{trial % 2 == 0 ? Vec3(0, 1, 0) : Vec3(0, 0, 1), random.between(-180, 180),
                              random.between(-85, 85), random.between(5, 100)};
        const int width = 400, height = trial % 3 == 0 ? 400 : 225;
        const double aspect = static_cast<double>(width) / height;
        CameraFinder found(framing, aspect), other(framing, aspect);
        const Vec3 middle = random.cube() * 100;
        std::vector<Vec3> points;
        for (int i = 0; i < 20; ++i) {
            points.push_back(middle + random.cube() * std::pow(10, random.between(-3, 2)));
            (i % 2 == 0 ? found : other).add(points.back(), 0);
        }
        found.add(other);
        const View view(found.camera(), width, height);
        double room = 1;       // nearest to an edge, in parts of the picture
        double nearest = 1e9;  // to the camera
        Bounds seen;
        for (const Vec3& p : points) {
            ASSERT_GT(view.depth(p), 0);
            nearest = std::min(nearest, view.depth(p));
            const auto [x, y] = view.projected(p);
            seen.add({x / width, y / height, 0}, 0);
            room = std::min({room, x / width, 1 - x / width, y / height, 1 - y / height});
        }
        EXPECT_GT(room, framing.margin - 1e-9);
        Bounds extent;
        for (const Vec3& p : points) extent.add(p, 0);
        if (nearest > 0.002 * extent.diagonal()) {  // nearer still, and the lens would touch it
            EXPECT_NEAR(room, framing.margin, 1e-4);
        }
        if (framing.fov <= 40) {
            EXPECT_NEAR(seen.centre().x, 0.5, 0.03);
            EXPECT_NEAR(seen.centre().y, 0.5, 0.03);
        }
    }
}

TEST(Preview, ABallFillsThePictureUpToTheMargins) {
    RenderSettings settings = smallSettings();
    settings.samples = 4;
    Framing framing;
    framing.margin = 0.1;
    CameraFinder finder(framing, static_cast<double>(settings.width) / settings.height);
    finder.add({5, 6, 7}, 1);
    const Picture picture = renderFrame({}, ballAt({5, 6, 7}), finder.camera(), settings);
    int first = settings.height, last = 0;
    for (std::size_t i = 0; i < picture.size(); ++i)
        if (picture.alpha[i] > 0) {
            const int y = static_cast<int>(i) / settings.width;
            first = std::min(first, y), last = std::max(last, y);
        }
    EXPECT_NEAR(first, 0.1 * settings.height, 1);
    EXPECT_NEAR(last, 0.9 * settings.height, 1.5);
}

TEST(Preview, ExrFilesPreserveEveryPlane) {
    const Picture picture =
        renderFrame(sphereMesh({0, 0, 0}, {1, 2, 0}), ballAt({1.5, 0, 0}), facing({0, 0, 0}), smallSettings());
    const Picture back = decodeExr(encodeExr(picture), "test.exr");
    ASSERT_EQ(back.width, picture.width);
    ASSERT_EQ(back.height, picture.height);
    const auto same = [](const Plane& a, const Plane& b, float relative) {
        ASSERT_EQ(a.size(), b.size());
        for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], relative * std::abs(a[i]) + 1e-7f);
    };
    constexpr float kHalf = 1.0f / 2048;
    same(picture.red, back.red, kHalf);
    same(picture.green, back.green, kHalf);
    same(picture.blue, back.blue, kHalf);
    same(picture.alpha, back.alpha, kHalf);
    same(picture.shadow, back.shadow, kHalf);
    EXPECT_EQ(picture.depth, back.depth);
    EXPECT_EQ(picture.position, back.position);
    EXPECT_EQ(picture.motion, back.motion);
    EXPECT_EQ(picture.id, back.id);
    for (std::size_t axis = 0; axis < 3; ++axis) same(picture.normal[axis], back.normal[axis], kHalf);
}

TEST(Preview, DamagedPicturesAreErrorsThatNameTheFile) {
    const Picture picture = renderFrame({}, ballAt({0, 0, 0}), facing({0, 0, 0}), smallSettings());
    for (const std::string& whole : {encodeExr(picture), encodePng(toneMapped(picture))})
        for (const std::size_t length : {std::size_t{0}, std::size_t{10}, whole.size() / 2}) {
            const std::string cut = whole.substr(0, length);
            EXPECT_THROW(decodeExr(cut, "a.exr"), std::runtime_error);
            EXPECT_THROW(decodePng(cut, "a.png"), std::runtime_error);
        }
}

TEST(Preview, PngFilesPreserveEveryPixel) {
    Random random(1);
    Image image(37, 23, {});
    for (Colour& pixel : image.pixel)
        for (std::uint8_t& channel : pixel) channel = static_cast<std::uint8_t>(random.below(256));
    const Image back = decodePng(encodePng(image), "test.png");
    EXPECT_EQ(back.width, image.width);
    EXPECT_EQ(back.pixel, image.pixel);
}

TEST(Preview, TheCurvatureOfASphereIsOneOverItsRadius) {
    Mesh mesh = sphereMesh({0, 0, 0});
    for (Vec3& p : mesh.position) p *= 4;
    RenderSettings settings = smallSettings();
    settings.colouring.by = ColourBy::curvature;
    const auto green = [&](double low, double high) {
        settings.colouring.low = low, settings.colouring.high = high;
        return sum(renderFrame(mesh, {}, {{0, 0, 40}, {0, 0, 0}, {0, 1, 0}, kFov}, settings).green);
    };
    // The sphere has the middle colour of a scale centred on 1/4, and the end colour of a scale beyond.
    EXPECT_NEAR(green(0.15, 0.35), green(-9.75, 10.25), 0.01 * green(0.15, 0.35));
    EXPECT_GT(std::abs(green(0.15, 0.35) - green(0, 0.2)), 0.1 * green(0.15, 0.35));
}

TEST(Preview, AnEmptySceneGivesAnEmptyPicture) {
    const Picture picture = renderFrame({}, {}, facing({0, 0, 0}), smallSettings());
    EXPECT_EQ(sum(picture.alpha), 0);
    EXPECT_EQ(sum(picture.red), 0);
}

TEST(Preview, AMissingAttributeIsAnError) {
    RenderSettings settings = smallSettings();
    settings.colouring = {ColourBy::attribute, "Cd"};
    EXPECT_THROW(renderFrame(sphereMesh({0, 0, 0}), {}, facing({0, 0, 0}), settings), std::runtime_error);
    EXPECT_THROW(renderFrame({}, ballAt({0, 0, 0}), facing({0, 0, 0}), settings), std::runtime_error);
    renderFrame({}, {}, facing({0, 0, 0}), settings);
}

TEST(Preview, BallsAndMeshesHaveTheSameColoursOfAnAttribute) {
    for (const unsigned components : {1U, 3U}) {
        RenderSettings settings = smallSettings();
        settings.colouring = {ColourBy::attribute, "value"};
        Mesh mesh = sphereMesh({-3, 0, 0});
        Spheres balls = ballAt({3, 0, 0});
        const auto coloured = [&](float of_mesh, float of_ball) {
            mesh.attributes = {{"value", components, {}, {}}};
            mesh.attributes[0].real.assign(mesh.position.size() * components, of_mesh);
            balls.attributes = {{"value", components, std::vector<float>(components, of_ball), {}}};
            return surfaceColours(mesh, balls, {}, settings.colouring);
        };
        for (const float value : {0.0F, 0.3F, 1.0F}) {
            const SurfaceColours same = coloured(value, value);
            EXPECT_EQ(same.vertex.front(), same.sphere.front());
            const SurfaceColours different = coloured(value, value + 0.5F);
            EXPECT_EQ(different.vertex.front() == different.sphere.front(), components == 3 && value == 1.0F);
        }
        EXPECT_EQ(surfaceColours({}, balls, {}, settings.colouring).sphere.size(), 1U);
        balls.attributes.clear();
        EXPECT_TRUE(surfaceColours(mesh, balls, {}, settings.colouring).sphere.empty()) << "plain beside a mesh";
    }
}

TEST(Preview, ACameraThatIsTooFarAwayIsAnError) {
    for (const double distance : {1e2, 1e14, 1e17, 1e30, 1e38}) {
        Camera camera = facing({0, 0, 0});
        camera.position = {distance, 0, 0};
        if (distance < 1e15)
            renderFrame(sphereMesh({0, 0, 0}), {}, camera, smallSettings());
        else
            EXPECT_THROW(renderFrame(sphereMesh({0, 0, 0}), {}, camera, smallSettings()), std::runtime_error);
    }
}

}  // namespace
}  // namespace betamesh
