#include "skin/edge_flips.h"

#include "skin/constants.h"

#include <algorithm>

namespace betamesh {

namespace {

// Splits a triangle at `vertex` if it has an edge between a and b, in either direction; the second part is appended.
bool split(std::size_t row, std::uint32_t a, std::uint32_t b, std::uint32_t vertex, std::vector<Triangle>& triangles) {
    const Triangle t = triangles[row];
    for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t from = t[k], to = t[(k + 1) % 3], apex = t[(k + 2) % 3];
        if (std::minmax(from, to) != std::minmax(a, b)) continue;
        triangles[row] = {from, vertex, apex};
        triangles.push_back({vertex, to, apex});
        return true;
    }
    return false;
}

}  // namespace

std::optional<EdgeFlip> edgeFlip(const std::array<DualVec3, 4>& at, double farthest) {
    const DualVec3 edge = at[1] - at[0], other = at[3] - at[2], between = at[2] - at[0];
    const DualVec3 normal = cross(edge, other);
    const Dual square = dot(normal, normal);
    if (!(square.value > 0)) return std::nullopt;
    const Dual volume = dot(between, normal), distance = squareRoot(volume * volume / square);
    const Dual u = dot(cross(between, other), normal) / square, t = dot(cross(between, edge), normal) / square;
    Dual other_weight = 0.5 * smoothStep(1 - distance / farthest);
    for (const Dual& from_end : {u, 1 - u, t, 1 - t})
        other_weight = other_weight * smoothStep(from_end / kFlipEndMargin);
    if (!(other_weight.value > kMinFlipWeight)) return std::nullopt;
    return EdgeFlip{{},
                    {},
                    {(1 - other_weight) * (1 - u), (1 - other_weight) * u, other_weight * (1 - t), other_weight * t},
                    at[0] + edge * u};
}

void splitFlippingEdges(std::vector<EdgeFlip>& edges, std::size_t first, std::uint32_t first_vertex,
                        std::vector<Triangle>& triangles) {
    if (edges.empty()) return;
    std::stable_sort(edges.begin(), edges.end(),
                     [](const EdgeFlip& a, const EdgeFlip& b) { return a.otherWeight() > b.otherWeight(); });
    struct SplitTriangle {
        std::uint32_t original;
        std::size_t row;
    };
    std::vector<SplitTriangle> split_triangles;
    split_triangles.reserve(2 * edges.size());
    for (std::uint32_t e = 0; e < edges.size(); ++e) {
        const auto& [a, b, c, d] = edges[e].corner;
        for (const std::uint32_t t : edges[e].triangle) {
            const std::size_t whole = first + t, added = triangles.size();
            bool done = split(whole, a, b, first_vertex + e, triangles);
            for (std::size_t p = 0; p < split_triangles.size() && !done; ++p)
                done = split_triangles[p].original == t &&
                       split(split_triangles[p].row, a, b, first_vertex + e, triangles);
            split_triangles.push_back({t, added});
        }
    }
}

}  // namespace betamesh
