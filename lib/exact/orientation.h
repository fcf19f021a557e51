// Exact orientation predicates for points in floating point. No epsilon is involved.
//
// Coordinates are taken exactly as the doubles are, whether read from float or computed. Each determinant is first
// evaluated in doubles; where it does not exceed its proven rounding error, its sign is computed in integers.

#pragma once

#include "betamesh/vec3.h"

#include <cmath>

namespace betamesh {

/// Magnitudes of all coordinates have to be below this, as those of any float are; then no predicate overflows.
inline constexpr double kLargestCoordinate = 0x1p200;

/// False also for NaN and infinity.
inline bool isInRange(const Vec3& p) {
    return std::abs(p.x) < kLargestCoordinate && std::abs(p.y) < kLargestCoordinate &&
           std::abs(p.z) < kLargestCoordinate;
}

/// Orientation of p against the plane through a, b, c: +1 on the side from which a, b, c are counter-clockwise, -1 on
/// the other side, 0 on the plane or where a, b, c are collinear.
int sideOfPlane(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p);

/// Orientation of a, b, c projected along an axis (0, 1, 2: x, y, z), seen from its positive end: +1 counter-clockwise,
/// -1 clockwise, 0 collinear.
int turnAlong(int axis, const Vec3& a, const Vec3& b, const Vec3& c);

/// Are the three points collinear?
inline bool onOneLine(const Vec3& a, const Vec3& b, const Vec3& c) {
    return turnAlong(0, a, b, c) == 0 && turnAlong(1, a, b, c) == 0 && turnAlong(2, a, b, c) == 0;
}

}  // namespace betamesh
