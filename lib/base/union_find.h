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
        for (std::uint32_t up = parent_[a]; up != a;) {
            const std::uint32_t above = parent_[up];
            if (above == up) return up;
            parent_[a] = above;
            a = above;
            up = parent_[a];
        }
        return a;
    }
    void join(std::uint32_t a, std::uint32_t b) {
        if (parent_[a] == parent_[b]) return;
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
