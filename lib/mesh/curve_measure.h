// The turning number of a line, part of measureCurves().

#pragma once

#include "betamesh/check.h"

namespace betamesh {

/// The turning number of a closed line: full left turns minus full right turns. Vertices that coincide in single
/// precision count once; a reversal of direction, as at the tip of a double-sided line, counts as a left turn.
std::int64_t turningNumber(const Curves& curves, std::span<const Edge> line);

}  // namespace betamesh
