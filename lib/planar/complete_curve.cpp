
#include "planar/complete_curve.h"

#include "base/angles.h"

#include <cmath>
#include <numbers>

namespace betamesh {

BetaCurve completeCurve(const DiscBoundary& boundary, const std::vector<DualVec3>& discs,
                        const std::vector<DualVec3>& vertices, int directions) {
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
    for (const std::uint32_t disc : boundary.isolated) {
        for (int k = 0; k < directions; ++k) addPoint(disc, k * step);
        curve.endLine();
    }
    return curve;
}

namespace {

// What runs round liquid holds at least one whole disc. What has less than this part of its area is a hole, even where
// rounding gives a tiny one a positive sign.
constexpr double kLeastBody = 0.25;

double areaOf(const BetaCurve& curve, std::size_t line) {
    const Vec3& origin = curve.vertex[curve.begin[line]].position;
    double twice = 0;
    for (std::uint32_t v = curve.begin[line]; v + 1 < curve.begin[line + 1]; ++v)
        twice += crossZ(curve.vertex[v].position - origin, curve.vertex[v + 1].position - origin);
    return twice / 2;
}

// How often a line runs round a point, by the edges that pass on its right.
int windingOf(const BetaCurve& curve, std::size_t line, const Vec3& point) {
    int winding = 0;
    const std::uint32_t first = curve.begin[line], last = curve.begin[line + 1] - 1;
    for (std::uint32_t v = first, before = last; v <= last; before = v++) {
        const Vec3 a = curve.vertex[before].position - point, b = curve.vertex[v].position - point;
        if ((a.y <= 0) == (b.y <= 0)) continue;
        const double side = crossZ(a, b);
        if (a.y <= 0 && side > 0) ++winding;
        if (a.y > 0 && side < 0) --winding;
    }
    return winding;
}

}  // namespace

std::size_t fillHoles(BetaCurve& curve, double radius,
                      const std::function<bool(std::size_t line, double area)>& isSmall) {
    const double least_body = kLeastBody * std::numbers::pi * radius * radius;
    std::vector<bool> leaves(curve.lines(), false);
    std::size_t filled = 0;
    for (std::size_t hole = 0; hole < curve.lines(); ++hole) {
        const double enclosed = areaOf(curve, hole);
        if (enclosed >= least_body || !isSmall(hole, -enclosed)) continue;
        leaves[hole] = true;
        ++filled;
        if (enclosed > -least_body) continue;  // no room for anything
        for (std::size_t other = 0; other < curve.lines(); ++other)
            if (other != hole && windingOf(curve, hole, curve.vertex[curve.begin[other]].position) != 0)
                leaves[other] = true;
    }
    if (filled == 0) return 0;
    BetaCurve rest;
    for (std::size_t line = 0; line < curve.lines(); ++line) {
        if (leaves[line]) continue;
        for (std::uint32_t v = curve.begin[line]; v < curve.begin[line + 1]; ++v)
            rest.add(curve.vertex[v], curve.pure[v] != 0);
        rest.endLine();
    }
    curve = std::move(rest);
    return filled;
}

}  // namespace betamesh
