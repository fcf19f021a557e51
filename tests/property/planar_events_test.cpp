// Single events: moments at which the boundary of moving discs changes its combinatorics, and how far curves jump
// there.

#include "base/random.h"
#include "base/rigid_motion.h"
#include "betamesh/skin.h"
#include "exact/snapped_particles.h"
#include "planar/disc_boundary.h"
#include "support/planar_clouds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

namespace betamesh {
namespace {

constexpr double kRadius = 1.5;                                  // of the discs; spacings are 1
constexpr std::array<double, 4> kSpans{1e-3, 1e-4, 1e-5, 1e-6};  // seconds
constexpr double kSteepest = 40;                                 // radii a second
constexpr double kNoise = 1e-5;                                  // radii: coordinates are snapped to 1e-6

Particles moved(const Particles& start, double time) {
    Particles particles = start;
    for (std::size_t i = 0; i < start.size(); ++i)
        particles.position[i] = Vec3f(Vec3(start.position[i]) + Vec3(start.velocity[i]) * time);
    return particles;
}

SegmentSet combinatoricsOf(const Particles& particles) {
    const DiscBoundary boundary = discBoundary(snapParticles(particles, kRadius));
    SegmentSet segments;
    for (const auto& [from, to] : boundary.segment) segments.insert({boundary.row[from], boundary.row[to]});
    return segments;
}

// Kinds of events, by the numbers of vertices that vanish and appear; each includes its reverse.
//
//     birth    1 -> 2  a disc emerges at a vertex
//     contact  0 -> 2  two discs touch
//     hole     0 -> 3  a hole opens between three discs
struct Event {
    std::string kind, name;
    Particles particles;  // at time 0
    double time;
};

std::string kindOf(const SegmentSet& before, const SegmentSet& after) {
    std::vector<std::array<std::uint32_t, 2>> gone, come;
    std::set_difference(before.begin(), before.end(), after.begin(), after.end(), std::back_inserter(gone));
    std::set_difference(after.begin(), after.end(), before.begin(), before.end(), std::back_inserter(come));
    const auto [less, more] = std::minmax({gone.size(), come.size()});
    if (less == 1 && more == 2) return "birth";
    if (less == 0 && more == 2) return "contact";
    if (less == 0 && more == 3) return "hole";
    return "several";
}

using Found = std::function<void(double time, const std::string& kind)>;
void findEvents(const Particles& start, double begin, const SegmentSet& before, double end, const SegmentSet& after,
                const Found& found) {
    if (before == after) return;
    const double middle = (begin + end) / 2;
    if (end - begin < 1e-9) return found(middle, kindOf(before, after));
    const SegmentSet between = combinatoricsOf(moved(start, middle));
    findEvents(start, begin, before, middle, between, found);
    findEvents(start, middle, between, end, after, found);
}

// Near the origin, where floats are finest; speeds up to one spacing per second.
Particles cloud(std::uint64_t seed) {
    Random random(seed);
    const double jitter = seed % 2 == 0 ? 0.25 : 1, keep = seed % 2 == 0 ? 0.9 : 0.35;
    Particles particles;
    for (int y = -4; y <= 4; ++y)
        for (int x = -4; x <= 4; ++x) {
            const Vec3 place = Vec3(x, y, 0) + random.cube() * jitter, velocity = random.cube();
            if (random.unit() > keep) continue;
            particles.position.emplace_back(Vec3(place.x, place.y, 0));
            particles.velocity.emplace_back(Vec3(velocity.x, velocity.y, 0));
        }
    return particles;
}

const std::vector<Event>& events() {
    static const std::vector<Event> all = [] {
        constexpr std::size_t kMost = 24, kMostOfACloud = 3;
        std::vector<Event> list;
        std::map<std::string, std::size_t> count;
        for (std::uint64_t seed = 0; seed < 60; ++seed) {
            const Particles start = cloud(seed);
            constexpr double kSpan = 0.2;
            std::map<std::string, std::size_t> here;
            findEvents(
                start, 0, combinatoricsOf(start), kSpan, combinatoricsOf(moved(start, kSpan)),
                [&](double time, const std::string& kind) {
                    if (kind == "several" || count[kind] == kMost || here[kind] == kMostOfACloud) return;
                    ++count[kind], ++here[kind];
                    list.push_back({kind, kind + " of cloud " + std::to_string(seed) + " at " + std::to_string(time),
                                    start, time});
                });
        }
        std::stable_sort(list.begin(), list.end(), [](const Event& a, const Event& b) { return a.kind < b.kind; });
        return list;
    }();
    return all;
}

double distanceTo(const Curves& curves, const Vec3& point) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Edge& edge : curves.edges) {
        const Vec3 &a = curves.position[edge[0]], way = curves.position[edge[1]] - a;
        const double t = way.length2() > 0 ? std::clamp(dot(point - a, way) / way.length2(), 0.0, 1.0) : 0;
        nearest = std::min(nearest, (a + way * t - point).length());
    }
    return nearest;
}

