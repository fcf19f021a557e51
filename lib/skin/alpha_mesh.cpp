#include "skin/alpha_mesh.h"

namespace betamesh {

Mesh alphaMesh(const BallBoundary& boundary, const std::vector<Moving>& balls) {
    constexpr std::uint32_t kUnused = ~std::uint32_t{0};
    std::vector<std::uint32_t> place(balls.size(), kUnused);
    for (const Triangle& t : boundary.triangle)
        for (const std::uint32_t ball : t) place[ball] = 0;
    Mesh mesh;
    for (std::size_t ball = 0; ball < balls.size(); ++ball) {
        if (place[ball] == kUnused) continue;
        place[ball] = static_cast<std::uint32_t>(mesh.position.size());
        mesh.position.push_back(balls[ball].position);
        mesh.velocity.push_back(balls[ball].velocity);
    }
    mesh.triangles.reserve(boundary.triangle.size());
    for (const Triangle& t : boundary.triangle) mesh.triangles.push_back({place[t[0]], place[t[1]], place[t[2]]});
    return mesh;
}

std::size_t doubleSidedTriangles(const BallBoundary& boundary) {
    std::size_t sides = 0;
    for (std::uint32_t v = 0; v < boundary.triangle.size(); ++v) sides += reverseSide(boundary, v) != v;
    return sides / 2;
}

}  // namespace betamesh
