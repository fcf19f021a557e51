#include "planar/complete_curve.h"

#include "core/angles.h"

#include <cmath>
#include <numbers>

namespace betamesh {

BetaCurve completeCurve(const DiscBoundary& boundary, const std::vector<Moving>& discs,
                        const std::vector<Moving>& vertices, int directions) {
    const double step = 2 * std::numbers::pi / directions, radius = boundary.worldRadius();
    BetaCurve curve;
    const auto addPoint = [&](std::uint32_t disc, double angle) {
        const auto [sine, cosine] = sineCosine(angle);
        curve.add({discs[disc].position + Vec3(cosine, sine, 0) * radius, discs[disc].velocity}, false);
    };
    for (std::size_t c = 0; c < boundary.cycle.size(); ++c) {
        for (const std::uint32_t v : boundary.cycle[c]) {
            curve.add(vertices[v], true);
            const std::uint32_t disc = boundary.segment[v][1];
            const Vec3 outwards = vertices[v].position - discs[disc].position;
            const double begin = angleOf(outwards.y, outwards.x), end = begin + arcAngle(boundary, v);
            for (double k = std::floor(begin / step) + 1; k * step < end; ++k) addPoint(disc, k * step);
        }
        curve.endLine();
    }
    for (const std::uint32_t disc : boundary.bare) {
        for (int k = 0; k < directions; ++k) addPoint(disc, k * step);
        curve.endLine();
    }
    return curve;
}

}  // namespace betamesh
