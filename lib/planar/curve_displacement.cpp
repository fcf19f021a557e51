
#include "planar/curve_displacement.h"

#include "base/cell_grid.h"
#include "base/parallel.h"
#include "exact/orientation.h"
#include "planar/scaled_points.h"
#include "skin/constants.h"

#include <algorithm>
#include <cmath>

namespace betamesh {

namespace {

constexpr double kOwnWeight = 1e-9;  // widths; weight of the vertex itself, for vertices without any length nearby

// Half the length of the two edges at each vertex: the length that the vertex represents, world units.
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

}  // namespace

std::vector<DualVec3> smoothedValues(const std::vector<DualVec3>& values, const BetaCurve& curve, double width) {
    const std::vector<Dual> lengths = vertexLengths(curve);
    std::vector<DualVec3> means(values.size());
    const auto positionOf = [&](std::size_t v) -> const Vec3& { return curve.vertex[v].position; };
    forScaledNeighbours(width, values.size(), positionOf, curve.scales(),
                        [&](std::uint32_t v, std::span<const std::uint32_t> near) {
                            const Dual own = width * curve.scaleOf(v), inverse_square = 1 / (own * own);
                            DualVec3 sum = values[v] * (kOwnWeight * own.value);
                            Dual total = kOwnWeight * own.value;
                            for (const std::uint32_t u : near) {
                                if (!((positionOf(u) - positionOf(v)).length2() * inverse_square.value < 1)) continue;
                                const DualVec3 offset = curve.vertex[u] - curve.vertex[v];
                                const Dual t = 1 - dot(offset, offset) * inverse_square, weight = t * t * lengths[u];
                                sum = sum + values[u] * weight;
                                total = total + weight;
                            }
                            means[v] = sum / total;
                        });
    return means;
}

void smoothScales(BetaCurve& curve, double spacing) {
    if (curve.scale.empty()) return;
    for (int round = 0; round < kScaleMeans; ++round) {
        std::vector<DualVec3> scale(curve.scale.size());
        for (std::size_t v = 0; v < scale.size(); ++v)
            scale[v].position.x = curve.scale[v].value, scale[v].velocity.x = curve.scale[v].rate;
        const std::vector<DualVec3> mean = smoothedValues(scale, curve, kScaleKernel * spacing);
        for (std::size_t v = 0; v < scale.size(); ++v) curve.scale[v] = {mean[v].position.x, mean[v].velocity.x};
    }
}

namespace {

constexpr double kShallow = 1e-9;    // units; depth up to which a crossing is ignored
constexpr int kHalvings = 5;         // of a displacement, before it is set to zero
constexpr int kShortenedBeside = 2;  // vertices on either side of a crossing edge that are shortened with it

double distanceToLine(const Vec3& p, const Vec3& a, const Vec3& b) {
    return std::abs(crossZ(b - a, p - a)) / (b - a).length();
}

bool edgesCross(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, double shallow) {
    constexpr int kAxis = 2;
    if (std::max(a.x, b.x) < std::min(c.x, d.x) || std::max(c.x, d.x) < std::min(a.x, b.x) ||
        std::max(a.y, b.y) < std::min(c.y, d.y) || std::max(c.y, d.y) < std::min(a.y, b.y))
        return false;
    if (orientationAlong(kAxis, a, b, c) * orientationAlong(kAxis, a, b, d) >= 0 ||
        orientationAlong(kAxis, c, d, a) * orientationAlong(kAxis, c, d, b) >= 0)
        return false;
    return std::min({distanceToLine(c, a, b), distanceToLine(d, a, b), distanceToLine(a, c, d),
                     distanceToLine(b, c, d)}) > shallow;
}

// The vertices before and after each vertex.
struct CurveNeighbours {
    std::vector<std::uint32_t> before, after;

    explicit CurveNeighbours(const BetaCurve& curve) : before(curve.vertex.size()), after(curve.vertex.size()) {
        forEveryVertex(curve, [&](std::uint32_t b, std::uint32_t v, std::uint32_t a) { before[v] = b, after[v] = a; });
    }
};

// For each vertex: does the edge that begins there cross another one?
std::vector<std::uint8_t> crossingEdges(const std::vector<Vec3>& position, const CurveNeighbours& neighbours,
                                        double shallow) {
    const std::size_t n = position.size();
    std::vector<std::uint8_t> crosses(n, 0);
    double longest = 0;
    for (std::size_t v = 0; v < n; ++v)
        longest = std::max(longest, (position[neighbours.after[v]] - position[v]).length());
    if (!(longest > 0)) return crosses;
    const CellGrid cells(n, longest, [&](std::size_t v) { return position[v]; });
    parallelFor(n, 512, [&](std::size_t v) {
        const Vec3 &a = position[v], &b = position[neighbours.after[v]], middle = (a + b) / 2;
        cells.forRowsIn(middle - Vec3(1.5, 1.5, 0) * longest, middle + Vec3(1.5, 1.5, 0) * longest,
                        [&](std::uint32_t u) {
                            if (!crosses[v] && edgesCross(a, b, position[u], position[neighbours.after[u]], shallow))
                                crosses[v] = 1;
                        });
    });
    return crosses;
}

}  // namespace

void moveWithoutCrossings(BetaCurve& curve, const std::vector<DualVec3>& displacement, double unit) {
    const std::size_t n = curve.vertex.size();
    const CurveNeighbours neighbours(curve);
    std::vector<double> share(n, 1);  // of the displacement that each vertex moves
    std::vector<Vec3> position(n);
    for (int round = 0;; ++round) {
        for (std::size_t v = 0; v < n; ++v)
            position[v] = curve.vertex[v].position + displacement[v].position * share[v];
        const std::vector<std::uint8_t> crosses = crossingEdges(position, neighbours, kShallow * unit);
        std::vector<std::uint8_t> shortened(n, 0);
        for (std::uint32_t v = 0; v < n; ++v) {
            if (!crosses[v]) continue;
            std::uint32_t at = v;
            for (int k = 0; k < kShortenedBeside; ++k) at = neighbours.before[at];
            for (int k = 0; k < 2 * kShortenedBeside + 2; ++k, at = neighbours.after[at]) shortened[at] = 1;
        }
        bool any = false;
        for (std::size_t v = 0; v < n; ++v) {
            if (!shortened[v] || share[v] == 0) continue;
            share[v] = round < kHalvings ? share[v] / 2 : 0;
            any = true;
        }
        if (!any) break;
    }
    for (std::size_t v = 0; v < n; ++v) curve.vertex[v] = curve.vertex[v] + displacement[v] * share[v];
}

}  // namespace betamesh
