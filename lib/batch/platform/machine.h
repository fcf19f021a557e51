// The share of the machine that this process may use: processors and memory.

#pragma once

#include <cstdint>

namespace betamesh {

/// The smallest of: the processors this process may run on, the quota of its container, SLURM_CPUS_PER_TASK,
/// CUE_THREADS. At least 1.
int availableThreads();

/// The largest number of threads that a job may be given: those of availableThreads(), but at least 64, so that a small
/// machine can do what a large one does. Each thread costs time to start, and more than there are processors are of no
/// use.
int mostThreads();

/// The smallest of: the memory of the machine, the limit of its container, SLURM_MEM_PER_NODE. Bytes.
std::uint64_t availableMemory();

/// The part of availableMemory() that no process uses, bytes. Caches that the system can drop count as unused.
std::uint64_t freeMemory();

/// The resident memory of this process, now and at its peak, bytes.
std::uint64_t currentMemory();
std::uint64_t peakMemory();

/// Makes malloc keep freed memory for later allocations. Returning it to the system and getting it back, cleared page
/// by page, would take a tenth of the time of a frame.
void keepFreedMemory();

/// Returns the memory that malloc keeps to the system, once.
void releaseFreeMemory();

/// Undoes keepFreedMemory(): from now on freed memory returns to the system early.
void returnFreedMemory();

/// Makes allocations throw std::bad_alloc if this process would exceed its present memory by more than
/// availableMemory(). There is no limit if the system refuses it.
void limitToMachine();

/// Makes allocations throw std::bad_alloc if this process would exceed its present memory by more than this many bytes.
/// The stacks of two further threads do not count.
///
/// errors  the system refuses the limit
void limitMemory(std::uint64_t bytes);

}  // namespace betamesh
