
#include "exact/predicates.h"

#include "exact/wide.h"

#include <cassert>
#include <cmath>
#include <utility>

namespace betamesh {

namespace {

constexpr double kRounding = 0x1p-53;

// Sums wrap modulo 2^128. The final values fit whenever the triangle has a circumradius of at most R.
Unsigned dotWide(const Vec3i& a, const Vec3i& b) {
    return static_cast<Unsigned>(Int{a.x} * b.x) + static_cast<Unsigned>(Int{a.y} * b.y) +
           static_cast<Unsigned>(Int{a.z} * b.z);
}

std::int64_t square(const Vec3i& a) { return a.x * a.x + a.y * a.y + a.z * a.z; }

std::int64_t power(const OffsetBall& u, std::int64_t radius) {
    return square(u.centre) + (radius * radius - u.radius * u.radius);
}

// D = 4R²N - |p_u v - p_v u|², where N = |u × v|²: four times N times the squared distance of the points where the
// three spheres meet from the plane of the centres; negative where they do not meet. Sums wrap modulo 2^128: correct
// where |D| < 2^127. (Among balls of one radius D = 4R²N - UVW with the squared sides U, V, W.)
Int discriminant(const OffsetBall& u, const OffsetBall& v, std::int64_t radius, Int n_squared) {
    const auto p = static_cast<Unsigned>(Int{power(u, radius)}), q = static_cast<Unsigned>(Int{power(v, radius)});
    const Unsigned cancelling = p * p * static_cast<Unsigned>(square(v.centre)) +
                                q * q * static_cast<Unsigned>(square(u.centre)) -
                                2 * p * q * static_cast<Unsigned>(Int{u.centre.dot(v.centre)});
    const std::int64_t diameter_squared = 4 * radius * radius;
    return static_cast<Int>(static_cast<Unsigned>(diameter_squared) * static_cast<Unsigned>(n_squared) - cancelling);
}

// Where w is in the plane of the centres 0, u and v, and its sphere passes through the points where theirs meet: the
// sign of w's power there when every squared radius has an ε of its own.
int cocircularSign(const Vec3i& u, const Vec3i& v, const Vec3i& w, const Vec3i& n) {
    // w = α·0 + β·u + γ·v with α + β + γ = 1, and the power changes by α ε_0 + β ε_u + γ ε_v - ε_w. The first of these
    // in the lexicographic order that is not 0 decides; a coefficient is 0 where w is in line with the other two.
    const auto signOf = [&](const Vec3i& a, const Vec3i& b) { return sign(static_cast<Int>(dotWide(cross(a, b), n))); };
    const std::pair<Vec3i, int> terms[] = {
        {Vec3i(0, 0, 0), signOf(u - w, v - w)}, {u, signOf(w, v)}, {v, signOf(u, w)}};
    std::pair<Vec3i, int> first{w, -1};
    for (const auto& term : terms)
        if (term.second != 0 && before(term.first, first.first)) first = term;
    return first.second;
}

// Quantities of the triangle 0, u, v and of the points where the three spheres meet, in floating point.
struct MeetingPoints {
    double p, q;            // powers of u and v
    Vec3 normal;            // u × v
    double n_squared;       // |u × v|²
    double cancelling = 0;  // |p_u v - p_v u|²
    double d = 0, d_error;  // D and a bound on its error

