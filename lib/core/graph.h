// Compressed rows: a list of lists in two arrays.

#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace betamesh {

/// Row i is item[begin[i]] … item[begin[i + 1] - 1]. begin has one more entry than there are rows.
struct Rows {
    std::vector<std::uint32_t> begin{0};
    std::vector<std::uint32_t> item;

    std::size_t size() const { return begin.size() - 1; }
    std::span<const std::uint32_t> operator[](std::size_t row) const {
        return {item.data() + begin[row], item.data() + begin[row + 1]};
    }
};

}  // namespace betamesh
