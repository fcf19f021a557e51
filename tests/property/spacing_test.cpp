// The particle spacing: the plain median against brute force, and the estimate on arrangements of known spacing.

#include "skin/spacing.h"

#include "base/parallel.h"
#include "base/random.h"
#include "support/clouds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <vector>

namespace betamesh {

using Points = std::vector<Vec3f>;

TEST(Spacing, IsThatOfTheLattice) {
    EXPECT_FALSE(medianSixNearest({}));
    Particles lattice;
    for (int z = 0; z < 9; ++z)
        for (int y = 0; y < 9; ++y)
            for (int x = 0; x < 9; ++x)
                lattice.position.emplace_back(0.5f * static_cast<float>(x), 0.5f * static_cast<float>(y),
                                              0.5f * static_cast<float>(z));
    ASSERT_TRUE(medianSixNearest(lattice.position));
    EXPECT_NEAR(*medianSixNearest(lattice.position), 0.5, 0.05);
    lattice.position.resize(6);
    EXPECT_FALSE(medianSixNearest(lattice.position));
}

// By brute force over all pairs.
std::optional<double> spacingByBruteForce(std::vector<Vec3f> points) {
    const auto before = [](const Vec3f& a, const Vec3f& b) {
        return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
    };
    std::sort(points.begin(), points.end(), before);
    points.erase(std::unique(points.begin(), points.end()), points.end());
    if (points.size() < 7) return std::nullopt;
    std::vector<double> means;
    for (const Vec3f& p : points) {
        std::vector<double> squared;
        for (const Vec3f& q : points) squared.push_back((Vec3(q) - Vec3(p)).length2());
        std::partial_sort(squared.begin(), squared.begin() + 7, squared.end());
        double sum = 0;
        for (std::size_t k = 1; k < 7; ++k) sum += std::sqrt(squared[k]);
        means.push_back(sum / 6);
    }
    std::sort(means.begin(), means.end());
    return means[means.size() / 2];
}

TEST(Spacing, AgreesWithBruteForce) {
    forEveryCloud(300, [](const Cloud& cloud) {
        EXPECT_EQ(medianSixNearest(cloud.particles.position), spacingByBruteForce(cloud.particles.position));
    });
    Random random(2);
    std::vector<Vec3f> uneven;  // clumps of very different density, copies, and some on their own
    for (int i = 0; i < 1500; ++i) uneven.emplace_back(random.cube());
    for (int i = 0; i < 1500; ++i) uneven.emplace_back(random.cube() * 1e-4 + Vec3(0.3));
    for (int i = 0; i < 300; ++i) uneven.push_back(uneven[static_cast<std::size_t>(i)]);
    for (int i = 0; i < 40; ++i) uneven.emplace_back(random.cube() * 1000);
    for (int i = 0; i < 300; ++i) uneven.emplace_back(0.5f, 0.5f, 0.5f);
    EXPECT_EQ(medianSixNearest(uneven), spacingByBruteForce(uneven));
}

TEST(Spacing, IsTheSameInAnyOrderOnAnyNumberOfThreads) {
    Particles particles;
    Random random(3);
    for (int i = 0; i < 40000; ++i) particles.position.emplace_back(random.cube() * (i % 3 == 0 ? 0.1 : 1.0));
    const auto usual = medianSixNearest(particles.position);
    for (const int threads : {1, 2, 5})
        withThreads(threads, [&] { EXPECT_EQ(medianSixNearest(shuffled(particles, 4).position), usual); });
}

/// Particles of a lattice with spacing 0.1 for which `inside` is true of the indices, moved by up to `jitter` spacings.
Points lattice(const std::function<bool(int, int, int)>& inside, double jitter = 0, double spacing = 0.1) {
    Random random(7);
    Points points;
    for (int z = 0; z < 40; ++z)
        for (int y = 0; y < 40; ++y)
            for (int x = 0; x < 40; ++x)
                if (inside(x, y, z)) points.emplace_back((Vec3(x, y, z) + random.cube() * jitter) * spacing);
    return points;
}

Points joined(Points points, const Points& more) {
    points.insert(points.end(), more.begin(), more.end());
    return points;
}

Points spray(int count, double extent) {
    Random random(8);
    Points points;
    for (int i = 0; i < count; ++i) points.emplace_back(random.cube() * extent + Vec3(2));
    return points;
}

TEST(SpacingEstimate, OfARowALayerAndABlockIsTheirs) {
    for (const double jitter : {0.0, 0.2}) {
        const auto estimated = [&](const std::function<bool(int, int, int)>& inside) {
            return spacingOf(lattice(inside, jitter)).value().spacing;
        };
        EXPECT_NEAR(estimated([](int, int y, int z) { return y == 0 && z == 0; }), 0.1, 0.012) << jitter;
        EXPECT_NEAR(estimated([](int, int, int z) { return z == 3; }), 0.1, 0.01) << jitter;
        EXPECT_NEAR(estimated([](int x, int y, int z) { return x < 12 && y < 12 && z < 12; }), 0.1, 0.01) << jitter;
        EXPECT_NEAR(estimated([](int x, int, int z) { return z == 3 || (x < 8 && z == 20); }), 0.1, 0.01) << jitter;
    }
    EXPECT_FALSE(spacingOf(lattice([](int x, int y, int z) { return x < 6 && y == 0 && z == 0; })));
}

TEST(SpacingEstimate, IsThatOfTheLiquidAmongSprayWallsClumpsAndNearDuplicates) {
    const Points block = lattice([](int x, int y, int z) { return x < 12 && y < 12 && z < 12; }, 0.2);
    const double alone = spacingOf(block).value().spacing;
    const auto near = [&](const Points& others, const char* what) {
        EXPECT_NEAR(spacingOf(joined(block, others)).value().spacing, alone, 0.1 * alone) << what;
    };
    near(spray(2500, 40), "spray");
    near(lattice([](int x, int y, int z) { return x < 36 && y < 36 && z == 39; }, 0, 0.05), "wall");
    Points clump = spray(900, 0.01);
    for (Vec3f& p : clump) p += Vec3f(20, 0, 0);
    near(clump, "clump");
    Points duplicates(block.begin(), block.begin() + 170);
    for (Vec3f& p : duplicates) p += Vec3f(1e-4f, 0, 0);
    near(duplicates, "near-duplicates");
}

TEST(SpacingEstimate, OfASequenceIsNotThatOfItsFirstFrame) {
    const Points row = lattice([](int x, int y, int z) { return x < 8 && y == 0 && z == 0; });
    const Points block = lattice([](int x, int y, int z) { return x < 12 && y < 12 && z < 12; });
    for (const Points& first : {row, spray(20, 5), lattice([](int, int, int z) { return z == 3; })}) {
        SpacingEstimator estimator;
        EXPECT_TRUE(estimator.add(first));
        EXPECT_TRUE(estimator.add(block));
        EXPECT_FALSE(estimator.add({}));
        const SpacingEstimate estimate = estimator.estimate().value();
        EXPECT_NEAR(estimate.spacing, 0.1, 0.01);
        EXPECT_LE(estimate.low, estimate.spacing);
        EXPECT_GE(estimate.high, estimate.spacing);
    }
}

TEST(SpacingEstimate, TellsRandomSeedingFromEvenSpacing) {
    const auto clumped = [](const Points& points) { return spacingOf(points).value().clumped; };
    const auto isInBlock = [](int x, int y, int z) { return x < 12 && y < 12 && z < 12; };
    for (const double jitter : {0.0, 0.1, 0.2, 0.25}) EXPECT_LE(clumped(lattice(isInBlock, jitter)), 0.05) << jitter;
    EXPECT_GE(clumped(spray(2000, 1)), 0.15);
    Points pairs = lattice(isInBlock);
    const std::size_t half = pairs.size() / 2;
    for (std::size_t i = 0; i < half; ++i) pairs.push_back(pairs[i] + Vec3f(0.02F, 0, 0));
    EXPECT_NEAR(clumped(pairs), 2.0 / 3, 0.05);
}

TEST(SpacingEstimate, InTwoDimensionsIsTheMeanDistanceInAPlane) {
    const Points sheet = lattice([](int, int, int z) { return z == 3; }, 0);
    EXPECT_EQ(spacingOf(sheet, 2).value().spacing, medianSixNearest(sheet).value());
}

TEST(SpacingEstimate, IsTheSameInAnyOrderOnAnyNumberOfThreads) {
    Particles particles;
    particles.position = joined(lattice([](int x, int, int) { return x < 20; }, 0.3), spray(20000, 10));
    const SpacingEstimate usual = spacingOf(particles.position).value();
    for (const int threads : {1, 2, 5})
        withThreads(threads, [&] {
            const SpacingEstimate other = spacingOf(shuffled(particles, 4).position).value();
            EXPECT_EQ(other.spacing, usual.spacing);
            EXPECT_EQ(other.low, usual.low);
            EXPECT_EQ(other.high, usual.high);
        });
}

}  // namespace betamesh
