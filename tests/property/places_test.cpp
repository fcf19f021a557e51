// What happens at places where a surface jumps, of scenes whose truth is known.

#include "base/icosphere.h"
#include "base/parallel.h"
#include "base/random.h"
#include "mesh/jump_sites.h"
#include "mesh/local_topology.h"
#include "mesh/mesh_measure.h"
#include "skin/pipeline.h"

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
    for (const Vec3& p : cloud) {  // turned, so that no axis is special
        const Vec3 q = p + shift;
        particles.position.emplace_back(0.36 * q.x + 0.48 * q.y - 0.8 * q.z, -0.8 * q.x + 0.6 * q.y,
                                        0.48 * q.x + 0.64 * q.y + 0.6 * q.z);
    }
    SkinParams params;
    params.radius = kRadius;
    return skinFrame(particles, params).mesh;
}

std::vector<Place> placesBetween(const Mesh& before, const Mesh& after, double beyond) {
    DistanceSampling sampling;
    sampling.beyond = beyond;
    return placesOf(before, after, surfaceDistance(before, after, sampling).far, kRadius);
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

Cloud together(Cloud cloud, const Cloud& more, const Vec3& shift) {
    for (const Vec3& p : more) cloud.push_back(p + shift);
    return cloud;
}

// Particles on a sphere, but within so much of a point.
Cloud shell(double radius, double opening) {
    Cloud cloud;
    for (const Vec3& p : icosphere(5).position)
        if (p.z < 1 - opening) cloud.push_back(p * radius);
    return cloud;
}

// Balls in a row round an axis, all the way but for a part of a turn.
Cloud ring(double opening) {
    Cloud cloud;
    for (int i = 0; i <= 24; ++i) {
        const double turn = opening / 2 + (6.283185307179586 - opening) * i / 24;
        cloud.emplace_back(4 * std::cos(turn), 4 * std::sin(turn), 0);
    }
    return cloud;
}

// A sheet torn open at its middle: what is there goes outwards.
Cloud torn(double way) {
    Cloud cloud = lattice(12, 12, 1, 1);
    for (Vec3& p : cloud) p += p / p.length() * way * std::exp(-p.length2() / 8);
    return cloud;
}

struct Scene {
    std::string name;
    Cloud before, after;
    SurfaceEvent there, back;  // what happens, and what if before and after change places
};

const std::vector<Scene>& scenes() {
    const auto row = [](double apart) {
        return Cloud{{0, 0, 0}, {0.9, 0, 0}, {0.9 + apart, 0, 0}, {1.8 + apart, 0, 0}};
    };
    const Cloud pool = lattice(9, 9, 4, 0.7), drop{{0, 0, 0}, {0.3, 0.2, 0}, {-0.2, 0.3, 0.2}};
    const auto outside = [](double radius) { return [=](const Vec3& p) { return p.length() > radius; }; };
    static const std::vector<Scene> all{
        {"two rods meet", row(2.02), row(1.98), pieces_joined, pieces_parted},
        {"a drop lands", together(pool, drop, {0, 0, 3.1}), together(pool, drop, {0, 0, 2.9}), pieces_joined,
         pieces_parted},
        {"a void opens inside", lattice(9, 9, 9, 0.7, outside(0.98)), lattice(9, 9, 9, 0.7, outside(1.3)),
         void_appeared, void_vanished},
        {"a sheet tears", torn(0.3), torn(0.9), hole_opened, hole_closed},
        {"a bubble bursts", shell(3, 0), shell(3, 0.15), void_opened, void_closed_off},
        {"a ring closes", ring(0.6), ring(0.4), neck_formed, neck_broke},
        {"a drop comes from nowhere", pool, together(pool, drop, {0, 0, 5}), piece_appeared, piece_vanished},
    };
    return all;
}

std::string described(const std::vector<Place>& places) {
    std::string words;
    for (const Place& place : places) {
        words += "jump " + std::to_string(place.jump) + ", " + std::string(nameOf(place.liquid)) + ":";
        for (const auto& [event, times] : place.events)
            words += " " + std::string(nameOf(event)) + " " + std::to_string(times);
        words += "\n";
    }
    return words;
}

// What all events together do to the Euler characteristic.
std::int64_t eulerOf(const std::vector<Place>& places) {
    std::int64_t sum = 0;
    for (const Place& place : places)
        for (const auto& [event, times] : place.events) {
            const bool more = event == void_appeared || event == void_closed_off || event == hole_closed ||
                              event == neck_broke || event == pieces_parted || event == piece_appeared;
            sum += (more ? 2 : -2) * static_cast<std::int64_t>(times);
        }
    return sum;
}

std::vector<SurfaceEvent> eventsIn(const std::vector<Place>& places) {
    std::vector<SurfaceEvent> events;
    for (const Place& place : places)
        for (const auto& [event, times] : place.events) events.insert(events.end(), times, event);
    return events;
}

TEST(Places, TellWhatHappens) {
    for (const Scene& scene : scenes()) {
        SCOPED_TRACE(scene.name);
        const Mesh before = skinned(scene.before), after = skinned(scene.after);
        const auto there = placesBetween(before, after, 0.05), back = placesBetween(after, before, 0.05);
        EXPECT_EQ(eventsIn(there), std::vector{scene.there}) << described(there);
        EXPECT_EQ(eventsIn(back), std::vector{scene.back}) << described(back);
        EXPECT_EQ(eulerOf(there), measureMesh(after).euler - measureMesh(before).euler);
        ASSERT_EQ(there.size(), back.size());
        for (std::size_t i = 0; i < there.size(); ++i) {
            EXPECT_EQ(there[i].jump, back[i].jump);
            EXPECT_EQ(there[i].position, back[i].position);
            EXPECT_EQ(there[i].vanished, back[i].appeared);
        }
        EXPECT_EQ(there.front().jump, surfaceDistance(before, after).max);
    }
}

// Everything moves on, far more than what is a place: nothing opens or closes.
TEST(Places, WhatOnlyMovesHasNoEvents) {
    for (const Scene& scene : scenes()) {
        SCOPED_TRACE(scene.name);
        const Mesh before = skinned(scene.after);
        for (const Vec3& way : {Vec3(0.1, 0, 0), Vec3(-0.3, 0, 0.2)}) {
            const auto places = placesBetween(before, skinned(scene.after, way), 0.08);
            EXPECT_FALSE(places.empty());
            EXPECT_TRUE(eventsIn(places).empty()) << described(places);
        }
    }
}

// What happens at one place is told whatever happens elsewhere.
TEST(Places, EventsFarApartAreToldApart) {
    Cloud before, after;
    for (std::size_t i = 0; i < scenes().size(); ++i) {
        const Vec3 shift(20.0 * static_cast<double>(i), 0, 0);
        before = together(before, scenes()[i].before, shift);
        after = together(after, scenes()[i].after, shift);
    }
    const auto places = placesBetween(skinned(before), skinned(after), 0.05);
    auto events = eventsIn(places);
    std::vector<SurfaceEvent> expected;
    for (const Scene& scene : scenes()) expected.push_back(scene.there);
    std::sort(events.begin(), events.end());
    std::sort(expected.begin(), expected.end());
    EXPECT_EQ(events, expected) << described(places);
    EXPECT_TRUE(
        std::is_sorted(places.begin(), places.end(), [](const Place& a, const Place& b) { return a.jump > b.jump; }));
}

// Spray, threads and sheets of balls that move by a hundredth of their radius. Where all that happens has a name, it
// adds up to what the whole mesh has become; in few clouds is a place too tangled.
TEST(Places, EventsAddUpInTangledClouds) {
    std::size_t changed = 0, vague = 0;
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
        const auto places = placesBetween(was, is, 0.01);
        const auto events = eventsIn(places);
        if (std::count(events.begin(), events.end(), several) + std::count(events.begin(), events.end(), unclear) > 0) {
            ++vague;
            continue;
        }
        const std::int64_t change = measureMesh(is).euler - measureMesh(was).euler;
        changed += change != 0;
        EXPECT_EQ(eulerOf(places), change) << described(places);
    }
    EXPECT_GE(changed, 5u);
    EXPECT_LE(vague, 5u);
}

