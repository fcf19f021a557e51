// Exact predicates for discs at integer coordinates with integer radii in a plane of constant z. No epsilon is
// involved.
//
// Points are offsets from a common origin, which is itself the centre of a disc of radius R: doubles that hold
// integers. Radii are at most 2^20, so offsets to discs whose circles meet that one are at most 2^21 long. Among discs
// of one radius every intermediate result then fits in 128 bits, among others in 256.
//
// Ties are broken symbolically, as in three dimensions (exact/predicates.h): where a sign is zero, the answer is that
// for squared radii R_i² + η + ε_i. Then no three circles share a point and no two are tangent, so the configuration is
// in general position and results do not depend on the order of the particles. Among discs of one radius η decides
// everything. Otherwise the ε_i matter only where three circles share both their points. Their centres are then in
// line, and whichever ε is the largest, the disc in the middle is inside the union of the other two.

#pragma once

#include "betamesh/vec3.h"
#include "exact/predicates.h"

namespace betamesh {

/// Is w inside the disc of radius R whose circle passes through 0 and u and whose centre is to the right of the segment
/// from 0 to u? Requires 0 < |u| <= 2R, |w| <= 2R, and w different from 0 and u.
bool insideDisc(const Vec3& u, const Vec3& w, double radius);

/// The centre of that disc, rounded.
Vec3 discCentre(const Vec3& u, double radius);

/// The same for discs of different radii: is the point where the circles of the origin (radius R) and of u meet, to the
/// right of the segment from 0 to u, inside the disc w? Requires that both circles meet that of the origin,
/// spheresMeet(), and a centre of w different from 0 and u.
bool insideDisc(const OffsetBall& u, const OffsetBall& w, std::int64_t radius);

/// That point, with a certified floating-point filter in front of the exact predicate. There the boundary of the union,
/// counter-clockwise round the discs, changes from the circle of the particle to that of its neighbour.
class CircleIntersection {
public:
    /// u: a neighbour whose circle meets that of the particle. radius: of the particle. largest: of all discs.
    CircleIntersection(const Neighbour& u, double radius, double largest);

    /// The point relative to the particle, rounded.
    const Vec3& position() const { return position_; }
    bool isInside(const Neighbour& w) const {
        const double power = w.power - 2 * dot(w.offset, position_);
        if (power > tolerance_) return false;
        if (power < -tolerance_) return true;
        return insideDisc(u_.ball(), w.ball(), static_cast<std::int64_t>(radius_));
    }

private:
    Neighbour u_;
    double radius_;
    Vec3 position_{0, 0, 0};
    double tolerance_ = 0;  // bound on the rounding error of a neighbour's power
};

/// Is the angle of a, in [0, 2π) counter-clockwise from the x axis, smaller than that of b? False where they are equal.
bool directionBefore(const Vec3& a, const Vec3& b);

}  // namespace betamesh
