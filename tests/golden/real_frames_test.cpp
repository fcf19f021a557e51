// Frames of real simulations: velocities, comparison with CGAL's fixed alpha shapes, topological events.

#include "base/cell_grid.h"
#include "base/rigid_motion.h"
#include "betamesh/check.h"
#include "betamesh/coherence.h"
#include "betamesh/skin.h"
#include "io/particle_file.h"
#include "mesh/jump_sites.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>

namespace betamesh {

namespace {

const std::filesystem::path kShared = BETAMESH_SHARED;

// Snapping moves particles by up to 1e-6 radii, which may reverse the decision of a near tie.
void expectWithinOneInTenThousand(std::size_t found, std::size_t expected, const char* what) {
    EXPECT_NEAR(static_cast<double>(found), static_cast<double>(expected), 1e-4 * static_cast<double>(expected))
        << what;
}

// Change of the Euler characteristic by the events at a place.
int eulerChange(const JumpSite& place) {
    using enum SurfaceEvent;
    const std::set<SurfaceEvent> adding{void_appeared, void_closed_off, hole_closed,
                                        neck_broke,    pieces_parted,   piece_appeared};
    int sum = 0;
    for (const auto& [event, times] : place.events) sum += (adding.contains(event) ? 2 : -2) * static_cast<int>(times);
    return sum;
}

}  // namespace

TEST(RealFrames, NoVertexIsMuchFasterThanTheParticlesAroundIt) {
    const auto frames = {std::pair("sph_dam3d/sph_dam3d.0029.bgeo", 0.02),
                         std::pair("flip_rotcube/flip_rotcube.0012.bgeo", 1.0 / 192)};
    for (const auto& [name, spacing] : frames) {
        const std::filesystem::path file = kShared / "data" / name;
        if (!std::filesystem::exists(file)) GTEST_SKIP() << "no frame at " << file;
        SCOPED_TRACE(name);
        const Particles particles = readParticles(file);
        SkinParams params;
        params.radius = 1.5 * spacing;
        params.spacing = spacing;
        const Mesh mesh = skinFrame(particles, params).mesh;
        const double reach = 3 * spacing;
        const CellGrid cells(particles.size(), reach, [&](std::size_t i) { return Vec3(particles.position[i]); });
        std::size_t judged = 0, over = 0;
        double worst = 0;
        std::vector<std::uint32_t> near;
        for (std::size_t v = 0; v < mesh.position.size(); v += 5) {
            const Vec3& at = mesh.position[v];
            near.clear();
            RigidMotionFit fit;
            double speed = 0;
            cells.forRowsIn(at - Vec3(reach), at + Vec3(reach), [&](std::uint32_t i) {
                if ((Vec3(particles.position[i]) - at).length() > reach) return;
                near.push_back(i);
                fit.add(Vec3(particles.position[i]), Vec3(particles.velocity[i]), 1);
                speed += particles.velocity[i].length();
            });
            if (near.size() < 5) continue;  // too few to differ from a rigid motion
            double most = 0.05 * speed / static_cast<double>(near.size());
            for (const std::uint32_t i : near)
                most = std::max(most,
                                (Vec3(particles.velocity[i]) - fit.velocityAt(Vec3(particles.position[i]))).length());
            const double ratio = (mesh.velocity[v] - fit.velocityAt(at)).length() / most;
            ++judged;
            over += ratio > 1.1;
            worst = std::max(worst, ratio);
        }
        EXPECT_LE(worst, 2);
        EXPECT_LE(static_cast<double>(over), 5e-4 * static_cast<double>(judged));
    }
}

TEST(RealFrames, AlphaMeshCountsEqualThoseOfCgal) {
    std::ifstream file(kShared / "oracle/alpha_counts.json");
    if (!file) GTEST_SKIP() << "no recorded alpha counts at " << kShared / "oracle";
    const auto oracle = nlohmann::json::parse(file);
    for (const auto& [name, expected] : oracle.at("frames").items()) {
        SCOPED_TRACE(name);
        const Particles particles = readParticles(kShared / "data" / name);
        ASSERT_EQ(particles.size(), expected.at("particles"));
        SkinParams params;
        params.radius = expected.at("radius");
        params.surface = SurfaceKind::alpha;
        const SkinnedFrame frame = skinFrame(particles, params);
        EXPECT_EQ(frame.report.distinct_particles, expected.at("distinct"));
        expectWithinOneInTenThousand(frame.report.alpha_triangles, expected.at("alpha_triangles"), "alpha triangles");
        expectWithinOneInTenThousand(frame.report.double_sided_triangles, expected.at("double_sided"), "double-sided");
        expectWithinOneInTenThousand(frame.report.degenerate_edges, expected.at("degenerate_edges"),
                                     "degenerate edges");
        expectWithinOneInTenThousand(frame.report.isolated_particles, expected.at("isolated_particles"), "isolated");
        EXPECT_EQ(measureMesh(frame.mesh).unpaired_edges, 0u);
        EXPECT_EQ(frame.mesh.velocity.size(), particles.velocity.empty() ? 0 : frame.mesh.position.size());
    }
}

// Two time steps of a splash. The expected events are computed independently, from the unsmoothed surface of the balls
// near each place.
TEST(RealFrames, EventsAgreeWithTheTopologyOfTheBallsAroundThem) {
    const auto folder = kShared / "data/sph_dam3d_tinydt";
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no frames at " << folder;
    const Particles frames[] = {readParticles(folder / "sph_dam3d_tinydt.0000.bgeo"),
                                readParticles(folder / "sph_dam3d_tinydt.0001.bgeo")};
    SkinParams params;
    params.radius = 0.03;
    params.skin = 0;  // events are computed from the surface without the skin
    const Mesh before = skinFrame(frames[0], params).mesh, after = skinFrame(frames[1], params).mesh;
    DistanceSampling sampling;
    sampling.beyond = particleMotion(frames[0], frames[1])->max;
    const auto places = jumpSites(before, after, surfaceDistance(before, after, sampling).far, params.radius);

    params.smoothing = SmoothingMethod::none;
    for (const JumpSite& place : places) {
        std::set<std::uint64_t> near;
        for (std::size_t i = 0; i < frames[0].size(); ++i)
            if ((Vec3(frames[0].position[i]) - place.position).length() < 2.5 * params.radius)
                near.insert(frames[0].id[i]);
        std::int64_t euler[2];
        for (int k = 0; k < 2; ++k) {
            Particles balls;
            for (std::size_t i = 0; i < frames[k].size(); ++i)
                if (near.contains(frames[k].id[i])) balls.position.push_back(frames[k].position[i]);
            euler[k] = measureMesh(skinFrame(balls, params).mesh).euler;
        }
        EXPECT_EQ(eulerChange(place), euler[1] - euler[0])
            << place.position.x << ' ' << place.position.y << ' ' << place.position.z;
    }
    ASSERT_FALSE(places.empty());
    using Events = std::vector<std::pair<SurfaceEvent, std::size_t>>;
    EXPECT_EQ(places.at(0).events,
              (Events{{SurfaceEvent::void_appeared, 2}}));       // the largest jump: two voids inside the liquid
    EXPECT_NEAR(places.at(0).jump / sampling.beyond, 4.8, 0.5);  // their depth, for any smoothing
}

// Splashing liquid, between two frames of an SPH simulation, in steps of at most 0.012 particle spacings. Most steps
// have a place where the surface moves farther than particles, as where crossings are removed.
TEST(RealFrames, TheSkinHardlyJumpsInSmallSteps) {
    const std::filesystem::path folder = kShared / "data/sph_dam3d";
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no frames at " << folder;
    constexpr double kSpacing = 0.0190719;
    const Particles from = readParticles(folder / "sph_dam3d.0026.bgeo"),
                    to = readParticles(folder / "sph_dam3d.0027.bgeo");
    std::map<std::uint64_t, std::size_t> row_in_to;
    for (std::size_t i = 0; i < to.size(); ++i) row_in_to[to.id[i]] = i;
    std::vector<std::pair<Vec3, Vec3>> moving;
    for (std::size_t i = 0; i < from.size(); ++i)
        if (const Vec3f& p = from.position[i]; p.x > 1.1F && p.y > 0.25F)
            moving.emplace_back(p, to.position[row_in_to.at(from.id[i])]);
    ASSERT_GT(moving.size(), 1000u);
    SkinParams params;
    params.spacing = kSpacing;
    params.radius = 1.5 * kSpacing;
    const auto meshAt = [&](double time) {
        Particles particles;
        for (const auto& [p, q] : moving) particles.position.emplace_back(p + (q - p) * time);
        return skinFrame(particles, params).mesh;
    };
    constexpr int kSteps = 20;
    std::vector<double> largest, of_nearly_all;
    Mesh before = meshAt(0);
    for (int i = 1; i <= kSteps; ++i) {
        Mesh now = meshAt(0.002 * i);
        const SurfaceDistance distance = surfaceDistance(before, now);
        largest.push_back(distance.max / kSpacing);
        of_nearly_all.push_back(distance.quantile999 / kSpacing);
        before = std::move(now);
    }
    std::sort(largest.begin(), largest.end());
    std::sort(of_nearly_all.begin(), of_nearly_all.end());
    EXPECT_LE(largest[kSteps / 2], 0.08);
    EXPECT_LE(largest.back(), 0.4);
    EXPECT_LE(of_nearly_all[kSteps / 2], 0.015);
}

}  // namespace betamesh
