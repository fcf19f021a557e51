#include "skin/alpha_mesh.h"

#include "core/beta_mesh.h"
#include "core/parallel.h"

namespace betamesh {

Mesh alphaMesh(const BallBoundary& boundary, std::vector<Moving> balls) {
    BetaMesh alpha;
    alpha.vertex = std::move(balls);
    alpha.triangles = boundary.triangle;
    return asMesh(std::move(alpha));
}

std::size_t doubleSidedTriangles(const BallBoundary& boundary) {
    return countWhere(boundary.triangle.size(), [&](std::uint32_t v) { return reverseSide(boundary, v) != v; }) / 2;
}

}  // namespace betamesh