// The Hausdorff distance of two curves, radii.
double distance(const Curves& one, const Curves& other) {
    double farthest = 0;
    for (const auto& [from, to] : {std::pair(&one, &other), std::pair(&other, &one)})
        for (const Edge& edge : from->edges)
            for (const double t : {0.0, 0.25, 0.5, 0.75}) {
                const Vec3 point = from->position[edge[0]] * (1 - t) + from->position[edge[1]] * t;
                farthest = std::max(farthest, distanceTo(*to, point));
            }
    return farthest / kRadius;
}

double jump(const Event& event, double span, const SkinParams& params) {
    return distance(skinPlane(moved(event.particles, event.time - span / 2), params).curves,
                    skinPlane(moved(event.particles, event.time + span / 2), params).curves);
}

SkinParams skin(Tessellation tessellation, SmoothingMethod smoothing) {
    SkinParams params;
    params.radius = kRadius;
    params.tessellation = tessellation;
    params.smoothing = smoothing;
    return params;
}

const std::map<std::string, SkinParams>& surfaces() {
    static const std::map<std::string, SkinParams> all = [] {
        std::map<std::string, SkinParams> list{
            {"ours", skin(Tessellation::complete, SmoothingMethod::coherent)},
            {"ours, not smoothed", skin(Tessellation::complete, SmoothingMethod::none)},
            {"ours, three passes", skin(Tessellation::complete, SmoothingMethod::coherent)},
            {"paper's, not smoothed", skin(Tessellation::paper, SmoothingMethod::none)},
            {"paper's", skin(Tessellation::paper, SmoothingMethod::paper)},
            {"alpha mesh", skin(Tessellation::complete, SmoothingMethod::none)}};
        list["ours, three passes"].passes = 3;
        list["ours, on the discs"] = list["ours"];
        list["ours, on the discs"].skin = 0;
        list["ours, bare skin"] = list["ours, not smoothed"];
        list["ours, bare skin"].skin = 0.5;
        list["alpha mesh"].surface = SurfaceKind::alpha;
        return list;
    }();
    return all;
}

TEST(PlanarEvents, TableOfJumps) {
    for (const char* kind : {"birth", "contact", "hole"}) {
        std::printf("%-25s", kind);
        for (const double span : kSpans) std::printf("  %15.0e", span);
        for (const auto& [name, params] : surfaces()) {
            std::printf("\n  %-23s", name.c_str());
            for (const double span : kSpans) {
                std::vector<double> found;
                for (const Event& event : events())
                    if (event.kind == kind) found.push_back(jump(event, span, params));
                ASSERT_GE(found.size(), 8U) << kind;
                std::sort(found.begin(), found.end());
                std::printf("  %7.1e %7.1e", found[found.size() / 2], found.back());
            }
        }
        std::printf("\n");
    }
}

// Smoothing is a continuous function of continuous input. The allowed speed covers that of the discs, of vertices where
// discs barely overlap, and the steepness of the smoothing.
TEST(PlanarEvents, OurCurveIsContinuousThroughBirths) {
    for (const Event& event : events()) {
        if (event.kind != "birth") continue;
        for (const char* name :
             {"ours", "ours, not smoothed", "ours, three passes", "ours, on the discs", "ours, bare skin"})
            for (const double span : kSpans)
                EXPECT_LE(jump(event, span, surfaces().at(name)), kSteepest * span + kNoise)
                    << name << ", " << event.name << ", over " << span << " s";
    }
}

// A point of contact is on both circles, but not on their chords.
TEST(PlanarEvents, OurCurveHardlyJumpsWhereDiscsBeginToTouch) {
    for (const Event& event : events()) {
        if (event.kind != "contact") continue;
        EXPECT_LE(jump(event, 1e-5, surfaces().at("ours, not smoothed")), 0.01) << event.name;
        EXPECT_LE(jump(event, 1e-5, surfaces().at("ours")), 0.04) << event.name;
        SkinParams fine = surfaces().at("ours");
        fine.arc_subdivisions = 32;
        EXPECT_LE(jump(event, 1e-6, fine), 0.006) << event.name;  // the arc's samples become those of two arcs
    }
}

