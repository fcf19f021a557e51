// The index that refers to no row.

#pragma once

#include <cstdint>
#include <limits>

namespace betamesh {

/// Means "no row": there is nothing, or it was left out.
inline constexpr std::uint32_t kInvalidIndex = std::numeric_limits<std::uint32_t>::max();

}  // namespace betamesh
