// The numbers in the rows of a PLY file. Both encodings have the same interface.

#pragma once

#include "io/ply_header.h"

#include <bit>
#include <charconv>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>

namespace betamesh {

/// Converts a floating-point number that must be an integer; some writers store ids as floats. source: reports errors.
template <typename Source>
std::int64_t integerFrom(double value, const Source& source) {
    if (!(std::abs(value) <= 9007199254740992.0) || std::trunc(value) != value)
        source.fail(std::to_string(value) + " is not an integer of at most 2^53");
    return static_cast<std::int64_t>(value);
}

/// The numbers of a binary file, one after another.
class BinaryPlyNumbers {
public:
    BinaryPlyNumbers(Cursor& in, PlyEncoding encoding)
        : in_(in), swap_bytes_((encoding == PlyEncoding::little) != (std::endian::native == std::endian::little)) {}

    float real(PlyNumber type) {
        return withType(type, [&](auto zero) { return static_cast<float>(next<decltype(zero)>()); });
    }
    double wide(PlyNumber type) {
        return withType(type, [&](auto zero) { return static_cast<double>(next<decltype(zero)>()); });
    }
    std::int64_t integer(PlyNumber type) {
        return withType(type, [&](auto zero) {
            const auto value = next<decltype(zero)>();
            if constexpr (std::is_floating_point_v<decltype(zero)>)
                return integerFrom(double{value}, in_);
            else
                return static_cast<std::int64_t>(value);
        });
    }
    /// The last number that real() returned, before it was rounded.
    static double unrounded() { return std::numeric_limits<double>::infinity(); }
    /// The line of the last number; 0 in a binary file.
    static std::size_t line() { return 0; }
    void skip(PlyNumber type, std::uint64_t count) {
        in_.requireRows(count, sizeOf(type), "a list");
        in_.skip(count * sizeOf(type), "a list");
    }
    void requireItems(std::uint64_t count, PlyNumber type) const { in_.requireRows(count, sizeOf(type), "a list"); }

    void requireRows(const PlyElement& element) const {
        std::size_t least = 0;
        for (const PlyProperty& p : element.properties) least += sizeOf(p.is_list ? p.count_type : p.type);
        in_.requireRows(element.rows, least, element.name.c_str());
    }
    [[noreturn]] void fail(const std::string& text) const { in_.fail(text); }

    Cursor& cursor() { return in_; }
    bool swapBytes() const { return swap_bytes_; }

private:
    template <typename T>
    T next() {
        return loadNumber<T>(in_.take(sizeof(T), "a number"), swap_bytes_);
    }
    Cursor& in_;
    bool swap_bytes_;
};

/// The numbers of an ascii file, one after another.
class AsciiPlyNumbers {
public:
    /// header_lines: those before the numbers.
    AsciiPlyNumbers(Cursor& in, std::size_t header_lines) : in_(in), line_(header_lines + 1) {}

    float real(PlyNumber type) {
        if (!isReal(type)) return static_cast<float>(integer(type));
        const std::string_view word = next();
        float value = 0;
        unrounded_ = std::numeric_limits<double>::infinity();
        if (parse(word, value)) return value;
        if (!parse(word, unrounded_)) fail(inQuotes(word) + " is not a number");
        return static_cast<float>(unrounded_);  // out of the range of a float: becomes infinity or zero
    }
    /// The number in double precision.
    double wide(PlyNumber type) {
        if (!isReal(type)) return static_cast<double>(integer(type));
        const std::string_view word = next();
        double value = 0;
        if (!parse(word, value)) fail(inQuotes(word) + " is not a number");
        return value;
    }
    std::int64_t integer(PlyNumber type) {
        const std::string_view word = next();
        if (isReal(type)) {
            double value = 0;
            if (!parse(word, value)) fail(inQuotes(word) + " is not a number");
            return integerFrom(value, *this);
        }
        if (type == PlyNumber::uint64) {
            std::uint64_t value = 0;
            if (!parse(word, value)) fail(inQuotes(word) + " is not an integer from 0 to 2^64 - 1");
            return static_cast<std::int64_t>(value);
        }
        std::int64_t value = 0;
        if (!parse(word, value)) fail(inQuotes(word) + " is not an integer");
        const bool fits = withType(type, [&](auto zero) {
            using Limits = std::numeric_limits<decltype(zero)>;
            return static_cast<double>(value) >= static_cast<double>(Limits::lowest()) &&
                   static_cast<double>(value) <= static_cast<double>(Limits::max());
        });
        if (!fits) fail(inQuotes(word) + " is out of the range of " + nameOf(type));
        return value;
    }
    double unrounded() const { return unrounded_; }
    std::size_t line() const { return line_; }
    void skip(PlyNumber, std::uint64_t count) {
        for (std::uint64_t i = 0; i < count; ++i) next();
    }
    /// A number and the white space after it take at least two characters.
    void requireItems(std::uint64_t count, PlyNumber) const {
        if (count > in_.remaining() / 2 + 1)
            in_.fail("a list of " + std::to_string(count) +
                     " numbers is longer than the rest of the file, which is truncated or damaged");
    }
    void requireRows(const PlyElement& element) const {
        const std::uint64_t numbers = in_.remaining() / 2 + 1;
        if (element.rows > numbers / element.properties.size())
            in_.fail(std::to_string(element.rows) + " rows of '" + element.name +
                     "' were expected, which is more than fits in the rest of the file. It is truncated or damaged.");
    }
    [[noreturn]] void fail(const std::string& text) const {
        throw Error(in_.file() + ": line " + std::to_string(line_) + ": " + text);
    }

private:
    static bool isSpace(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

    /// The next word; valid until the next call.
    std::string_view next() {
        constexpr std::size_t kMaxLength = 4096;  // of a number
        std::size_t begin = 0;
        std::string_view text = in_.peek(kMaxLength);
        for (;;) {
            for (; begin < text.size() && isSpace(text[begin]); ++begin) line_ += text[begin] == '\n';
            if (begin < text.size()) break;
            if (text.empty()) in_.fail("the file ends where more numbers were expected. It is truncated or damaged.");
            in_.take(std::exchange(begin, 0), "white space");
            text = in_.peek(kMaxLength);
        }
        if (text.size() - begin < kMaxLength) {
            in_.take(std::exchange(begin, 0), "white space");
            text = in_.peek(kMaxLength);
        }
        std::size_t end = begin;
        while (end < text.size() && !isSpace(text[end])) ++end;
        in_.take(end, "a number");
        return text.substr(begin, end - begin);
    }
    template <typename T>
    static bool parse(std::string_view word, T& value) {
        if (word.starts_with('+')) word.remove_prefix(1);
        const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        return error == std::errc() && stop == word.data() + word.size();
    }

    Cursor& in_;
    std::size_t line_;
    double unrounded_ = 0;
};

}  // namespace betamesh
