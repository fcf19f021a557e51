// Single events: moments at which the boundary of the union of moving balls changes its combinatorics, and how far each
// surface jumps there. README.md has the measurements.

#include "support/events.h"
#include "base/random.h"
#include "betamesh/coherence.h"
#include "betamesh/skin.h"
#include "support/jumps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

namespace betamesh {
namespace {

// Radii per second: allowed speed of a surface whose particles move at up to 0.67 of that; vertices of nearly coplanar
// triplets are faster than particles.
constexpr double kSteepest = 50;
// Radii. Coordinates are snapped to a grid of r / 2^19 or finer, which vertices magnify.
constexpr double kNoise = 3e-5;

const SkinParams& onTheBalls() { return comparedSurface("ours, on the balls"); }
const SkinParams& withSkin() { return comparedSurface("ours, the skin"); }

bool changesFaces(const SingleEvent& event) { return event.kind == "flip" || event.kind == "birth"; }

// In radii.
double jumpOf(const SingleEvent& event, double span, const SkinParams& params) {
    return jumpAcross(event.particles, event.time, span, params);
}

TEST(Events, OfEveryKindAreFound) {
    std::map<std::string, std::size_t> count;
    for (const SingleEvent& event : singleEvents()) ++count[event.kind];
    for (const char* kind : {"flip", "birth", "void", "hole", "graze", "contact"}) EXPECT_GE(count[kind], 4u) << kind;
}

// Over longer times there are other events, too: larger balls of the same cloud touch or separate.
TEST(Events, OurSurfaceIsContinuousThroughFlipsAndBirths) {
    for (const SingleEvent& event : singleEvents()) {
        if (!changesFaces(event)) continue;
        for (const double span : {1e-6, 1e-7})
            EXPECT_LE(jumpOf(event, span, onTheBalls()), kSteepest * span + kNoise)
                << event.name << ", over " << span << " s";
        EXPECT_LE(jumpOf(event, 1e-5, onTheBalls()), 0.003) << event.name;
    }
}

// In bulk none of these events moves the skin. In thin liquid most do not; there folds are relaxed.
TEST(Events, TheSkinHardlyJumpsAtFlipsAndBirths) {
    std::vector<double> found;
    for (const SingleEvent& event : singleEvents()) {
        if (!changesFaces(event)) continue;
        found.push_back(jumpOf(event, 1e-6, withSkin()));
        if (event.in_block) {
            EXPECT_LE(found.back(), 0.0002) << event.name;
        }
    }
    ASSERT_GE(found.size(), 16u);
    std::sort(found.begin(), found.end());
    EXPECT_LE(found[found.size() / 2], 0.0002);
    EXPECT_LE(found[found.size() * 3 / 4], 0.006);
    EXPECT_LE(found.back(), 0.04);
}

TEST(Events, TheSkinHardlyJumpsWhereDropsMeet) {
    std::size_t found = 0;
    for (const SingleEvent& event : singleEvents()) {
        if (event.kind != "contact") continue;
        EXPECT_LE(jumpOf(event, 1e-6, withSkin()), 0.06) << event.name;
        ++found;
    }
    EXPECT_GE(found, 4u);
}

// Nor where holes open or close: what is left is what the retracted arcs miss of the balls.
TEST(Events, TheSkinHardlyJumpsWhereHolesOpenAndClose) {
    std::vector<double> found;
    for (const SingleEvent& event : singleEvents())
        if (event.kind == "hole") found.push_back(jumpOf(event, 1e-6, withSkin()));
    ASSERT_GE(found.size(), 4u);
    std::sort(found.begin(), found.end());
    EXPECT_LE(found[found.size() / 2], 0.06);
    EXPECT_LE(found.back(), 0.1);
}

// Where balls begin to touch, the jump is as large as the distance between triangles and balls.
TEST(Events, OurSurfaceHardlyJumpsWhereBallsBeginToTouch) {
    for (const SingleEvent& event : singleEvents()) {
        if (changesFaces(event) || event.kind == "void") continue;
        EXPECT_LE(jumpOf(event, 1e-5, onTheBalls()), 0.01) << event.name;
    }
}

// The paper's smoothing averages over neighbouring faces, and neighbours change at a flip.
TEST(Events, AlgorithmFourJumpsAtFlipsHoweverShortTheTime) {
    std::vector<double> found;
    for (const SingleEvent& event : singleEvents()) {
        if (event.kind != "flip" || !event.in_block) continue;
        const double shorter = jumpOf(event, 1e-5, comparedSurface("Algorithm 4"));
        EXPECT_NEAR(jumpOf(event, 1e-4, comparedSurface("Algorithm 4")), shorter, 0.3 * shorter) << event.name;
        found.push_back(shorter);
    }
    ASSERT_GE(found.size(), 4u);
    std::sort(found.begin(), found.end());
    EXPECT_GE(found.front(), 0.02);
    EXPECT_GE(found[found.size() / 2], 0.05);
    EXPECT_LE(found[found.size() / 2], 0.3);
}

// The boundary has no event here: a point inside a face sinks below the facet of three others. At that moment all four
// are coplanar; after smoothing they are still on one surface only if smoothing preserves planes.
TEST(Events, PointsInsideFacesVanishWithoutAJump) {
    Particles three;
    three.position = {{0.777068675f, 0.804629683f, -1.56435454f},
                      {1.56641459f, 0.0210944861f, -0.733647585f},
                      {1.76278329f, 2.93039513f, -0.717127562f}};
    three.velocity = {
        {-0.0765557f, 0.648931f, 0.969507f}, {1.97399f, -0.361015f, -1.11566f}, {0.99669f, -0.72244f, 0.802014f}};
    constexpr double kTime = 2.7734375e-05;
    const SkinParams& params = onTheBalls();
    EXPECT_EQ(combinatoricsOf(advected(three, kTime - 1e-3), params),
              combinatoricsOf(advected(three, kTime + 1e-3), params));
    for (const double span : {1e-4, 1e-5, 2e-6})
        EXPECT_LE(jumpAcross(three, kTime, span, params), kSteepest * span + kNoise) << span;
}

// The jump, in radii, when balls approach by `way` radii; rotated, so that nothing is aligned with an axis.
double jumpAt(const std::function<std::vector<Vec3>(double)>& ballsAt, double way, const SkinParams& params) {
    const auto mesh = [&](double closer) {
        Particles particles;
        for (const Vec3& p : ballsAt(closer))
            particles.position.emplace_back(kEventRadius * Vec3(0.36 * p.x + 0.48 * p.y - 0.8 * p.z,
                                                                -0.8 * p.x + 0.6 * p.y,
                                                                0.48 * p.x + 0.64 * p.y + 0.6 * p.z));
        return skinFrame(particles, params).mesh;
    };
    return surfaceDistance(mesh(-way / 2), mesh(way / 2)).max / kEventRadius;
}

// For any points inside faces nearby.
TEST(Events, ANeckGrowsFromNothing) {
    Random random(1);
    for (int i = 0; i < 50; ++i) {
        const Vec3 towards = random.ball().normalized();
        const auto twoBalls = [&](double closer) { return std::vector<Vec3>{{0, 0, 0}, towards * (2 - closer)}; };
        EXPECT_LE(jumpAt(twoBalls, 1e-7, onTheBalls()), 0.001) << towards;
        EXPECT_LE(jumpAt(twoBalls, 1e-5, onTheBalls()), 0.002) << towards;
        EXPECT_LE(jumpAt(twoBalls, 1e-3, onTheBalls()), 0.025) << towards;  // the neck is 0.03 thick by then
    }
}

TEST(Events, AHoleBetweenThreeBallsCloses) {
    const auto threeBalls = [](double closer) {
        const double side = std::sqrt(3.0) - closer;
        return std::vector<Vec3>{{0, 0, 0}, {side, 0, 0}, {side / 2, side * std::sqrt(0.75), 0}};
    };
    EXPECT_LE(jumpAt(threeBalls, 1e-5, onTheBalls()), 0.01);
}

// Exactly on a lattice points of arcs coincide and are connected by slivers; after a tiny perturbation none coincide.
TEST(Events, ALatticeHasTheSurfaceOfItsTinyPerturbation) {
    for (const int side : {3, 5, 6}) {
        Random random(5);
        Particles lattice, shaken;
        for (int i = 0; i < side * side * side; ++i) {
            const Vec3 place = Vec3(i % side, i / side % side, i / (side * side)) * 0.2;
            lattice.position.emplace_back(place);
            shaken.position.emplace_back(place + random.cube() * 1e-5);
        }
        SkinParams params = onTheBalls();
        params.arc_subdivisions = 1;
        const Mesh exact = skinFrame(lattice, params).mesh, near = skinFrame(shaken, params).mesh;
        EXPECT_LE(surfaceDistance(exact, near).max / kEventRadius, 0.001) << side;
    }
}

// A ball of 2,109 jittered particles in fine steps, in which no particle moves by more than this many spacings: the
// largest jump between two steps, and the largest 99.9 % quantile.
struct Jumps {
    double largest = 0, of_nearly_all = 0;
};
Jumps jumpsOf(const SkinParams& params, unsigned seed, double farthest, int steps) {
    Random random(seed);
    Particles ball;
    for (int z = -8; z <= 8; ++z)
        for (int y = -8; y <= 8; ++y)
            for (int x = -8; x <= 8; ++x) {
                if (x * x + y * y + z * z > 64) continue;
                ball.position.emplace_back(Vec3(x, y, z) + random.cube() * 0.25);
                const double radius = std::sqrt(-2 * std::log(1 - random.unit())),
                             turn = 6.283185307179586 * random.unit();
                const double other =
                    std::sqrt(-2 * std::log(1 - random.unit())) * std::cos(6.283185307179586 * random.unit());
                ball.velocity.emplace_back(Vec3(radius * std::cos(turn), radius * std::sin(turn), other));
            }
    double fastest = 0;
    for (const Vec3f& v : ball.velocity) fastest = std::max(fastest, Vec3(v).length());
    Jumps jumps;
    Mesh before = skinFrame(ball, params).mesh;
    for (int i = 1; i <= steps; ++i) {
        Mesh now = skinFrame(advected(ball, i * farthest / fastest), params).mesh;
        const SurfaceDistance distance = surfaceDistance(before, now);
        jumps.largest = std::max(jumps.largest, distance.max);
        jumps.of_nearly_all = std::max(jumps.of_nearly_all, distance.quantile999);
        before = std::move(now);
    }
    return jumps;
}

TEST(Events, AMovingBallDoesNotJump) {
    for (const unsigned seed : {4, 11}) EXPECT_LE(jumpsOf(onTheBalls(), seed, 0.0003, 60).largest, 0.003);
    EXPECT_LE(jumpsOf(onTheBalls(), 15, 0.0003, 60).largest, 0.0015);  // edges turn beneath points that sink
    EXPECT_LE(jumpsOf(onTheBalls(), 1, 0.003, 20).largest, 0.03);
}

// A few sites still jump where vertices appear or vanish.
TEST(Events, TheSkinOfAMovingBallJumpsAtFewSites) {
    for (const unsigned seed : {1, 4, 7, 11}) {
        const Jumps jumps = jumpsOf(withSkin(), seed, 0.0003, 20);
        EXPECT_LE(jumps.of_nearly_all, 0.015);
        EXPECT_LE(jumps.largest, 0.05);
    }
}

}  // namespace
}  // namespace betamesh
