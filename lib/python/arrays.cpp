#include "python/arrays.h"

#include "base/parallel.h"
#include "betamesh/error.h"

#include <cmath>
#include <limits>
#include <optional>
#include <type_traits>

namespace betamesh {
namespace {

constexpr std::size_t kRowsPerTask = 16384;

/// An array in native byte order and aligned memory, whose numbers are of a type that withNumbers() knows.
struct Numbers {
    nb::ndarray<nb::ro> array;
    char kind = 'f';  ///< as in numpy: f floating-point, i and u whole numbers, b truth values

    std::size_t rows() const { return array.ndim() > 0 ? array.shape(0) : 0; }
    std::size_t columns() const { return array.ndim() > 1 ? array.shape(1) : 1; }
};

/// The shape of the array that a value becomes: "(4, 2)".
std::string shapeText(nb::handle value) {
    return textOf(nb::module_::import_("numpy").attr("asarray")(value).attr("shape"));
}

Numbers numbersFrom(const char* name, nb::handle value) {
    const nb::module_ numpy = nb::module_::import_("numpy");
    nb::object array = numpy.attr("asarray")(value);
    const std::string kind = nb::cast<std::string>(array.attr("dtype").attr("kind"));
    const auto bytes = nb::cast<std::size_t>(array.attr("dtype").attr("itemsize"));
    if (kind != "f" && kind != "i" && kind != "u" && kind != "b")
        throw Error(std::string(name) + " has the type " + textOf(array.attr("dtype")) +
                    ". Use real numbers, such as float32 or float64.");
    if (kind == "f" && bytes != 4 && bytes != 8)
        array = array.attr("astype")("float64");
    else if (kind == "b")
        array = array.attr("astype")("uint8");
    else if (!nb::cast<bool>(array.attr("dtype").attr("isnative")))
        array = array.attr("astype")(array.attr("dtype").attr("newbyteorder")("="));
    bool is_regular = nb::cast<bool>(array.attr("flags").attr("aligned"));  // fields of packed records are not
    for (const nb::handle stride : array.attr("strides"))
        is_regular = is_regular && nb::cast<std::int64_t>(stride) % static_cast<std::int64_t>(bytes) == 0;
    if (!is_regular) array = array.attr("copy")();
    return {nb::cast<nb::ndarray<nb::ro>>(array), kind[0]};
}

/// Calls visit(at), where at(row, column) is a number of the array in its own type.
template <typename Visit>
void withNumbers(const Numbers& numbers, const Visit& visit) {
    const nb::ndarray<nb::ro>& array = numbers.array;
    const std::int64_t row_stride = array.ndim() > 0 ? array.stride(0) : 0;
    const std::int64_t column_stride = array.ndim() > 1 ? array.stride(1) : 0;
    const auto as = [&]<typename T>(T) {
        const T* const data = static_cast<const T*>(array.data());
        visit([=](std::size_t row, std::size_t column) {
            return data[static_cast<std::int64_t>(row) * row_stride +
                        static_cast<std::int64_t>(column) * column_stride];
        });
    };
    const nb::dlpack::dtype type = array.dtype();
    if (type == nb::dtype<float>()) return as(float{});
    if (type == nb::dtype<double>()) return as(double{});
    if (type == nb::dtype<std::int8_t>()) return as(std::int8_t{});
    if (type == nb::dtype<std::int16_t>()) return as(std::int16_t{});
    if (type == nb::dtype<std::int32_t>()) return as(std::int32_t{});
    if (type == nb::dtype<std::int64_t>()) return as(std::int64_t{});
    if (type == nb::dtype<std::uint8_t>()) return as(std::uint8_t{});
    if (type == nb::dtype<std::uint16_t>()) return as(std::uint16_t{});
    if (type == nb::dtype<std::uint32_t>()) return as(std::uint32_t{});
    if (type == nb::dtype<std::uint64_t>()) return as(std::uint64_t{});
    throw Error("the type of an array is not supported. Use float32, float64 or whole numbers of up to 64 bits.");
}

bool isEmptyList(const Numbers& numbers) { return numbers.array.ndim() == 1 && numbers.rows() == 0; }

template <typename Vector>
std::vector<Vector> vectorsOfType(const char* name, nb::handle value, const Vec3& origin, bool two_columns) {
    const Numbers numbers = numbersFrom(name, value);
    if (isEmptyList(numbers)) return {};
    const bool fits = numbers.array.ndim() == 2 && (numbers.columns() == 3 || (two_columns && numbers.columns() == 2));
    if (!fits)
        throw Error(std::string(name) + " has the shape " + shapeText(value) + ". Use " +
                    (two_columns ? "(n, 2) or (n, 3)" : "(n, 3)") + ", with one row for each particle or vertex.");
    using Scalar = typename Vector::BaseType;
    std::vector<Vector> rows(numbers.rows());
    const std::size_t columns = numbers.columns();
    withNumbers(numbers, [&](const auto& at) {
        parallelFor(rows.size(), kRowsPerTask, [&](std::size_t row) {
            for (std::size_t k = 0; k < columns; ++k) {
                const auto axis = static_cast<int>(k);
                rows[row][axis] = static_cast<Scalar>(static_cast<double>(at(row, k)) - origin[axis]);
            }
            if (columns == 2) rows[row].z = 0;
        });
    });
    return rows;
}

/// The first row and column for which holds(number), if there is one.
template <typename Holds>
std::optional<std::pair<std::size_t, std::string>> firstWhere(const Numbers& numbers, const Holds& holds) {
    std::optional<std::pair<std::size_t, std::string>> found;
    withNumbers(numbers, [&](const auto& at) {
        for (std::size_t row = 0; row < numbers.rows() && !found; ++row)
            for (std::size_t column = 0; column < numbers.columns() && !found; ++column)
                if (holds(at(row, column))) found.emplace(row, std::to_string(at(row, column)));
    });
    return found;
}

template <typename T>
std::vector<T> copied(const Numbers& numbers) {
    const std::size_t columns = numbers.columns();
    std::vector<T> copy(numbers.rows() * columns);
    withNumbers(numbers, [&](const auto& at) {
        parallelFor(numbers.rows(), kRowsPerTask, [&](std::size_t row) {
            for (std::size_t k = 0; k < columns; ++k) copy[row * columns + k] = static_cast<T>(at(row, k));
        });
    });
    return copy;
}

IntegerType integerTypeOf(const Numbers& numbers) {
    const nb::dlpack::dtype type = numbers.array.dtype();
    if (type == nb::dtype<std::int8_t>()) return IntegerType::int8;
    if (type == nb::dtype<std::uint8_t>()) return IntegerType::uint8;
    if (type == nb::dtype<std::int16_t>()) return IntegerType::int16;
    if (type == nb::dtype<std::uint16_t>()) return IntegerType::uint16;
    return IntegerType::int32;
}

Attribute attributeFrom(const std::string& attribute_name, nb::handle value, std::size_t n) {
    const std::string name = "attributes['" + attribute_name + "']";
    const Numbers numbers = numbersFrom(name.c_str(), value);
    const std::size_t dimensions = numbers.array.ndim();
    if (dimensions < 1 || dimensions > 2 || numbers.rows() != n || numbers.columns() == 0)
        throw Error(name + " has the shape " + shapeText(value) + ". Use (" + std::to_string(n) + ",) or (" +
                    std::to_string(n) + ", components), with one row for each of the " + std::to_string(n) +
                    " positions.");
    Attribute attribute{attribute_name, static_cast<std::uint32_t>(numbers.columns()), {}, {}, {}};
    if (numbers.kind == 'f') {
        const auto large = firstWhere(numbers, [](auto number) {
            const auto x = static_cast<double>(number);
            return std::isfinite(x) && std::abs(x) > static_cast<double>(std::numeric_limits<float>::max());
        });
        if (large)
            throw Error(name + ": row " + std::to_string(large->first) + " is " + large->second +
                        ", which 32-bit floating-point numbers cannot hold. Choose another unit.");
        attribute.real = copied<float>(numbers);
        return attribute;
    }
    const auto large = firstWhere(numbers, [](auto number) {
        if constexpr (std::is_floating_point_v<decltype(number)>)
            return false;
        else
            return !std::in_range<std::int32_t>(number);
    });
    if (large)
        throw Error(name + ": row " + std::to_string(large->first) + " is " + large->second +
                    ", which does not fit into 32 bits. Convert the attribute to float32 if rounding is acceptable.");
    attribute.integer = copied<std::int32_t>(numbers);
    attribute.integer_type = integerTypeOf(numbers);
    return attribute;
}

template <typename T>
nb::object view(const T* data, std::size_t rows, std::size_t columns, bool is_flat, nb::handle owner) {
    const std::size_t shape[] = {rows, columns};
    return nb::cast(nb::ndarray<nb::numpy, const T>(data, is_flat ? 1 : 2, shape, owner));
}

}  // namespace

std::vector<Vec3f> vectorsFrom(const char* name, nb::handle value, const Vec3& origin, bool two_columns) {
    return vectorsOfType<Vec3f>(name, value, origin, two_columns);
}

std::vector<Vec3> doubleVectorsFrom(const char* name, nb::handle value) {
    return vectorsOfType<Vec3>(name, value, {0, 0, 0}, false);
}

bool isDouble(nb::handle value) {
    const nb::object type = nb::module_::import_("numpy").attr("asarray")(value).attr("dtype");
    return nb::cast<std::string>(type.attr("kind")) == "f" && nb::cast<std::size_t>(type.attr("itemsize")) >= 8;
}

std::vector<std::uint32_t> indicesFrom(const char* name, nb::handle value, std::size_t columns, std::size_t vertices) {
    const Numbers numbers = numbersFrom(name, value);
    if (isEmptyList(numbers)) return {};
    if (numbers.array.ndim() != 2 || numbers.columns() != columns || numbers.kind == 'f')
        throw Error(std::string(name) + " has the shape " + shapeText(value) +
                    (numbers.kind == 'f' ? " of floating-point numbers" : "") + ". Use whole numbers of shape (m, " +
                    std::to_string(columns) + "): rows of vertices.");
    const auto missing = firstWhere(numbers, [&](auto number) {
        if constexpr (std::is_floating_point_v<decltype(number)>)
            return false;
        else
            return std::cmp_less(number, 0) || !std::cmp_less(number, vertices);
    });
    if (missing)
        throw Error(std::string(name) + ": row " + std::to_string(missing->first) + " has the vertex " +
                    missing->second + ". Use numbers from 0 to " + std::to_string(vertices) + " - 1.");
    return copied<std::uint32_t>(numbers);
}

std::vector<std::uint64_t> idsFrom(const char* name, nb::handle value) {
    const Numbers numbers = numbersFrom(name, value);
    if (numbers.array.ndim() != 1 || (numbers.kind == 'f' && numbers.rows() > 0))
        throw Error(std::string(name) + " has the shape " + shapeText(value) +
                    (numbers.kind == 'f' ? " of floating-point numbers" : "") + ". Use whole numbers of shape (n,).");
    const auto negative = firstWhere(numbers, [](auto number) { return number < decltype(number){0}; });
    if (negative)
        throw Error(std::string(name) + ": row " + std::to_string(negative->first) + " is " + negative->second +
                    ". Use whole numbers from 0.");
    return copied<std::uint64_t>(numbers);
}

std::vector<Attribute> attributesFrom(nb::handle dict, std::size_t n) {
    if (dict.is_none()) return {};
    if (!nb::isinstance<nb::dict>(dict))
        throw Error("attributes is no dict. Use a dict of arrays by name, such as {\"temperature\": temperature}.");
    std::vector<Attribute> attributes;
    for (const auto& [name, value] : nb::borrow<nb::dict>(dict)) {
        if (!nb::isinstance<nb::str>(name) || nb::len(name) == 0)
            throw Error("attributes: a key is no name. Use text, such as \"temperature\".");
        attributes.push_back(attributeFrom(nb::cast<std::string>(name), value, n));
    }
    return attributes;
}

nb::object arrayOf(std::span<const Vec3f> rows, nb::handle owner) {
    return view(rows.empty() ? nullptr : &rows[0].x, rows.size(), 3, false, owner);
}

nb::object arrayOf(std::span<const float> numbers, std::size_t columns, nb::handle owner) {
    return view(numbers.data(), numbers.size() / columns, columns, columns == 1, owner);
}

nb::object arrayOf(std::span<const std::int32_t> numbers, std::size_t columns, nb::handle owner) {
    return view(numbers.data(), numbers.size() / columns, columns, columns == 1, owner);
}

nb::object arrayOf(std::span<const std::uint32_t> numbers, std::size_t columns, nb::handle owner) {
    return view(numbers.data(), numbers.size() / columns, columns, columns == 1, owner);
}

nb::object arrayOf(std::span<const std::uint64_t> numbers, nb::handle owner) {
    return view(numbers.data(), numbers.size(), 1, true, owner);
}

nb::dict dictOf(const std::vector<Attribute>& attributes, nb::handle owner) {
    nb::dict dict;
    for (const Attribute& attribute : attributes)
        dict[attribute.name.c_str()] = attribute.real.empty() && !attribute.integer.empty()
                                           ? arrayOf(attribute.integer, attribute.components, owner)
                                           : arrayOf(attribute.real, attribute.components, owner);
    return dict;
}

std::vector<Vec3f> rounded(const std::vector<Vec3>& vectors) {
    std::vector<Vec3f> copy(vectors.size());
    parallelFor(copy.size(), kRowsPerTask, [&](std::size_t i) { copy[i] = Vec3f(vectors[i]); });
    return copy;
}

std::string textOf(nb::handle value) {
    return nb::cast<std::string>(nb::module_::import_("builtins").attr("str")(value));
}

nb::tuple tupleOf(const Vec3& v) { return nb::make_tuple(v.x, v.y, v.z); }

}  // namespace betamesh
