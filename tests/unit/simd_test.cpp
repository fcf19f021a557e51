// Kernels that compare lanes give the same results for every register width.

#include "base/simd.h"

#include "base/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace betamesh {

namespace {

// The largest value and the index of its first occurrence, as kernels find them.
struct FirstLargest {
    const std::vector<float>& values;  // size: a multiple of kLanes
    float &largest, &first;

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()() const {
        Floats<kWidth> most = Floats<kWidth>{} - 1e30F, most_at{}, at;
        setNumbers<kWidth>(at);
        for (std::size_t i = 0; i < values.size(); i += kWidth, at += static_cast<float>(kWidth)) {
            Floats<kWidth> some;
            std::memcpy(&some, &values[i], sizeof some);
            most_at = some > most ? at : most_at;
            most = some > most ? some : most;
        }
        takeLargest<kWidth>(most, largest);
        takeFirst<kWidth>(most, largest, most_at, first);
    }
};

TEST(Simd, TheFirstOfTheLargestIsTheSameForEveryWidth) {
    Random random(1);
    for (int trial = 0; trial < 2000; ++trial) {
        std::vector<float> values(kLanes * static_cast<std::size_t>(1 + trial % 5));
        for (float& value : values) value = static_cast<float>(static_cast<int>(random.between(-4, 4)));  // many alike
        const auto expected = std::max_element(values.begin(), values.end());
        const auto check = [&](const auto& run) {
            float largest = 0, first = 0;
            run(FirstLargest{values, largest, first});
            ASSERT_EQ(largest, *expected);
            ASSERT_EQ(first, static_cast<float>(expected - values.begin()));
        };
        check([](const FirstLargest& kernel) { kernel.operator()<4>(); });
        check([](const FirstLargest& kernel) { kernel.operator()<8>(); });
        check([](const FirstLargest& kernel) { kernel.operator()<16>(); });
        check([](const FirstLargest& kernel) { onThisCpu(kernel); });
    }
}

}  // namespace

}  // namespace betamesh
