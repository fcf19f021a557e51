// What tests leave out on sanitizers.

#pragma once

namespace betamesh {

/// Sanitizers hold memory of their own, are to be loaded before any other library, and end a process that lacks memory.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

}  // namespace betamesh
