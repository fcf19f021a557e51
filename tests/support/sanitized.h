// Whether tests run under sanitizers, where some are left out.

#pragma once

namespace betamesh {

#if defined(__SANITIZE_THREAD__)
inline constexpr bool kThreadSanitized = true;
#else
inline constexpr bool kThreadSanitized = false;
#endif

/// Sanitizers use memory of their own, have to be loaded before any other library, and end a process that runs out of
/// memory.
#if defined(__SANITIZE_ADDRESS__)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = kThreadSanitized;
#endif

}  // namespace betamesh
