
#include "planar/smooth_paper.h"

namespace betamesh {

void smoothAsInPaper(BetaCurve& curve, int passes) {
    std::vector<DualVec3> middle(curve.vertex.size());
    std::vector<Dual> weight(curve.vertex.size());
    for (int pass = 0; pass < passes; ++pass) {
        forEveryVertex(curve, [&](std::uint32_t before, std::uint32_t v, std::uint32_t after) {
            if (curve.pure[v]) return;
            middle[v] = (curve.vertex[before] + curve.vertex[after]) * 0.5;
            weight[v] = length(curve.vertex[after] - curve.vertex[before]);
        });
        forEveryVertex(curve, [&](std::uint32_t before, std::uint32_t v, std::uint32_t after) {
            const Dual sum = weight[before] + weight[after];
            if (!curve.pure[v] || !(sum.value > 0)) return;
            curve.vertex[v] = (middle[before] * weight[before] + middle[after] * weight[after]) / sum;
        });
        forEveryVertex(curve, [&](std::uint32_t before, std::uint32_t v, std::uint32_t after) {
            if (!curve.pure[v]) curve.vertex[v] = (curve.vertex[before] + curve.vertex[after]) * 0.5;
        });
    }
}

void resolveIntersections(const DiscBoundary& boundary, const std::vector<DualVec3>& discs, BetaCurve& curve) {
    for (std::size_t k = 0; k < boundary.cycle.item.size(); ++k) {
        const auto [from, to] = boundary.segment[boundary.cycle.item[k]];
        DualVec3& vertex = curve.vertex[2 * k];
        const DualVec3 way = discs[to] - discs[from], offset = vertex - discs[from];
        if (crossZ(way.position, offset.position) > 0) vertex = discs[from] + way * (dot(offset, way) / dot(way, way));
    }
    forEveryVertex(curve, [&](std::uint32_t before, std::uint32_t v, std::uint32_t after) {
        if (curve.pure[v]) return;
        const DualVec3& particle = discs[boundary.segment[boundary.cycle.item[v / 2]][1]];
        const Vec3 &a = curve.vertex[before].position, &b = curve.vertex[v].position, &c = curve.vertex[after].position;
        if (crossZ(b - a, particle.position - a) < 0 || crossZ(c - b, particle.position - b) < 0)
            curve.vertex[v] = particle;
    });
}

}  // namespace betamesh
