#include "core/exposure.h"

#include "core/icosphere.h"

#include <algorithm>
#include <cmath>

namespace betamesh {

namespace {

DirectionPatches makePatches() {
    const Icosphere sphere = icosphere(4);
    DirectionPatches patches{};
    double cos_angle = 1;
    for (std::size_t p = 0; p < kPatches; ++p) {
        const Triangle& t = sphere.triangles[p];
        const Vec3 middle = (sphere.position[t[0]] + sphere.position[t[1]] + sphere.position[t[2]]).normalized();
        for (const std::uint32_t corner : t) cos_angle = std::min(cos_angle, dot(middle, sphere.position[corner]));
        patches.corners[p] = {sphere.position[t[0]], sphere.position[t[1]], sphere.position[t[2]]};
        patches.x[p] = static_cast<float>(middle.x);
        patches.y[p] = static_cast<float>(middle.y);
        patches.z[p] = static_cast<float>(middle.z);
    }
    const double angle = std::acos(cos_angle) + 1e-6;
    patches.cos_angle = static_cast<float>(std::cos(angle));
    patches.sin_angle = static_cast<float>(std::sin(angle));
    return patches;
}

}  // namespace

const DirectionPatches& directionPatches() {
    static const DirectionPatches patches = makePatches();
    return patches;
}

}  // namespace betamesh
