// The wrapper of Boost.Multiprecision.

#include "exact/orientation.h"

#include <algorithm>
#include <array>
#include <bit>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <limits>

namespace betamesh {

namespace {

// Integers of fixed width, which need no allocation. Doubles are multiples of 2^-1074, so differences of coordinates
// below kLargestCoordinate have at most 200 + 1074 + 1 bits; Widest holds the product of three of them.
template <unsigned bits>
using Fixed = boost::multiprecision::number<
    boost::multiprecision::cpp_int_backend<bits, bits, boost::multiprecision::signed_magnitude,
                                           boost::multiprecision::unchecked, void>,
    boost::multiprecision::et_off>;
using Usual = Fixed<512>;
using Widest = Fixed<4096>;

// Error bounds, with u = 2^-53. Each difference, product and sum has a relative error of at most u. A term of three
// factors accumulates at most eight such errors, a term of two factors five; (1 + u)^8 - 1 < 9u, relative to the sum of
// the terms' magnitudes, which has itself a relative error of at most that size. Underflow adds less than 2^-800,
// because no value exceeds 2^202.
constexpr double kErrorOfThree = 16 * 0x1p-53, kErrorOfTwo = 10 * 0x1p-53, kUnderflow = 0x1p-800;

int sign(double x) { return (x > 0) - (x < 0); }

int bitWidth(std::uint64_t x) { return 64 - std::countl_zero(x); }

// A double as an integer times a power of two.
struct Dyadic {
    std::int64_t number = 0;  // odd, or zero
    int exponent = 0;

    explicit Dyadic(double x) {
        const auto bits = std::bit_cast<std::uint64_t>(x);
        const int biased = static_cast<int>(bits >> 52 & 0x7ff);
        const std::uint64_t mantissa = (bits & ((std::uint64_t{1} << 52) - 1)) | std::uint64_t{biased != 0} << 52;
        if (mantissa == 0) return;
        const int zeros = std::countr_zero(mantissa);
        number = static_cast<std::int64_t>(mantissa >> zeros);
        if (x < 0) number = -number;
        exponent = std::max(biased, 1) - 1075 + zeros;
    }
    int end() const { return exponent + bitWidth(static_cast<std::uint64_t>(std::abs(number))); }
};

// Differences between n coordinates of one axis and the last coordinate, as integers. The axis has a unit of its own, a
// power of two, which does not change the sign of a determinant.
template <std::size_t n>
class Axis {
public:
    template <typename... Coordinate>
    explicit Axis(Coordinate... x) : x_{Dyadic(x)...} {
        int highest = std::numeric_limits<int>::min();
        for (const Dyadic& x_i : x_) {
            if (x_i.number == 0) continue;
            lowest_ = std::min(lowest_, x_i.exponent);
            highest = std::max(highest, x_i.end());
        }
        bits_ = highest < lowest_ ? 1 : highest - lowest_ + 1;
        if (bits_ > 127) return;
        unsigned __int128 magnitudes = 0;
        for (std::size_t i = 0; i < n; ++i) {
            difference_[i] = at<__int128>(i) - at<__int128>(n);
            magnitudes |= static_cast<unsigned __int128>(difference_[i] < 0 ? -difference_[i] : difference_[i]);
        }
        const auto high = static_cast<std::uint64_t>(magnitudes >> 64), low = static_cast<std::uint64_t>(magnitudes);
        bits_ = high != 0 ? 64 + bitWidth(high) : bitWidth(low);
    }
    /// Bits of the largest difference, without its sign. Exact up to 127, an upper bound above.
    int bits() const { return bits_; }
    template <typename Number>
    Number difference(std::size_t i) const {
        if (bits_ <= 127) return Number(difference_[i]);
        return at<Number>(i) - at<Number>(n);
    }

private:
    template <typename Number>
    Number at(std::size_t i) const {
        if (x_[i].number == 0) return 0;
        return Number(x_[i].number) * (Number(1) << (x_[i].exponent - lowest_));
    }
    std::array<Dyadic, n + 1> x_;
    std::array<__int128, n> difference_{};
    int lowest_ = std::numeric_limits<int>::max(), bits_ = 0;
};

template <typename Number>
int signOf(const Number& x) {
    return (x > 0) - (x < 0);
}

template <typename Number>
int determinantSign(const Axis<3>& x, const Axis<3>& y, const Axis<3>& z) {
    std::array<Number, 3> a, b, c;
    for (std::size_t i = 0; i < 3; ++i) {
        a[i] = x.difference<Number>(i);
        b[i] = y.difference<Number>(i);
        c[i] = z.difference<Number>(i);
    }
    const Number determinant = a[0] * Number(b[1] * c[2] - b[2] * c[1]) + a[1] * Number(b[2] * c[0] - b[0] * c[2]) +
                               a[2] * Number(b[0] * c[1] - b[1] * c[0]);
    return signOf(determinant);
}

template <typename Number>
int determinantSign(const Axis<2>& x, const Axis<2>& y) {
    const Number determinant =
        x.difference<Number>(0) * y.difference<Number>(1) - x.difference<Number>(1) * y.difference<Number>(0);
    return signOf(determinant);
}

// For differences of at most 62 bits: the minors fit 128 bits; their products with differences are summed in two parts,
// the bits below 2^64 and those above.
int determinantSignIn192Bits(const Axis<3>& x, const Axis<3>& y, const Axis<3>& z) {
    __int128 high = 0;
    unsigned __int128 low = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
        const __int128 minor = y.difference<__int128>(j) * z.difference<__int128>(k) -
                               y.difference<__int128>(k) * z.difference<__int128>(j);
        const __int128 factor = x.difference<__int128>(i);
        const __int128 below = static_cast<__int128>(static_cast<std::uint64_t>(minor)) * factor;
        high += (minor >> 64) * factor + (below >> 64);
        low += static_cast<std::uint64_t>(below);
    }
    high += static_cast<__int128>(low >> 64);
    return high != 0 ? signOf(high) : static_cast<std::uint64_t>(low) != 0;
}

bool fits192Bits(const Axis<3>& x, const Axis<3>& y, const Axis<3>& z) {
    return x.bits() <= 62 && y.bits() <= 62 && z.bits() <= 62;
}

// Uses the narrowest integers that hold the sum of six products of one difference per axis.
template <typename... Axes>
int exactSign(const Axes&... axes) {
    if (((axes.bits() == 0) || ...)) return 0;
    const int bits = (axes.bits() + ...) + 3;
    if (bits <= 127) return determinantSign<__int128>(axes...);
    if constexpr (sizeof...(axes) == 3)
        if (fits192Bits(axes...)) return determinantSignIn192Bits(axes...);
    return bits <= 512 ? determinantSign<Usual>(axes...) : determinantSign<Widest>(axes...);
}

}  // namespace

