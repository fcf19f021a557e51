
#include "betamesh/curves.h"

namespace betamesh {

std::vector<std::span<const Edge>> linesOf(const Curves& curves) {
    std::vector<std::span<const Edge>> lines;
    const std::span<const Edge> edges = curves.edges;
    for (std::size_t first = 0, i = 0; i < edges.size(); ++i) {
        const bool closed = edges[i][1] == edges[first][0];
        if (!closed && i + 1 < edges.size() && edges[i + 1][0] == edges[i][1]) continue;
        lines.push_back(edges.subspan(first, i + 1 - first));
        first = i + 1;
    }
    return lines;
}

}  // namespace betamesh
