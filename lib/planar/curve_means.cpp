
#include "planar/curve_means.h"

#include "base/cell_order.h"

#include <algorithm>

namespace betamesh {

namespace {

constexpr double kOwnWeight = 1e-9;  // of a vertex itself, in widths: where nothing near it has a length

}  // namespace

std::vector<Dual> vertexLengths(const BetaCurve& curve) {
    std::vector<Dual> edge(curve.vertex.size()), lengths(curve.vertex.size());
    forEveryVertex(curve, [&](std::uint32_t, std::uint32_t v, std::uint32_t after) {
        edge[v] = length(curve.vertex[after] - curve.vertex[v]);
    });
    forEveryVertex(curve, [&](std::uint32_t before, std::uint32_t v, std::uint32_t) {
        lengths[v] = (edge[before] + edge[v]) * 0.5;
    });
    return lengths;
}

std::vector<DualVec3> meansOf(const std::vector<DualVec3>& values, const BetaCurve& curve, double width) {
    const std::vector<Dual> lengths = vertexLengths(curve);
    std::vector<DualVec3> means(values.size());
    const double inverse_square = 1 / (width * width);
    const auto positionOf = [&](std::size_t v) -> const Vec3& { return curve.vertex[v].position; };
    const CellOrder cells(values.size(), width / 2, positionOf);
    forCellsWithin(width, cells, cells, positionOf, [&](std::uint32_t cell, std::span<const std::uint32_t> near) {
        for (const std::uint32_t v : cells.rowsOf(cell)) {
            DualVec3 sum = values[v] * (kOwnWeight * width);
            Dual total = kOwnWeight * width;
            for (const std::uint32_t u : near) {
                if (!((positionOf(u) - positionOf(v)).length2() * inverse_square < 1)) continue;
                const DualVec3 offset = curve.vertex[u] - curve.vertex[v];
                const Dual t = 1 - dot(offset, offset) * inverse_square, weight = t * t * lengths[u];
                sum = sum + values[u] * weight;
                total = total + weight;
            }
            means[v] = sum / total;
        }
    });
    return means;
}

}  // namespace betamesh
