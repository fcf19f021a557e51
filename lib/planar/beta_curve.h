// The beta mesh of a plane on its way: closed lines of vertices that move.

#pragma once

#include "base/dual.h"

#include <cstdint>
#include <vector>

namespace betamesh {

/// Vertices of one line stand together, in order, the liquid on their left; the last is joined to the first.
struct BetaCurve {
    std::vector<DualVec3> vertex;
    std::vector<std::uint8_t> pure;       ///< of each vertex: 1 where two circles meet, 0 on an arc between them
    std::vector<std::uint32_t> begin{0};  ///< first vertex of each line, and one entry past the last

    std::size_t lines() const { return begin.size() - 1; }
    void add(const DualVec3& point, bool is_pure) {
        vertex.push_back(point);
        pure.push_back(is_pure);
    }
    void endLine() { begin.push_back(static_cast<std::uint32_t>(vertex.size())); }
};

/// Calls visit(vertex before, vertex, vertex after) for every vertex of every line.
template <typename Visit>
void forEveryVertex(const BetaCurve& curve, const Visit& visit) {
    for (std::size_t l = 0; l < curve.lines(); ++l) {
        const std::uint32_t first = curve.begin[l], last = curve.begin[l + 1] - 1;
        for (std::uint32_t v = first; v <= last; ++v) visit(v == first ? last : v - 1, v, v == last ? first : v + 1);
    }
}

}  // namespace betamesh
