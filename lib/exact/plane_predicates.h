// Exact predicates for discs of one radius R in a plane of constant z. No epsilon is involved.
//
// Points are offsets from a common origin, which is itself the centre of a disc: doubles that hold integers. Offsets
// are at most 2R long and R is at most 2^20, so every intermediate result fits in 128 bits.
//
// Ties are broken symbolically: where a sign is zero, the answer is the one for an infinitesimally larger R. Then no
// three circles share a point and no two are tangent, so the configuration is in general position and results do not
// depend on the order of the particles.

#pragma once

#include "betamesh/vec3.h"

namespace betamesh {

/// Is w inside the disc of radius R whose circle passes through 0 and u and whose centre is to the right of the segment
/// from 0 to u? Requires 0 < |u| <= 2R, |w| <= 2R, and w different from 0 and u.
bool insideDisc(const Vec3& u, const Vec3& w, double radius);

/// The centre of that disc, rounded.
Vec3 discCentre(const Vec3& u, double radius);

/// Is the angle of a, in [0, 2π) counter-clockwise from the x axis, smaller than that of b? False where they are equal.
bool directionBefore(const Vec3& a, const Vec3& b);

}  // namespace betamesh
