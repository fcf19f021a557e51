// Blocks of memory: in huge pages, in a file.

#include "batch/platform/scratch_memory.h"

#include "base/parallel.h"
#include "batch/platform/huge_pages.h"
#include "batch/platform/machine.h"
#include "support/sanitized.h"
#include "support/temporary_folder.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <chrono>
#include <csignal>
#include <limits>
#include <new>
#include <optional>
#include <random>
#include <thread>
#include <vector>

namespace betamesh {
namespace {

constexpr std::size_t kMiB = std::size_t{1} << 20;

/// Whose words tell where they are.
class Block {
public:
    Block(std::size_t words, std::size_t alignment, std::uint64_t seed)
        : words_(words), seed_(seed), word_(static_cast<std::uint64_t*>(allocateMemory(8 * words, alignment))) {
        EXPECT_EQ(reinterpret_cast<std::uintptr_t>(word_) % alignment, 0U);
        for (std::size_t i = 0; i < words_; ++i) word_[i] = i * seed_;
    }
    Block(Block&& other) noexcept : words_(other.words_), seed_(other.seed_), word_(std::exchange(other.word_, {})) {}
    Block& operator=(Block&& other) noexcept {
        std::swap(words_, other.words_), std::swap(seed_, other.seed_), std::swap(word_, other.word_);
        return *this;
    }
    ~Block() { releaseMemory(word_); }

