// The tokens of Houdini's binary JSON and the numbers that follow them.

#pragma once

#include "io/bytes.h"

#include <cmath>
#include <limits>
#include <string_view>

namespace betamesh::houdini_json {

// source  files of Houdini 13.0 to 21.0. The binary encoding is the byte 7f, the magic number, one value. A value is a
//         token and what the token says follows it. Lengths: one byte below f1, else f2, f4 or f8 and a number of two,
//         four or eight bytes. Strings that occur more than once are defined once (2b number text) and referred to.
inline constexpr std::string_view kLittleMagic = "\x7fNSJb";
inline constexpr std::string_view kBigMagic =
    "\x7f"
    "bJSN";

namespace code {
inline constexpr std::uint8_t null = 0x00, boolean = 0x10, int8 = 0x11, int16 = 0x12, int32 = 0x13, int64 = 0x14,
                              real16 = 0x18, real32 = 0x19, real64 = 0x1a, uint8 = 0x21, uint16 = 0x22,
                              reference = 0x26, text = 0x27, define = 0x2b, undefine = 0x2d, no = 0x30, yes = 0x31,
                              uniform = 0x40, array_begin = 0x5b, array_end = 0x5d, map_begin = 0x7b, map_end = 0x7d;
inline constexpr std::uint8_t length16 = 0xf2, length32 = 0xf4, length64 = 0xf8;
inline constexpr std::uint8_t first_length_code = 0xf1;
}  // namespace code

/// A number of the 16-bit floating-point type that both IEEE 754 and Houdini call half.
struct Half {
    std::uint16_t bits;
};

inline float fromHalf(Half half) {
    const int exponent = half.bits >> 10 & 0x1f;
    const auto fraction = static_cast<float>(half.bits & 0x3ff);
    float size;
    if (exponent == 0x1f)
        size = fraction == 0 ? std::numeric_limits<float>::infinity() : std::numeric_limits<float>::quiet_NaN();
    else if (exponent == 0)
        size = std::ldexp(fraction, -24);
    else
        size = std::ldexp(fraction + 1024.0F, exponent - 25);
    return half.bits & 0x8000 ? -size : size;
}

template <typename T>
T load(const std::byte* from, bool swapped) {
    if constexpr (std::is_same_v<T, Half>)
        return {loadNumber<std::uint16_t>(from, swapped)};
    else
        return loadNumber<T>(from, swapped);
}

/// Calls visit with a value of the C++ type of a number's token; false for other tokens.
template <typename Visit>
bool withNumberType(std::uint8_t type, const Visit& visit) {
    switch (type) {
        case code::int8:
            return visit(std::int8_t{}), true;
        case code::int16:
            return visit(std::int16_t{}), true;
        case code::int32:
            return visit(std::int32_t{}), true;
        case code::int64:
            return visit(std::int64_t{}), true;
        case code::uint8:
            return visit(std::uint8_t{}), true;
        case code::uint16:
            return visit(std::uint16_t{}), true;
        case code::real16:
            return visit(Half{}), true;
        case code::real32:
            return visit(float{}), true;
        case code::real64:
            return visit(double{}), true;
        default:
            return false;
    }
}

}  // namespace betamesh::houdini_json
