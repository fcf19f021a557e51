#include "core/disc_boundary.h"

#include "core/angles.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace betamesh {

namespace {

constexpr double kNearlyNothing = 1e-3;  // radians, far above rounding

std::int64_t dotPlane(const Vec3i& a, const Vec3i& b) { return a.x * b.x + a.y * b.y; }

}  // namespace

double arcAngle(const DiscBoundary& boundary, std::uint32_t v) {
    constexpr double kTurn = 2 * std::numbers::pi;
    const auto [before, disc] = boundary.segment[v];
    const std::uint32_t after = boundary.segment[boundary.next[v]][1];
    const Vec3 centre = boundary.centre(disc), begin = boundary.vertex[v] - centre,
               end = boundary.vertex[boundary.next[v]] - centre;
    const double angle = angleOf(crossZ(begin, end), begin.x * end.x + begin.y * end.y);
    if (std::abs(angle) > kNearlyNothing) return angle < 0 ? angle + kTurn : angle;
    // Next to nothing, or nearly the whole circle? Then what covers the rest begins with the one neighbour and ends
    // with the other, both far away in nearly the same direction.
    const Vec3i from = boundary.position[before] - boundary.position[disc],
                to = boundary.position[after] - boundary.position[disc];
    const bool whole = before == after || (crossZ(from, to) < 0 && dotPlane(from, to) > 0);
    return whole ? std::min(kTurn, kTurn + angle) : std::max(0.0, angle);
}

}  // namespace betamesh
