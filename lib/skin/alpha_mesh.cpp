
#include "skin/alpha_mesh.h"

#include "base/parallel.h"
#include "skin/beta_mesh.h"

namespace betamesh {

Mesh alphaMesh(const BallBoundary& boundary, const std::vector<DualVec3>& balls) {
    return asMesh(balls, boundary.triangle);
}

std::size_t doubleSidedTriangles(const BallBoundary& boundary) {
    return countWhere(boundary.triangle.size(), [&](std::uint32_t v) { return reverseSide(boundary, v) != v; }) / 2;
}

}  // namespace betamesh
