// Jump sites and their events in scenes with known changes of topology.

#include "mesh/jump_sites.h"
#include "base/icosphere.h"
#include "base/parallel.h"
#include "base/random.h"
#include "betamesh/check.h"
#include "betamesh/skin.h"
#include "mesh/local_topology.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace betamesh {
namespace {

using Cloud = std::vector<Vec3>;
using enum SurfaceEvent;

constexpr double kRadius = 1;

Mesh skinned(const Cloud& cloud, const Vec3& shift = Vec3(0)) {
    Particles particles;
    for (const Vec3& p : cloud) {  // rotated, so that no feature is aligned with an axis
        const Vec3 q = p + shift;
        particles.position.emplace_back(0.36 * q.x + 0.48 * q.y - 0.8 * q.z, -0.8 * q.x + 0.6 * q.y,
                                        0.48 * q.x + 0.64 * q.y + 0.6 * q.z);
    }
    SkinParams params;
    params.radius = kRadius;
    return skinFrame(particles, params).mesh;
}

std::vector<JumpSite> sitesBetween(const Mesh& before, const Mesh& after, double beyond) {
    DistanceSampling sampling;
    sampling.beyond = beyond;
    return jumpSites(before, after, surfaceDistance(before, after, sampling).far, kRadius);
}

Cloud lattice(int nx, int ny, int nz, double spacing, const std::function<bool(const Vec3&)>& isWanted = {}) {
    Cloud cloud;
    for (int z = 0; z < nz; ++z)
        for (int y = 0; y < ny; ++y)
            for (int x = 0; x < nx; ++x) {
                const Vec3 p = Vec3(2 * x - nx + 1, 2 * y - ny + 1, 2 * z - nz + 1) * (spacing / 2);
                if (!isWanted || isWanted(p)) cloud.push_back(p);
            }
    return cloud;
}

Cloud merged(Cloud cloud, const Cloud& more, const Vec3& shift) {
    for (const Vec3& p : more) cloud.push_back(p + shift);
    return cloud;
}

// Particles on a sphere except for a cap of height `opening` radii.
Cloud shell(double radius, double opening) {
    Cloud cloud;
    for (const Vec3& p : icosphere(5).position)
        if (p.z < 1 - opening) cloud.push_back(p * radius);
    return cloud;
}

// Balls on a circle with a gap of `opening` radians.
Cloud ring(double opening) {
    Cloud cloud;
    for (int i = 0; i <= 24; ++i) {
        const double angle = opening / 2 + (6.283185307179586 - opening) * i / 24;
        cloud.emplace_back(4 * std::cos(angle), 4 * std::sin(angle), 0);
    }
    return cloud;
}

// A sheet torn open at its middle: particles there are displaced outwards.
Cloud torn(double displacement) {
    Cloud cloud = lattice(12, 12, 1, 1);
    for (Vec3& p : cloud) p += p / p.length() * displacement * std::exp(-p.length2() / 8);
    return cloud;
}

struct Scene {
    std::string name;
    Cloud before, after;
    SurfaceEvent forward, backward;  // expected from before to after and in reverse
};

const std::vector<Scene>& scenes() {
    const auto rods = [](double gap) { return Cloud{{0, 0, 0}, {0.9, 0, 0}, {0.9 + gap, 0, 0}, {1.8 + gap, 0, 0}}; };
    const Cloud pool = lattice(9, 9, 4, 0.7), drop{{0, 0, 0}, {0.3, 0.2, 0}, {-0.2, 0.3, 0.2}};
    const auto outside = [](double radius) { return [=](const Vec3& p) { return p.length() > radius; }; };
    static const std::vector<Scene> all{
        {"two rods meet", rods(2.02), rods(1.98), pieces_joined, pieces_parted},
        {"a drop lands", merged(pool, drop, {0, 0, 3.1}), merged(pool, drop, {0, 0, 2.9}), pieces_joined,
         pieces_parted},
        {"a void opens inside", lattice(9, 9, 9, 0.7, outside(0.98)), lattice(9, 9, 9, 0.7, outside(1.3)),
         void_appeared, void_vanished},
        {"a sheet tears", torn(0.3), torn(0.9), hole_opened, hole_closed},
        {"a bubble bursts", shell(3, 0), shell(3, 0.15), void_opened, void_closed_off},
        {"a ring closes", ring(0.6), ring(0.4), neck_formed, neck_broke},
        {"a drop appears", pool, merged(pool, drop, {0, 0, 5}), piece_appeared, piece_vanished},
    };
    return all;
}

std::string description(const std::vector<JumpSite>& sites) {
    std::string words;
    for (const JumpSite& site : sites) {
        words += "jump " + std::to_string(site.jump) + ", " + std::string(nameOf(site.liquid)) + ":";
        for (const auto& [event, times] : site.events)
            words += " " + std::string(nameOf(event)) + " " + std::to_string(times);
        words += "\n";
    }
    return words;
}

// The change of the Euler characteristic that the events imply.
std::int64_t eulerOf(const std::vector<JumpSite>& sites) {
    std::int64_t sum = 0;
    for (const JumpSite& site : sites)
        for (const auto& [event, times] : site.events) {
            const bool more = event == void_appeared || event == void_closed_off || event == hole_closed ||
                              event == neck_broke || event == pieces_parted || event == piece_appeared;
            sum += (more ? 2 : -2) * static_cast<std::int64_t>(times);
        }
    return sum;
}

std::vector<SurfaceEvent> eventsIn(const std::vector<JumpSite>& sites) {
    std::vector<SurfaceEvent> events;
    for (const JumpSite& site : sites)
        for (const auto& [event, times] : site.events) events.insert(events.end(), times, event);
    return events;
}

TEST(JumpSites, HaveTheEventsOfTheScene) {
    for (const Scene& scene : scenes()) {
        SCOPED_TRACE(scene.name);
        const Mesh before = skinned(scene.before), after = skinned(scene.after);
        const auto forward = sitesBetween(before, after, 0.05), backward = sitesBetween(after, before, 0.05);
        EXPECT_EQ(eventsIn(forward), std::vector{scene.forward}) << description(forward);
        EXPECT_EQ(eventsIn(backward), std::vector{scene.backward}) << description(backward);
        EXPECT_EQ(eulerOf(forward), measureMesh(after).euler - measureMesh(before).euler);
        ASSERT_EQ(forward.size(), backward.size());
        for (std::size_t i = 0; i < forward.size(); ++i) {
            EXPECT_EQ(forward[i].jump, backward[i].jump);
            EXPECT_EQ(forward[i].position, backward[i].position);
            EXPECT_EQ(forward[i].vanished, backward[i].appeared);
        }
        EXPECT_EQ(forward.front().jump, surfaceDistance(before, after).max);
    }
}

// The whole scene moves by more than the threshold of a site, but its topology stays the same.
TEST(JumpSites, OfRigidMotionHaveNoEvents) {
    for (const Scene& scene : scenes()) {
        SCOPED_TRACE(scene.name);
        const Mesh before = skinned(scene.after);
        for (const Vec3& shift : {Vec3(0.1, 0, 0), Vec3(-0.3, 0, 0.2)}) {
            const auto sites = sitesBetween(before, skinned(scene.after, shift), 0.08);
            EXPECT_FALSE(sites.empty());
            EXPECT_TRUE(eventsIn(sites).empty()) << description(sites);
        }
    }
}

// Events at one site do not depend on what happens elsewhere.
TEST(JumpSites, FarApartHaveIndependentEvents) {
    Cloud before, after;
    for (std::size_t i = 0; i < scenes().size(); ++i) {
        const Vec3 shift(20.0 * static_cast<double>(i), 0, 0);
        before = merged(before, scenes()[i].before, shift);
        after = merged(after, scenes()[i].after, shift);
    }
    const auto sites = sitesBetween(skinned(before), skinned(after), 0.05);
    auto events = eventsIn(sites);
    std::vector<SurfaceEvent> expected;
    for (const Scene& scene : scenes()) expected.push_back(scene.forward);
    std::sort(events.begin(), events.end());
    std::sort(expected.begin(), expected.end());
    EXPECT_EQ(events, expected) << description(sites);
    EXPECT_TRUE(std::is_sorted(sites.begin(), sites.end(),
                               [](const JumpSite& a, const JumpSite& b) { return a.jump > b.jump; }));
}

// Spray, threads and sheets of balls that move by a hundredth of their radius. Where every event is classified, the
// events sum up to the change of the whole mesh; few clouds have sites that are too tangled to classify.
TEST(JumpSites, EventsSumUpInTangledClouds) {
    std::size_t changed = 0, unclassified = 0;
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const double box = 3.4 * random.between(0.5, 0.9);
        Cloud before, after;
        for (int i = 0; i < 40; ++i) {
            before.push_back(random.cube() * box);
            after.push_back(before.back() + random.ball() * 0.01);
        }
        const Mesh was = skinned(before), is = skinned(after);
        const auto sites = sitesBetween(was, is, 0.003);
        const auto events = eventsIn(sites);
        if (std::count(events.begin(), events.end(), several) + std::count(events.begin(), events.end(), unclear) > 0) {
            ++unclassified;
            continue;
        }
        const std::int64_t change = measureMesh(is).euler - measureMesh(was).euler;
        changed += change != 0;
        EXPECT_EQ(eulerOf(sites), change) << description(sites);
    }
    EXPECT_GE(changed, 5u);
    EXPECT_LE(unclassified, 5u);
}

