// Products of integers of 128 bits, to compare them.

#pragma once

#include <cstdint>

namespace betamesh {

using Int = __int128;
using Unsigned = unsigned __int128;

inline int sign(Int x) { return (x > 0) - (x < 0); }
inline Unsigned magnitude(Int x) { return x < 0 ? -static_cast<Unsigned>(x) : static_cast<Unsigned>(x); }

/// An unsigned integer of 256 bits.
struct Wide {
    Unsigned high, low;
};

inline Wide multiply(Unsigned a, Unsigned b) {
    const Unsigned mask = ~std::uint64_t{0};
    const Unsigned a0 = a & mask, a1 = a >> 64, b0 = b & mask, b1 = b >> 64;
    const Unsigned low = a0 * b0, cross0 = a1 * b0, cross1 = a0 * b1, high = a1 * b1;
    const Unsigned middle = (low >> 64) + (cross0 & mask) + (cross1 & mask);
    return {high + (cross0 >> 64) + (cross1 >> 64) + (middle >> 64), (middle << 64) | (low & mask)};
}

/// The sign of a - b.
inline int compare(const Wide& a, const Wide& b) {
    if (a.high != b.high) return a.high < b.high ? -1 : 1;
    if (a.low != b.low) return a.low < b.low ? -1 : 1;
    return 0;
}

}  // namespace betamesh
