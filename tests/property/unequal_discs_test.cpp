// Properties of the boundary of discs of different radii, and of the curves made of it.

#include "support/unequal_discs.h"
#include "base/parallel.h"
#include "base/random.h"
#include "base/union_find.h"
#include "betamesh/check.h"
#include "betamesh/error.h"
#include "betamesh/skin.h"
#include "mesh/enclosure.h"
#include "planar/boundary_curves.h"
#include "planar/disc_boundary.h"
#include "planar/velocity.h"
#include "support/oracles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace betamesh {

namespace {

constexpr double kTurn = 2 * std::numbers::pi;

DiscBoundary boundaryOf(const UnequalDiscs& cloud) {
    return discBoundary(snapParticles(cloud.particles, cloud.radius));
}

SegmentSet segmentsOfRows(const DiscBoundary& boundary) {
    SegmentSet segments;
    for (const auto& [from, to] : boundary.segment) segments.insert({boundary.row[from], boundary.row[to]});
    return segments;
}

// Turning number of a curve: arcs turn left, vertices turn right.
double turningNumber(const DiscBoundary& boundary, std::size_t c) {
    double turn = 0;
    for (const std::uint32_t v : boundary.cycle[c]) {
        const Vec3 before = boundary.vertex[v] - boundary.centre(boundary.segment[v][0]),
                   after = boundary.vertex[v] - boundary.centre(boundary.segment[v][1]);
        turn += arcAngle(boundary, v) - std::abs(std::atan2(crossZ(before, after), dot(before, after)));
    }
    return turn / kTurn;
}

// Discs that meet or contain each other are in one component.
std::size_t componentsOf(const SnappedParticles& snapped) {
    UnionFind groups(snapped.size());
    for (std::uint32_t i = 0; i < snapped.size(); ++i)
        for (std::uint32_t k = 0; k < i; ++k) {
            const std::int64_t sum = snapped.radiusOf(i) + snapped.radiusOf(k);
            if ((snapped.position[i] - snapped.position[k]).length2() <= sum * sum) groups.join(i, k);
        }
    return groups.groups();
}

Curves curvesOn(const UnequalDiscs& cloud, int directions) {
    const DiscBoundary boundary = boundaryOf(cloud);
    const std::vector<DualVec3> discs = movingDiscs(boundary, cloud.particles);
    const BetaCurve curve = completeCurve(boundary, discs, boundaryVertices(boundary, discs), directions);
    Curves curves;
    for (const DualVec3& vertex : curve.vertex) curves.position.push_back(vertex.position);
    forEveryVertex(curve, [&](std::uint32_t, std::uint32_t v, std::uint32_t after) {
        curves.edges.push_back({v, after});
    });
    return curves;
}

// Particles with an attribute that makes skinPlane() give them the discs of the cloud.
Particles sized(const UnequalDiscs& cloud, const std::vector<double>& rate = {}) {
    Particles particles = cloud.particles;
    particles.attributes = {{"size", 1, {}, {}}};
    for (const double r : cloud.radius) particles.attributes[0].real.push_back(static_cast<float>(r / 1.5));
    if (rate.empty()) return particles;
    particles.attributes.push_back({"growth", 1, {}, {}});
    for (const double r : rate) particles.attributes[1].real.push_back(static_cast<float>(r / 1.5));
    return particles;
}

SkinParams sizedParams() {
    SkinParams params;
    params.radius = 1.5;
    params.spacing = 1;
    params.radius_attribute = "size";
    return params;
}

// The area within the skin.
double skinArea(const UnequalDiscs& cloud) { return measureCurves(skinPlane(sized(cloud), sizedParams()).curves).area; }

// Adds a jittered square of particles with this spacing, `side` wide, from a corner on.
void addSquare(const Vec3& corner, double spacing, double side, UnequalDiscs& cloud) {
    Random random(cloud.radius.size());
    const int n = static_cast<int>(std::lround(side / spacing));
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x) {
            const Vec3 jitter = random.cube() * Vec3(0.1, 0.1, 0);
            cloud.particles.position.emplace_back(corner + (Vec3(x, y, 0) + Vec3(0.5, 0.5, 0) + jitter) * spacing);
            cloud.radius.push_back(1.5 * spacing);
        }
}

}  // namespace

