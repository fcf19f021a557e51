// A local origin for coordinates that are too large for single precision.

#pragma once

#include "betamesh/vec3.h"

#include <cstddef>

namespace betamesh {

/// A round point to subtract from positions in double precision. With M the largest coordinate, L the longest side of
/// the bounding box and n particles, it is the middle of the box, rounded to multiples of the power of ten at or above
/// L, if
///   - the largest rounding error of single precision, M 2^-24, is more than a thousandth of L / cbrt(n), about the
///     spacing of particles that fill the box, and
///   - M is more than 16 L, so that another origin is much better;
/// otherwise it is zero.
///
/// in      box: of n >= 1 positions
Vec3 localOrigin(const Box& box, std::size_t particles);

/// Whether single precision rounds a coordinate by more than a thousandth of the spacing.
bool isCoarselyRounded(double coordinate, double spacing);

}  // namespace betamesh
