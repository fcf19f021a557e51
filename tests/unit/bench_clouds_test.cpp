// What benches are said to skin is what they skin.

#include "bench/bench_clouds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace betamesh {
namespace {

// The shares of a cloud that lie in its block, in the sheet above it, and in the drops above that: wide gaps part them.
std::vector<double> sharesOf(const Particles& cloud) {
    constexpr float kGap = 3;
    std::vector<float> height;
    for (const Vec3f& p : cloud.position) height.push_back(p.z);
    std::sort(height.begin(), height.end());
    std::vector<std::size_t> begin{0};
    for (std::size_t i = 1; i < height.size() && begin.size() < 3; ++i)
        if (height[i] - height[i - 1] > kGap) begin.push_back(i);
    begin.push_back(height.size());
    std::vector<double> shares;
    for (std::size_t part = 0; part + 1 < begin.size(); ++part)
        shares.push_back(static_cast<double>(begin[part + 1] - begin[part]) / static_cast<double>(height.size()));
    return shares;
}

void expectLoose(const Particles& cloud, double loose) {
    const std::vector<double> shares = sharesOf(cloud);
    ASSERT_EQ(shares.size(), 3U) << cloud.size();
    EXPECT_NEAR(shares[1], loose / 2, loose / 10) << cloud.size();
    EXPECT_NEAR(shares[2], loose / 2, loose / 4) << cloud.size();
}

TEST(BenchClouds, HaveTheSheetAndTheDropsTheySay) {
    for (const std::size_t n : {100000, 110000, 250000, 1000000}) {
        expectLoose(splash(n), 0.1);
        expectLoose(calm(n), 0.02);
    }
}

}  // namespace
}  // namespace betamesh
