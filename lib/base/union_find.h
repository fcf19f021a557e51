// Union-find: disjoint groups of rows, merged pair by pair.

#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

namespace betamesh {

/// The rows 0 … n - 1, initially each in a group of its own. The representative of a group is its smallest row.
class UnionFind {
public:
    explicit UnionFind(std::size_t n) : parent_(n), groups_(n) { std::iota(parent_.begin(), parent_.end(), 0u); }

    /// The smallest row of the group of a.
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
    /// The number of groups.
    std::size_t groups() const { return groups_; }

private:
    std::vector<std::uint32_t> parent_;
    std::size_t groups_;
};

}  // namespace betamesh
