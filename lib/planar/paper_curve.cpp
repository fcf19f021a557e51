
#include "planar/paper_curve.h"

namespace betamesh {

BetaCurve paperCurve(const DiscBoundary& boundary, const std::vector<DualVec3>& vertices) {
    BetaCurve curve;
    for (std::size_t c = 0; c < boundary.cycle.size(); ++c) {
        for (const std::uint32_t v : boundary.cycle[c]) {
            curve.add(vertices[v], true);
            curve.add((vertices[v] + vertices[boundary.next[v]]) * 0.5, false);
        }
        curve.endLine();
    }
    return curve;
}

}  // namespace betamesh
