#include "base/parallel.h"
#include "base/compressed_rows.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

namespace betamesh {
namespace {

TEST(Parallel, SortingIntoRowsKeepsTheOrderOfItemsForAnyThreadCount) {
    for (const int threads : {1, 2, 3, 8}) {
        for (const std::size_t n : {0, 1, 1023, 20'000}) {
            const std::size_t rows = 1 + n / 3;
            const auto rowOf = [&](std::size_t i, std::size_t k) { return (i * 7919 + k * i * i) % rows; };
            std::vector<std::vector<std::uint32_t>> expected(rows);
            for (std::size_t i = 0; i < n; ++i)
                for (std::size_t k = 0; k < i % 3; ++k)
                    expected[rowOf(i, k)].push_back(static_cast<std::uint32_t>(3 * i + k));
            IndexRows sorted;
            withThreads(threads, [&] {
                sorted = sortedIntoRows<std::uint32_t>(rows, n, [&](std::size_t i, const auto& visit) {
                    for (std::size_t k = 0; k < i % 3; ++k) visit(rowOf(i, k), static_cast<std::uint32_t>(3 * i + k));
                });
            });
            ASSERT_EQ(sorted.size(), rows);
            for (std::size_t row = 0; row < rows; ++row)
                ASSERT_EQ(std::vector<std::uint32_t>(sorted[row].begin(), sorted[row].end()), expected[row]);
        }
    }
}

TEST(Parallel, IndicesWhereFindsAllIndicesInAscendingOrder) {
    std::vector<std::uint32_t> expected;
    for (std::uint32_t i = 0; i < 100'000; ++i)
        if (i % 7 < 3) expected.push_back(i);
    withThreads(3, [&] { EXPECT_EQ(indicesWhere(100'000, [](std::uint32_t i) { return i % 7 < 3; }), expected); });
}

TEST(Parallel, FirstRowWhereFindsTheLowestForAnyThreadCount) {
    const std::size_t n = 200'000;
    for (const int threads : {1, 2, 3, 8})
        withThreads(threads, [&] {
            for (const std::size_t first : {std::size_t{0}, std::size_t{1}, std::size_t{16'384}, n / 3, n - 1, n}) {
                EXPECT_EQ(firstIndexWhere(n, [&](std::size_t i) { return i >= first; }), first);
                EXPECT_EQ(firstIndexWhere(n, [&](std::size_t i) { return i == first || i + 1 == n; }),
                          std::min(first, n - 1));
            }
            EXPECT_EQ(firstIndexWhere(0, [](std::size_t) { return true; }), 0U);
        });
}

// Runs 0 … 999 through the pipeline; a stage for which fails(stage, i) holds throws its name and i.
template <typename Fails>
std::pair<std::vector<int>, std::string> givenInOrder(int threads, const Fails& fails) {
    std::vector<int> given;
    std::string what;
    const auto check = [&](const char* stage, int i) {
        if (fails(stage, i)) throw std::runtime_error(stage + std::to_string(i));
    };
    int next = 0;
    const auto take = [&]() -> std::optional<int> {
        check("take", next);
        if (next == 1000) return std::nullopt;
        return next++;
    };
    const auto make = [&](int&& i) {
        check("make", i);
        return 2 * i;
    };
    const auto give = [&](int&& twice) {
        check("give", twice / 2);
        given.push_back(twice);
    };
    withThreads(threads, [&] {
        try {
            parallelInOrder(take, make, give);
        } catch (const std::exception& error) {
            what = error.what();
        }
    });
    return {given, what};
}

// One of two branches fails while the other runs loops and relies on their results.
TEST(Parallel, ALoopInsideAFailedOneNeverReturnsIncomplete) {
    withThreads(3, [] {
        for (int trial = 0; trial < 200; ++trial) {
            std::atomic<bool> relied_on_nothing = false, begun = false;
            const auto fail = [&] {
                while (!begun) std::this_thread::yield();
                throw std::runtime_error("failed");
            };
            const auto goOn = [&] {
                for (int loop = 0; loop < 50; ++loop) {
                    begun = true;
                    std::vector<std::uint8_t> done(5000, 0);
                    parallelFor(done.size(), 16, [&](std::size_t i) { done[i] = 1; });
                    if (std::count(done.begin(), done.end(), 0) > 0) relied_on_nothing = true;
                }
            };
            EXPECT_THROW(parallelBoth(goOn, fail), std::runtime_error);
            ASSERT_FALSE(relied_on_nothing) << "trial " << trial;
        }
    });
}

// A run is cancelled by another thread, at any time, while its loops rely on the results of inner ones.
TEST(Parallel, ACancelledRunEndsEarlyAndNeverReturnsIncomplete) {
    for (int trial = 0; trial < 200; ++trial) {
        CancellableRun run;
        std::atomic<bool> relied_on_nothing = false, begun = false;
        std::thread canceller([&] {
            while (!begun) std::this_thread::yield();
            run.cancel();
        });
        const bool has_returned = run.run(1 + trial % 3, [&] {
            for (;;) {
                std::vector<std::uint8_t> done(5000, 0);
                parallelFor(done.size(), 16, [&](std::size_t i) { done[i] = 1; });
                if (std::count(done.begin(), done.end(), 0) > 0) relied_on_nothing = true;
                begun = true;
            }
        });
        canceller.join();
        EXPECT_FALSE(has_returned);
        ASSERT_FALSE(relied_on_nothing) << "trial " << trial;
    }
}

TEST(Parallel, ARunPassesOnWhatItThrowsAndNothingElseIsCancelled) {
    CancellableRun cancelled;
    cancelled.cancel();
    EXPECT_FALSE(cancelled.run(0, [] {}));
    CancellableRun failing, succeeding;
    const auto fail = [] {
        parallelFor(100, 1, [](std::size_t i) {
            if (i == 50) throw std::runtime_error("failed");
        });
    };
    EXPECT_THROW(failing.run(2, fail), std::runtime_error);
    std::atomic<int> count = 0;
    EXPECT_TRUE(succeeding.run(2, [&] { parallelFor(100, 1, [&](std::size_t) { ++count; }); }));
    EXPECT_EQ(count, 100);
}

TEST(Parallel, ThePipelineKeepsTheOrderUntilTheFirstFailure) {
    const auto firstOnes = [](int n) {
        std::vector<int> twice(static_cast<std::size_t>(n));
        for (int i = 0; i < n; ++i) twice[static_cast<std::size_t>(i)] = 2 * i;
        return twice;
    };
    for (const int threads : {1, 2, 4}) {
        const auto none = [](const std::string&, int) { return false; };
        EXPECT_EQ(givenInOrder(threads, none), std::pair(firstOnes(1000), std::string()));
        for (const std::string stage : {"take", "make", "give"}) {
            const auto from = [&](const std::string& s, int i) { return s == stage && i >= 500; };
            EXPECT_EQ(givenInOrder(threads, from), std::pair(firstOnes(500), stage + "500"));
        }
        const auto takenLater = [](const std::string& s, int i) { return i == (s == "make" ? 500 : 501); };
        EXPECT_EQ(givenInOrder(threads, takenLater).second, "make500");
    }
}

}  // namespace
}  // namespace betamesh
