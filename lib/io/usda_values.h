// Values of .usda files: types, numbers and matrices.

#pragma once

#include "io/number_columns.h"

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace betamesh {

/// A type of numbers, such as `point3f`: three floats.
struct UsdaType {
    NumberType number = NumberType::float32;
    std::size_t components = 1;
    std::string_view name;  ///< of one number: "float", "half", "int64"
    bool is_array = false;
};

/// nullopt: a type that is not made of numbers, such as a token.
std::optional<UsdaType> usdaType(std::string_view type);

/// The numbers of a value, row after row. None and an empty text have no numbers.
///
/// what    of the value, for messages
/// errors  a value that has another form than the type
NumberColumn usdaNumbers(std::string_view value, const UsdaType& type, const std::string& what);

/// The strings of an array such as ["a", "b"].
std::vector<std::string> usdaStrings(std::string_view value);

/// An affine map p -> p M of row vectors; the last column is not stored.
struct UsdaTransform {
    std::array<std::array<double, 3>, 4> rows{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}}};

    bool operator==(const UsdaTransform&) const = default;

    Vec3 point(const Vec3& p) const;
    Vec3 vector(const Vec3& v) const;
    /// The normal of a surface after the map, of length 1.
    Vec3 normal(const Vec3& n) const;
    double determinant() const;
    /// The map that applies this one first and then `next`.
    UsdaTransform followedBy(const UsdaTransform& next) const;
};

}  // namespace betamesh
