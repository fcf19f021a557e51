
#include "planar/hole_room.h"

#include "base/angles.h"
#include "base/cell_order.h"

#include <algorithm>
#include <numbers>

namespace betamesh {

namespace {

constexpr double kSameParticle = 1e-4;  // radii, above what snapping moves

}  // namespace

std::vector<bool> cyclesWithRoom(const DiscBoundary& boundary, const DiscBoundary& wider) {
    const IndexRows arcs = sortedIntoRows<std::uint32_t>(
        boundary.position.size(), boundary.segment.size(),
        [&](std::size_t v, const auto& visit) { visit(boundary.segment[v][1], static_cast<std::uint32_t>(v)); });
    std::vector<std::size_t> cycle_of(boundary.segment.size());
    for (std::size_t c = 0; c < boundary.cycle.size(); ++c)
        for (const std::uint32_t v : boundary.cycle[c]) cycle_of[v] = c;
    const double same = kSameParticle * wider.worldRadius();
    const CellOrder discs(boundary.position.size(), boundary.worldRadius(),
                          [&](std::size_t d) { return boundary.centre(d); });
    std::vector<bool> has_room(boundary.cycle.size(), false);
    for (std::size_t v = 0; v < wider.segment.size(); ++v) {
        // The empty disc round the vertex touches a particle; between the two the smaller disc leaves its arc free.
        const Vec3 centre = wider.centre(wider.segment[v][0]), way = wider.vertex[v] - centre;
        const double direction = angleOf(way.y, way.x);
        double least = std::numeric_limits<double>::infinity();
        std::size_t cycle = 0;
        discs.forRowsIn(centre - Vec3(same), centre + Vec3(same), [&](std::uint32_t d) {
            if ((boundary.centre(d) - centre).length() > same) return;
            for (const std::uint32_t arc : arcs[d]) {
                constexpr double kTurn = 2 * std::numbers::pi;
                const Vec3 begin = boundary.vertex[arc] - boundary.centre(d);
                double after = direction - angleOf(begin.y, begin.x);
                if (after < 0) after += kTurn;
                const double beyond = std::max(0.0, std::min(after - arcAngle(boundary, arc), kTurn - after));
                if (beyond < least) least = beyond, cycle = cycle_of[arc];
            }
        });
        if (least < std::numbers::pi) has_room[cycle] = true;
    }
    return has_room;
}

}  // namespace betamesh
