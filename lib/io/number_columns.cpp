#include "io/number_columns.h"

#include "base/parallel.h"
#include "betamesh/error.h"
#include "io/bytes.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

namespace betamesh {

namespace {

template <typename T, typename Number>
void append(const std::byte* from, std::size_t count, bool other_order, std::vector<Number>& numbers) {
    numbers.reserve(numbers.size() + count);
    for (std::size_t i = 0; i < count; ++i)
        numbers.push_back(static_cast<Number>(loadNumber<T>(from + i * sizeof(T), other_order)));
}

void skipSpace(std::string_view& text) {
    text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n\f\v"), text.size()));
}

template <typename Number>
std::optional<Number> next(std::string_view& text) {
    skipSpace(text);
    std::string_view digits = text;
    if (digits.starts_with('+')) digits.remove_prefix(1);
    Number number{};
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    if (error == std::errc::invalid_argument) return std::nullopt;
    if (error == std::errc::result_out_of_range) {
        if constexpr (std::is_integral_v<Number>) return std::nullopt;
        number =
            static_cast<Number>(std::clamp(std::strtod(std::string(digits.data(), end).c_str(), nullptr),
                                           std::numeric_limits<double>::lowest(), std::numeric_limits<double>::max()));
    }
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    return number;
}

}  // namespace

std::size_t bytesOf(NumberType type) {
    switch (type) {
        case NumberType::int8:
        case NumberType::uint8:
            return 1;
        case NumberType::int16:
        case NumberType::uint16:
            return 2;
        case NumberType::int32:
        case NumberType::uint32:
        case NumberType::float32:
            return 4;
        default:
            return 8;
    }
}

void appendNumbers(NumberType type, const std::byte* from, std::size_t count, bool other_order, NumberColumn& column) {
    switch (type) {
        case NumberType::int8:
            return append<std::int8_t>(from, count, other_order, column.integer);
        case NumberType::uint8:
            return append<std::uint8_t>(from, count, other_order, column.integer);
        case NumberType::int16:
            return append<std::int16_t>(from, count, other_order, column.integer);
        case NumberType::uint16:
            return append<std::uint16_t>(from, count, other_order, column.integer);
        case NumberType::int32:
            return append<std::int32_t>(from, count, other_order, column.integer);
        case NumberType::uint32:
            return append<std::uint32_t>(from, count, other_order, column.integer);
        case NumberType::int64:
            return append<std::int64_t>(from, count, other_order, column.integer);
        case NumberType::uint64:
            return append<std::uint64_t>(from, count, other_order, column.integer);
        case NumberType::float32:
            return append<float>(from, count, other_order, column.real);
        case NumberType::float64:
            return append<double>(from, count, other_order, column.real);
    }
}

std::optional<double> nextReal(std::string_view& text) { return next<double>(text); }

std::optional<std::int64_t> nextInteger(std::string_view& text) { return next<std::int64_t>(text); }

std::optional<LostNumber> firstTooLarge(const std::string& name, std::size_t components, const NumberColumn& column) {
    const std::size_t i = firstIndexWhere(column.real.size(), [&](std::size_t k) {
        return !std::isfinite(static_cast<float>(column.real[k])) && std::isfinite(column.real[k]);
    });
    if (i == column.real.size()) return std::nullopt;
    return LostNumber{name, i / components, column.real[i]};
}

void addColumn(const std::string& name, std::size_t components, NumberColumn&& column, std::size_t n,
               const ReadOptions& options, const std::string& file, FileContents& contents) {
    if (components == 0 || column.size() != n * components)
        throw Error(file + ": array '" + name + "' has " + std::to_string(column.size()) + " numbers, expected " +
                    std::to_string(components) + " for each of " + std::to_string(n) + " points");
    if (!options.id.empty() && name == options.id && components == 1 && column.real.empty()) {
        contents.id.assign(column.integer.begin(), column.integer.end());
        return;
    }
    if (!options.attributes || n == 0) return;
    const auto width = static_cast<std::uint32_t>(components);
    if (column.real.empty()) {
        contents.attributes.push_back(integerAttribute(name, width, std::move(column.integer)));
        return;
    }
    Attribute a{name, width, {}, {}};
    a.real.assign(column.real.begin(), column.real.end());
    if (auto lost = firstTooLarge(name, components, column)) contents.lost_numbers.push_back(std::move(*lost));
    contents.attributes.push_back(std::move(a));
}

FileContents deliverWhole(FileContents&& contents, const ReadOptions& options) {
    FileContents points, rest = std::move(contents);
    points.has_double_positions = rest.has_double_positions;
    std::swap(points.position, rest.position);
    std::swap(points.id, rest.id);
    std::swap(points.attributes, rest.attributes);
    std::swap(points.lost_numbers, rest.lost_numbers);
    rest.begun = false;
    const std::uint64_t all = points.position.size();
    deliver(std::move(points), all, options, rest);
    return rest;
}

std::vector<Vec3f> positionsFrom(const NumberColumn& column, std::size_t components, const Vec3& origin) {
    std::vector<Vec3f> positions;
    firstTouchResize(positions, column.size() / components);
    parallelFor(positions.size(), 8192, [&](std::size_t i) {
        for (std::size_t k = 0; k < 3; ++k)
            positions[i][static_cast<int>(k)] =
                static_cast<float>(column.number(components * i + k) - origin[static_cast<int>(k)]);
    });
    return positions;
}

}  // namespace betamesh
