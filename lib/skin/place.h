// Places on the surface that have an axis, and what is around them.

#pragma once

#include "base/dual.h"
#include "skin/deforming_mesh.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace betamesh {

struct Place {
    Vec3 middle, axis;     ///< world units; unit vector
    double unit;           ///< of the other lengths at the place, world units
    double length, width;  ///< how far its surroundings reach along the axis and across it
};

inline double square(double x) { return x * x; }

/// 1 up to half of the reach, then down to 0.
inline double within(double distance, double reach) { return 1 - smoothStep(2 * distance / reach - 1).value; }

/// Calls visit(vertex, along, across) for the vertices at these positions that are in the surroundings of a place: how
/// far from its middle along the axis, and the offset from the axis, both in its unit. margin: how far vertices may
/// have moved from there, in its unit.
template <typename Visit>
void forVerticesNear(const Place& place, double margin, const std::vector<Vec3>& position, const DeformingMesh& surface,
                     const Visit& visit) {
    const PointGroups& groups = surface.groups();
    const Vec3 reach((std::max(place.length, place.width) + margin) * place.unit);
    groups.forGroupsNear(
        Box(place.middle - reach, place.middle + reach), [](double) { return 0.0; },
        [&](std::uint32_t group, std::uint32_t) {
            for (std::uint32_t v = groups.begin(group); v < groups.begin(group + 1); ++v) {
                const Vec3 offset = (position[v] - place.middle) / place.unit;
                const double along = dot(offset, place.axis);
                const Vec3 across = offset - place.axis * along;
                if (std::abs(along) < place.length && across.length2() < square(place.width)) visit(v, along, across);
            }
        });
}

}  // namespace betamesh
