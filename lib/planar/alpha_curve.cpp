
#include "planar/alpha_curve.h"

#include "base/index.h"

#include <algorithm>

namespace betamesh {

Curves alphaCurves(const DiscBoundary& boundary, const std::vector<DualVec3>& discs) {
    std::vector<std::uint32_t> vertex(discs.size(), kInvalidIndex);
    for (const auto& [from, to] : boundary.segment) vertex[from] = vertex[to] = 0;
    Curves curves;
    for (std::size_t d = 0; d < discs.size(); ++d) {
        if (vertex[d] == kInvalidIndex) continue;
        vertex[d] = static_cast<std::uint32_t>(curves.position.size());
        curves.position.push_back(discs[d].position);
        curves.velocity.push_back(discs[d].velocity);
    }
    std::vector<std::uint32_t> visits(discs.size(), 0);
    for (std::size_t c = 0; c < boundary.cycle.size(); ++c) {
        const auto cycle = boundary.cycle[c];
        const auto begin = [&](std::size_t k) { return boundary.segment[cycle[k % cycle.size()]][0]; };
        for (std::size_t k = 0; k < cycle.size(); ++k) ++visits[begin(k)];
        std::size_t first =
            0;  // a line ends where it is back at its first particle: begin with one that it visits once
        while (first + 1 < cycle.size() && visits[begin(first)] > 1) ++first;
        for (std::size_t k = 0; k < cycle.size(); ++k) {
            curves.edges.push_back({vertex[begin(first + k)], vertex[begin(first + k + 1)]});
            visits[begin(k)] = 0;
        }
    }
    return curves;
}

std::size_t doubleSidedSegments(const DiscBoundary& boundary) {
    std::vector<std::array<std::uint32_t, 2>> sorted = boundary.segment;
    std::sort(sorted.begin(), sorted.end());
    return static_cast<std::size_t>(std::count_if(sorted.begin(), sorted.end(), [&](const auto& segment) {
        return std::binary_search(sorted.begin(), sorted.end(), std::array{segment[1], segment[0]});
    }));
}

}  // namespace betamesh
