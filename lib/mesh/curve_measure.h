// What curves in a plane are, in numbers.

#pragma once

#include "betamesh/curves.h"

#include <span>

namespace betamesh {

struct CurveMeasure {
    std::size_t curves = 0;    ///< lines, closed or not
    std::int64_t turning = 0;  ///< how often closed ones turn round to the left, in sum: pieces of liquid less holes
    double area = 0;           ///< enclosed, world units squared; meaningful for closed curves
    double length = 0;         ///< world units
    std::size_t unpaired_ends = 0;  ///< at vertices that more edges leave than come to, or fewer; 0 when closed
};

/// How often a closed line turns round to the left. Vertices nearer to each other than single precision tells apart
/// count once; where it turns right round, as at the end of something thin, it turns to the left.
std::int64_t turningNumber(const Curves& curves, std::span<const Edge> line);

/// in      edges of vertices that exist; z does not matter
/// cost    O(edges)
CurveMeasure measureCurves(const Curves& curves);

}  // namespace betamesh
