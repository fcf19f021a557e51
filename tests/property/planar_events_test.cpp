// Single events: moments at which the boundary of moving discs changes its combinatorics, and how far curves jump
// there. README.md has the measurements.

#include "base/rigid_motion.h"
#include "betamesh/skin.h"
#include "support/planar_jumps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace betamesh {
namespace {

constexpr double kSteepest = 40;  // radii a second
constexpr double kNoise = 1e-5;   // radii: coordinates are snapped to 1e-6

TEST(PlanarEvents, OfEveryKindAreFound) {
    std::map<std::string, std::size_t> count;
    for (const PlanarEvent& event : planarEvents()) ++count[event.kind];
    for (const char* kind : {"birth", "contact", "hole"}) EXPECT_GE(count[kind], 8U) << kind;
}

// Smoothing is a continuous function of continuous input. The allowed speed covers that of the discs, of vertices where
// discs barely overlap, and the steepness of the smoothing.
TEST(PlanarEvents, OurCurveIsContinuousThroughBirths) {
    for (const PlanarEvent& event : planarEvents()) {
        if (event.kind != "birth") continue;
        for (const char* name : {"ours, the skin", "ours, not smoothed", "ours, three passes", "ours, on the discs",
                                 "ours, the skin, not smoothed"})
            for (const double span : {1e-3, 1e-4, 1e-5, 1e-6})
                EXPECT_LE(planarJumpAcross(event, span, comparedCurve(name)), kSteepest * span + kNoise)
                    << name << ", " << event.name << ", over " << span << " s";
    }
}

// A point of contact is on both circles, but not on their chords.
TEST(PlanarEvents, OurCurveHardlyJumpsWhereDiscsBeginToTouch) {
    for (const PlanarEvent& event : planarEvents()) {
        if (event.kind != "contact") continue;
        EXPECT_LE(planarJumpAcross(event, 1e-5, comparedCurve("ours, not smoothed")), 0.01) << event.name;
        EXPECT_LE(planarJumpAcross(event, 1e-5, comparedCurve("ours, the skin")), 0.04) << event.name;
        SkinParams fine = comparedCurve("ours, the skin");
        fine.arc_subdivisions = 32;
        EXPECT_LE(planarJumpAcross(event, 1e-6, fine), 0.006)
            << event.name;  // the arc's samples become those of two arcs
    }
}

TEST(PlanarEvents, ThePapersSmoothingAndTheAlphaMeshJumpAtBirthsHoweverShortTheTime) {
    for (const char* name : {"Algorithm 4", "alpha mesh"}) {
        std::vector<double> found;
        for (const PlanarEvent& event : planarEvents())
            if (event.kind == "birth") found.push_back(planarJumpAcross(event, 1e-6, comparedCurve(name)));
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
            const double t = 1 - offset.length2() / (4 * kDiscRadius * kDiscRadius), weight = t > 0 ? t * t : 0;
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
    for (const char* name : {"ours, the skin", "ours, not smoothed", "ours, three passes", "ours, on the discs",
                             "ours, the skin, not smoothed", "Algorithm 4", "paper's, not smoothed"}) {
        std::vector<double> errors;
        for (std::uint64_t seed = 0; seed < 20; ++seed) {
            constexpr double kStep = 1e-3;
            const Particles particles = movingPlanarCloud(seed);
            const auto at = [&](double time) {
                return skinPlane(movedInPlane(particles, time), comparedCurve(name)).curves;
            };
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
    for (const PlanarEvent& event : planarEvents())
        for (const char* name :
             {"ours, the skin", "ours, three passes", "ours, the skin, not smoothed", "Algorithm 4"}) {
            const Particles particles = movedInPlane(event.particles, event.time + 1e-6);
            const Curves curves = skinPlane(particles, comparedCurve(name)).curves;
            for (std::size_t v = 0; v < curves.position.size(); ++v) {
                const LocalMotion liquid = motionNear(particles, curves.position[v]);
                const double deviation = (curves.velocity[v] - liquid.velocity).length();
                EXPECT_LE(deviation, 1.1 * liquid.largest + 0.05) << name << ", " << event.name << ", vertex " << v;
            }
        }
}

}  // namespace
}  // namespace betamesh
