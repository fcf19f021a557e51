#include "skin/arcs.h"

#include "exact/snapped_particles.h"
#include "skin/ball_boundary.h"
#include "skin/coverage.h"
#include "skin/velocity.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace betamesh {
namespace {

constexpr double kRadius = 1.5, kLongest = 0.25;
using Line = std::vector<Vec3>;

struct Arcs {
    BallBoundary boundary;
    ArcNetwork network;
};

Arcs arcsOf(const Particles& particles) {
    const SnappedParticles snapped = snapParticles(particles, kRadius);
    BallBoundary boundary = ballBoundary(snapped, exposureCandidates(snapped));
    const std::vector<DualVec3> balls = ballCentres(boundary, particles);
    ArcNetwork network = arcPoints(boundary, balls, boundaryVertices(particles, snapped, boundary, balls),
                                   {kLongest, 0, Appearance::gradual});
    return {std::move(boundary), std::move(network)};
}

// The arcs and circles between the first two particles, in any order.
std::vector<Line> linesOf(const std::vector<Vec3>& centres) {
    Particles particles;
    for (const Vec3& centre : centres) particles.position.emplace_back(centre);
    particles.velocity.assign(particles.size(), Vec3f(0));
    const auto [boundary, network] = arcsOf(particles);
    std::vector<Line> lines;
    for (std::size_t a = 0; a < network.arc_start.size(); ++a) {
        const std::uint32_t start = network.arc_start[a], end = boundary.twin[start];
        const std::uint32_t low = boundary.row[boundary.triangle[start / 3][start % 3]],
                            high = boundary.row[boundary.triangle[end / 3][end % 3]];
        if (std::max(low, high) != 1) continue;
        Line line{network.point[start / 3].position};
        for (std::uint32_t p = network.arc_begin[a]; p < network.arc_begin[a + 1]; ++p)
            line.push_back(network.point[p].position);
        line.push_back(network.point[end / 3].position);
        lines.push_back(line);
    }
    for (std::size_t k = 0; k < boundary.circle.size(); ++k) {
        Line line;
        for (std::uint32_t p = network.circle_begin[k]; p < network.circle_begin[k + 1]; ++p)
            line.push_back(network.point[p].position);
        line.push_back(line.front());
        lines.push_back(line);
    }
    return lines;
}

double distanceTo(const Line& line, const Vec3& point) {
    double least = 1e9;
    for (std::size_t k = 0; k + 1 < line.size(); ++k) {
        const Vec3 along = line[k + 1] - line[k];
        const double t = std::clamp(dot(point - line[k], along) / along.length2(), 0.0, 1.0);
        least = std::min(least, (line[k] + along * t - point).length());
    }
    return least;
}

double distance(const Line& a, const Line& b) {
    double most = 0;
    for (const Vec3& point : a) most = std::max(most, distanceTo(b, point));
    for (const Vec3& point : b) most = std::max(most, distanceTo(a, point));
    return most;
}

constexpr double kWide = 1.4, kNarrow = 0.01;  // radii of circles

// Two balls, and others round them that hide all of their circle but some radians.
std::vector<Vec3> withAnArcOf(double angle, double rim = kWide) {
    const double half = std::sqrt(kRadius * kRadius - rim * rim), along = rim * std::cos(1.0);
    const double out = along + std::sqrt(along * along + half * half);  // hides one radian to either side
    std::vector<Vec3> centres{{0, 0, -half}, {0, 0, half}};
    const auto hide = [&](double turn) { centres.emplace_back(out * std::cos(turn), out * std::sin(turn), 0); };
    const double first = angle / 2 + 1, last = 2 * std::numbers::pi - first;
    for (double turn = first; turn < last; turn += 0.5) hide(turn);
    hide(last);
    return centres;
}

// Two balls whose circle is seen so wide from either.
std::vector<Vec3> withACircleOf(double half_angle) { return {{0, 0, 0}, {0, 0, 2 * kRadius * std::cos(half_angle)}}; }

TEST(ArcPoints, AreNowhereFartherApartThanAskedForAndNotManyMore) {
    for (double angle = 0.01; angle < 4; angle += 0.01) {
        const std::vector<Line> lines = linesOf(withAnArcOf(angle));
        ASSERT_EQ(lines.size(), 1u) << angle;
        double longest = 0;
        for (std::size_t k = 0; k + 1 < lines[0].size(); ++k)
            longest = std::max(longest, (lines[0][k + 1] - lines[0][k]).length());
        EXPECT_LE(longest, kLongest * kRadius * 1.0001) << angle;
        EXPECT_LE(lines[0].size(), angle / kLongest + 5) << angle;
    }
}

TEST(ArcPoints, GoRoundNarrowCirclesInStepsOfAtMostTwoRadians) {
    for (double angle = 0.2; angle < 4; angle += 0.01) {
        const std::vector<Line> lines = linesOf(withAnArcOf(angle, kNarrow));
        ASSERT_EQ(lines.size(), 1u) << angle;
        for (double turn = -angle / 2; turn < angle / 2; turn += 0.01)
            EXPECT_LE(distanceTo(lines[0], Vec3(std::cos(turn), std::sin(turn), 0) * kNarrow),
                      (1 - std::cos(1.0) + 0.05) * kNarrow)
                << angle;
    }
}

// centresAt: an angle -> balls with one arc or circle. farthest: that it moves, in steps.
template <typename CentresAt>
void expectToMoveOn(const CentresAt& centresAt, double first, double last, double step, double farthest) {
    Line before;
    for (double angle = first; angle < last; angle += step) {
        const std::vector<Line> lines = linesOf(centresAt(angle));
        ASSERT_EQ(lines.size(), 1u) << angle;
        if (before.empty()) before = lines[0];
        EXPECT_LE(distance(before, lines[0]), farthest * step) << angle;
        before = lines[0];
    }
}

TEST(ArcPoints, MoveOnAsAnArcGrows) {
    expectToMoveOn([](double angle) { return withAnArcOf(angle); }, 0.01, 4, 2e-3, 1.2);
}

TEST(ArcPoints, MoveOnAsACircleGrows) { expectToMoveOn(withACircleOf, 0.02, 1.5, 5e-4, 3 * kRadius); }

// Which ball comes first depends on where they are: it may change as they move.
TEST(ArcPoints, AreTheSameWhicheverBallComesFirst) {
    for (double angle = 0.01; angle < 4; angle += 0.01) {
        std::vector<Vec3> centres = withAnArcOf(angle);
        const std::vector<Line> lines = linesOf(centres);
        for (Vec3& centre : centres) centre = {-centre.x, centre.y, -centre.z};
        std::vector<Line> turned = linesOf(centres);
        ASSERT_EQ(lines.size(), turned.size());
        for (Vec3& point : turned[0]) point = {-point.x, point.y, -point.z};
        EXPECT_EQ(lines[0].size(), turned[0].size()) << angle;
        EXPECT_LE(distance(lines[0], turned[0]), 1e-5) << angle;
    }
    for (double half_angle = 0.02; half_angle < 1.5; half_angle += 0.01) {
        std::vector<Vec3> centres = withACircleOf(half_angle);
        const std::vector<Line> lines = linesOf(centres);
        centres[1].z *= -1;
        std::vector<Line> turned = linesOf(centres);
        for (Vec3& point : turned.at(0)) point.z *= -1;
        EXPECT_LE(distance(lines.at(0), turned[0]), 1e-5) << half_angle;
    }
}

// So many a side, a spacing of 1 apart, but for a quarter of that.

}  // namespace
}  // namespace betamesh