TEST(JumpSites, AreTheSameForEveryThreadCount) {
    const Mesh before = skinned(scenes()[3].before), after = skinned(scenes()[3].after);
    const auto two_threads = sitesBetween(before, after, 0.05);
    std::vector<JumpSite> one_thread;
    withThreads(1, [&] { one_thread = sitesBetween(before, after, 0.05); });
    ASSERT_EQ(two_threads.size(), one_thread.size());
    EXPECT_EQ(description(two_threads), description(one_thread));
}

TEST(JumpSites, OfOpenMeshesAreUnclear) {
    Mesh before = skinned({{0, 0, 0}}), after = skinned({{0, 0, 0}}, Vec3(0.5, 0, 0));
    before.triangles.erase(before.triangles.begin(), before.triangles.begin() + 40);
    for (const JumpSite& site : sitesBetween(before, after, 0.3)) {
        ASSERT_EQ(site.events.size(), 1u);
        EXPECT_EQ(site.events[0].first, unclear);
    }
    after.position[after.triangles[0][0]].x = std::nan("");
    after.triangles.push_back({0, 1, 1000000});
    EXPECT_FALSE(sitesBetween(before, after, 0.3).empty());
    EXPECT_TRUE(sitesBetween(before, {}, 0.3).empty());
    EXPECT_TRUE(sitesBetween({}, {}, 0).empty());
}

