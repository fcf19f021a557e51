// Places where two or three balls are about to meet or to part are found alike before and after.

#include "skin/meetings.h"
#include "betamesh/coherence.h"
#include "skin/constants.h"
#include "skin/coverage.h"
#include "skin/faces.h"
#include "skin/velocity.h"
#include "support/events.h"

#include <gtest/gtest.h>

#include <cmath>

namespace betamesh {
namespace {

constexpr double kRadius = 1.5;  // in spacings, as by default

std::vector<Meeting> meetingsOf(const Particles& particles) {
    const SnappedParticles snapped = snapParticles(particles, kRadius);
    const Icosphere directions = icosphereOf(0.55);
    BallBoundary boundary = ballBoundary(snapped, exposureCandidates(snapped), directions.position);
    groupFaces(snapped, boundary);
    const std::vector<DualVec3> balls = ballCentres(boundary, particles);
    const ArcNetwork network = arcPoints(boundary, balls, boundaryVertices(particles, snapped, boundary, balls),
                                         {0.6, 0, Appearance::gradual});
    return meetings(boundary, network, facePoints(snapped, boundary, balls, directions), 1);
}

// The greatest nearness of those about at the same place and with about the same axis.
double nearnessAt(const std::vector<Meeting>& meetings, const Meeting& place) {
    double nearness = 0;
    for (const Meeting& m : meetings)
        if ((m.middle - place.middle).length() < 0.001 && std::abs(dot(m.axis, place.axis)) > 0.99)
            nearness = std::max(nearness, m.nearness);
    return nearness;
}

// Whatever happens in a short time, meetings hardly ever come or go. Left out are voids, which make the surface jump
// anyway.
TEST(Meetings, AreContinuousThroughEvents) {
    SkinParams params;
    params.radius = kRadius;
    std::size_t events = 0, near_one = 0, abrupt = 0;
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
        const bool is_spray = seed % 2 == 0;
        const Particles start =
            is_spray ? movingCloud(seed, {5, 5, 5}, 0.5, 0.1) : movingCloud(seed, {5, 5, 1}, 0.25, 0.8);
        const auto particlesAt = [&](double time) { return advected(start, time); };
        findEvents(0, is_spray ? 1 : 0.05, params, particlesAt, [&](double time, const std::string& kind) {
            if (kind == "void" || kind == "several") return;
            constexpr double kSpan = 1e-6;
            const std::vector<Meeting> before = meetingsOf(particlesAt(time - kSpan / 2)),
                                       after = meetingsOf(particlesAt(time + kSpan / 2));
            ++events;
            double nearest = 0, change = 0;
            for (const auto& [from, to] : {std::pair(&before, &after), std::pair(&after, &before)})
                for (const Meeting& meeting : *from) {
                    nearest = std::max(nearest, meeting.nearness);
                    change = std::max(change, std::abs(nearnessAt(*to, meeting) - meeting.nearness));
                }
            near_one += nearest > 0.9;
            abrupt += change > 0.03;
        });
    }
    EXPECT_GE(events, 300u);
    EXPECT_GE(near_one, 200u);
    EXPECT_LE(abrupt, events / 100);
}

// Three balls that come to meet around a point, as a hole closes, and in a row, where none is.
TEST(Meetings, OfThreeBallsAreHoles) {
    for (const double radius : {1.3, 1.49, 1.5, 1.51, 1.7})
        for (const double corner : {0.5, 2.0, 2.4}) {  // radians that the third ball is away from the second
            Particles three;
            for (const double angle : {0.3, 2.4, 2.4 + corner})
                three.position.emplace_back(radius * std::cos(angle), 0.2, radius * std::sin(angle));
            std::vector<Meeting> found = meetingsOf(three);
            std::erase_if(found, [](const Meeting& m) { return m.width != kHoleWidth; });
            const bool is_acute = corner > 1;
            if (std::abs(radius - 1.5) > 0.1 || !is_acute) {
                EXPECT_TRUE(found.empty()) << radius << ' ' << corner;
                continue;
            }
            ASSERT_EQ(found.size(), 1u) << radius << ' ' << corner;
            const double power = radius * radius - 1.5 * 1.5;
            EXPECT_NEAR(found[0].nearness, 1 - std::sqrt(std::abs(power)) / kThinMembrane, 0.01);
            EXPECT_LT((found[0].middle - Vec3(0, 0.2, 0)).length(), 1e-5);
            EXPECT_NEAR(std::abs(found[0].axis.y), 1, 1e-9);
        }
}

}  // namespace
}  // namespace betamesh
