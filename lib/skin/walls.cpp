#include "skin/walls.h"

#include "base/parallel.h"
#include "skin/constants.h"
#include "skin/self_intersections.h"

namespace betamesh {

DualVec3 laidAgainst(const Wall& wall, double spacing, const DualVec3& point) {
    const DualVec3 normal{wall.normal, Vec3(0)};
    const Dual distance = (wall.offset - dot(normal, point)) / spacing;
    const Dual magnitude = distance.value < 0 ? 0 - distance : distance;
    if (!(magnitude.value < kWallReach)) return point;
    const Dual share = smoothStep((magnitude - kWallFlat) / (kWallReach - kWallFlat));
    return point + normal * (distance * (1 - share) * ((1 - kWallRemainder) * spacing));
}

std::size_t layAgainstWalls(const std::vector<Wall>& walls, double spacing, const BallBoundary& boundary,
                            BetaMesh& mesh) {
    const DualPoints from = dualPoints(mesh.vertex);
    std::vector<DualVec3> displacement(mesh.vertex.size());
    parallelFor(mesh.vertex.size(), 4096, [&](std::size_t v) {
        DualVec3 point = mesh.vertex[v];
        const double own = mesh.scale.empty() ? spacing : spacing * static_cast<double>(mesh.scale[v]);
        for (const Wall& wall : walls) point = laidAgainst(wall, own, point);
        displacement[v] = point - mesh.vertex[v];
    });
    blendFading(mesh.fading, displacement);
    parallelFor(mesh.vertex.size(), 4096, [&](std::size_t v) { mesh.vertex[v] = mesh.vertex[v] + displacement[v]; });
    return resolveSelfIntersections(boundary, from, mesh, true);
}

}  // namespace betamesh
