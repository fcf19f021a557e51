// Exact predicates for balls of one radius R at integer coordinates. No epsilon is involved.
//
// Every point is given relative to a common origin, itself a particle centre: u, v, w are offsets to other centres.
// Offsets are at most 2R long and R is at most 2^20, so all terms fit in 128 bits, and one comparison in 256.
//
// Ties are broken symbolically: where a sign is zero, the answer is that of one nearby configuration in general
// position, with squared radii R² + η + ε_i, η ≫ ε_1 ≫ ε_2 …, the ε ordered by the lexicographic position of the
// centres. Results do not depend on the order in which particles are stored.
//
// source  Edelsbrunner & Mücke 1990 (simulation of simplicity); Devillers & Teillaud 2011 (lexicographic order)

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

/// Is there a sphere of radius R through 0, u and v? True also where there is exactly one.
bool ballExists(const Vec3i& u, const Vec3i& v, std::int64_t radius);

/// Is w inside the ball of radius R whose sphere passes through 0, u and v and whose centre is on the positive (side
/// +1) or negative (side -1) side of the plane with normal u × v? Requires ballExists(u, v, radius) and w different
/// from 0, u and v.
bool insideBall(const Vec3i& u, const Vec3i& v, const Vec3i& w, int side, std::int64_t radius);

/// For spheres at 0 and u whose intersection circle the sphere at w does not cross (no ball exists for the three): is
/// the circle inside the ball at w?
bool coversCircle(const Vec3i& u, const Vec3i& w);

/// The sign of (u × a) · b: +1 where b is less than half a turn counter-clockwise from a, about the axis u.
int turn(const Vec3i& u, const Vec3i& a, const Vec3i& b);

/// The sign of (u × a) · (u × b): +1 where a and b are less than a quarter turn apart, about the axis u.
int sameSide(const Vec3i& u, const Vec3i& a, const Vec3i& b);

/// The two balls of radius R whose spheres pass through 0, u and v: a certified floating-point filter in front of the
/// exact predicates. Offsets are doubles that hold integers.
class ExactBalls {
public:
    ExactBalls(const Vec3& origin, const Vec3& u, const Vec3& v, double radius);

    bool exist() const { return exist_; }
    /// The centre relative to the origin, rounded.
    Vec3 centre(int side) const { return side > 0 ? circumcentre_ + height_ : circumcentre_ - height_; }
    /// Is w, with |w|² = w_squared <= 4R², inside the ball on that side? centre: centre(side).
    bool contains(const Vec3& centre, int side, const Vec3& w, double w_squared) const {
        const double power = w_squared - 2 * dot(w, centre);
        if (power > tolerance_) return false;
        if (power < -tolerance_) return true;
        return containsExactly(side, w);
    }

private:
    bool containsExactly(int side, const Vec3& w) const;

    Vec3 u_, v_;
    double radius_;
    Vec3 circumcentre_{0, 0, 0};  // of the triangle 0, u, v
    Vec3 height_{0, 0, 0};        // from there to the centre of the ball on side +1
    double tolerance_ = 0;        // bound on the rounding error of |w|² - 2 w·centre
    bool exist_ = false;
};

/// The same questions answered as in the paper (Algorithms 1 and 2): in double precision on world coordinates, without
/// guarantee. Four cocircular particles, as on any lattice, get all or none of their triangles.
class FloatBalls {
public:
    FloatBalls(const Vec3& origin, const Vec3& u, const Vec3& v, double radius);

    bool exist() const { return exist_; }
    Vec3 centre(int side) const { return (side > 0 ? circumcentre_ + height_ : circumcentre_ - height_) - origin_; }
    bool contains(const Vec3&, int side, const Vec3& w, double) const {
        const Vec3 centre = side > 0 ? circumcentre_ + height_ : circumcentre_ - height_;
        return !(((origin_ + w) - centre).length() > radius_);
    }

private:
    Vec3 origin_;
    double radius_;
    Vec3 circumcentre_{0, 0, 0}, height_{0, 0, 0};
    bool exist_ = false;
};

}  // namespace betamesh
