// Estimates of the memory of frames, and how many may be in progress at once.

#include "batch/platform/memory.h"

#include "support/temporary_folder.h"

#include <gtest/gtest.h>

#include <fstream>

namespace betamesh {
namespace {

constexpr std::uint64_t kMiB = 1 << 20;

TEST(Memory, EstimatesGrowWithTheFileAndAreLargestForCompressedFormats) {
    const TemporaryFolder folder;
    write(folder / "a.ply", std::string(1000, 'a'));
    write(folder / "b.ply", std::string(3000, 'a'));
    write(folder / "a.vdb", std::string(1000, 'a'));
    EXPECT_NEAR(static_cast<double>(workingMemory(folder / "b.ply")),
                3 * static_cast<double>(workingMemory(folder / "a.ply")), 3);
    EXPECT_GT(workingMemory(folder / "a.vdb"), workingMemory(folder / "a.ply"));
    EXPECT_EQ(workingMemory(folder / "absent.vdb"), 0U);
}

TEST(Memory, FramesInProgressStayWithinTheBudgetButOneMayAlwaysBegin) {
    MemoryWatch memory(100 * kMiB);
    EXPECT_EQ(memory.fitting(10 * kMiB), 10U);
    EXPECT_EQ(memory.fitting(1000 * kMiB), 1U);
    EXPECT_TRUE(memory.hasRoomFor(1000 * kMiB));
    memory.begins(60 * kMiB);
    EXPECT_FALSE(memory.hasRoomFor(50 * kMiB));
    EXPECT_TRUE(memory.hasRoomFor(30 * kMiB));
    memory.begins(30 * kMiB);
    EXPECT_FALSE(memory.hasRoomFor(20 * kMiB));
    memory.ends(60 * kMiB);
    memory.ends(30 * kMiB);
    EXPECT_TRUE(memory.hasRoomFor(1000 * kMiB));
}

TEST(Memory, MeasuredMemoryCorrectsTheEstimates) {
    std::ofstream("/proc/self/clear_refs") << 5;  // resets the peak, which includes earlier tests
    MemoryWatch memory(1000 * kMiB);
    memory.begins(10 * kMiB);  // but uses 232 MiB, of which 32 are for the program itself
    std::string much(232 * kMiB, 'a');
    EXPECT_EQ(much.back(), 'a');
    much.clear();
    much.shrink_to_fit();
    memory.ends(10 * kMiB);
    EXPECT_LE(memory.fitting(10 * kMiB), 6U);  // 100 by the estimate
    EXPECT_GE(memory.fitting(10 * kMiB), 2U);

    MemoryWatch other(1000 * kMiB);  // allocates nothing above the earlier peak
    other.begins(1000 * kMiB);
    other.ends(1000 * kMiB);
    EXPECT_GE(other.fitting(1000 * kMiB), 2U);
}

}  // namespace
}  // namespace betamesh