    bool isWhole() const {
        for (std::size_t i = 0; i < words_; ++i)
            if (word_[i] != i * seed_) return false;
        return true;
    }

private:
    std::size_t words_;
    std::uint64_t seed_;
    std::uint64_t* word_;
};

/// Makes blocks and frees them, on several threads, and looks whether those that stay are whole.
void checkBlocks(std::size_t largest_words, std::size_t at_once) {
    parallelFor(4, 1, [&](std::size_t seed) {
        std::mt19937_64 random(seed);
        std::vector<Block> blocks;
        for (int i = 0; i < 300; ++i) {
            Block block(random() % largest_words, std::size_t{16} << 4 * (random() % 4), random());
            if (blocks.size() < at_once) {
                blocks.push_back(std::move(block));
                continue;
            }
            Block& one = blocks[random() % at_once];
            EXPECT_TRUE(one.isWhole()) << "seed " << seed << ", step " << i;
            one = std::move(block);
        }
        for (const Block& block : blocks) EXPECT_TRUE(block.isWhole()) << "seed " << seed;
    });
}

/// Huge pages are used while there is one.
struct HugePages {
    HugePages() { useHugePages(); }
    ~HugePages() { leaveHugePages(); }
};

TEST(HugePages, HoldLargeBlocksAsLongAsTheyAreUsed) {
    const auto isThere = [](std::size_t bytes) {
        void* const block = takeHuge(bytes);
        const bool there = block != nullptr;
        if (there) {
            EXPECT_TRUE(isHuge(block));
            EXPECT_GE(bytesOfHuge(block), bytes);
            giveBackHuge(block);
        }
        return there;
    };
    EXPECT_FALSE(isThere(kMiB));
    {
        const HugePages pages;
        for (int i = 0; i < 2; ++i) isThere(kMiB);  // before it is worth it
        if (!isThere(kMiB)) GTEST_SKIP() << "no huge pages on this machine, or addresses are limited";
        EXPECT_FALSE(isThere(64));
        EXPECT_FALSE(isThere(std::numeric_limits<std::size_t>::max() / 4));
    }
    EXPECT_FALSE(isThere(kMiB));
}

TEST(HugePages, BlocksOutliveThem) {
    std::vector<Block> blocks;
    for (int round = 0; round < 2; ++round) {
        const HugePages pages;
        checkBlocks(200'000, 20);
        for (std::uint64_t i = 0; i < 10; ++i) blocks.emplace_back(kMiB / 8 * i, 16, i);
        std::swap(blocks.front(), blocks.back());
        blocks.pop_back();
        releaseFreeHugePages();
        for (const Block& block : blocks) EXPECT_TRUE(block.isWhole());
    }
    for (const Block& block : blocks) EXPECT_TRUE(block.isWhole());
}

TEST(HugePages, WhatIsGivenBackIsKeptWhileTheyAreUsed) {
    constexpr std::size_t kBytes = 100 * kMiB;
    const auto held = [before = currentMemory()] { return currentMemory() - std::min(before, currentMemory()); };
    std::optional<HugePages> pages(std::in_place);
    Block block(kBytes / 8, 16, 1);
    if (void* const other = takeHuge(kMiB))
        giveBackHuge(other);
    else
        GTEST_SKIP() << "no huge pages on this machine, or addresses are limited";
    block = Block(1, 16, 1);
    EXPECT_GE(held(), kBytes * 9 / 10);
    releaseFreeHugePages();
    EXPECT_LE(held(), kBytes / 2);
    block = Block(kBytes / 8, 16, 1);
    EXPECT_GE(held(), kBytes * 9 / 10);
    pages.reset();
    EXPECT_GE(held(), kBytes * 9 / 10);
    block = Block(1, 16, 1);
    EXPECT_LE(held(), kBytes / 2);
}

TEST(ScratchMemory, WithoutAFolderBlocksAreInMemory) {
    const TemporaryFolder folder;
    const ScratchMemory scratch(kMiB, folder / "absent");
    checkBlocks(20'000, 20);
}

TEST(ScratchMemory, WhereTheFileIsFullBlocksAreInMemory) {
    std::signal(SIGXFSZ, SIG_IGN);
    rlimit before{};
    ::getrlimit(RLIMIT_FSIZE, &before);
    rlimit small = before;
    small.rlim_cur = 300 * kMiB;
    ::setrlimit(RLIMIT_FSIZE, &small);
    const TemporaryFolder folder;
    const ScratchMemory scratch(kMiB, folder.path());
    checkBlocks(600'000, 50);  // about 480 MB
    ::setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, SIG_DFL);
}

TEST(ScratchMemory, BlocksWithoutRoomLieInAFileWithoutAName) {
    const TemporaryFolder folder;
    const ScratchMemory scratch(16 * kMiB, folder.path());
    checkBlocks(100'000, 50);  // about 80 MB
    EXPECT_GT(peakScratch(), 20 * kMiB);
    EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(ScratchMemory, BlocksOutliveIt) {
    const TemporaryFolder folder;
    std::vector<Block> blocks;
    for (const bool limited : {true, false}) {
        std::optional<ScratchMemory> scratch;
        if (limited) scratch.emplace(kMiB, folder.path());
        for (std::uint64_t i = 0; i < 10; ++i) blocks.emplace_back(kMiB / 8, 16, i);
        for (const Block& block : blocks) EXPECT_TRUE(block.isWhole());
    }
    for (const Block& block : blocks) EXPECT_TRUE(block.isWhole());
}

TEST(ScratchMemory, BlocksAreCountedAsTheyAreFreed) {
    const TemporaryFolder folder;
    const ScratchMemory scratch(16 * kMiB, folder.path());
    const std::uint64_t before = peakScratch();
    for (const std::size_t alignment : {16, 64, 4096, 65536})
        for (const std::size_t bytes : {1, 64, 16'000, 16'384, 32'700, 32'768, 65'536})
            releaseMemory(allocateMemory(bytes, alignment));
    const Block block(5'000, 16, 1);
    EXPECT_EQ(peakScratch(), before);  // there is room in memory
}

TEST(ScratchMemory, NoMemoryHasRoomForAllOfIt) {
    if (kSanitized) GTEST_SKIP() << "sanitizers end what asks for so much";
    const TemporaryFolder folder;
    const ScratchMemory scratch(kMiB, folder.path());
    constexpr std::size_t kMost = std::numeric_limits<std::size_t>::max();
    for (const std::size_t alignment : {16, 64, 65536})
        for (const std::size_t bytes : {kMost, kMost - 10, kMost - 100'000, kMost / 2, kMost / 2 - 100'000})
            EXPECT_THROW(releaseMemory(allocateMemory(bytes, alignment)), std::bad_alloc);
}

TEST(ScratchMemory, TheProcessHoldsLittleMoreThanTheBudget) {
    const TemporaryFolder folder;
    const std::uint64_t most = currentMemory() + 128 * kMiB;
    const ScratchMemory scratch(64 * kMiB, folder.path());
    std::vector<Block> blocks;
    for (std::uint64_t i = 0; i < 50; ++i) blocks.emplace_back(4 * kMiB / 8, 16, i);
    const auto latest = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    while (currentMemory() > most && std::chrono::steady_clock::now() < latest)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    EXPECT_LE(currentMemory(), most);
    for (const Block& block : blocks) EXPECT_TRUE(block.isWhole());
}

}  // namespace
}  // namespace betamesh
