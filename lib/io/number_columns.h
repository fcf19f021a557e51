// Columns of numbers as files store them: any type, either byte order, or text.

#pragma once

#include "betamesh/particles.h"
#include "io/file_contents.h"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace betamesh {

enum class NumberType { int8, uint8, int16, uint16, int32, uint32, int64, uint64, float32, float64 };

std::size_t bytesOf(NumberType type);
inline bool isReal(NumberType type) { return type == NumberType::float32 || type == NumberType::float64; }

/// Numbers of one column before it is known what they are for: exactly one of the two is filled.
struct NumberColumn {
    std::vector<double> real;
    std::vector<std::int64_t> integer;  ///< of 64-bit types without sign the same bits

    std::size_t size() const { return std::max(real.size(), integer.size()); }
    double number(std::size_t i) const { return real.empty() ? static_cast<double>(integer[i]) : real[i]; }
};

/// Appends `count` numbers of a type from memory.
void appendNumbers(NumberType type, const std::byte* from, std::size_t count, bool other_order, NumberColumn& column);

/// The next number of some text after white space, which it steps over; none at the end or where there is no number.
/// nan and inf in any case are numbers; one beyond double precision becomes the largest of that.
std::optional<double> nextReal(std::string_view& text);
std::optional<std::int64_t> nextInteger(std::string_view& text);

/// The first number of a column that is finite, but too large for single precision.
std::optional<LostNumber> firstTooLarge(const std::string& name, std::size_t components, const NumberColumn& column);

/// Makes a column of n rows what it is for: the id that was asked for (one integer per row), else an attribute.
/// Doubles become floats.
///
/// errors  numbers that are not `components` for each of n rows
void addColumn(const std::string& name, std::size_t components, NumberColumn&& column, std::size_t n,
               const ReadOptions& options, const std::string& file, FileContents& contents);

/// Hands the points of a whole file to whoever is to have them (see deliver()); the rest is returned.
FileContents deliverWhole(FileContents&& contents, const ReadOptions& options);

/// The first three of `components` numbers of each row as positions, less an origin.
std::vector<Vec3f> positionsFrom(const NumberColumn& column, std::size_t components, const Vec3& origin);

}  // namespace betamesh
