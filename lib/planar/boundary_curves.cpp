
#include "planar/boundary_curves.h"

#include "base/angles.h"
#include "base/cell_grid.h"
#include "base/index.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace betamesh {

Curves alphaCurves(const DiscBoundary& boundary, const std::vector<DualVec3>& discs) {
    std::vector<std::uint32_t> vertex(discs.size(), kInvalidIndex);
    for (const auto& [from, to] : boundary.segment) vertex[from] = vertex[to] = 0;
    Curves curves;
    for (std::size_t d = 0; d < discs.size(); ++d) {
        if (vertex[d] == kInvalidIndex) continue;
        vertex[d] = static_cast<std::uint32_t>(curves.position.size());
        curves.position.push_back(discs[d].position);
        curves.velocity.push_back(discs[d].velocity);
    }
    std::vector<std::uint32_t> visits(discs.size(), 0);
    for (std::size_t c = 0; c < boundary.cycle.size(); ++c) {
        const auto cycle = boundary.cycle[c];
        const auto begin = [&](std::size_t k) { return boundary.segment[cycle[k % cycle.size()]][0]; };
        for (std::size_t k = 0; k < cycle.size(); ++k) ++visits[begin(k)];
        // Curves end a line when it returns to its first vertex, so begin at a particle that the cycle visits once.
        std::size_t first = 0;
        while (first + 1 < cycle.size() && visits[begin(first)] > 1) ++first;
        for (std::size_t k = 0; k < cycle.size(); ++k) {
            curves.edges.push_back({vertex[begin(first + k)], vertex[begin(first + k + 1)]});
            visits[begin(k)] = 0;
        }
    }
    return curves;
}

std::size_t doubleSidedSegments(const DiscBoundary& boundary) {
    std::vector<std::array<std::uint32_t, 2>> sorted = boundary.segment;
    std::sort(sorted.begin(), sorted.end());
    return static_cast<std::size_t>(std::count_if(sorted.begin(), sorted.end(), [&](const auto& segment) {
        return std::binary_search(sorted.begin(), sorted.end(), std::array{segment[1], segment[0]});
    }));
}

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

BetaCurve completeCurve(const DiscBoundary& boundary, const std::vector<DualVec3>& discs,
                        const std::vector<DualVec3>& vertices, int directions) {
    const double step = kTwoPi / directions;
    BetaCurve curve;
    const auto addPoint = [&](std::uint32_t disc, double angle) {
        const auto [sine, cosine] = sineCosine(angle);
        const Vec3 outwards(cosine, sine, 0);
        const Dual radius = boundary.worldRadiusOf(disc);
        curve.add({discs[disc].position + outwards * radius.value, discs[disc].velocity + outwards * radius.rate},
                  false);
        if (boundary.hasScales()) curve.scale.push_back(boundary.movingScaleOf(disc));
    };
    for (std::size_t c = 0; c < boundary.cycle.size(); ++c) {
        for (const std::uint32_t v : boundary.cycle[c]) {
            curve.add(vertices[v], true);
            if (boundary.hasScales()) curve.scale.push_back(boundary.movingScaleOfVertex(v));
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

// Of a disc's area. A line that bounds liquid encloses at least one whole disc, so a line that encloses less than this
// bounds a hole, even if rounding gives a tiny one a positive area.
constexpr double kLeastLiquid = 0.25;

double areaOf(const BetaCurve& curve, std::size_t line) {
    const Vec3& origin = curve.vertex[curve.begin[line]].position;
    double doubled = 0;
    for (std::uint32_t v = curve.begin[line]; v + 1 < curve.begin[line + 1]; ++v)
        doubled += crossZ(curve.vertex[v].position - origin, curve.vertex[v + 1].position - origin);
    return doubled / 2;
}

// The winding number of a line about a point, counted by the edges that cross the ray in the direction of +x.
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
    const double least_liquid = kLeastLiquid * std::numbers::pi * radius * radius;
    std::vector<bool> removed(curve.lines(), false);
    std::size_t filled = 0;
    for (std::size_t hole = 0; hole < curve.lines(); ++hole) {
        const double enclosed = areaOf(curve, hole);
        if (enclosed >= least_liquid || !isSmall(hole, -enclosed)) continue;
        removed[hole] = true;
        ++filled;
        if (enclosed > -least_liquid) continue;  // too small to contain a drop
        for (std::size_t other = 0; other < curve.lines(); ++other)
            if (other != hole && windingOf(curve, hole, curve.vertex[curve.begin[other]].position) != 0)
                removed[other] = true;
    }
    if (filled == 0) return 0;
    BetaCurve remaining;
    for (std::size_t line = 0; line < curve.lines(); ++line) {
        if (removed[line]) continue;
        for (std::uint32_t v = curve.begin[line]; v < curve.begin[line + 1]; ++v) {
            remaining.add(curve.vertex[v], curve.pure[v] != 0);
            if (!curve.scale.empty()) remaining.scale.push_back(curve.scale[v]);
        }
        remaining.endLine();
    }
    curve = std::move(remaining);
    return filled;
}

std::vector<bool> cyclesWithRoom(const DiscBoundary& boundary, const DiscBoundary& wider) {
    constexpr double kSameParticle = 1e-4;  // radii: distance up to which centres are one particle, above snapping
    constexpr double kSameQuanta = 4;       // the same where the smallest discs may be nearly as small as that
    constexpr double kNearlyZero = 1e-2;    // radians, above rounding of directions on the smallest discs
    const double farthest = boundary.radius_of.empty() ? std::numbers::pi : kNearlyZero;
    const IndexRows arcs = sortedIntoRows<std::uint32_t>(
        boundary.position.size(), boundary.segment.size(),
        [&](std::size_t v, const auto& visit) { visit(boundary.segment[v][1], static_cast<std::uint32_t>(v)); });
    std::vector<std::size_t> cycle_of(boundary.segment.size());
    for (std::size_t c = 0; c < boundary.cycle.size(); ++c)
        for (const std::uint32_t v : boundary.cycle[c]) cycle_of[v] = c;
    const double same = wider.radius_of.empty() ? kSameParticle * wider.worldRadius() : kSameQuanta * wider.quantum;
    const CellGrid discs(boundary.position.size(), boundary.worldRadius(),
                         [&](std::size_t d) { return boundary.centre(d); });
    std::vector<bool> has_room(boundary.cycle.size(), false);
    for (std::size_t v = 0; v < wider.segment.size(); ++v) {
        // The empty disc at the vertex touches a particle. In the direction of the vertex this particle's smaller disc
        // is exposed, so the arc there belongs to the cycle that bounds the vertex's region.
        const Vec3 centre = wider.centre(wider.segment[v][0]), to_vertex = wider.vertex[v] - centre;
        const double direction = angleOf(to_vertex.y, to_vertex.x);
        double least = std::numeric_limits<double>::infinity();
        std::size_t cycle = 0;
        discs.forRowsIn(centre - Vec3(same), centre + Vec3(same), [&](std::uint32_t d) {
            if ((boundary.centre(d) - centre).length() > same) return;
            for (const std::uint32_t arc : arcs[d]) {
                const Vec3 begin = boundary.vertex[arc] - boundary.centre(d);
                double after = direction - angleOf(begin.y, begin.x);
                if (after < 0) after += kTwoPi;
                const double outside_arc = std::max(0.0, std::min(after - arcAngle(boundary, arc), kTwoPi - after));
                if (outside_arc < least) least = outside_arc, cycle = cycle_of[arc];
            }
        });
        if (least < farthest) has_room[cycle] = true;
    }
    return has_room;
}

}  // namespace betamesh
