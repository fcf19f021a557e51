// Visual flaws that production shots must not have. Each test renders its scene without and with the skin, to
// flaws/NAME-on-balls.png and flaws/NAME-skin.png, and checks numbers where they can express the flaw.

#include "base/random.h"
#include "betamesh/check.h"
#include "betamesh/coherence.h"
#include "betamesh/skin.h"
#include "betamesh/skin_params.h"
#include "render/png_file.h"
#include "render/render_frame.h"
#include "support/slab_top.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>
#include <numeric>

namespace betamesh {

namespace {

// The particle spacing of all scenes is about 1.
struct Scene {
    std::string name;
    Particles particles;
    double radius = 1.5;

    void add(const Vec3& p) { particles.position.emplace_back(p); }
};

Mesh skinned(const Scene& scene, bool on_balls = false) {
    SkinParams params;
    params.radius = scene.radius;
    params.spacing = 1;
    if (on_balls) params.skin = 0;
    return skinFrame(scene.particles, params).mesh;
}

void renderToPng(const Mesh& mesh, const std::string& name) {
    RenderSettings settings;
    settings.width = 640, settings.height = 480, settings.samples = 16;
    CameraFinder finder({}, 640.0 / 480);
    for (const Vec3& p : mesh.position) finder.add(p, 0);
    std::filesystem::create_directories("flaws");
    std::ofstream("flaws/" + name + ".png", std::ios::binary)
        << encodePng(toneMapped(renderFrame(mesh, {}, finder.camera(), settings)));
}

// Renders the surface without and with the skin; returns the mesh with the skin.
Mesh renderedSkin(const Scene& scene) {
    renderToPng(skinned(scene, true), scene.name + "-on-balls");
    Mesh mesh = skinned(scene);
    renderToPng(mesh, scene.name + "-skin");
    return mesh;
}

Vec3 normalOf(const Mesh& mesh, const Triangle& t) {
    return cross(mesh.position[t[1]] - mesh.position[t[0]], mesh.position[t[2]] - mesh.position[t[0]]);
}

// Fraction of the area in triangles with an edge that is folded by more than 100 degrees.
double foldedFraction(const Mesh& mesh) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> side;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) side[{mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]}] = t;
    double all = 0, folded = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const Vec3 normal = normalOf(mesh, mesh.triangles[t]);
        all += normal.length();
        for (std::size_t k = 0; k < 3; ++k) {
            const auto neighbour = side.find({mesh.triangles[t][(k + 1) % 3], mesh.triangles[t][k]});
            if (neighbour == side.end()) continue;
            const Vec3 other = normalOf(mesh, mesh.triangles[neighbour->second]);
            if (dot(normal.normalized(), other.normalized()) < -0.17) {
                folded += normal.length();
                break;
            }
        }
    }
    return folded / all;
}

Scene block(const std::string& name, int x, int y, int z, double jitter, std::uint64_t seed) {
    Scene scene{name, {}};
    Random random(seed);
    for (int i = 0; i < x; ++i)
        for (int j = 0; j < y; ++j)
            for (int k = 0; k < z; ++k) scene.add(Vec3(i, j, k) + random.cube() * jitter);
    return scene;
}

}  // namespace

TEST(Flaws, NoHolesInSparseBulk) {
    Scene scene{"1-bulk", {}, 2};
    Random random(1);
    for (int i = 0; i < 14 * 14 * 8; ++i)
        scene.add(Vec3(random.between(0, 14), random.between(0, 14), random.between(0, 8)));
    const MeshMeasure measure = measureMesh(renderedSkin(scene));
    EXPECT_EQ(measure.components, 1U);
    EXPECT_EQ(measure.euler, 2);
}

TEST(Flaws, NoFoldsWhereSurfacesNearlyMeet) {
    Scene scene = block("2-folds", 8, 8, 4, 0.25, 2);
    for (const Vec3f& p : block("", 8, 8, 4, 0.25, 3).particles.position) scene.add(Vec3(p) + Vec3(0.3, 0.2, 6.6));
    EXPECT_LE(foldedFraction(renderedSkin(scene)), 3e-4);
}

TEST(Flaws, RimsAreAsThickAsTheSheet) {
    Scene scene{"3-tear", {}};
    Random random(4);
    for (int i = 0; i < 18; ++i)
        for (int j = 0; j < 18; ++j)
            if (Vec3(i - 8.5, j - 8.5, 0).length() > 4) scene.add(Vec3(i, j, 0) + random.cube() * 0.2);
    const Mesh mesh = renderedSkin(scene);
    const MeshMeasure measure = measureMesh(mesh);
    EXPECT_EQ(measure.components, 1U);
    EXPECT_EQ(measure.euler, 0);
    const auto thickness = [&](double from,
                               double to) {  // extent in z of the surface between two distances from the centre
        double high = 0, low = 0;
        for (const Vec3& p : mesh.position)
            if (const double r = Vec3(p.x - 8.5, p.y - 8.5, 0).length(); r > from && r < to)
                high = std::max(high, p.z), low = std::min(low, p.z);
        return high - low;
    };
    EXPECT_GE(thickness(4, 5), 0.8 * thickness(6, 8));
}

