#include "skin/walls.h"

#include "base/parallel.h"
#include "skin/constants.h"
#include "skin/self_intersections.h"

namespace betamesh {

namespace {

// Blends the displacements of vertices that fade in with those of the vertices they fade in from.
void blendFading(const FadingVertices& fading, std::vector<DualVec3>& displacement) {
    constexpr int kRounds = 4;  // vertices on facets fade in from each other
    std::vector<DualVec3> own, blended;
    for (const std::vector<FadingVertex>& group : fading) {
        own.resize(group.size());
        blended.resize(group.size());
        for (std::size_t i = 0; i < group.size(); ++i) own[i] = displacement[group[i].vertex];
        for (int round = 0; round < kRounds; ++round) {
            parallelFor(group.size(), 1024, [&](std::size_t i) {
                const FadingVertex& v = group[i];
                DualVec3 from;
                for (std::size_t k = 0; k < 4; ++k) from = from + displacement[v.anchor[k]] * v.anchor_weight[k];
                blended[i] = own[i] * v.fade + from * (1 - v.fade);
            });
            for (std::size_t i = 0; i < group.size(); ++i) displacement[group[i].vertex] = blended[i];
        }
    }
}

}  // namespace

DualVec3 laidAgainst(const Wall& wall, double spacing, const DualVec3& point) {
    const DualVec3 normal{wall.normal, Vec3(0)};
    const Dual distance = (wall.offset - dot(normal, point)) / spacing;
    const Dual magnitude = distance.value < 0 ? 0 - distance : distance;
    if (!(magnitude.value < kWallReach)) return point;
    const Dual share = smoothStep((magnitude - kWallFlat) / (kWallReach - kWallFlat));
    return point + normal * (distance * (1 - share) * ((1 - kWallRemainder) * spacing));
}

void layAgainstWalls(const std::vector<Wall>& walls, double spacing, const BallBoundary& boundary, BetaMesh& mesh) {
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
    resolveSelfIntersections(boundary, from, mesh, kCornerRelaxations);
}

}  // namespace betamesh
