// Exact signs about discs of one radius R in a plane of constant z. No epsilon decides anything.
//
// Points are given relative to a common origin, itself the centre of a disc: offsets to other centres, doubles that
// hold whole numbers. Offsets are at most 2R long and R is at most 2^20, so everything fits in 128 bits.
//
// Where a sign is zero the answer is that for a radius larger by next to nothing. Then no three circles share a point
// and no two touch: one configuration in general position, and nothing depends on any order.

#pragma once

#include "betamesh/vec3.h"

namespace betamesh {

/// Is w inside the disc of radius R whose circle passes through 0 and u, and whose centre lies to the right of the way
/// from 0 to u? Requires 0 < |u| <= 2R, |w| <= 2R, and w none of 0 and u.
bool insideDisc(const Vec3& u, const Vec3& w, double radius);

/// The centre of that disc, rounded.
Vec3 discCentre(const Vec3& u, double radius);

/// Does direction a come before b counter-clockwise from the x axis, in [0, 2π)? False where they are the same.
bool directionBefore(const Vec3& a, const Vec3& b);

}  // namespace betamesh