TEST(Places, AreTheSameForEveryThreadCount) {
    const Mesh before = skinned(scenes()[3].before), after = skinned(scenes()[3].after);
    const auto two_threads = placesBetween(before, after, 0.05);
    std::vector<Place> one_thread;
    withThreads(1, [&] { one_thread = placesBetween(before, after, 0.05); });
    ASSERT_EQ(two_threads.size(), one_thread.size());
    EXPECT_EQ(described(two_threads), described(one_thread));
}

TEST(Places, OpenMeshesAreUnclear) {
    Mesh before = skinned({{0, 0, 0}}), after = skinned({{0, 0, 0}}, Vec3(0.5, 0, 0));
    before.triangles.erase(before.triangles.begin(), before.triangles.begin() + 40);
    for (const Place& place : placesBetween(before, after, 0.3)) {
        ASSERT_EQ(place.events.size(), 1u);
        EXPECT_EQ(place.events[0].first, unclear);
    }
    after.position[after.triangles[0][0]].x = std::nan("");
    after.triangles.push_back({0, 1, 1000000});
    EXPECT_FALSE(placesBetween(before, after, 0.3).empty());
    EXPECT_TRUE(placesBetween(before, {}, 0.3).empty());
    EXPECT_TRUE(placesBetween({}, {}, 0).empty());
}

// A ball cut through by spheres round a point: nothing, a cap with one rim, all of it.
TEST(LocalTopology, OfASphere) {
    const Icosphere unit = icosphere(12);
    const Mesh ball{unit.position, {}, unit.triangles, {}};
    const std::vector<Vec3> points{{0, 0, 1.5}};
    const std::vector<double> distances{0.4, 1, 2, 2.6};
    const std::vector<LocalTopology> parts = MeshParts(ball).near(points, distances);
    const std::vector<std::array<std::int64_t, 4>> expected{{0, 0, 0, 0}, {1, 1, 1, 0}, {1, 1, 1, 0}, {2, 0, 1, 0}};
    for (std::size_t i = 0; i < parts.size(); ++i) {
        EXPECT_EQ((std::array{parts[i].euler, parts[i].rims, parts[i].pieces, parts[i].voids}), expected[i]) << i;
        EXPECT_TRUE(parts[i].closed);
    }
    // Near both poles: two caps, then a ring is left out, then nothing.
    const std::vector<Vec3> poles{{0, 0, 1}, {0, 0, -1}};
    const std::vector<double> wider{0.5, 1.2, 1.5};
    const std::vector<LocalTopology> both = MeshParts(ball).near(poles, wider);
    EXPECT_EQ(both[0].euler, 2);
    EXPECT_EQ(both[0].rims, 2);
    EXPECT_EQ(both[1].rims, 2);
    EXPECT_EQ(both[2].rims, 0);
    EXPECT_EQ(both[2].euler, 2);
}

}  // namespace
}  // namespace betamesh
