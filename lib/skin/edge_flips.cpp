
#include "skin/edge_flips.h"

#include <algorithm>

namespace betamesh {

namespace {

constexpr double kFromEnds = 0.1;     // shares of both diagonals between which they have to pass to count in full
constexpr double kLeastShare = 1e-4;  // of the other diagonal: with less nothing moves, and vertices may coincide

// Splits the triangle where it has an edge between a and b, whichever way; the piece that it gains goes to the end.
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
    const DualVec3 edge = at[1] - at[0], other = at[3] - at[2], apart = at[2] - at[0];
    const DualVec3 normal = cross(edge, other);
    const Dual square = dot(normal, normal);
    if (!(square.value > 0)) return std::nullopt;
    const Dual volume = dot(apart, normal), distance = squareRoot(volume * volume / square);
    const Dual u = dot(cross(apart, other), normal) / square, t = dot(cross(apart, edge), normal) / square;
    Dual share = 0.5 * smoothStep(1 - distance / farthest);
    for (const Dual& from_end : {u, 1 - u, t, 1 - t}) share = share * smoothStep(from_end / kFromEnds);
    if (!(share.value > kLeastShare)) return std::nullopt;
    return EdgeFlip{{}, {}, {(1 - share) * (1 - u), (1 - share) * u, share * (1 - t), share * t}, at[0] + edge * u};
}

void splitFlippingEdges(std::vector<EdgeFlip>& edges, std::size_t first, std::uint32_t first_vertex,
                       std::vector<Triangle>& triangles) {
    if (edges.empty()) return;
    std::stable_sort(edges.begin(), edges.end(),
                     [](const EdgeFlip& a, const EdgeFlip& b) { return a.shareOfOther() > b.shareOfOther(); });
    struct Piece {
        std::uint32_t of;  // triangle
        std::size_t row;
    };
    std::vector<Piece> pieces;
    pieces.reserve(2 * edges.size());
    for (std::uint32_t e = 0; e < edges.size(); ++e) {
        const auto& [a, b, c, d] = edges[e].corner;
        for (const std::uint32_t t : edges[e].triangle) {
            const std::size_t whole = first + t, gained = triangles.size();
            bool done = split(whole, a, b, first_vertex + e, triangles);
            for (std::size_t p = 0; p < pieces.size() && !done; ++p)
                done = pieces[p].of == t && split(pieces[p].row, a, b, first_vertex + e, triangles);
            pieces.push_back({t, gained});
        }
    }
}

}  // namespace betamesh
