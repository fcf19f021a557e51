// Single events: moments at which the boundary of the union of moving balls changes its combinatorics, and how far each
// surface jumps there. README.md has the measurements.

#include "support/events.h"
#include "base/random.h"
#include "betamesh/coherence.h"
#include "betamesh/skin.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>

namespace betamesh {
namespace {

constexpr double kRadius = 1.5;  // in spacings, as by default
constexpr std::array<double, 5> kSpans = {1e-3, 1e-4, 1e-5, 1e-6, 1e-7};
// Radii per second: allowed speed of a surface whose particles move at up to 0.67 of that; vertices of nearly coplanar
// triplets are faster than particles.
constexpr double kSteepest = 50;
// Radii. Coordinates are snapped to a grid of r / 2^19 or finer, which vertices magnify.
constexpr double kNoise = 3e-5;

struct Event {
    std::string kind;
    bool in_block;        // not in a thin sheet or in spray
    Particles particles;  // at time 0
    double time;
    std::string name;
};

struct Surface {
    const char* name;
    SkinParams params;
};

SkinParams skin(Tessellation tessellation, SmoothingMethod smoothing) {
    SkinParams params;
    params.radius = kRadius;
    params.tessellation = tessellation;
    params.smoothing = smoothing;
    return params;
}

constexpr std::size_t kOurs = 0, kAlgorithmFour = 4, kSkin = 6;  // in surfaces()

const std::vector<Surface>& surfaces() {
    static const std::vector<Surface> all = [] {
        std::vector<Surface> list{
            {"ours, on the balls", skin(Tessellation::complete, SmoothingMethod::coherent)},
            {"the same, not smoothed", skin(Tessellation::complete, SmoothingMethod::none)},
            {"paper's fans, smoothed as ours", skin(Tessellation::paper, SmoothingMethod::coherent)},
            {"paper's, not smoothed", skin(Tessellation::paper, SmoothingMethod::none)},
            {"paper's Algorithm 4", skin(Tessellation::paper, SmoothingMethod::paper)},
            {"alpha mesh", skin(Tessellation::complete, SmoothingMethod::coherent)}};
        list.back().params.surface = SurfaceKind::alpha;
        list[kOurs].params.skin = 0;
        list.push_back({"ours, the skin", skin(Tessellation::complete, SmoothingMethod::coherent)});
        return list;
    }();
    return all;
}

// A few events of each kind from blocks, and as many from sheets with gaps and from spray.
const std::vector<Event>& events() {
    static const std::vector<Event> all = [] {
        constexpr std::size_t kMost = 8, kMostOfACloud = 2;
        std::vector<Event> list;
        std::map<std::pair<std::string, bool>, std::size_t> count;
        for (std::uint64_t seed = 0; seed < 24; ++seed) {
            const bool block = seed % 3 == 0, spray = seed % 3 == 2;
            const Particles start = block   ? movingCloud(seed, {5, 5, 5}, 0.25, 1)
                                    : spray ? movingCloud(seed, {5, 5, 5}, 0.5, 0.1)
                                            : movingCloud(seed, {5, 5, 1}, 0.25, 0.8);
            const double span = spray ? 2 : 0.1;
            std::map<std::string, std::size_t> here;
            const auto particlesAt = [&](double time) { return advected(start, time); };
            findEvents(0, span, surfaces()[kOurs].params, particlesAt, [&](double time, const std::string& kind) {
                if (kind == "several" || count[{kind, block}] == kMost || here[kind] == kMostOfACloud) return;
                ++count[{kind, block}], ++here[kind];
                list.push_back({kind, block, start, time,
                                kind + " of cloud " + std::to_string(seed) + " at " + std::to_string(time)});
            });
        }
        std::stable_sort(list.begin(), list.end(), [](const Event& x, const Event& y) {
            return std::pair(x.kind, !x.in_block) < std::pair(y.kind, !y.in_block);
        });
        return list;
    }();
    return all;
}

double jump(const Particles& start, double time, double span, const SkinParams& params) {
    const Mesh before = skinFrame(advected(start, time - span / 2), params).mesh;
    const Mesh after = skinFrame(advected(start, time + span / 2), params).mesh;
    return surfaceDistance(before, after).max;
}

// Of event e, surface s, span k; in radii.
double jumpOf(std::size_t e, std::size_t s, std::size_t k) {
    return jump(events()[e].particles, events()[e].time, kSpans[k], surfaces()[s].params) / kRadius;
}

// The table of README.md: the median and the largest jump of each kind.
TEST(Events, TableOfJumps) {
    for (std::size_t first = 0, last = 0; first < events().size(); first = last) {
        const Event& event = events()[first];
        while (last < events().size() && events()[last].kind == event.kind && events()[last].in_block == event.in_block)
            ++last;
        std::printf("%s, %s (%zu)%*s", event.kind.c_str(), event.in_block ? "block" : "thin", last - first,
                    static_cast<int>(22 - event.kind.size()), "");
        for (const double span : kSpans) std::printf("  %15.0e", span);
        for (std::size_t s = 0; s < surfaces().size(); ++s) {
            std::printf("\n  %-31s", surfaces()[s].name);
            for (std::size_t k = 0; k < kSpans.size(); ++k) {
                std::vector<double> found;
                for (std::size_t e = first; e < last; ++e) found.push_back(jumpOf(e, s, k));
                std::sort(found.begin(), found.end());
                std::printf("  %7.1e %7.1e", found[found.size() / 2], found.back());
            }
        }
        std::printf("\n");
    }
}

TEST(Events, OfEveryKindAreFound) {
    std::map<std::string, std::size_t> count;
    for (const Event& event : events()) ++count[event.kind];
    for (const char* kind : {"flip", "birth", "void", "hole", "graze", "contact"}) EXPECT_GE(count[kind], 4u) << kind;
}

// Over longer times there are other events, too: larger balls of the same cloud touch or separate.
TEST(Events, OurSurfaceIsContinuousThroughFlipsAndBirths) {
    for (std::size_t e = 0; e < events().size(); ++e) {
        if (events()[e].kind != "flip" && events()[e].kind != "birth") continue;
        for (const std::size_t k : {3, 4})
            EXPECT_LE(jumpOf(e, kOurs, k), kSteepest * kSpans[k] + kNoise)
                << events()[e].name << ", over " << kSpans[k] << " s";
        EXPECT_LE(jumpOf(e, kOurs, 2), 0.003) << events()[e].name;
    }
}

// In bulk none of these events moves the skin. In thin liquid most do not; there folds are relaxed.
TEST(Events, TheSkinHardlyJumpsAtFlipsAndBirths) {
    std::vector<double> found;
    for (std::size_t e = 0; e < events().size(); ++e) {
        if (events()[e].kind != "flip" && events()[e].kind != "birth") continue;
        found.push_back(jumpOf(e, kSkin, 3));
        if (events()[e].in_block) {
            EXPECT_LE(found.back(), 0.0002) << events()[e].name;
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
    for (std::size_t e = 0; e < events().size(); ++e) {
        if (events()[e].kind != "contact") continue;
        EXPECT_LE(jumpOf(e, kSkin, 3), 0.06) << events()[e].name;
        ++found;
    }
    EXPECT_GE(found, 4u);
}

// Nor where holes open or close: what is left is what the retracted arcs miss of the balls.
TEST(Events, TheSkinHardlyJumpsWhereHolesOpenAndClose) {
    std::vector<double> found;
    for (std::size_t e = 0; e < events().size(); ++e)
        if (events()[e].kind == "hole") found.push_back(jumpOf(e, kSkin, 3));
    ASSERT_GE(found.size(), 4u);
    std::sort(found.begin(), found.end());
    EXPECT_LE(found[found.size() / 2], 0.06);
    EXPECT_LE(found.back(), 0.1);
}

// Where balls begin to touch, the jump is as large as the distance between triangles and balls.
TEST(Events, OurSurfaceHardlyJumpsWhereBallsBeginToTouch) {
    for (std::size_t e = 0; e < events().size(); ++e) {
        if (events()[e].kind == "flip" || events()[e].kind == "birth" || events()[e].kind == "void") continue;
        EXPECT_LE(jumpOf(e, kOurs, 2), 0.01) << events()[e].name;
    }
}

// The paper's smoothing averages over neighbouring faces, and neighbours change at a flip.
TEST(Events, AlgorithmFourJumpsAtFlipsHoweverShortTheTime) {
    std::vector<double> found;
    for (std::size_t e = 0; e < events().size(); ++e) {
        if (events()[e].kind != "flip" || !events()[e].in_block) continue;
        const double shorter = jumpOf(e, kAlgorithmFour, 2);
        EXPECT_NEAR(jumpOf(e, kAlgorithmFour, 1), shorter, 0.3 * shorter) << events()[e].name;
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
    const SkinParams& params = surfaces()[kOurs].params;
    EXPECT_EQ(combinatoricsOf(advected(three, kTime - 1e-3), params),
              combinatoricsOf(advected(three, kTime + 1e-3), params));
    for (const double span : {1e-4, 1e-5, 2e-6})
        EXPECT_LE(jump(three, kTime, span, params), kRadius * (kSteepest * span + kNoise)) << span;
}

// The jump, in radii, when balls approach by `way` radii; rotated, so that nothing is aligned with an axis.
double jumpAt(const std::function<std::vector<Vec3>(double)>& ballsAt, double way, const SkinParams& params) {
    const auto mesh = [&](double closer) {
        Particles particles;
        for (const Vec3& p : ballsAt(closer))
            particles.position.emplace_back(kRadius * Vec3(0.36 * p.x + 0.48 * p.y - 0.8 * p.z, -0.8 * p.x + 0.6 * p.y,
                                                           0.48 * p.x + 0.64 * p.y + 0.6 * p.z));
        return skinFrame(particles, params).mesh;
    };
    return surfaceDistance(mesh(-way / 2), mesh(way / 2)).max / kRadius;
}

// For any points inside faces nearby.
TEST(Events, ANeckGrowsFromNothing) {
    Random random(1);
    for (int i = 0; i < 50; ++i) {
        const Vec3 towards = random.ball().normalized();
        const auto twoBalls = [&](double closer) { return std::vector<Vec3>{{0, 0, 0}, towards * (2 - closer)}; };
        EXPECT_LE(jumpAt(twoBalls, 1e-7, surfaces()[kOurs].params), 0.001) << towards;
        EXPECT_LE(jumpAt(twoBalls, 1e-5, surfaces()[kOurs].params), 0.002) << towards;
        EXPECT_LE(jumpAt(twoBalls, 1e-3, surfaces()[kOurs].params), 0.025)
            << towards;  // the neck is 0.03 thick by then
    }
}

TEST(Events, AHoleBetweenThreeBallsCloses) {
    const auto threeBalls = [](double closer) {
        const double side = std::sqrt(3.0) - closer;
        return std::vector<Vec3>{{0, 0, 0}, {side, 0, 0}, {side / 2, side * std::sqrt(0.75), 0}};
    };
    EXPECT_LE(jumpAt(threeBalls, 1e-5, surfaces()[kOurs].params), 0.01);
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
        SkinParams params = surfaces()[kOurs].params;
        params.arc_subdivisions = 1;
        const Mesh exact = skinFrame(lattice, params).mesh, near = skinFrame(shaken, params).mesh;
        EXPECT_LE(surfaceDistance(exact, near).max / kRadius, 0.001) << side;
    }
}

// A ball of 2,109 jittered particles in fine steps, in which no particle moves by more than this many spacings: the
// largest jump between two steps, and the largest 99.9 % quantile.
struct Jumps {
    double largest = 0, of_nearly_all = 0;
};
Jumps jumpsOf(std::size_t surface, unsigned seed, double farthest, int steps) {
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
    const SkinParams& params = surfaces()[surface].params;
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
    for (const unsigned seed : {1, 4, 7, 11}) EXPECT_LE(jumpsOf(kOurs, seed, 0.0003, 60).largest, 0.003);
    EXPECT_LE(jumpsOf(kOurs, 15, 0.0003, 60).largest, 0.0015);  // edges turn beneath points that sink
    EXPECT_LE(jumpsOf(kOurs, 1, 0.003, 20).largest, 0.03);
}

// A few sites still jump where vertices appear or vanish.
TEST(Events, TheSkinOfAMovingBallJumpsAtFewSites) {
    for (const unsigned seed : {1, 4, 7, 11}) {
        const Jumps jumps = jumpsOf(kSkin, seed, 0.0003, 20);
        EXPECT_LE(jumps.of_nearly_all, 0.015);
        EXPECT_LE(jumps.largest, 0.05);
    }
}

}  // namespace
}  // namespace betamesh
