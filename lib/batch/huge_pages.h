// Memory in pages of megabytes, for large blocks.

#pragma once

#include <cstddef>

namespace betamesh {

/// From here on takeHuge() has memory to give, where the system has huge pages of 2 MiB and addresses are not limited.
/// What is given back is kept for what comes next.
///
/// A page that is touched for the first time costs 0.3 µs on a machine and up to 10 on a virtual one, mostly the same
/// whether it has 4 KiB or 2 MiB: in small ones a third of a frame's time went there.
void useHugePages();

/// Of memory that is not in use, all goes back to the system.
void releaseFreeHugePages();

/// There is no more to take from here on, and what is given back goes back to the system.
void leaveHugePages();

constexpr std::size_t kHugeAlignment = 64;

/// So many bytes > 0 at a multiple of kHugeAlignment, or null: there are none to be had, or it would not be worth it,
/// as they are few, or the first two megabytes of all.
void* takeHuge(std::size_t bytes);

bool isHuge(const void* block);  ///< is it one of takeHuge()?
/// The bytes of such a block, at least what was asked for.
std::size_t bytesOfHuge(const void* block);
void giveBackHuge(void* block) noexcept;

}  // namespace betamesh
