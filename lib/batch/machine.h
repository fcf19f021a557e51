// What this process may use of the machine: processors, memory.

#pragma once

#include <cstdint>

namespace betamesh {

/// The least of: processors this process may run on, its container's quota, SLURM_CPUS_PER_TASK,
/// CUE_THREADS. At least 1.
int availableThreads();

/// The least of: the machine's memory, its container's limit, SLURM_MEM_PER_NODE. Bytes.
std::uint64_t availableMemory();

/// The most memory this process has held at once, bytes.
std::uint64_t peakMemory();

/// From here on allocations that together would take this many bytes more than the process has now throw
/// std::bad_alloc. The stack of one more thread does not count.
void limitMemory(std::uint64_t bytes);

}  // namespace betamesh