TEST(UnequalDiscs, AgreeWithBruteForceSegmentForSegment) {
    std::size_t segments = 0;
    forEveryUnequalDiscs(120, [&](const UnequalDiscs& cloud) {
        if (cloud.particles.size() > 25) return;
        const SnappedParticles snapped = snapParticles(cloud.particles, cloud.radius);
        const SegmentSet found = segmentsOfRows(discBoundary(snapped));
        EXPECT_EQ(found, perturbedAlphaSegments(snapped));
        segments += found.size();
    });
    EXPECT_GT(segments, 1000U);
}

TEST(UnequalDiscs, OfOneRadiusAreThoseOfThatRadius) {
    forEveryPlanarCloud(300, [](const Cloud& cloud) {
        const DiscBoundary one = discBoundary(snapParticles(cloud.particles, cloud.radius));
        const DiscBoundary each = boundaryOf({"", cloud.particles, std::vector(cloud.particles.size(), cloud.radius)});
        EXPECT_TRUE(each.radius_of.empty());
        EXPECT_EQ(one.segment, each.segment);
        EXPECT_EQ(one.vertex, each.vertex);
        EXPECT_EQ(one.next, each.next);
        EXPECT_EQ(one.isolated, each.isolated);
    });
}

TEST(UnequalDiscs, HaveClosedCurvesThatTurnLeftAroundComponentsAndRightAroundHoles) {
    forEveryUnequalDiscs(6000, [](const UnequalDiscs& cloud) {
        const SnappedParticles snapped = snapParticles(cloud.particles, cloud.radius);
        const DiscBoundary boundary = discBoundary(snapped);
        std::vector<int> reached(boundary.vertex.size(), 0);
        for (std::uint32_t v = 0; v < boundary.vertex.size(); ++v) {
            ASSERT_EQ(boundary.segment[v][1], boundary.segment[boundary.next[v]][0]);
            ++reached[boundary.next[v]];
        }
        for (const int times : reached) ASSERT_EQ(times, 1);
        ASSERT_EQ(boundary.cycle.item.size(), boundary.vertex.size());
        std::size_t outer = boundary.isolated.size();
        for (std::size_t c = 0; c < boundary.cycle.size(); ++c) {
            const double turning = turningNumber(boundary, c);
            ASSERT_NEAR(std::abs(turning), 1, 1e-2);
            outer += turning > 0;
        }
        EXPECT_EQ(outer, componentsOf(snapped));
    });
}

TEST(UnequalDiscs, HaveVerticesOnTwoCirclesAndInsideNone) {
    forEveryUnequalDiscs(600, [](const UnequalDiscs& cloud) {
        const SnappedParticles snapped = snapParticles(cloud.particles, cloud.radius);
        const DiscBoundary boundary = discBoundary(snapped);
        const double rounding = 1e-6 * boundary.worldRadius();
        for (std::size_t v = 0; v < boundary.vertex.size(); ++v)
            for (std::uint32_t p = 0; p < snapped.size(); ++p) {
                const double distance = (boundary.vertex[v] - toDouble(snapped.position[p]) * snapped.quantum).length(),
                             radius = static_cast<double>(snapped.radiusOf(p)) * snapped.quantum;
                ASSERT_GE(distance, radius - rounding);
                for (const std::uint32_t disc : boundary.segment[v])
                    if (boundary.snapped_row[disc] == p) {
                        ASSERT_LE(distance, radius + rounding);
                    }
            }
    });
}

TEST(UnequalDiscs, DoNotDependOnParticleOrder) {
    forEveryUnequalDiscs(300, [](const UnequalDiscs& cloud) {
        const UnequalDiscs other = reversed(cloud);
        const DiscBoundary a = boundaryOf(cloud), b = boundaryOf(other);
        EXPECT_EQ(a.position, b.position);
        EXPECT_EQ(a.radius_of, b.radius_of);
        EXPECT_EQ(a.segment, b.segment);
        EXPECT_EQ(a.vertex, b.vertex);
        EXPECT_EQ(a.next, b.next);
        EXPECT_EQ(a.isolated, b.isolated);
    });
}

TEST(UnequalDiscs, HaveCurvesThatAreClosedAndDoNotCross) {
    forEveryUnequalDiscs(1000, [](const UnequalDiscs& cloud) {
        for (const int directions : {8, 24}) {
            const Curves curves = curvesOn(cloud, directions);
            EXPECT_EQ(measureCurves(curves).unpaired_ends, 0U);
            CheckParams check;
            check.tolerance = 1e-6 * *std::max_element(cloud.radius.begin(), cloud.radius.end());
            EXPECT_EQ(checkCurves(curves, check).crossings.count, 0U);
        }
    });
}

