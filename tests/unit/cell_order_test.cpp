// Properties of points sorted into grid cells, and of samples near them.

#include "base/cell_order.h"

#include "base/random.h"
#include "base/sample_groups.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

namespace betamesh {

namespace {

// Points near the origin and far from it, at corners of cells, and several at one position.
std::vector<Vec3> awkwardPoints(std::size_t n) {
    Random random(1);
    std::vector<Vec3> points;
    while (points.size() < n) {
        const Vec3 p = random.cube() * 8;
        points.push_back(p);
        points.emplace_back(std::floor(p.x), std::floor(p.y), -std::floor(p.z));
        if (points.size() % 7 == 0) points.push_back(p + Vec3(1e6, -1e6, 0));
        if (points.size() % 5 == 0) points.push_back(points[points.size() / 2]);
    }
    return points;
}

std::vector<std::uint32_t> rowsIn(const CellOrder& order, const Vec3& low, const Vec3& high) {
    std::vector<std::uint32_t> rows;
    order.forRowsIn(low, high, [&](std::uint32_t row) { rows.push_back(row); });
    return rows;
}

TEST(CellOrder, HasEveryPointOnceAndSortedCells) {
    for (const std::size_t n : {0, 1, 2, 100, 30000}) {
        const std::vector<Vec3> points = awkwardPoints(n);
        const CellOrder order(points.size(), 0.7, [&](std::size_t i) { return points[i]; });
        std::vector<bool> seen(points.size(), false);
        for (std::uint32_t cell = 0; cell < order.cells(); ++cell) {
            ASSERT_FALSE(order.rowsOf(cell).empty());
            EXPECT_TRUE(std::is_sorted(order.rowsOf(cell).begin(), order.rowsOf(cell).end()));
            EXPECT_TRUE(cell == 0 || order.place(cell - 1) < order.place(cell));
            for (const std::uint32_t row : order.rowsOf(cell)) {
                EXPECT_FALSE(seen[row]);
                seen[row] = true;
                const Vec3 inside = points[row] - order.lowestCorner(cell);
                for (int k = 0; k < 3; ++k) {
                    EXPECT_GE(inside[k], -1e-9);
                    EXPECT_LE(inside[k], order.edge() + 1e-9);
                }
            }
        }
        EXPECT_EQ(std::count(seen.begin(), seen.end(), true), static_cast<std::ptrdiff_t>(points.size()));
    }
}

TEST(CellOrder, FindsAllPointsInABoxAndNoneFarFromIt) {
    const std::vector<Vec3> points = awkwardPoints(4000);
    const double edge = 0.9;
    const CellOrder order(points.size(), edge, [&](std::size_t i) { return points[i]; });
    Random random(2);
    for (int trial = 0; trial < 300; ++trial) {
        const Vec3 low = random.cube() * 9, high = low + Vec3(random.unit(), random.unit(), random.unit()) * 4;
        std::vector<bool> found(points.size(), false);
        for (const std::uint32_t row : rowsIn(order, low, high)) found[row] = true;
        for (std::size_t i = 0; i < points.size(); ++i) {
            bool inside = true, near = true;
            for (int k = 0; k < 3; ++k) {
                inside = inside && points[i][k] >= low[k] && points[i][k] <= high[k];
                near = near && points[i][k] >= low[k] - edge && points[i][k] <= high[k] + edge;
            }
            EXPECT_TRUE(found[i] || !inside);
            EXPECT_TRUE(near || !found[i]);
        }
    }
}

TEST(CellOrder, IsTheSameForAnyThreadCount) {
    const std::vector<Vec3> points = awkwardPoints(50000);
    const auto orderOn = [&](int threads) {
        std::vector<std::uint32_t> rows;
        withThreads(threads,
                    [&] { rows = CellOrder(points.size(), 0.8, [&](std::size_t i) { return points[i]; }).rows(); });
        return rows;
    };
    const std::vector<std::uint32_t> on_one = orderOn(1);
    for (const int threads : {2, 3, 8}) EXPECT_EQ(orderOn(threads), on_one);
}

TEST(SampleGroups, HaveEveryPointOnceAndWhateverIsWithinItsReach) {
    const std::vector<Vec3> samples = awkwardPoints(3000);
    Random random(3);
    std::vector<Vec3> points(2000);
    for (Vec3& p : points) p = random.cube() * 9;
    constexpr double kReach = 1.1, kUnit = 0.5;
    constexpr std::size_t kFields = 9;
    const auto fieldsOf = [](std::size_t i) {  // numbers that tell which sample they are of
        std::array<float, kFields - 3> fields;
        std::iota(fields.begin(), fields.end(), static_cast<float>(10 * i + 1));
        return fields;
    };
    const SampleCloud<kFields> cloud(
        samples.size(), [&](std::size_t i) { return samples[i]; }, fieldsOf, kReach, kUnit);
    for (const Grouping grouping : {Grouping::compact, Grouping::unsorted}) {
        std::vector<int> visits(points.size(), 0);
        cloud.forPoints(
            points.size(), [&](std::size_t i) { return points[i]; }, grouping,
            [&](const PointGroup& group, SampleSubset<kFields> near) {
                ASSERT_GE(group.size, 1U);
                for (std::size_t lane = 0; lane < kLanes; ++lane) {
                    const std::uint32_t row = group.row[lane];
                    if (lane < group.size)
                        ++visits[row];
                    else
                        EXPECT_EQ(row, group.row[0]);
                    const Vec3f x(group.position[0][lane], group.position[1][lane], group.position[2][lane]);
                    std::vector<bool> seen(samples.size(), false);
                    for (const SampleFields<kFields>& sample : near) {
                        const auto i = static_cast<std::size_t>(sample[3]) / 10;
                        ASSERT_FALSE(seen[i]);
                        seen[i] = true;
                        const auto fields = fieldsOf(i);
                        ASSERT_TRUE(std::equal(fields.begin(), fields.end(), sample.begin() + 3));
                        const Vec3 apart(Vec3f(sample[0], sample[1], sample[2]) - x);
                        ASSERT_LT((apart * kUnit - (samples[i] - points[row])).length(), 1e-5);
                    }
                    for (std::size_t i = 0; i < samples.size(); ++i)
                        ASSERT_TRUE(seen[i] || (samples[i] - points[row]).length() >= kReach);
                }
            });
        EXPECT_EQ(visits, std::vector<int>(points.size(), 1));
    }
}

/// Σ (1 - |y|²)² over samples within one unit.
struct SumNear {
    SampleSubset<3> samples;
    const Lanes (&point)[3];
    Lanes (&sum)[1];

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()(std::size_t first) const {
        Floats<kWidth> x[3], total[1] = {};
        getLanes<kWidth>(point, first, x);
        const Floats<kWidth> zero{};
        for (const SampleFields<3>& f : samples) {
            const Floats<kWidth> a = f[0] - x[0], b = f[1] - x[1], c = f[2] - x[2];
            Floats<kWidth> t = 1.0F - (a * a + b * b + c * c);
            t = t > 0 ? t : zero;
            total[0] += t * t;
        }
        setLanes<kWidth>(sum, first, total);
    }
};

TEST(SampleGroups, WhatBecomesOfAPointDependsOnNoOtherNorOnTheWidthOfRegisters) {
    const std::vector<Vec3> samples = awkwardPoints(20000);
    Random random(4);
    std::vector<Vec3> points(3000);
    for (Vec3& p : points) p = random.cube() * 8;
    const SampleCloud<3> cloud(
        samples.size(), [&](std::size_t i) { return samples[i]; }, [](std::size_t) { return std::array<float, 0>(); },
        0.9, 0.9);
    Grouping grouping = Grouping::compact;
    const auto sumsAt = [&](std::size_t stride, const auto& forAllLanes) {
        std::vector<float> sums((points.size() + stride - 1) / stride);
        cloud.forPoints(
            sums.size(), [&](std::size_t i) { return points[i * stride]; }, grouping,
            [&](const PointGroup& group, SampleSubset<3> near) {
                Lanes sum[1];
                forAllLanes(SumNear{near, group.position, sum});
                for (std::size_t lane = 0; lane < group.size; ++lane) sums[group.row[lane]] = sum[0][lane];
            });
        return sums;
    };
    const auto inOneGo = [](const SumNear& kernel) { kernel.operator()<16>(0); };
    const auto eightAtATime = [](const SumNear& kernel) {
        for (std::size_t first = 0; first < kLanes; first += 8) kernel.operator()<8>(first);
    };
    const auto asThisProcessorDoes = [](const SumNear& kernel) { forLanes(kernel); };
    for (const Grouping each : {Grouping::compact, Grouping::unsorted}) {
        grouping = each;
        const std::vector<float> all = sumsAt(1, asThisProcessorDoes);
        EXPECT_GT(*std::max_element(all.begin(), all.end()), 1);
        EXPECT_EQ(sumsAt(1, inOneGo), all);
        EXPECT_EQ(sumsAt(1, eightAtATime), all);
        for (const std::size_t stride : {3, 100}) {
            const std::vector<float> some = sumsAt(stride, asThisProcessorDoes);
            for (std::size_t i = 0; i < some.size(); ++i) ASSERT_EQ(some[i], all[i * stride]) << i << ' ' << stride;
        }
    }
}

}  // namespace

}  // namespace betamesh
