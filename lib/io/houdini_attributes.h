// Attributes and groups of Houdini's geometry as they are stored in its JSON.

#pragma once

#include "io/houdini_json.h"

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace betamesh {

/// A column of numbers, or only the declaration of what is no numbers or was not asked for. One of the vectors has
/// size * rows numbers; all are empty where nothing was read.
struct HoudiniAttribute {
    std::string name;
    std::string type;        ///< "numeric", "string", …
    std::string storage;     ///< of numbers: "fpreal16", "fpreal32", "fpreal64", "int8", "int16", "int32", "int64", …
    std::uint32_t size = 0;  ///< numbers in a row
    std::vector<float> real;              ///< of the fpreal storages; fpreal64 is rounded
    std::vector<double> real64;           ///< of fpreal64, for the position `P` alone
    std::vector<std::int32_t> integer;    ///< of integers up to 32 bits
    std::vector<std::int64_t> integer64;  ///< of int64

    bool isReal() const { return storage.starts_with("fpreal"); }
    bool isInteger() const;
};

/// Reads the next value as an attribute.
///
/// in      rows: of the points or primitives that it belongs to; isWanted(attribute): asked when all but the numbers
///         is known
/// errors  a number of rows other than expected; damage, with the byte
HoudiniAttribute readHoudiniAttribute(HoudiniJsonReader& json, std::uint64_t rows,
                                      const std::function<bool(const HoudiniAttribute&)>& isWanted);

/// The members of a group among n points or primitives.
struct HoudiniGroup {
    std::string name;
    std::vector<std::int32_t> member;  ///< n rows: 1 or 0
};

/// Reads the next value as a group.
HoudiniGroup readHoudiniGroup(HoudiniJsonReader& json, std::uint64_t n);

/// Appends numbers to those of a column that will have `all` numbers. The capacity grows with what has arrived: `all`
/// may be damaged.
template <typename T>
void appendToColumn(std::span<const T> more, std::uint64_t all, std::vector<T>& column) {
    const std::size_t needed = column.size() + more.size();
    if (column.capacity() < needed)
        column.reserve(static_cast<std::size_t>(
            std::max<std::uint64_t>(needed, std::min<std::uint64_t>(all, 2 * std::uint64_t{needed}))));
    column.insert(column.end(), more.begin(), more.end());
}

}  // namespace betamesh
