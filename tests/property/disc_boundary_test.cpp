// Properties of the boundary of discs of every planar cloud.

#include "planar/disc_boundary.h"
#include "base/union_find.h"
#include "support/planar_clouds.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace betamesh {

namespace {

constexpr double kTurn = 2 * std::numbers::pi;

DiscBoundary boundaryOf(const Cloud& cloud) { return discBoundary(snapParticles(cloud.particles, cloud.radius)); }

SegmentSet segmentsOfRows(const DiscBoundary& boundary) {
    SegmentSet segments;
    for (const auto& [from, to] : boundary.segment) segments.insert({boundary.row[from], boundary.row[to]});
    return segments;
}

// Turning number of a curve: arcs turn left, vertices turn right.
double turningNumber(const DiscBoundary& boundary, std::size_t c) {
    double turn = 0;
    for (const std::uint32_t v : boundary.cycle[c]) {
        const auto [from, to] = boundary.segment[v];
        const double half = (boundary.centre(to) - boundary.centre(from)).length() / 2;
        turn += arcAngle(boundary, v) - 2 * std::asin(std::min(1.0, half / boundary.worldRadius()));
    }
    return turn / kTurn;
}

std::size_t componentsOfDiscs(const Cloud& cloud) {
    const SnappedParticles snapped = snapParticles(cloud.particles, cloud.radius);
    UnionFind groups(snapped.size());
    for (std::uint32_t i = 0; i < snapped.size(); ++i)
        for (std::uint32_t j = 0; j < i; ++j) {
            const Vec3i d = snapped.position[i] - snapped.position[j];
            if (d.x * d.x + d.y * d.y <= 4 * snapped.radius * snapped.radius) groups.join(i, j);
        }
    return groups.groups();
}

// Winding number of the curves about a point: the sum of the angles that all arcs subtend.
double windingNumber(const DiscBoundary& boundary, const Vec3& point) {
    double turn = 0;
    const auto along = [&](const Vec3& centre, double begin, double angle) {
        const auto pieces = static_cast<int>(std::ceil(angle / 0.05));
        const auto at = [&](int k) {
            const double theta = begin + angle * k / pieces;
            return centre + Vec3(std::cos(theta), std::sin(theta), 0) * boundary.worldRadius() - point;
        };
        for (int k = 0; k < pieces; ++k) {
            const Vec3 a = at(k), b = at(k + 1);
            turn += std::atan2(a.x * b.y - a.y * b.x, a.x * b.x + a.y * b.y);
        }
    };
    for (std::uint32_t v = 0; v < boundary.vertex.size(); ++v) {
        const Vec3 centre = boundary.centre(boundary.segment[v][1]), first = boundary.vertex[v] - centre;
        along(centre, std::atan2(first.y, first.x), arcAngle(boundary, v));
    }
    for (const std::uint32_t d : boundary.isolated) along(boundary.centre(d), 0, kTurn);
    return turn / kTurn;
}

}  // namespace

TEST(DiscBoundary, AgreesWithBruteForceSegmentForSegment) {
    forEveryPlanarCloud(3000, [](const Cloud& cloud) {
        if (cloud.particles.size() > 50) return;
        EXPECT_EQ(segmentsOfRows(boundaryOf(cloud)), bruteForceAlphaSegments(cloud.particles, cloud.radius));
    });
}

TEST(DiscBoundary, EveryArcIsOnTheDiscThatItsVerticesShare) {
    forEveryPlanarCloud(3000, [](const Cloud& cloud) {
        const DiscBoundary boundary = boundaryOf(cloud);
        std::vector<int> reached(boundary.vertex.size(), 0);
        for (std::uint32_t v = 0; v < boundary.vertex.size(); ++v) {
            ASSERT_EQ(boundary.segment[v][1], boundary.segment[boundary.next[v]][0]);
            ++reached[boundary.next[v]];
        }
        for (const int times : reached) ASSERT_EQ(times, 1);
        ASSERT_EQ(boundary.cycle.item.size(), boundary.vertex.size());
        for (std::size_t c = 0; c < boundary.cycle.size(); ++c) ASSERT_GE(boundary.cycle[c].size(), 2u);
    });
}

TEST(DiscBoundary, CurvesTurnLeftAroundComponentsAndRightAroundHoles) {
    forEveryPlanarCloud(3000, [](const Cloud& cloud) {
        const DiscBoundary boundary = boundaryOf(cloud);
        std::size_t outer = boundary.isolated.size();
        for (std::size_t c = 0; c < boundary.cycle.size(); ++c) {
            const double turning = turningNumber(boundary, c);
            ASSERT_NEAR(std::abs(turning), 1, 1e-3);
            outer += turning > 0;
        }
        EXPECT_EQ(outer, componentsOfDiscs(cloud));
    });
}

TEST(DiscBoundary, CurvesWindOnceAroundExactlyThePointsOfTheDiscs) {
    forEveryPlanarCloud(150, [](const Cloud& cloud) {
        if (cloud.particles.size() > 100) return;
        const DiscBoundary boundary = boundaryOf(cloud);
        const SnappedParticles snapped = snapParticles(cloud.particles, cloud.radius);
        for (std::uint32_t i = 0; i < snapped.size(); ++i)
            for (int k = 0; k < 8; ++k) {
                const double way = 0.31 * (k + 1) * cloud.radius;
                const Vec3 point = toDouble(snapped.position[i]) * snapped.quantum +
                                   Vec3(std::cos(2.4 * k + i), std::sin(2.4 * k + i), 0) * way;
                double nearest = 1e300;
                for (const Vec3i& p : snapped.position)
                    nearest = std::min(nearest, (toDouble(p) * snapped.quantum - point).length());
                if (std::abs(nearest - cloud.radius) < 0.02 * cloud.radius) continue;
                ASSERT_NEAR(windingNumber(boundary, point), nearest < cloud.radius ? 1 : 0, 1e-3);
            }
    });
}

TEST(DiscBoundary, VerticesAreOnTwoCirclesAndInsideNone) {
    forEveryPlanarCloud(500, [](const Cloud& cloud) {
        const DiscBoundary boundary = boundaryOf(cloud);
        const SnappedParticles snapped = snapParticles(cloud.particles, cloud.radius);
        const double radius = boundary.worldRadius();
        for (std::size_t v = 0; v < boundary.vertex.size(); ++v)
            for (std::uint32_t p = 0; p < snapped.size(); ++p) {
                const double distance = (boundary.vertex[v] - toDouble(snapped.position[p]) * snapped.quantum).length();
                ASSERT_GE(distance, radius * (1 - 1e-6));
                for (const std::uint32_t disc : boundary.segment[v])
                    if (boundary.snapped_row[disc] == p) {
                        ASSERT_LE(distance, radius * (1 + 1e-6));
                    }
            }
    });
}

TEST(DiscBoundary, DoesNotDependOnParticleOrder) {
    forEveryPlanarCloud(300, [](const Cloud& cloud) {
        const DiscBoundary one = boundaryOf(cloud);
        const DiscBoundary other = discBoundary(snapParticles(shuffled(cloud.particles, 7), cloud.radius));
        EXPECT_EQ(one.position, other.position);
        EXPECT_EQ(one.segment, other.segment);
        EXPECT_EQ(one.vertex, other.vertex);
        EXPECT_EQ(one.next, other.next);
        EXPECT_EQ(one.cycle.item, other.cycle.item);
        EXPECT_EQ(one.isolated, other.isolated);
    });
}

}  // namespace betamesh
