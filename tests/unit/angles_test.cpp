// Portable angle functions against those of the C library.

#include "base/angles.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

namespace betamesh {

TEST(Angles, AgreeWithTheCLibrary) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> anywhere(-20, 20), small(-1e-9, 1e-9);
    for (int i = 0; i < 200000; ++i) {
        const double x = i % 3 ? anywhere(random) : small(random), y = i % 5 ? anywhere(random) : small(random);
        EXPECT_NEAR(angleOf(y, x), std::atan2(y, x), 1e-15) << y << ", " << x;
        EXPECT_NEAR(sineCosine(x).sine, std::sin(x), 4e-16) << x;
        EXPECT_NEAR(sineCosine(x).cosine, std::cos(x), 4e-16) << x;
    }
}

TEST(Angles, AreExactAlongTheAxes) {
    constexpr double kPi = std::numbers::pi;
    EXPECT_EQ(angleOf(0, 0), 0);
    EXPECT_EQ(angleOf(0, 2), 0);
    EXPECT_EQ(angleOf(3, 0), kPi / 2);
    EXPECT_EQ(angleOf(-3, 0), -kPi / 2);
    EXPECT_EQ(angleOf(0, -1), kPi);
    EXPECT_EQ(sineCosine(0).sine, 0);
    EXPECT_EQ(sineCosine(0).cosine, 1);
}

}  // namespace betamesh