TEST(Flaws, NecksAreNotTooThin) {
    for (const double distance : {2.0, 2.6, 2.9}) {
        Scene scene{"4-neck-" + std::to_string(distance).substr(0, 3), {}};
        scene.add(Vec3(0, 0, 0)), scene.add(Vec3(distance, 0, 0));
        const Mesh mesh = renderedSkin(scene);
        EXPECT_EQ(measureMesh(mesh).components, 1U);
        double thinnest = 1;
        for (const Vec3& p : mesh.position)
            if (std::abs(p.x - distance / 2) < 0.25) thinnest = std::min(thinnest, std::hypot(p.y, p.z));
        EXPECT_GE(thinnest, 0.025) << distance;
    }
}

TEST(Flaws, SheetsAreFlat) {
    const Mesh mesh = renderedSkin(block("5-sheet", 18, 18, 1, 0.2, 5));
    double sum = 0, all = 0;
    for (const Triangle& t : mesh.triangles) {
        const Vec3 middle = (mesh.position[t[0]] + mesh.position[t[1]] + mesh.position[t[2]]) / 3;
        const Vec3 n = normalOf(mesh, t);
        if (std::min(middle.x, middle.y) < 4 || std::max(middle.x, middle.y) > 13) continue;
        const double angle = std::acos(std::min(1.0, std::abs(n.z) / n.length())) * 180 / std::numbers::pi;
        sum += n.length() * angle * angle, all += n.length();
    }
    EXPECT_LE(std::sqrt(sum / all), 8);
}

TEST(Flaws, SparseSheetsTear) {
    Scene scene{"6-lace", {}};
    Random random(6);
    for (int i = 0; i < 200; ++i) scene.add(Vec3(random.between(0, 18), random.between(0, 18), 0));
    renderedSkin(scene);
}

TEST(Flaws, LatticeRowsAreNotVisible) {
    const Mesh mesh = renderedSkin(block("7-rows", 18, 18, 6, 0, 7));
    double sum = 0, all = 0;
    forTopOf(mesh, 5, 12, [&](const Vec3&, const Vec3& n) {
        const double angle = std::acos(std::min(1.0, n.z / n.length())) * 180 / std::numbers::pi;
        sum += n.length() * angle * angle, all += n.length();
    });
    EXPECT_LE(std::sqrt(sum / all), 1);
}

TEST(Flaws, EdgesAreNotScalloped) {
    const Mesh mesh = renderedSkin(block("7-edges", 40, 10, 2, 0.25, 11));
    constexpr double kBin = 0.5;
    std::vector<double> edge(60, 0);  // the largest y in each bin of x from 5 on
    for (const Vec3& p : mesh.position)
        if (const double bin = std::floor((p.x - 5) / kBin); bin >= 0 && bin < 60)
            edge[static_cast<std::size_t>(bin)] = std::max(edge[static_cast<std::size_t>(bin)], p.y);
    double sum = 0;
    int count = 0;
    for (std::size_t i = 4; i + 4 < edge.size(); ++i, ++count) {  // heights over the mean of 4.5 dx
        const double mean =
            std::accumulate(edge.begin() + static_cast<int>(i) - 4, edge.begin() + static_cast<int>(i) + 5, 0.0) / 9;
        sum += (edge[i] - mean) * (edge[i] - mean);
    }
    EXPECT_LE(std::sqrt(sum / count), 0.025);
}

TEST(Flaws, SheetsStayConnectedAsTheyThinTowardsTheirEdge) {
    Scene scene = block("8-edge", 14, 14, 3, 0.2, 8);
    for (int i = 14; i < 18; ++i)
        for (int j = 0; j < 14; ++j) scene.add(Vec3(i, j, 1));
    EXPECT_EQ(measureMesh(renderedSkin(scene)).components, 1U);
}

TEST(Flaws, DropsHaveTheVolumeOfTheirParticles) {
    Scene scene{"9-drops", {}};
    for (int n = 1; n <= 4; ++n)
        for (int i = 0; i < n * n; ++i) scene.add(Vec3(n * n * 2.5 + i % n * 0.9, i / n * 0.9, 0));
    const Mesh mesh = renderedSkin(scene);
    const MeshMeasure measure = measureMesh(mesh);
    EXPECT_EQ(measure.components, 4U);
    EXPECT_GE(measure.volume, 0.75 * 30);
    EXPECT_LE(measure.volume, 1.15 * 30);
}

TEST(Flaws, SilhouettesAreRound) {
    Scene scene{"10-silhouette", {}};
    scene.add(Vec3(0));
    const Mesh mesh = renderedSkin(scene);
    double smallest = 10, largest = 0;
    for (const Vec3& p : mesh.position)
        smallest = std::min(smallest, p.length()), largest = std::max(largest, p.length());
    for (const Triangle& t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k)
            smallest = std::min(smallest, ((mesh.position[t[k]] + mesh.position[t[(k + 1) % 3]]) / 2).length());
    EXPECT_GE(smallest, 0.95 * largest);
}

TEST(Flaws, SmallMotionsDoNotMakeTheSurfaceJump) {
    Scene scene = block("11-motion", 8, 8, 5, 0.25, 11);
    const Mesh before = renderedSkin(scene);
    Random random(12);
    for (Vec3f& p : scene.particles.position) p += Vec3f(random.cube() * 0.002);
    const Mesh after = skinned(scene);
    renderToPng(after, "11-motion-later");
    EXPECT_LE(surfaceDistance(before, after).max, 0.02);
}

}  // namespace betamesh
