// Header of a PLY file: its elements and their properties.

#pragma once

#include "io/bytes.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace betamesh {

/// Number types of the format.
enum class PlyNumber { int8, uint8, int16, uint16, int32, uint32, int64, uint64, float32, float64 };

/// A property of an element: a scalar or a list per row.
struct PlyProperty {
    std::string name;
    PlyNumber type = PlyNumber::float32;
    bool is_list = false;
    PlyNumber count_type = PlyNumber::uint8;  ///< of a list's length
};

struct PlyElement {
    std::string name;
    std::uint64_t rows = 0;
    std::vector<PlyProperty> properties;
};

enum class PlyEncoding { ascii, little, big };

struct PlyHeader {
    PlyEncoding encoding = PlyEncoding::ascii;
    std::vector<PlyElement> elements;
    std::size_t lines = 0;
};

/// Reads the header, up to and including its last line.
///
/// errors  a damaged header or one longer than 1 MiB, with the line
PlyHeader readPlyHeader(Cursor& in);

inline bool isReal(PlyNumber type) { return type == PlyNumber::float32 || type == PlyNumber::float64; }

/// Name of a type in header and messages: "char", "float" …
std::string nameOf(PlyNumber type);

/// Calls visit with a zero of the corresponding C++ type.
template <typename Visit>
auto withType(PlyNumber type, const Visit& visit) {
    switch (type) {
        case PlyNumber::int8:
            return visit(std::int8_t{});
        case PlyNumber::uint8:
            return visit(std::uint8_t{});
        case PlyNumber::int16:
            return visit(std::int16_t{});
        case PlyNumber::uint16:
            return visit(std::uint16_t{});
        case PlyNumber::int32:
            return visit(std::int32_t{});
        case PlyNumber::uint32:
            return visit(std::uint32_t{});
        case PlyNumber::int64:
            return visit(std::int64_t{});
        case PlyNumber::uint64:
            return visit(std::uint64_t{});
        case PlyNumber::float32:
            return visit(float{});
        case PlyNumber::float64:
            break;
    }
    return visit(double{});
}

inline std::size_t sizeOf(PlyNumber type) {
    return withType(type, [](auto zero) { return sizeof(zero); });
}

/// Text from the file in quotation marks, for messages: shortened, and without characters that cannot be printed.
std::string inQuotes(std::string_view text);

}  // namespace betamesh
