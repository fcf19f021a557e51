// Exact predicates for balls at integer coordinates with integer radii. No epsilon is involved.
//
// Every ball is given relative to a common origin, itself the centre of a ball of radius R: u, v, w are others whose
// spheres meet that one. Radii are at most 2^20, so offsets are at most 2^21 long, all terms fit in 128 bits, and one
// comparison in 256. With R_u for the radius of u, its power p_u = |u|² + R² - R_u² is |u|² among balls of one radius,
// and its sphere meets that of the origin in the plane 2 u·x = p_u.
//
// Ties are broken symbolically: where a sign is zero, the answer is that of one nearby configuration in general
// position, with squared radii R_i² + η + ε_i, η ≫ ε_1 ≫ ε_2 …, the ε ordered by the lexicographic position of the
// centres. Results do not depend on the order in which particles are stored.
//
// source  Edelsbrunner & Mücke 1990 (simulation of simplicity); Devillers & Teillaud 2011 (lexicographic order);
//         Edelsbrunner 1993 (the union of balls: power in the place of squared distance)

#pragma once

#include "betamesh/vec3.h"

#include <cstdint>

namespace betamesh {

/// The lexicographic order of positions, by which all ties are broken.
inline bool before(const Vec3i& a, const Vec3i& b) {
    if (a.x != b.x) return a.x < b.x;
    if (a.y != b.y) return a.y < b.y;
    return a.z < b.z;
}

/// A ball by the offset of its centre from the origin.
struct OffsetBall {
    Vec3i centre;
    std::int64_t radius;
};

/// Do the spheres of radius R at 0, and of u, meet in a circle? True also where they touch, from outside or inside.
bool spheresMeet(const OffsetBall& u, std::int64_t radius);

/// Do the spheres of the origin (radius R), u and v meet in a point? True also where they meet in exactly one. Among
/// balls of one radius, that is where a ball of radius R fits on the three centres. Its centre is the point.
bool ballExists(const OffsetBall& u, const OffsetBall& v, std::int64_t radius);

/// Is the point where the spheres of the origin, u and v meet, on the positive (side +1) or negative (side -1) side of
/// the plane with normal u × v, inside the ball w? Requires ballExists(u, v, radius), spheresMeet(w, radius), and a
/// centre of w different from 0, u and v.
bool insideBall(const OffsetBall& u, const OffsetBall& v, const OffsetBall& w, int side, std::int64_t radius);

/// For spheres of the origin and u whose intersection circle the sphere of w does not cross (no ball exists for the
/// three): is the circle inside the ball w?
bool coversCircle(const OffsetBall& u, const OffsetBall& w, std::int64_t radius);

/// The sign of (u × a) · b: +1 where b is less than half a turn counter-clockwise from a, about the axis u.
int turn(const Vec3i& u, const Vec3i& a, const Vec3i& b);

/// The sign of (u × a) · (u × b): +1 where a and b are less than a quarter turn apart, about the axis u.
int sameSide(const Vec3i& u, const Vec3i& a, const Vec3i& b);

/// A neighbour of a particle: its offset, its power, and the radius of its ball, in quanta; all hold integers.
struct Neighbour {
    Vec3 offset;
    double power;  ///< |offset|² + R² - radius², where R is the particle's own radius
    std::uint32_t particle;
    std::int32_t radius;

    double squaredDistance() const { return dot(offset, offset); }
    OffsetBall ball() const { return {Vec3i(offset), radius}; }
};

/// The two points where the spheres of a particle and of two neighbours meet: a certified floating-point filter in
/// front of the exact predicates. Among balls of one radius they are centres of balls that rest on the three.
class ExactBalls {
public:
    /// radius: of the particle. largest: of all balls.
    ExactBalls(const Vec3& origin, const Neighbour& u, const Neighbour& v, double radius, double largest);

    bool exist() const { return exist_; }
    /// The point relative to the origin, rounded.
    Vec3 centre(int side) const { return side > 0 ? circumcentre_ + height_ : circumcentre_ - height_; }
    /// Is the point on that side, centre(side), inside the ball of w?
    bool contains(const Vec3& centre, int side, const Neighbour& w) const {
        const double power = w.power - 2 * dot(w.offset, centre);
        if (power > tolerance_) return false;
        if (power < -tolerance_) return true;
        return insideBall(u_.ball(), v_.ball(), w.ball(), side, static_cast<std::int64_t>(radius_));
    }

private:
    Neighbour u_, v_;
    double radius_;
    Vec3 circumcentre_{0, 0, 0};  // the point of equal power in the plane of 0, u and v
    Vec3 height_{0, 0, 0};        // from there to the point on side +1
    double tolerance_ = 0;        // bound on the rounding error of p_w - 2 w·centre
    bool exist_ = false;
};

/// The same questions answered as in the paper (Algorithms 1 and 2): in double precision on world coordinates, without
/// guarantee. Four cocircular particles, as on any lattice, get all or none of their triangles.
class FloatBalls {
public:
    /// All balls have the same radius.
    FloatBalls(const Vec3& origin, const Neighbour& u, const Neighbour& v, double radius, double);

    bool exist() const { return exist_; }
    Vec3 centre(int side) const { return (side > 0 ? circumcentre_ + height_ : circumcentre_ - height_) - origin_; }
    bool contains(const Vec3&, int side, const Neighbour& w) const {
        const Vec3 centre = side > 0 ? circumcentre_ + height_ : circumcentre_ - height_;
        return !(((origin_ + w.offset) - centre).length() > radius_);
    }

private:
    Vec3 origin_;
    double radius_;
    Vec3 circumcentre_{0, 0, 0}, height_{0, 0, 0};
    bool exist_ = false;
};

}  // namespace betamesh