TEST(PlanarEvents, ThePapersSmoothingAndTheAlphaMeshJumpAtBirthsHoweverShortTheTime) {
    for (const char* name : {"paper's", "alpha mesh"}) {
        std::vector<double> found;
        for (const Event& event : events())
            if (event.kind == "birth") found.push_back(jump(event, 1e-6, surfaces().at(name)));
        std::sort(found.begin(), found.end());
        EXPECT_GE(found[found.size() / 2], 0.05) << name;
    }
}

// The rigid motion of the particles within 2 r of a point, and how far their velocities are from it.
struct LocalMotion {
    Vec3 velocity;
    double mean_square, largest;
};

LocalMotion motionNear(const Particles& particles, const Vec3& point) {
    RigidMotionFit fit;
    double squares = 0, weights = 0, largest = 0;
    for (const bool is_fitted : {false, true})
        for (std::size_t i = 0; i < particles.size(); ++i) {
            const Vec3 offset = Vec3(particles.position[i]) - point, velocity(particles.velocity[i]);
            const double t = 1 - offset.length2() / (4 * kRadius * kRadius), weight = t > 0 ? t * t : 0;
            if (!(weight > 0)) continue;
            if (!is_fitted) {
                fit.add(offset, velocity, weight);
                continue;
            }
            const double square = (velocity - fit.velocityAt(offset)).length2();
            squares += weight * square;
            weights += weight;
            largest = std::max(largest, std::sqrt(square));
        }
    return {fit.velocityAt(Vec3(0)), weights > 0 ? squares / weights : 0, largest};
}

// Between events the normal displacement of a vertex agrees with its velocity, where it moves as the particles near it.
// In narrow gaps the skin follows the medial axis, whose branches take turns as the nearest, each with its own
// velocity.
TEST(PlanarEvents, VelocitiesAreThoseOfTheCurve) {
    for (const char* name : {"ours", "ours, not smoothed", "ours, three passes", "ours, on the discs",
                             "ours, bare skin", "paper's", "paper's, not smoothed"}) {
        std::vector<double> errors;
        for (std::uint64_t seed = 0; seed < 20; ++seed) {
            constexpr double kStep = 1e-3;
            const Particles particles = cloud(seed);
            const auto at = [&](double time) { return skinPlane(moved(particles, time), surfaces().at(name)).curves; };
            const Curves now = at(0), before = at(-kStep), after = at(kStep);
            if (before.edges != now.edges || after.edges != now.edges) continue;
            std::vector<Vec3> ways(now.position.size(), Vec3(0));
            for (const Edge& edge : now.edges)
                for (const std::uint32_t v : edge)
                    ways[v] += (now.position[edge[1]] - now.position[edge[0]]).normalized();
            for (std::size_t v = 0; v < ways.size(); ++v) {
                const Vec3 normal = Vec3(ways[v].y, -ways[v].x, 0).normalized();
                const Vec3 moves = (after.position[v] - before.position[v]) / (2 * kStep);
                const LocalMotion liquid = motionNear(particles, now.position[v]);
                const double relative = dot(normal, moves - liquid.velocity);
                if (relative * relative < liquid.mean_square / 4)
                    errors.push_back(std::abs(dot(normal, moves - now.velocity[v])));
            }
        }
        ASSERT_GE(errors.size(), 500U) << name;
        std::sort(errors.begin(), errors.end());
        EXPECT_LE(errors[errors.size() / 2], 0.001) << name;
        EXPECT_LE(errors[errors.size() * 95 / 100], 0.005) << name;
    }
}

// As for motion blur: a vertex deviates from the rigid motion near it no more than some particle does.
TEST(PlanarEvents, VelocitiesAreBoundedByTheMotionOfTheParticles) {
    for (const Event& event : events())
        for (const char* name : {"ours", "ours, three passes", "ours, bare skin", "paper's"}) {
            const Particles particles = moved(event.particles, event.time + 1e-6);
            const Curves curves = skinPlane(particles, surfaces().at(name)).curves;
            for (std::size_t v = 0; v < curves.position.size(); ++v) {
                const LocalMotion liquid = motionNear(particles, curves.position[v]);
                const double deviation = (curves.velocity[v] - liquid.velocity).length();
                EXPECT_LE(deviation, 1.1 * liquid.largest + 0.05) << name << ", " << event.name << ", vertex " << v;
            }
        }
}

}  // namespace
}  // namespace betamesh
