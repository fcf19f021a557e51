// Measures of plane curves: count, turning number, area, length.

#pragma once

#include "betamesh/curves.h"

#include <span>

namespace betamesh {

struct CurveMeasure {
    std::size_t curves = 0;         ///< lines, closed or open
    std::int64_t turning = 0;       ///< sum of the closed lines' turning numbers: components of liquid minus holes
    double area = 0;                ///< enclosed, world units squared; meaningful for closed curves
    double length = 0;              ///< world units
    std::size_t unpaired_ends = 0;  ///< sum over vertices of |outgoing - incoming edges|; 0 when closed
};

/// The turning number of a closed line: full left turns minus full right turns. Vertices that coincide in single
/// precision count once; a reversal of direction, as at the tip of a double-sided line, counts as a left turn.
std::int64_t turningNumber(const Curves& curves, std::span<const Edge> line);

/// in      edges whose vertices exist; z is ignored
/// cost    O(edges)
CurveMeasure measureCurves(const Curves& curves);

}  // namespace betamesh
