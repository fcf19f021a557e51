// Memory in pages of megabytes, for large blocks.

#pragma once

#include <cstddef>

namespace betamesh {

/// From here on takeHuge() has memory to give, where the system has huge pages of 2 MiB and addresses are not limited.
/// What is given back is kept for what comes next.
///
/// A page of 4 KiB that is touched for the first time costs 11 µs on some virtual machines, where a third of a frame's
/// time went there, and one of 2 MiB, 512 times as much, 130 µs, or 4 ms where the machine's host has to find it, as it
/// has a few seconds after a page was given back. On others a small one costs 1.5 µs and a huge one 0.2 ms, but 4.6 ms
/// where it has to be found: after a pause frames took a fifth to a third longer in huge pages there, and right after
/// one another a tenth less. Which it is, stays so for many pages, but the first is often dear alone. So the pages are
/// small from where two in a row have taken longer than 512 small ones.
void useHugePages();

/// Of memory that is not in use, all goes back to the system.
void releaseFreeHugePages();

/// There is no more to take from here on, and what is given back goes back to the system.
void leaveHugePages();

constexpr std::size_t kHugeAlignment = 64;

/// So many bytes > 0 at a multiple of kHugeAlignment, or null: there are none to be had, or it would not be worth it,
/// as they are few, or the first quarter of a megabyte of all.
void* takeHuge(std::size_t bytes);

bool isHuge(const void* block);  ///< is it one of takeHuge()?
/// The bytes of such a block, at least what was asked for.
std::size_t bytesOfHuge(const void* block);
void giveBackHuge(void* block) noexcept;

}  // namespace betamesh
