// Properties of the boundary of discs of different radii, and of the curves made of it.

#include "support/unequal_discs.h"
#include "base/random.h"
#include "base/union_find.h"
#include "betamesh/check.h"
#include "planar/boundary_curves.h"
#include "planar/disc_boundary.h"
#include "planar/velocity.h"

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

}  // namespace

TEST(UnequalDiscs, AgreeWithBruteForceSegmentForSegment) {
    std::size_t segments = 0;
    forEveryUnequalDiscs(360, [&](const UnequalDiscs& cloud) {
        if (cloud.particles.size() > 25) return;
        const SnappedParticles snapped = snapParticles(cloud.particles, cloud.radius);
        const SegmentSet found = segmentsOfRows(discBoundary(snapped));
        EXPECT_EQ(found, perturbedAlphaSegments(snapped));
        segments += found.size();
    });
    EXPECT_GT(segments, 3000U);
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

}  // namespace betamesh
