// Memory of frames that are larger than it: a file that the system pages in and out.

#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <thread>

namespace betamesh {

/// While there is one, large blocks that the memory has no room for lie in a file without a name, which goes when the
/// process does: those of a program whose operators new and delete call allocateMemory() and releaseMemory(). What
/// computes does not know, so it computes the same bytes.
///
/// cost    what is touched again and has left the memory comes from the disk. Arrays are in the order of particles, and
///         what uses them goes along them, so that is a few times a stage
class ScratchMemory {
public:
    /// A quarter of the budget is for large blocks in memory; of those in the file so much is at hand that the process
    /// takes little more than the budget above what it has now; bytes. Where the folder takes no file a warning is
    /// logged; there, and where its disk has less than 64 MiB left, blocks without room throw std::bad_alloc as ever.
    ScratchMemory(std::uint64_t budget, const std::string& folder);
    ~ScratchMemory();
    ScratchMemory(const ScratchMemory&) = delete;
    ScratchMemory& operator=(const ScratchMemory&) = delete;

private:
    std::jthread trimming_;
};

/// alignment  a power of two
/// errors     std::bad_alloc
void* allocateMemory(std::size_t bytes, std::size_t alignment);
void releaseMemory(void* block) noexcept;

/// The most that has been in the file at once, bytes.
std::uint64_t peakScratch();

}  // namespace betamesh