int sideOfPlane(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p) {
    const Vec3 u = a - p, v = b - p, w = c - p;
    const double yz = v.y * w.z, zy = v.z * w.y, zx = v.z * w.x, xz = v.x * w.z, xy = v.x * w.y, yx = v.y * w.x;
    const double determinant = u.x * (yz - zy) + u.y * (zx - xz) + u.z * (xy - yx);
    const double terms = std::abs(u.x) * (std::abs(yz) + std::abs(zy)) + std::abs(u.y) * (std::abs(zx) + std::abs(xz)) +
                         std::abs(u.z) * (std::abs(xy) + std::abs(yx));
    if (std::abs(determinant) > kErrorOfThree * terms + kUnderflow) return -sign(determinant);
    return -exactSign(Axis<3>(a.x, b.x, c.x, p.x), Axis<3>(a.y, b.y, c.y, p.y), Axis<3>(a.z, b.z, c.z, p.z));
}

int turnAlong(int axis, const Vec3& a, const Vec3& b, const Vec3& c) {
    const int k = (axis + 1) % 3, m = (axis + 2) % 3;
    const double left = (a[k] - c[k]) * (b[m] - c[m]), right = (a[m] - c[m]) * (b[k] - c[k]);
    const double determinant = left - right;
    if (std::abs(determinant) > kErrorOfTwo * (std::abs(left) + std::abs(right)) + kUnderflow) return sign(determinant);
    return exactSign(Axis<2>(a[k], b[k], c[k]), Axis<2>(a[m], b[m], c[m]));
}

}  // namespace betamesh
