// Between parts of the liquid that are too close for the rolling ball, smaller balls roll: sheets that come near stay
// thin, and do not become thick at once.

#include "skin/narrow_gaps.h"
#include "base/random.h"
#include "betamesh/check.h"
#include "betamesh/coherence.h"
#include "betamesh/skin.h"
#include "skin/coverage.h"
#include "skin/faces.h"
#include "skin/velocity.h"
#include "support/clouds.h"

#include <gtest/gtest.h>

#include <cmath>

namespace betamesh {
namespace {

/// Two sheets one particle thick, `gap` apart, of a jittered grid with side² particles each.
Particles twoSheets(double gap, int side) {
    Random random(5);
    Particles sheets;
    for (int sheet = 0; sheet < 2; ++sheet)
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) sheets.position.emplace_back(Vec3(x, y, sheet * gap) + random.cube() * 0.2);
    return sheets;
}

// Where a ball of 1.5 dx or more fits in, the sheets are as thick as it leaves them, no thicker. With the second
// radius, the rolling ball is 3.4 dx large, as in the preset for FLIP.
TEST(NarrowGaps, AreKeptOpen) {
    for (const double radius : {1.5, 2.0}) {
        SkinParams params;
        params.radius = radius;
        params.spacing = 1;
        const double apart = checkMesh(skinFrame(twoSheets(6 * radius, 14), params).mesh).volume;
        for (const double ball : {1.5, 1.6, 1.7, 1.8, 2.5, 3.3}) {
            const double gap = 2 * std::sqrt(radius * radius + ball * ball);
            SCOPED_TRACE(testing::Message() << "radius " << radius << ", gap " << gap);
            const double volume = checkMesh(skinFrame(twoSheets(gap, 14), params).mesh).volume;
            const double skin = 0.55, inside = std::max(skin, gap / 2 - ball);
            EXPECT_LT(volume, 1.1 * (skin + inside) / (2 * skin) * apart);
            EXPECT_GT(volume, 0.95 * apart);
        }
    }
}

// From where the rolling ball fits in easily to where the sheets nearly join.
TEST(NarrowGaps, CloseGradually) {
    SkinParams params;
    params.radius = 1.5;
    constexpr double kStep = 0.02;
    Mesh before = skinFrame(twoSheets(5, 8), params).mesh;
    double farthest = 0;
    for (double gap = 5 - kStep; gap > 3.7; gap -= kStep) {
        const Mesh now = skinFrame(twoSheets(gap, 8), params).mesh;
        farthest = std::max(farthest, surfaceDistance(before, now).max);
        before = now;
    }
    EXPECT_LT(farthest, 0.3);
}

// Whatever the cloud, no ball that rolls in a gap enters a ball around a particle of which it ought to be clear: from a
// particle at its square distance d² its square radius is at most d² - a².
TEST(NarrowGaps, HaveBallsThatFit) {
    std::size_t balls_in_gaps = 0;
    forEveryCloud(200, [&](const Cloud& cloud) {
        const double spacing = cloud.radius / 1.5;
        const SnappedParticles snapped = snapParticles(cloud.particles, cloud.radius);
        Icosphere directions = icosphereOf(0.55);
        BallBoundary boundary = ballBoundary(snapped, exposureCandidates(snapped), directions.position);
        groupFaces(snapped, boundary);
        const std::vector<DualVec3> balls = ballCentres(boundary, cloud.particles);
        const ArcNetwork network =
            arcPoints(boundary, balls, boundaryVertices(cloud.particles, snapped, boundary, balls),
                      {0.6, 0, Appearance::gradual});
        const FacePoints points = facePoints(snapped, boundary, balls, std::move(directions));
        const SkinLengths lengths;
        OuterSamples gaps;
        addNarrowGaps(boundary, balls, network, points, lengths, spacing, gaps);
        balls_in_gaps += gaps.point.size();
        const double square_rolling = lengths.rolling() * lengths.rolling();
        for (std::size_t i = 0; i < gaps.point.size(); ++i) {
            EXPECT_GT(gaps.weight[i], 0);
            const double square = (square_rolling - gaps.squared_offset[i]) * spacing * spacing;
            for (const Vec3f& particle : cloud.particles.position)
                EXPECT_GT((gaps.point[i].position - Vec3(particle)).length2(),
                          cloud.radius * cloud.radius + square - 1e-4 * spacing * spacing);
        }
    });
    EXPECT_GT(balls_in_gaps, 100);
}

}  // namespace
}  // namespace betamesh
