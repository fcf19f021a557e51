// The samples of the boundary of larger balls, on which the rolling ball rolls.

#include "skin/outer_boundary.h"

#include "base/cell_grid.h"
#include "skin/coverage.h"
#include "skin/skin_lengths.h"
#include "support/clouds.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace betamesh {
namespace {

OuterSamples samplesOf(const Particles& particles, const SkinLengths& lengths, double spacing) {
    const SnappedParticles snapped = snapParticles(particles, lengths.joining * spacing);
    return outerSamples(particles, snapped, ballBoundary(snapped, exposureCandidates(snapped)), lengths, spacing);
}

// All samples are on a larger ball and in none, whether or not its particle is exposed at the joining radius.
TEST(OuterBoundary, HasNoSampleInALargerBall) {
    SkinLengths lengths;
    std::size_t samples = 0;
    forEveryCloud(50, [&](const Cloud& cloud) {
        if (cloud.particles.size() == 0) return;
        const double spacing = cloud.radius / lengths.joining, radius = lengths.outer() * spacing;
        const CellGrid grid(cloud.particles.size(), 2 * radius,
                            [&](std::size_t i) { return Vec3(cloud.particles.position[i]); });
        for (const DualVec3& sample : samplesOf(cloud.particles, lengths, spacing).point) {
            double nearest = 2 * radius;
            const Vec3 reach(radius * 1.01);
            grid.forCellsIn(sample.position - reach, sample.position + reach, [&](std::uint32_t cell) {
                for (const std::uint32_t i : grid.rowsOf(cell))
                    nearest = std::min(nearest, (Vec3(cloud.particles.position[i]) - sample.position).length());
            });
            ASSERT_NEAR(nearest, radius, 1e-4 * radius);
            ++samples;
        }
    });
    EXPECT_GT(samples, 100000u);
}

}  // namespace
}  // namespace betamesh
