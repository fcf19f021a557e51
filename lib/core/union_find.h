// Disjoint groups of rows that are joined one pair at a time.

#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

namespace betamesh {

/// Every group is named by its smallest row.
class UnionFind {
public:
    explicit UnionFind(std::size_t n) : parent_(n), groups_(n) { std::iota(parent_.begin(), parent_.end(), 0u); }

    std::uint32_t find(std::uint32_t a) {
        while (parent_[a] != a) a = parent_[a] = parent_[parent_[a]];
        return a;
    }
    void join(std::uint32_t a, std::uint32_t b) {
        a = find(a), b = find(b);
        if (a == b) return;
        parent_[std::max(a, b)] = std::min(a, b);
        --groups_;
    }
    std::size_t groups() const { return groups_; }

private:
    std::vector<std::uint32_t> parent_;
    std::size_t groups_;
};

}  // namespace betamesh