    MeetingPoints(const Neighbour& u, const Neighbour& v, double radius)
        : p(u.power), q(v.power), normal(cross(u.offset, v.offset)), n_squared(dot(normal, normal)) {
        const double four_rr_n = 4 * radius * radius * n_squared;
        if (u.radius == radius && v.radius == radius) {
            const Vec3 edge = u.offset - v.offset;
            cancelling = p * q * dot(edge, edge);
            d_error = 16 * kRounding * (four_rr_n + cancelling);
        } else {
            cancelling = (p * v.offset - q * u.offset).length2();
            const double terms = cancellingTerms(u, v);
            d_error = 16 * kRounding * (four_rr_n + cancelling + std::sqrt(cancelling) * terms) +
                      16 * kRounding * kRounding * terms * terms;
        }
        d = four_rr_n - cancelling;
    }
    Vec3 circumcentre(const Vec3& u, const Vec3& v) const { return cross(p * v - q * u, normal) / (2 * n_squared); }
    // |p_u||v| + |p_v||u|: magnitude of the terms that cancel in p_u v - p_v u.
    double cancellingTerms(const Neighbour& u, const Neighbour& v) const {
        return std::abs(p) * std::sqrt(v.squaredDistance()) + std::abs(q) * std::sqrt(u.squaredDistance());
    }
};

Neighbour neighbourOf(const OffsetBall& ball, std::int64_t radius) {
    return {toDouble(ball.centre), static_cast<double>(power(ball, radius)), 0, static_cast<std::int32_t>(ball.radius)};
}

}  // namespace

bool spheresMeet(const OffsetBall& u, std::int64_t radius) {
    const std::int64_t squared = square(u.centre), sum = radius + u.radius, difference = radius - u.radius;
    return squared <= sum * sum && squared >= difference * difference && squared > 0;
}

bool ballExists(const OffsetBall& u, const OffsetBall& v, std::int64_t radius) {
    if (!spheresMeet(u, radius) || !spheresMeet(v, radius) || !spheresMeet({v.centre - u.centre, v.radius}, u.radius))
        return false;
    const MeetingPoints points(neighbourOf(u, radius), neighbourOf(v, radius), static_cast<double>(radius));
    if (points.n_squared == 0) return false;
    if (std::abs(points.d) > points.d_error) return points.d > 0;
    const Vec3i n = cross(u.centre, v.centre);
    return discriminant(u, v, radius, static_cast<Int>(dotWide(n, n))) >= 0;
}

bool insideBall(const OffsetBall& u, const OffsetBall& v, const OffsetBall& w, int side, std::int64_t radius) {
    // N times the power of the point is A + B √D
    const Vec3i n = cross(u.centre, v.centre);
    const Int n_squared = static_cast<Int>(dotWide(n, n));
    const Int d = discriminant(u, v, radius, n_squared);
    assert(n_squared > 0 && d >= 0);
    const auto powerOf = [&](const OffsetBall& ball) { return static_cast<Unsigned>(Int{power(ball, radius)}); };
    const Unsigned term_w = static_cast<Unsigned>(n_squared) * powerOf(w);
    const Unsigned term_u = powerOf(u) * dotWide(n, cross(w.centre, v.centre));
    const Unsigned term_v = powerOf(v) * dotWide(n, cross(u.centre, w.centre));
    const Int a = static_cast<Int>(term_w - term_u - term_v);
    const Int b = -side * static_cast<Int>(dotWide(w.centre, n));

    const int sign_a = sign(a), sign_b = sign(b);
    if (sign_b == 0) return (sign_a != 0 ? sign_a : cocircularSign(u.centre, v.centre, w.centre, n)) < 0;
    if (d == 0 && sign_a != 0) return sign_a < 0;
    if (sign_a == 0 || sign_a == sign_b) return sign_b < 0;
    const int larger =
        compare(multiply(magnitude(a), magnitude(a)), multiply(magnitude(b) * magnitude(b), static_cast<Unsigned>(d)));
    if (larger == 0) return sign_b < 0;
    return (larger > 0 ? sign_a : sign_b) < 0;
}

bool coversCircle(const OffsetBall& u, const OffsetBall& w, std::int64_t radius) {
    // |u|² times the mean power of the circle's points. Where it is 0 the three spheres share the circle, with w = λu.
    const std::int64_t uu = square(u.centre), along = u.centre.dot(w.centre);
    const Int mean = Int{power(w, radius)} * uu - Int{power(u, radius)} * along;
    if (mean != 0) return mean < 0;
    const Vec3i zero(0, 0, 0);
    if (before(w.centre, zero) && before(w.centre, u.centre)) return true;
    return before(zero, u.centre) ? along > uu : along < 0;
}

int turn(const Vec3i& u, const Vec3i& a, const Vec3i& b) { return sign(static_cast<Int>(dotWide(cross(u, a), b))); }

int sameSide(const Vec3i& u, const Vec3i& a, const Vec3i& b) {
    return sign(static_cast<Int>(dotWide(cross(u, a), cross(u, b))));
}

// Error bounds. Offsets, u × v and powers are integers below 2^53, hence exact. With e = 2^-53, the error of N is at
// most 3e relative, that of p_u v - p_v u at most 2e·cancellingTerms(), and so that of D at most 8e·(4R²N + |p_u v -
// p_v u|² + |p_u v - p_v u|·cancellingTerms()) and a term with e²; among balls of one radius, where D is made of
// products alone, without the last two. The error of the circumcentre is at most 12e·cancellingTerms()/|n|, that of the
// height follows from that of D. All bounds are at least doubled here. Radii are at most 2^20, so nothing overflows or
// underflows.
ExactBalls::ExactBalls(const Vec3&, const Neighbour& u, const Neighbour& v, double radius, double largest)
    : u_(u), v_(v), radius_(radius) {
    const Vec3 edge = u.offset - v.offset;
    const double sum = static_cast<double>(u.radius) + v.radius;
    if (dot(edge, edge) > sum * sum) return;
    const MeetingPoints points(u, v, radius);
    if (points.n_squared == 0) return;

    double d = points.d, d_error = points.d_error;
    if (d < -d_error) return;
    if (d <= d_error) {
        const Vec3i n = cross(Vec3i(u.offset), Vec3i(v.offset));
        const Int exact =
            discriminant(u.ball(), v.ball(), static_cast<std::int64_t>(radius), static_cast<Int>(dotWide(n, n)));
        if (exact < 0) return;
        d = static_cast<double>(exact);
        d_error = 2 * kRounding * d;
    }
    exist_ = true;
    const double root = std::sqrt(d), n_length = std::sqrt(points.n_squared);
    circumcentre_ = points.circumcentre(u.offset, v.offset);
    height_ = points.normal * (root / (2 * points.n_squared));
    const double centre_error = 32 * kRounding * (points.cancellingTerms(u, v) / n_length + radius) +
                                (root > 0 ? d_error / (root * n_length) : 0);
    tolerance_ = 4 * largest * centre_error + 64 * kRounding * largest * largest;
}

FloatBalls::FloatBalls(const Vec3& origin, const Neighbour& u, const Neighbour& v, double radius, double)
    : origin_(origin), radius_(radius) {
    const MeetingPoints points(u, v, radius);
    const double circumradius = std::sqrt(points.cancelling) / (2 * std::sqrt(points.n_squared));
    if (!(circumradius <= radius)) return;  // collinear triplets give infinity or NaN
    exist_ = true;
    circumcentre_ = origin + points.circumcentre(u.offset, v.offset);
    height_ = points.normal * std::sqrt((radius * radius - circumradius * circumradius) / points.n_squared);
}

}  // namespace betamesh
