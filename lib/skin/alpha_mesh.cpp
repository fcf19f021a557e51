#include "skin/alpha_mesh.h"

#include "core/parallel.h"

#include <atomic>

namespace betamesh {

std::vector<std::uint32_t> ballsOfTriangles(const BallBoundary& boundary) {
    std::vector<std::uint8_t> is_used(boundary.position.size(), 0);
    parallelFor(boundary.triangle.size(), 4096, [&](std::size_t t) {
        for (const std::uint32_t ball : boundary.triangle[t])
            std::atomic_ref(is_used[ball]).store(1, std::memory_order_relaxed);
    });
    return rowsWhere(is_used.size(), [&](std::uint32_t ball) { return is_used[ball] != 0; });
}

Mesh alphaMesh(const BallBoundary& boundary, const std::vector<Moving>& balls) {
    const std::vector<std::uint32_t> used = ballsOfTriangles(boundary);
    std::vector<std::uint32_t> place(balls.size());
    Mesh mesh;
    resizeOnAll(mesh.position, used.size());
    resizeOnAll(mesh.velocity, used.size());
    parallelFor(used.size(), 4096, [&](std::size_t v) {
        const std::uint32_t ball = used[v];
        place[ball] = static_cast<std::uint32_t>(v);
        mesh.position[v] = Vec3f(balls[ball].position);
        mesh.velocity[v] = Vec3f(balls[ball].velocity);
    });
    resizeOnAll(mesh.triangles, boundary.triangle.size());
    parallelFor(mesh.triangles.size(), 4096, [&](std::size_t t) {
        const auto& [a, b, c] = boundary.triangle[t];
        mesh.triangles[t] = {place[a], place[b], place[c]};
    });
    return mesh;
}

std::size_t doubleSidedTriangles(const BallBoundary& boundary) {
    return countWhere(boundary.triangle.size(), [&](std::uint32_t v) { return reverseSide(boundary, v) != v; }) / 2;
}

}  // namespace betamesh
