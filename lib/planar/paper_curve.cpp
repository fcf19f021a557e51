#include "planar/paper_curve.h"

namespace betamesh {

BetaCurve paperCurve(const DiscBoundary& boundary, const std::vector<Moving>& vertices) {
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

Spheres externalDiscs(const DiscBoundary& boundary, const std::vector<Moving>& discs, const Particles& particles) {
    Spheres spheres;
    for (const std::uint32_t d : boundary.bare) {
        spheres.position.push_back(discs[d].position);
        spheres.radius.push_back(static_cast<float>(boundary.worldRadius()));
        if (!particles.velocity.empty()) spheres.velocity.push_back(discs[d].velocity);
        if (!particles.id.empty()) spheres.id.push_back(particles.id[boundary.row[d]]);
    }
    return spheres;
}

}  // namespace betamesh
