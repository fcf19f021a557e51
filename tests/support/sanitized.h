// Whether tests run under a sanitizer, so that some can be skipped.

#pragma once

namespace betamesh {

/// Sanitizers need memory of their own, have to be loaded before any other library, and abort a process that runs out
/// of memory.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

}  // namespace betamesh
