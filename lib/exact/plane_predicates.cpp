
#include "exact/plane_predicates.h"

#include "exact/wide.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace betamesh {

namespace {

int signOf(double x) { return (x > 0) - (x < 0); }

std::int64_t dotXY(const Vec3i& a, const Vec3i& b) { return a.x * b.x + a.y * b.y; }

std::int64_t powerXY(const OffsetBall& u, std::int64_t radius) {
    return dotXY(u.centre, u.centre) + (radius * radius - u.radius * u.radius);
}

// D = 4R²|u|² - p_u²: four times |u|² times the squared distance of the points where the circles meet from the line of
// the centres. Where they meet, |p_u| <= 2R|u|, so both terms are at most 2^84.
Int discriminant(const OffsetBall& u, std::int64_t radius) {
    const Int p = powerXY(u, radius), diameter_squared = Int{4} * radius * radius;
    return diameter_squared * dotXY(u.centre, u.centre) - p * p;
}

// The sign of a²·b - c²·d for integers a, b, c, d of at most 42 bits, b and d not negative.
int compareProducts(double a, double b, double c, double d) {
    constexpr double kRounding = 0x1p-50;  // relative; more than three times the error of a product of three
    const double left = a * a * b, right = c * c * d;
    if (left > right * (1 + kRounding)) return 1;
    if (right > left * (1 + kRounding)) return -1;
    const auto integer = [](double x) { return static_cast<Int>(x); };
    const Int difference = integer(a) * integer(a) * integer(b) - integer(c) * integer(c) * integer(d);
    return sign(difference);
}

}  // namespace

bool insideDisc(const Vec3& u, const Vec3& w, double radius) {
    // |w - c|² - R² = A + B √(D / |u|²), with the centre c and D = 4R² - |u|²
    const double diameter_squared = 4 * radius * radius, u_squared = dot(u, u);
    const Vec3 edge = w - u;
    if (dot(edge, edge) > diameter_squared) return false;
    const double a = dot(w, edge), b = crossZ(u, w), d = diameter_squared - u_squared;
    const int sign_a = signOf(a), sign_b = signOf(b);
    if (sign_b == 0) return sign_a < 0;
    if (sign_a == 0 || sign_a == sign_b) return sign_b < 0;
    return (compareProducts(a, u_squared, b, d) > 0 ? sign_a : sign_b) < 0;  // in a tie B wins, as for a larger R
}

Vec3 discCentre(const Vec3& u, double radius) {
    const double u_squared = dot(u, u), offset = std::sqrt((4 * radius * radius - u_squared) / u_squared);
    return Vec3(u.x + u.y * offset, u.y - u.x * offset, 0) / 2;
}

bool insideDisc(const OffsetBall& u, const OffsetBall& w, std::int64_t radius) {
    assert(std::max({radius, u.radius, w.radius}) <= 1 << 20);
    assert(spheresMeet(u, radius) && spheresMeet(w, radius));
    // |u|² times the power of the point is A + B √D. With |u|, |w| <= 2^21 and |p| <= 2^42, |A| <= 2^85, |B| <= 2^42.
    const std::int64_t uu = dotXY(u.centre, u.centre), along = dotXY(u.centre, w.centre);
    const Int a = Int{uu} * powerXY(w, radius) - Int{along} * powerXY(u, radius), d = discriminant(u, radius);
    const Int b = u.centre.x * w.centre.y - u.centre.y * w.centre.x;
    assert(d >= 0);
    const int sign_a = sign(a), sign_b = sign(b);
    if (sign_b == 0) return sign_a != 0 ? sign_a < 0 : along < 0 || along > uu;
    if (d == 0 && sign_a != 0) return sign_a < 0;
    if (sign_a == 0 || sign_a == sign_b) return sign_b < 0;
    const int larger =
        compare(multiply(magnitude(a), magnitude(a)), multiply(magnitude(b * b), static_cast<Unsigned>(d)));
    return (larger > 0 ? sign_a : sign_b) < 0;  // in a tie B wins, as for larger radii
}

// Error bounds. Offsets, |u|² and powers are integers below 2^53, hence exact, and D is rounded once. With e = 2^-53
// both summands of the point have an error of at most 6e relative, and are together at most 2R long. Then |w| <= R +
// R_max and |p_w| <= 2R|w| bound that of a power. All bounds are at least doubled here.
CircleIntersection::CircleIntersection(const Neighbour& u, double radius, double largest) : u_(u), radius_(radius) {
    constexpr double kRounding = 0x1p-53;
    const auto d = static_cast<double>(discriminant(u.ball(), static_cast<std::int64_t>(radius)));
    const double root = std::sqrt(d), twice = 2 * u.squaredDistance();
    position_ =
        Vec3((u.power * u.offset.x + root * u.offset.y) / twice, (u.power * u.offset.y - root * u.offset.x) / twice, 0);
    tolerance_ = 96 * kRounding * radius * (radius + largest);
}

bool directionBefore(const Vec3& a, const Vec3& b) {
    const auto inSecondHalfTurn = [](const Vec3& p) { return p.y < 0 || (p.y == 0 && p.x < 0); };
    return inSecondHalfTurn(a) != inSecondHalfTurn(b) ? inSecondHalfTurn(b) : crossZ(a, b) > 0;
}

}  // namespace betamesh
