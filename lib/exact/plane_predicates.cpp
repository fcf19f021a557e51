
#include "exact/plane_predicates.h"

#include <cmath>

namespace betamesh {

namespace {

int sign(double x) { return (x > 0) - (x < 0); }

// The sign of a²·b - c²·d for integers a, b, c, d of at most 42 bits, b and d not negative.
int compareProducts(double a, double b, double c, double d) {
    constexpr double kRounding = 0x1p-50;  // relative; more than three times the error of a product of three
    const double left = a * a * b, right = c * c * d;
    if (left > right * (1 + kRounding)) return 1;
    if (right > left * (1 + kRounding)) return -1;
    using Int = __int128;
    const auto integer = [](double x) { return static_cast<Int>(x); };
    const Int difference = integer(a) * integer(a) * integer(b) - integer(c) * integer(c) * integer(d);
    return (difference > 0) - (difference < 0);
}

}  // namespace

bool insideDisc(const Vec3& u, const Vec3& w, double radius) {
    // |w - c|² - R² = A + B √(D / |u|²), with the centre c and D = 4R² - |u|²
    const double diameter_squared = 4 * radius * radius, u_squared = dot(u, u);
    const Vec3 edge = w - u;
    if (dot(edge, edge) > diameter_squared) return false;
    const double a = dot(w, edge), b = crossZ(u, w), d = diameter_squared - u_squared;
    const int sign_a = sign(a), sign_b = sign(b);
    if (sign_b == 0) return sign_a < 0;
    if (sign_a == 0 || sign_a == sign_b) return sign_b < 0;
    return (compareProducts(a, u_squared, b, d) > 0 ? sign_a : sign_b) < 0;  // in a tie B wins, as for a larger R
}

Vec3 discCentre(const Vec3& u, double radius) {
    const double u_squared = dot(u, u), offset = std::sqrt((4 * radius * radius - u_squared) / u_squared);
    return Vec3(u.x + u.y * offset, u.y - u.x * offset, 0) / 2;
}

bool directionBefore(const Vec3& a, const Vec3& b) {
    const auto inSecondHalfTurn = [](const Vec3& p) { return p.y < 0 || (p.y == 0 && p.x < 0); };
    return inSecondHalfTurn(a) != inSecondHalfTurn(b) ? inSecondHalfTurn(b) : crossZ(a, b) > 0;
}

}  // namespace betamesh
