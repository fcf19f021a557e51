// Exact signs about balls of one radius R on integer coordinates. No epsilon decides anything.
//
// Every point is given relative to a common origin, itself a particle centre: u, v, w are offsets to other
// centres. Offsets are at most 2R long and R is at most 2^20, so all of it fits in 128 bits, and one
// comparison in 256.
//
// Where a sign is zero the answers are those of one nearby configuration in general position: squared
// radii R² + η + ε_i with η ≫ ε_1 ≫ ε_2 …, the ε ordered by the lexicographic position of the centres.
// Nothing depends on the order in which particles are stored.
//
// source  Edelsbrunner & Mücke 1990 (simulation of simplicity); Devillers & Teillaud 2011 (lexicographic order)

#pragma once

#include "betamesh/vec3.h"

#include <cstdint>

namespace betamesh {

/// The lexicographic order of positions, on which all ties rest.
inline bool before(const Vec3i& a, const Vec3i& b) {
    if (a.x != b.x) return a.x < b.x;
    if (a.y != b.y) return a.y < b.y;
    return a.z < b.z;
}

/// Does a sphere of radius R pass through 0, u and v? True also where exactly one does.
bool ballExists(const Vec3i& u, const Vec3i& v, std::int64_t radius);

/// Is w inside the ball of radius R whose sphere passes through 0, u and v, and whose centre lies on the
/// positive (side +1) or negative (side -1) side of the plane with normal u × v? Requires ballExists, and
/// w none of 0, u, v.
bool insideBall(const Vec3i& u, const Vec3i& v, const Vec3i& w, int side, std::int64_t radius);

/// Where the spheres at 0 and u meet in a circle that the sphere at w does not cross (no ball exists for the
/// three): is the circle inside the ball at w?
bool coversCircle(const Vec3i& u, const Vec3i& w);

/// The sign of (u × a) · b: +1 where b follows a counter-clockwise round the axis u within half a turn.
int turn(const Vec3i& u, const Vec3i& a, const Vec3i& b);

/// The sign of (u × a) · (u × b): +1 where a and b lie less than a quarter turn apart round the axis u.
int sameSide(const Vec3i& u, const Vec3i& a, const Vec3i& b);

/// The two balls of radius R through 0, u and v: a certified floating-point filter in front of the exact
/// predicates. Offsets come as doubles that hold integers.
class ExactBalls {
public:
    ExactBalls(const Vec3& origin, const Vec3& u, const Vec3& v, double radius);

    bool exist() const { return exist_; }
    /// The centre relative to the origin, rounded.
    Vec3 centre(int side) const { return side > 0 ? mid_ + rise_ : mid_ - rise_; }
    /// Is w, |w|² = w_squared <= 4R², inside the ball on that side?
    bool contains(const Vec3& centre, int side, const Vec3& w, double w_squared) const {
        const double power = w_squared - 2 * dot(w, centre);
        if (power > tolerance_) return false;
        if (power < -tolerance_) return true;
        return decide(side, w);
    }

private:
    bool decide(int side, const Vec3& w) const;

    Vec3 u_, v_;
    double radius_;
    Vec3 mid_{0, 0, 0}, rise_{0, 0, 0};  // circumcentre of the triangle; from there to the centre on side +1
    double tolerance_ = 0;               // bound on the rounding error of |w|² - 2 w·centre
    bool exist_ = false;
};

/// The same questions answered as the paper does (Algorithms 1 and 2): in double precision, on coordinates
/// as they stand in the world, with no guarantee. Four particles on one circle, as on any lattice, get all
/// or none of their triangles.
class FloatBalls {
public:
    FloatBalls(const Vec3& origin, const Vec3& u, const Vec3& v, double radius);

    bool exist() const { return exist_; }
    Vec3 centre(int side) const { return (side > 0 ? foot_ + rise_ : foot_ - rise_) - origin_; }
    bool contains(const Vec3&, int side, const Vec3& w, double) const {
        const Vec3 centre = side > 0 ? foot_ + rise_ : foot_ - rise_;
        return !(((origin_ + w) - centre).length() > radius_);
    }

private:
    Vec3 origin_;
    double radius_;
    Vec3 foot_{0, 0, 0}, rise_{0, 0, 0};
    bool exist_ = false;
};

}  // namespace betamesh
