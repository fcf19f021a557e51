
#include "planar/boundary_samples.h"

#include "base/angles.h"

#include <cmath>
#include <numbers>

namespace betamesh {

namespace {

// The piece of a circle from one angle to another.
BoundarySample piece(const DualVec3& centre, double radius, Dual begin, Dual end) {
    const Dual angle = (begin + end) / 2;
    const auto [s, c] = sineCosine(angle.value);
    const DualVec3 outwards{{c, s, 0}, Vec3(-s, c, 0) * angle.rate};
    return {centre + outwards * radius, outwards, (end - begin) * radius};
}

// The angle of a point on a circle round a centre.
Dual angleRate(const DualVec3& point, const DualVec3& centre) {
    const DualVec3 q = point - centre;
    return {angleOf(q.position.y, q.position.x), crossZ(q.position, q.velocity) / q.position.length2()};
}

}  // namespace

BoundarySamples boundarySamples(const DiscBoundary& boundary, const std::vector<DualVec3>& discs,
                                const std::vector<DualVec3>& vertices, int directions) {
    const double radius = boundary.worldRadius(), step = 2 * std::numbers::pi / directions;
    BoundarySamples samples;
    for (std::uint32_t v = 0; v < vertices.size(); ++v) {
        const DualVec3& centre = discs[boundary.segment[v][1]];
        Dual begin = angleRate(vertices[v], centre);
        const Dual end(begin.value + arcAngle(boundary, v), angleRate(vertices[boundary.next[v]], centre).rate);
        for (double k = std::floor(begin.value / step) + 1; k * step < end.value; ++k) {
            samples.push_back(piece(centre, radius, begin, k * step));
            begin = k * step;
        }
        samples.push_back(piece(centre, radius, begin, end));
    }
    for (const std::uint32_t d : boundary.isolated)
        for (int k = 0; k < directions; ++k) samples.push_back(piece(discs[d], radius, k * step, (k + 1) * step));
    return samples;
}

}  // namespace betamesh
