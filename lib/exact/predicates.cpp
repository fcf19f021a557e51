
#include "exact/predicates.h"

#include <cassert>
#include <cmath>

namespace betamesh {

namespace {

using Int = __int128;
using Unsigned = unsigned __int128;

struct Wide {  // an unsigned integer of 256 bits
    Unsigned high, low;
};

Wide multiply(Unsigned a, Unsigned b) {
    const Unsigned mask = ~std::uint64_t{0};
    const Unsigned a0 = a & mask, a1 = a >> 64, b0 = b & mask, b1 = b >> 64;
    const Unsigned low = a0 * b0, cross0 = a1 * b0, cross1 = a0 * b1, high = a1 * b1;
    const Unsigned middle = (low >> 64) + (cross0 & mask) + (cross1 & mask);
    return {high + (cross0 >> 64) + (cross1 >> 64) + (middle >> 64), (middle << 64) | (low & mask)};
}

int compare(const Wide& a, const Wide& b) {
    if (a.high != b.high) return a.high < b.high ? -1 : 1;
    if (a.low != b.low) return a.low < b.low ? -1 : 1;
    return 0;
}

int sign(Int x) { return (x > 0) - (x < 0); }
Unsigned magnitude(Int x) { return x < 0 ? -static_cast<Unsigned>(x) : static_cast<Unsigned>(x); }

// Sums wrap modulo 2^128. The final values fit whenever the triangle has a circumradius of at most R.
Unsigned dotWide(const Vec3i& a, const Vec3i& b) {
    return static_cast<Unsigned>(Int{a.x} * b.x) + static_cast<Unsigned>(Int{a.y} * b.y) +
           static_cast<Unsigned>(Int{a.z} * b.z);
}

std::int64_t square(const Vec3i& a) { return a.x * a.x + a.y * a.y + a.z * a.z; }

// D = 4R²N - UVW, where N = |u × v|² and U, V, W are the squared sides: zero where the circumradius of the triangle is
// exactly R, negative where it is larger.
Int discriminant(const Vec3i& u, const Vec3i& v, std::int64_t radius, Int n_squared) {
    const std::int64_t diameter_squared = 4 * radius * radius;
    return Int{diameter_squared} * n_squared - Int{square(u)} * square(v) * square(u - v);
}

bool circleFits(const Vec3i& u, const Vec3i& v, std::int64_t radius) {
    const std::int64_t diameter_squared = 4 * radius * radius;
    return square(u) <= diameter_squared && square(v) <= diameter_squared && square(u - v) <= diameter_squared;
}

Vec3i toInteger(const Vec3& v) {
    return {static_cast<std::int64_t>(v.x), static_cast<std::int64_t>(v.y), static_cast<std::int64_t>(v.z)};
}

// For four cocircular points 0, u, v, w: the sign of w's power when every squared radius has an ε of its own.
int cocircularSign(const Vec3i& u, const Vec3i& v, const Vec3i& w, const Vec3i& n) {
    const Vec3i zero(0, 0, 0);
    if (before(w, zero) && before(w, u) && before(w, v)) return -1;
    // w = α·0 + β·u + γ·v; the coefficient of the lexicographically first of the three decides.
    if (before(zero, u) && before(zero, v)) return sign(static_cast<Int>(dotWide(cross(u - w, v - w), n)));
    if (before(u, v)) return sign(static_cast<Int>(dotWide(cross(w, v), n)));
    return sign(static_cast<Int>(dotWide(cross(u, w), n)));
}

}  // namespace

bool ballExists(const Vec3i& u, const Vec3i& v, std::int64_t radius) {
    if (!circleFits(u, v, radius)) return false;
    const Vec3i n = cross(u, v);
    const Int n_squared = static_cast<Int>(dotWide(n, n));
    return n_squared > 0 && discriminant(u, v, radius, n_squared) >= 0;
}

bool insideBall(const Vec3i& u, const Vec3i& v, const Vec3i& w, int side, std::int64_t radius) {
    // N (|w - c|² - R²) = A + B √D, with the centre c of the ball
    const Vec3i n = cross(u, v);
    const Int n_squared = static_cast<Int>(dotWide(n, n));
    const Int d = discriminant(u, v, radius, n_squared);
    assert(n_squared > 0 && d >= 0);
    const Unsigned term_w = static_cast<Unsigned>(n_squared) * static_cast<Unsigned>(square(w));
    const Unsigned term_u = static_cast<Unsigned>(square(u)) * dotWide(n, cross(w, v));
    const Unsigned term_v = static_cast<Unsigned>(square(v)) * dotWide(n, cross(u, w));
    const Int a = static_cast<Int>(term_w - term_u - term_v);
    const Int b = -side * static_cast<Int>(dotWide(w, n));

    const int sign_a = sign(a), sign_b = sign(b);
    if (sign_b == 0) return (sign_a != 0 ? sign_a : cocircularSign(u, v, w, n)) < 0;
    if (d == 0 && sign_a != 0) return sign_a < 0;
    if (sign_a == 0 || sign_a == sign_b) return sign_b < 0;
    const int larger =
        compare(multiply(magnitude(a), magnitude(a)), multiply(magnitude(b) * magnitude(b), static_cast<Unsigned>(d)));
    if (larger == 0) return sign_b < 0;
    return (larger > 0 ? sign_a : sign_b) < 0;
}

bool coversCircle(const Vec3i& u, const Vec3i& w) { return static_cast<Int>(dotWide(w, w - u)) < 0; }

int turn(const Vec3i& u, const Vec3i& a, const Vec3i& b) { return sign(static_cast<Int>(dotWide(cross(u, a), b))); }

int sameSide(const Vec3i& u, const Vec3i& a, const Vec3i& b) {
    return sign(static_cast<Int>(dotWide(cross(u, a), cross(u, b))));
}

namespace {

// Quantities of the triangle 0, u, v, in floating point.
struct TriangleTerms {
    double uu, vv;     // |u|², |v|²
    Vec3 normal;       // u × v
    double n_squared;  // |u × v|²
    double uvw;        // |u|² |v|² |u - v|²

