#include "skin/star_shaped.h"

#include "exact/orientation.h"

#include <algorithm>

namespace betamesh {

bool isStarShaped(const Vec3& centre, std::span<const std::array<Vec3, 3>> triangles) {
    const Vec3 on_ray = centre + Vec3(0.6123, 0.5347, 0.5821);  // an arbitrary direction, along no likely symmetry
    int covering = 0;
    for (const auto& [a, b, c] : triangles) {
        if (sideOfPlane(a, b, c, centre) >= 0) return false;
        int least = sideOfPlane(centre, on_ray, a, b);
        if (least >= 0) least = std::min(least, sideOfPlane(centre, on_ray, b, c));
        if (least >= 0) least = std::min(least, sideOfPlane(centre, on_ray, c, a));
        if (least == 0) return false;
        covering += least > 0;
    }
    return covering == 1;
}

}  // namespace betamesh
