#include "measure/mesh_edges.h"

#include "core/parallel.h"

#include <algorithm>

namespace betamesh {

std::vector<TriangleSide> sortedSides(std::span<const Triangle> triangles) {
    std::vector<TriangleSide> sides(3 * triangles.size());
    parallelFor(triangles.size(), 4096, [&](std::size_t t) {
        for (std::size_t m = 0; m < 3; ++m) {
            const std::uint32_t a = triangles[t][m], b = triangles[t][(m + 1) % 3];
            sides[3 * t + m] = {std::min(a, b), std::max(a, b), static_cast<std::uint32_t>(3 * t + m), a < b ? 1 : -1};
        }
    });
    parallelSort(sides, [](const TriangleSide& a, const TriangleSide& b) {
        if (a.low != b.low) return a.low < b.low;
        if (a.high != b.high) return a.high < b.high;
        return a.side < b.side;
    });
    return sides;
}

}  // namespace betamesh
