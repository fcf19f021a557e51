// Rows of arrays by number.

#pragma once

#include <cstdint>
#include <limits>

namespace betamesh {

/// Stands for no row: nothing there, or left out.
inline constexpr std::uint32_t kInvalidIndex = std::numeric_limits<std::uint32_t>::max();

}  // namespace betamesh