TEST(UnequalDiscs, HaveCurvesWithTheAreaOfTheirUnion) {
    for (std::uint64_t seed = 0; seed < 12; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        UnequalDiscs cloud;
        for (int i = 0; i < 15; ++i) {
            cloud.particles.position.emplace_back(random.cube() * Vec3(1, 1, 0));
            cloud.radius.push_back(std::pow(20, -random.unit()));
        }
        const double area = measureCurves(curvesOn(cloud, 400)).area;
        constexpr int kPoints = 200000;
        int inside = 0;
        for (int i = 0; i < kPoints; ++i) {
            const Vec3 point = random.cube() * Vec3(2, 2, 0);
            for (std::size_t d = 0; d < cloud.radius.size(); ++d)
                if ((point - Vec3(cloud.particles.position[d])).length() < cloud.radius[d]) {
                    ++inside;
                    break;
                }
        }
        EXPECT_NEAR(area, 16.0 * inside / kPoints, 0.06);
    }
}

TEST(UnequalDiscs, HaveASkinThatIsClosedAroundAllParticlesAndWithoutCrossings) {
    forEveryUnequalDiscs(72, [](const UnequalDiscs& cloud) {
        if (cloud.particles.size() > 40) return;  // takes too long
        for (const double skin : {0.55, 0.2, 0.0}) {
            SkinParams params = sizedParams();
            if (skin != 0.55) params.skin = skin * params.spacing;
            const Curves curves = skinPlane(sized(cloud), params).curves;
            EXPECT_EQ(measureCurves(curves).unpaired_ends, 0U);
            for (const Vec3& p : curves.position) ASSERT_TRUE(std::isfinite(p.x) && std::isfinite(p.y));
            for (const Vec3& v : curves.velocity) ASSERT_TRUE(std::isfinite(v.x) && std::isfinite(v.y));
            CheckParams check;
            check.tolerance = 1e-6 * *std::max_element(cloud.radius.begin(), cloud.radius.end());
            EXPECT_EQ(checkCurves(curves, check).crossings.count, 0U);
            const std::vector<Vec3> points(cloud.particles.position.begin(), cloud.particles.position.end());
            for (const double distance : distancesOutside(curves, {}, points)) EXPECT_LE(distance, check.tolerance);
        }
    });
}

TEST(UnequalDiscs, OfOneSizeHaveTheCurvesOfThatRadius) {
    forEveryPlanarCloud(60, [](const Cloud& cloud) {
        if (cloud.particles.size() == 0 || cloud.particles.size() > 12) return;
        const UnequalDiscs discs{"", cloud.particles, std::vector(cloud.particles.size(), 0.75)};
        SkinParams given = sizedParams();
        given.radius_attribute.clear();
        given.radius = 0.75;
        given.spacing = 0.5;
        const SkinnedPlane one = skinPlane(cloud.particles, given), each = skinPlane(sized(discs), sizedParams());
        EXPECT_EQ(one.curves.position, each.curves.position);
        EXPECT_EQ(one.curves.velocity, each.curves.velocity);
        EXPECT_EQ(one.curves.edges, each.curves.edges);
    });
}

TEST(UnequalDiscs, HaveASkinThatEnclosesAPlaneOfEachDropsSize) {
    UnequalDiscs cloud;
    double expected = 0;
    for (const double spacing : {1.0, 0.7, 0.3, 0.1, 0.05}) {
        cloud.particles.position.emplace_back(Vec3(10.0 * static_cast<double>(cloud.radius.size()), 0, 0));
        cloud.radius.push_back(1.5 * spacing);
        expected += spacing * spacing;
    }
    const Curves curves = skinPlane(sized(cloud), sizedParams()).curves;
    EXPECT_NEAR(measureCurves(curves).area, expected, 0.05 * expected);
    for (const Vec3& p : curves.position) {
        const auto nearest = static_cast<std::size_t>(std::lround(p.x / 10));
        const double distance = (p - Vec3(cloud.particles.position[nearest])).length(),
                     spacing = cloud.radius[nearest] / 1.5;
        EXPECT_NEAR(distance, spacing / std::sqrt(std::numbers::pi), 0.03 * spacing);
    }
}

