// Compressed rows (CSR): a list of lists in two arrays.

#pragma once

#include "base/parallel.h"

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace betamesh {

/// Row i is item[begin[i]] … item[begin[i + 1] - 1]. begin has one more entry than there are rows.
template <typename T>
struct CompressedRows {
    std::vector<std::uint32_t> begin{0};
    std::vector<T> item;

    std::size_t size() const { return begin.size() - 1; }
    std::span<const T> operator[](std::size_t row) const {
        return {item.data() + begin[row], item.data() + begin[row + 1]};
    }
    std::span<T> operator[](std::size_t row) { return {item.data() + begin[row], item.data() + begin[row + 1]}; }
};

using IndexRows = CompressedRows<std::uint32_t>;

/// Counting sort of items into rows. forItemsOf(i, visit) calls visit(row, item) for every item that element i of
/// [0, n) contributes; items of one row keep the order of these calls.
///
/// in      forItemsOf: called twice for each i, concurrently for different i, with the same items both times
/// same    rows for any thread count
/// cost    O(n + items + rows · threads)
template <typename T, typename ForItemsOf>
CompressedRows<T> sortedIntoRows(std::size_t rows, std::size_t n, const ForItemsOf& forItemsOf) {
    std::vector<std::vector<std::uint32_t>> next(sharesOf(n));  // [share][row]: number of items, then next position
    parallelShares(n, [&](std::size_t share, std::size_t first, std::size_t last) {
        next[share].resize(rows);
        const auto count = [&](std::size_t row, const T&) { ++next[share][row]; };
        for (std::size_t i = first; i < last; ++i) forItemsOf(i, count);
    });
    CompressedRows<T> sorted;
    firstTouchResize(sorted.begin, rows + 1);
    std::uint32_t end = 0;
    for (std::size_t row = 0; row < rows; ++row) {
        sorted.begin[row] = end;
        for (std::vector<std::uint32_t>& of_share : next) end += std::exchange(of_share[row], end);
    }
    sorted.begin[rows] = end;
    firstTouchResize(sorted.item, end);
    parallelShares(n, [&](std::size_t share, std::size_t first, std::size_t last) {
        const auto put = [&](std::size_t row, const T& item) { sorted.item[next[share][row]++] = item; };
        for (std::size_t i = first; i < last; ++i) forItemsOf(i, put);
    });
    return sorted;
}

}  // namespace betamesh
