#include "skin/edge_flips.h"

#include "skin/constants.h"

#include <algorithm>
#include <utility>

namespace betamesh {

namespace {

// Sets the weights, with the other diagonal's growing from 0 at the remoteness `first`. share: of the way along the
// edge and along the other diagonal at which they pass each other.
void setWeights(const std::array<Dual, 2>& share, Dual first, EdgeFlip& edge) {
    const Dual other = 0.5 * smoothStep(1 - edge.remoteness / first);
    edge.weight = {(1 - other) * (1 - share[0]), (1 - other) * share[0], other * (1 - share[1]), other * share[1]};
}

// Splits a triangle at `vertex` on its edge between a and b; the second part is appended.
void split(std::size_t row, std::uint32_t a, std::uint32_t b, std::uint32_t vertex, std::vector<Triangle>& triangles) {
    const Triangle t = triangles[row];
    for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t from = t[k], to = t[(k + 1) % 3], apex = t[(k + 2) % 3];
        if (std::minmax(from, to) != std::minmax(a, b)) continue;
        triangles[row] = {from, vertex, apex};
        triangles.push_back({vertex, to, apex});
        return;
    }
}

}  // namespace

std::optional<EdgeFlip> edgeFlip(const std::array<DualVec3, 4>& at, double farthest) {
    const DualVec3 edge = at[1] - at[0], other = at[3] - at[2], between = at[2] - at[0];
    const DualVec3 normal = cross(edge, other);
    const Dual square = dot(normal, normal);
    if (!(square.value > 0)) return std::nullopt;
    const Dual volume = dot(between, normal), distance = squareRoot(volume * volume / square);
    const Dual u = dot(cross(between, other), normal) / square, t = dot(cross(between, edge), normal) / square;
    Dual nearness = 1 - distance / farthest;
    for (const Dual& from_end : {u, 1 - u, t, 1 - t}) nearness = nearness * smoothStep(from_end / kFlipEndMargin);
    if (!(nearness.value > 0)) return std::nullopt;
    EdgeFlip flip{{}, {}, {}, at[0] + edge * u, 1 - nearness};
    setWeights({u, t}, 1, flip);
    if (!(flip.otherWeight() > kMinFlipWeight)) return std::nullopt;
    return flip;
}

void keepNearestFlips(std::vector<EdgeFlip>& edges) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> flip_at;  // a triangle, and a flip that it is part of
    for (std::uint32_t e = 0; e < edges.size(); ++e)
        for (const std::uint32_t triangle : edges[e].triangle) flip_at.emplace_back(triangle, e);
    std::sort(flip_at.begin(), flip_at.end());
    std::vector<Dual> least(edges.size(), 1);  // remoteness of other flips
    for (std::size_t first = 0, last = 0; first < flip_at.size(); first = last) {
        while (last < flip_at.size() && flip_at[last].first == flip_at[first].first) ++last;
        for (std::size_t i = first; i < last; ++i)
            for (std::size_t k = first; k < last; ++k) {
                const Dual& other = edges[flip_at[k].second].remoteness;
                Dual& least_here = least[flip_at[i].second];
                if (i != k && other.value < least_here.value) least_here = other;
            }
    }
    std::size_t kept = 0;
    for (std::size_t e = 0; e < edges.size(); ++e) {
        EdgeFlip& edge = edges[e];
        if (!(edge.remoteness.value < least[e].value)) continue;
        const Dual of_edge = edge.weight[0] + edge.weight[1], of_other = edge.weight[2] + edge.weight[3];
        setWeights({edge.weight[1] / of_edge, edge.weight[3] / of_other}, least[e], edge);
        if (edge.otherWeight() > kMinFlipWeight) edges[kept++] = edge;
    }
    edges.resize(kept);
}

void splitFlippingEdges(const std::vector<EdgeFlip>& edges, std::size_t first, std::uint32_t first_vertex,
                        std::vector<Triangle>& triangles) {
    for (std::uint32_t e = 0; e < edges.size(); ++e)
        for (const std::uint32_t t : edges[e].triangle)
            split(first + t, edges[e].corner[0], edges[e].corner[1], first_vertex + e, triangles);
}

}  // namespace betamesh