// Two squares far from each other, each with the area of its liquid.
TEST(UnequalDiscs, HaveASkinAtTheDistanceOfTheirSize) {
    for (const double fine : {1.0, 0.5, 0.25, 0.0625}) {
        SCOPED_TRACE("spacing " + std::to_string(fine));
        UnequalDiscs cloud;
        addSquare(Vec3(0), 1, 20, cloud);
        const double alone = skinArea(cloud);
        addSquare(Vec3(40, 0, 0), fine, 20 * fine, cloud);
        const double both = skinArea(cloud);
        EXPECT_NEAR(alone / 400, 1.01, 0.03);
        EXPECT_NEAR((both - alone) / (400 * fine * fine), 1.01, 0.03);
    }
}

// Coarse and fine particles side by side, with one curve around both.
TEST(UnequalDiscs, OfASquareThatIsCoarseOnOneSideEncloseItsArea) {
    for (const double fine : {0.5, 0.25, 0.125}) {
        SCOPED_TRACE("spacing " + std::to_string(fine));
        UnequalDiscs cloud;
        addSquare(Vec3(0), 1, 16, cloud);
        addSquare(Vec3(16, 0, 0), fine, 16, cloud);
        const Curves curves = skinPlane(sized(cloud), sizedParams()).curves;
        EXPECT_EQ(linesOf(curves).size(), 1U);
        EXPECT_NEAR(measureCurves(curves).area / (2 * 16 * 16), 1.01, 0.03);
    }
}

// Fine particles round coarse ones: all discs near the surface have one size, which is not the largest.
TEST(UnequalDiscs, HaveASkinOfTheSizeAtTheSurface) {
    UnequalDiscs cloud, fine;
    addSquare(Vec3(-4, -4, 0), 1, 8, cloud);
    addSquare(Vec3(-12, -12, 0), 0.5, 24, fine);
    for (std::size_t i = 0; i < fine.radius.size(); ++i) {
        const Vec3f& p = fine.particles.position[i];
        if (std::max(std::abs(p.x), std::abs(p.y)) < 4) continue;
        cloud.particles.position.push_back(p);
        cloud.radius.push_back(fine.radius[i]);
    }
    const Curves mixed = skinPlane(sized(cloud), sizedParams()).curves,
                 alone = skinPlane(sized(fine), sizedParams()).curves;
    ASSERT_EQ(mixed.position.size(), alone.position.size());
    for (std::size_t v = 0; v < mixed.position.size(); ++v) EXPECT_LE(distanceTo(alone, mixed.position[v]), 1e-4);
}

// The reference is not a size of its own: the same skin follows from another radius with its spacing.
TEST(UnequalDiscs, DoNotDependOnWhichSizeTheRadiusIsGivenFor) {
    UnequalDiscs cloud;
    addSquare(Vec3(0), 1, 8, cloud);
    addSquare(Vec3(8, 0, 0), 0.5, 8, cloud);
    SkinParams other = sizedParams();
    other.radius = 0.375;
    other.spacing = 0.25;
    EXPECT_EQ(skinPlane(sized(cloud), sizedParams()).curves.position, skinPlane(sized(cloud), other).curves.position);
}

TEST(UnequalDiscs, DoNotDependOnOrderOrThreads) {
    forEveryUnequalDiscs(24, [](const UnequalDiscs& cloud) {
        if (cloud.particles.size() > 12) return;
        const SkinnedPlane one = skinPlane(sized(cloud), sizedParams());
        const auto expectSame = [&](const SkinnedPlane& other) {
            EXPECT_EQ(one.curves.position, other.curves.position);
            EXPECT_EQ(one.curves.velocity, other.curves.velocity);
            EXPECT_EQ(one.curves.edges, other.curves.edges);
        };
        expectSame(skinPlane(sized(reversed(cloud)), sizedParams()));
        withThreads(1, [&] { expectSame(skinPlane(sized(cloud), sizedParams())); });
    });
}

// Holes of three sizes in a square: they are filled if no disc wider than what is between the discs fits.
TEST(UnequalDiscs, HaveHolesFilledIfNoDiscOfTheGapFitsBetweenThem) {
    const auto filled = [](double scale, double hole, double gap) {
        UnequalDiscs cloud;
        addSquare(Vec3(0), scale, 20 * scale, cloud);
        UnequalDiscs rest;
        for (std::size_t i = 0; i < cloud.radius.size(); ++i) {
            const Vec3 p(cloud.particles.position[i]);
            if ((p - Vec3(10 * scale, 10 * scale, 0)).length() < 1.5 * scale + hole) continue;
            rest.particles.position.emplace_back(p);
            rest.radius.push_back(cloud.radius[i]);
        }
        rest.particles.position.emplace_back(Vec3(100, 0, 0));
        rest.radius.push_back(1.5);
        SkinParams params = sizedParams();
        params.features.bubbles = Bubbles::fill;
        params.features.bubble_gap = gap;
        return skinPlane(sized(rest), params).report.bubbles_filled;
    };
    for (const double scale : {0.5, 0.25}) {
        SCOPED_TRACE("spacing " + std::to_string(scale));
        EXPECT_EQ(filled(scale, 1, 3 + 2 * 0.9), 0U);
        EXPECT_EQ(filled(scale, 1, 3 + 2 * (1.2 + scale)), 1U);
        EXPECT_EQ(filled(scale, 1, 2.9), 0U);
    }
}

