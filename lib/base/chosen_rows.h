// Some rows of arrays and attributes, in any order.

#pragma once

#include "base/parallel.h"
#include "betamesh/particles.h"

#include <cstdint>
#include <vector>

namespace betamesh {

/// The chosen rows of an array with `components` numbers per row; none of an array that is empty.
template <typename Value>
std::vector<Value> chosenRows(const std::vector<Value>& from, const std::vector<std::uint32_t>& chosen,
                              std::size_t components = 1) {
    std::vector<Value> rows(from.empty() ? 0 : chosen.size() * components);
    parallelFor(rows.size(), 8192,
                [&](std::size_t i) { rows[i] = from[chosen[i / components] * components + i % components]; });
    return rows;
}

/// An attribute with the chosen rows of another one, and with its name and type.
inline Attribute chosenRows(const Attribute& from, const std::vector<std::uint32_t>& chosen) {
    return {from.name,
            from.components,
            chosenRows(from.real, chosen, from.components),
            chosenRows(from.integer, chosen, from.components),
            from.integer_type,
            from.hasIntegers()};
}

}  // namespace betamesh
