// Exact signs about points given in floating point. No epsilon decides anything.
//
// Coordinates are doubles as they stand, whether they were read as float or computed. Each sign is first
// taken in doubles; where that is too small for its proven rounding error, it is computed in integers.

#pragma once

#include "betamesh/vec3.h"

#include <cmath>

namespace betamesh {

/// All coordinates have to be smaller than this (any float is): then nothing below overflows.
inline constexpr double kLargestCoordinate = 0x1p200;

/// Also false for what is not a number.
inline bool isInRange(const Vec3& p) {
    return std::abs(p.x) < kLargestCoordinate && std::abs(p.y) < kLargestCoordinate &&
           std::abs(p.z) < kLargestCoordinate;
}

/// +1 where p lies on the side of the plane through a, b, c from which they run counter-clockwise, -1 on
/// the other side, 0 on the plane or where a, b, c are on one line.
int sideOfPlane(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p);

/// +1 where a, b, c, seen from the positive end of the axis (0, 1, 2: x, y, z), run counter-clockwise, -1
/// where clockwise, 0 where on one line.
int turnAlong(int axis, const Vec3& a, const Vec3& b, const Vec3& c);

/// Are the three points on one line?
inline bool onOneLine(const Vec3& a, const Vec3& b, const Vec3& c) {
    return turnAlong(0, a, b, c) == 0 && turnAlong(1, a, b, c) == 0 && turnAlong(2, a, b, c) == 0;
}

}  // namespace betamesh