TEST(UnequalDiscs, HaveVerticesThatMoveAsTheirVelocitiesSay) {
    constexpr double kTime = 1e-4;
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        UnequalDiscs cloud;
        std::vector<double> rate;
        for (int i = 0; i < 12; ++i) {
            cloud.particles.position.emplace_back(random.cube() * Vec3(2, 2, 0));
            cloud.particles.velocity.emplace_back(random.cube() * Vec3(1, 1, 0));
            cloud.radius.push_back(random.between(0.2, 1));
            rate.push_back(random.between(-1, 1));
        }
        DiscBoundary before = boundaryOf(cloud);
        for (const std::uint32_t row : before.row) before.radius_rate.push_back(rate[row]);
        const std::vector<DualVec3> discs = movingDiscs(before, cloud.particles),
                                    vertices = boundaryVertices(before, discs);
        std::size_t checked = 0;
        for (std::size_t v = 0; v < vertices.size(); ++v) {
            const auto [from, to] = before.segment[v];
            const Vec3 q1 = (vertices[v].position - discs[from].position).normalized(),
                       q2 = (vertices[v].position - discs[to].position).normalized();
            if (std::abs(crossZ(q1, q2)) < 0.3) continue;
            for (const std::uint32_t disc : before.segment[v]) {  // it stays on both circles
                const Vec3 q = vertices[v].position + vertices[v].velocity * kTime - discs[disc].position -
                               discs[disc].velocity * kTime;
                const Dual radius = before.worldRadiusOf(disc);
                EXPECT_NEAR(q.length(), radius.value + radius.rate * kTime, 100 * kTime * kTime);
            }
            ++checked;
        }
        EXPECT_GT(checked, 0U);
    }
}

// A liquid that grows and moves as a whole, and single drops: the curve after a short time is where velocities put it.
TEST(UnequalDiscs, HaveASkinThatMovesAsItsVelocitiesSay) {
    constexpr double kTime = 1e-3, kGrowth = 0.3;
    const Vec3 drift(0.2, -0.1, 0);
    UnequalDiscs cloud;
    addSquare(Vec3(-8, -4, 0), 1, 8, cloud);
    addSquare(Vec3(0, -4, 0), 0.5, 8, cloud);
    for (const double x : {15.0, 20.0, 25.0}) {
        cloud.particles.position.emplace_back(Vec3(x, 0, 0));
        cloud.radius.push_back(1.5 * (30 - x) / 15);
    }
    const auto at = [&](double time) {
        UnequalDiscs then = cloud;
        std::vector<double> rate;
        for (std::size_t i = 0; i < then.radius.size(); ++i) {
            const Vec3 p(cloud.particles.position[i]);
            then.particles.position[i] = Vec3f(p + (p * kGrowth + drift) * time);
            then.particles.velocity.emplace_back(p * kGrowth + drift);
            then.radius[i] *= 1 + kGrowth * time;
            rate.push_back(cloud.radius[i] * kGrowth);
        }
        SkinParams params = sizedParams();
        params.radius_rate_attribute = "growth";
        return skinPlane(sized(then, rate), params).curves;
    };
    const Curves before = at(0), after = at(kTime);
    double squares = 0, largest = 0;
    for (std::size_t v = 0; v < before.position.size(); ++v) {
        const double missed = distanceTo(after, before.position[v] + before.velocity[v] * kTime) / kTime;
        squares += missed * missed;
        largest = std::max(largest, missed);
    }
    EXPECT_LE(std::sqrt(squares / static_cast<double>(before.position.size())), 0.03);
    EXPECT_LE(largest, 0.1);
}

TEST(UnequalDiscs, AreRefusedWithThePapersTessellation) {
    SkinParams params = sizedParams();
    params.tessellation = Tessellation::paper;
    EXPECT_THROW(requirePlanar(params), Error);
}

}  // namespace betamesh