// A sphere cut by concentric spheres of growing radius: nothing, a cap with one rim, the whole sphere.
TEST(LocalTopology, OfASphere) {
    const Icosphere unit = icosphere(12);
    const Mesh ball{unit.position, {}, unit.triangles, {}};
    const std::vector<Vec3> points{{0, 0, 1.5}};
    const std::vector<double> distances{0.4, 1, 2, 2.6};
    const std::vector<LocalTopology> found = LocalTopologyQuery(ball).near(points, distances);
    const std::vector<std::array<std::int64_t, 4>> expected{{0, 0, 0, 0}, {1, 1, 1, 0}, {1, 1, 1, 0}, {2, 0, 1, 0}};
    for (std::size_t i = 0; i < found.size(); ++i) {
        const LocalTopology& topology = found[i];
        EXPECT_EQ((std::array{topology.euler, topology.rims, topology.outer_surfaces, topology.voids}), expected[i])
            << i;
        EXPECT_TRUE(topology.closed);
    }
    // Near both poles: two caps, then all but a ring, then all.
    const std::vector<Vec3> poles{{0, 0, 1}, {0, 0, -1}};
    const std::vector<double> wider{0.5, 1.2, 1.5};
    const std::vector<LocalTopology> both = LocalTopologyQuery(ball).near(poles, wider);
    EXPECT_EQ(both[0].euler, 2);
    EXPECT_EQ(both[0].rims, 2);
    EXPECT_EQ(both[1].rims, 2);
    EXPECT_EQ(both[2].rims, 0);
    EXPECT_EQ(both[2].euler, 2);
}

}  // namespace
}  // namespace betamesh
