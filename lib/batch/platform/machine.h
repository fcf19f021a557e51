// What this process may use of the machine: processors, memory.

#pragma once

#include <cstdint>

namespace betamesh {

/// The least of: processors this process may run on, its container's quota, SLURM_CPUS_PER_TASK,
/// CUE_THREADS. At least 1.
int availableThreads();

/// The least of: the machine's memory, its container's limit, SLURM_MEM_PER_NODE. Bytes.
std::uint64_t availableMemory();

/// What is left of availableMemory() by the use of all processes, bytes. What can be dropped from caches counts as
/// left.
std::uint64_t freeMemory();

/// The memory this process holds, and the most it has held at once, bytes.
std::uint64_t currentMemory();
std::uint64_t peakMemory();

/// How much the system reads at once of a file that is mapped, bytes; 0 where it does not tell.
std::uint64_t readAhead(int file);

/// Keeps what is freed for later allocations: of a frame's time a tenth and more would go into pages that the system
/// takes back and hands out again, cleared. Large blocks lie in huge pages.
void keepFreedMemory();

/// Gives the system back what this process holds for later allocations.
void releaseFreeMemory();

/// Gives it back as soon as it is freed, from here on.
void returnFreedMemory();

/// From here on allocations that together would take this many bytes more than the process has now throw
/// std::bad_alloc. The stacks of two more threads do not count.
void limitMemory(std::uint64_t bytes);

}  // namespace betamesh
