// Which places of a range are in use.

#include "batch/job/places.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace betamesh {
namespace {

constexpr std::size_t kSize = 200;

/// The smallest run of free cells that has room, the first of several; kSize where there is none.
std::size_t smallestGap(const std::vector<bool>& used, std::size_t bytes) {
    std::size_t best = kSize, room = kSize + 1;
    for (std::size_t begin = 0; begin < kSize;) {
        const auto end = static_cast<std::size_t>(
            std::find(used.begin() + static_cast<std::ptrdiff_t>(begin), used.end(), true) - used.begin());
        if (end - begin >= bytes && end - begin < room) best = begin, room = end - begin;
        begin = end + 1;
    }
    return best;
}

TEST(Places, AreTheSmallestGapsWithRoom) {
    for (unsigned seed = 0; seed < 100; ++seed) {
        std::mt19937 random(seed);
        Places places(kSize);
        std::vector<bool> used(kSize, false);
        std::vector<std::size_t> taken;
        const auto mark = [&](std::size_t place, std::size_t bytes, bool as) {
            std::fill_n(used.begin() + static_cast<std::ptrdiff_t>(place), bytes, as);
        };
        for (int step = 0; step < 300; ++step) {
            SCOPED_TRACE("seed " + std::to_string(seed) + ", step " + std::to_string(step));
            if (taken.empty() || random() % 2 == 0) {
                const std::size_t bytes = 1 + random() % 20;
                const std::size_t expected = smallestGap(used, bytes);
                const auto place = places.take(bytes);
                ASSERT_EQ(place.value_or(kSize), expected);
                if (!place) continue;
                EXPECT_EQ(places.bytesAt(*place), bytes);
                mark(*place, bytes, true);
                taken.push_back(*place);
            } else {
                std::swap(taken[random() % taken.size()], taken.back());
                const std::size_t place = taken.back();
                taken.pop_back();
                mark(place, places.bytesAt(place), false);
                const auto [begin, end] = places.giveBack(place);
                EXPECT_TRUE(begin == 0 || used[begin - 1]);
                EXPECT_TRUE(end == kSize || used[end]);
                EXPECT_TRUE(std::none_of(used.begin() + static_cast<std::ptrdiff_t>(begin),
                                         used.begin() + static_cast<std::ptrdiff_t>(end), [](bool u) { return u; }));
            }
            const auto [first, last] = places.used();
            EXPECT_EQ(first, last == 0
                                 ? 0
                                 : static_cast<std::size_t>(std::find(used.begin(), used.end(), true) - used.begin()));
            EXPECT_EQ(last,
                      kSize - static_cast<std::size_t>(std::find(used.rbegin(), used.rend(), true) - used.rbegin()));
        }
    }
}

TEST(Places, OfNoRoomAreNone) { EXPECT_FALSE(Places().take(1)); }

}  // namespace
}  // namespace betamesh