    TriangleTerms(const Vec3& u, const Vec3& v)
        : uu(dot(u, u)), vv(dot(v, v)), normal(cross(u, v)), n_squared(dot(normal, normal)) {
        const Vec3 edge = u - v;
        uvw = uu * vv * dot(edge, edge);
    }
    Vec3 circumcentre(const Vec3& u, const Vec3& v) const { return cross(uu * v - vv * u, normal) / (2 * n_squared); }
    // |u|²|v| + |v|²|u|: magnitude of the terms that cancel in circumcentre().
    double cancellingTerms() const { return uu * std::sqrt(vv) + vv * std::sqrt(uu); }
};

}  // namespace

// Error bounds. u, v, u × v and squared lengths are integers below 2^53, hence exact. With e = 2^-53, the error of N is
// at most 3e relative, that of D at most 8e·(4R²N + UVW), that of the circumcentre at most 12e·cancellingTerms()/|n|;
// the error of the height follows from that of D. All bounds are at least doubled here. R is at most 2^20, so nothing
// overflows or underflows.
ExactBalls::ExactBalls(const Vec3&, const Vec3& u, const Vec3& v, double radius) : u_(u), v_(v), radius_(radius) {
    constexpr double kRounding = 0x1p-53;
    const Vec3 edge = u - v;
    if (dot(edge, edge) > 4 * radius * radius) return;
    const TriangleTerms triangle(u, v);
    if (triangle.n_squared == 0) return;

    const double four_rr_n = 4 * radius * radius * triangle.n_squared;
    double d = four_rr_n - triangle.uvw;
    double d_error = 16 * kRounding * (four_rr_n + triangle.uvw);
    if (d < -d_error) return;
    if (d <= d_error) {
        const Vec3i iu = toInteger(u), iv = toInteger(v), n = cross(iu, iv);
        const Int exact = discriminant(iu, iv, static_cast<std::int64_t>(radius), static_cast<Int>(dotWide(n, n)));
        if (exact < 0) return;
        d = static_cast<double>(exact);
        d_error = 2 * kRounding * d;
    }
    exist_ = true;
    const double root = std::sqrt(d), n_length = std::sqrt(triangle.n_squared);
    circumcentre_ = triangle.circumcentre(u, v);
    height_ = triangle.normal * (root / (2 * triangle.n_squared));
    const double centre_error = 32 * kRounding * (triangle.cancellingTerms() / n_length + radius) +
                                (root > 0 ? d_error / (root * n_length) : 0);
    tolerance_ = 4 * radius * centre_error + 64 * kRounding * radius * radius;
}

bool ExactBalls::containsExactly(int side, const Vec3& w) const {
    return insideBall(toInteger(u_), toInteger(v_), toInteger(w), side, static_cast<std::int64_t>(radius_));
}

FloatBalls::FloatBalls(const Vec3& origin, const Vec3& u, const Vec3& v, double radius)
    : origin_(origin), radius_(radius) {
    const TriangleTerms triangle(u, v);
    const double circumradius = std::sqrt(triangle.uvw) / (2 * std::sqrt(triangle.n_squared));
    if (!(circumradius <= radius)) return;  // collinear triplets give infinity or NaN
    exist_ = true;
    circumcentre_ = origin + triangle.circumcentre(u, v);
    height_ = triangle.normal * std::sqrt((radius * radius - circumradius * circumradius) / triangle.n_squared);
}

}  // namespace betamesh
