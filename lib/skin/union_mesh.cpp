#include "skin/union_mesh.h"

#include "base/icosphere.h"
#include "base/index.h"
#include "base/parallel.h"
#include "exact/neighbour_finder.h"

#include <algorithm>

namespace betamesh {

namespace {

constexpr std::uint32_t kEdgeDivisions = 5;  // of the icosahedron: 20 · 5² triangles

// Appends the sphere's triangles that no single neighbour contains.
void addExposed(const Icosphere& sphere, double radius, double quantum, const std::vector<Neighbour>& neighbours,
                const DualVec3& ball, std::vector<std::uint8_t>& is_covered, Mesh& mesh) {
    is_covered.assign(sphere.triangles.size(), 0);
    std::vector<std::uint8_t> inside(sphere.position.size());
    for (const Neighbour& n : neighbours) {
        for (std::size_t v = 0; v < inside.size(); ++v)
            inside[v] = 2 * radius * dot(sphere.position[v], n.offset) > n.power;
        for (std::size_t t = 0; t < is_covered.size(); ++t) {
            const Triangle& corners = sphere.triangles[t];
            if (inside[corners[0]] && inside[corners[1]] && inside[corners[2]]) is_covered[t] = 1;
        }
    }
    std::vector<std::uint32_t> vertex_of(sphere.position.size(), kInvalidIndex);
    for (std::size_t t = 0; t < is_covered.size(); ++t) {
        if (is_covered[t]) continue;
        Triangle corners = sphere.triangles[t];
        for (std::uint32_t& v : corners) {
            if (vertex_of[v] == kInvalidIndex) {
                vertex_of[v] = static_cast<std::uint32_t>(mesh.position.size());
                mesh.position.push_back(ball.position + sphere.position[v] * (radius * quantum));
                mesh.velocity.push_back(ball.velocity);
            }
            v = vertex_of[v];
        }
        mesh.triangles.push_back(corners);
    }
}

}  // namespace

Mesh unionOfBalls(const SnappedParticles& particles, const BallBoundary& boundary, const std::vector<DualVec3>& balls) {
    const Icosphere sphere = icosphere(kEdgeDivisions);
    const auto parts =
        parallelParts<Mesh>(balls.size(), kBallsPerTask, [&](std::size_t begin, std::size_t end, Mesh& part) {
            NeighbourFinder finder(particles);
            std::vector<Neighbour> neighbours;
            std::vector<std::uint8_t> is_covered;
            for (std::size_t b = begin; b < end; ++b) {
                finder.find(boundary.snapped_row[b], neighbours);
                addExposed(sphere, static_cast<double>(boundary.radiusOf(b)), boundary.quantum, neighbours, balls[b],
                           is_covered, part);
            }
        });
    Mesh mesh;
    for (const Mesh& part : parts) {
        const auto first = static_cast<std::uint32_t>(mesh.position.size());
        mesh.position.insert(mesh.position.end(), part.position.begin(), part.position.end());
        mesh.velocity.insert(mesh.velocity.end(), part.velocity.begin(), part.velocity.end());
        for (const Triangle& t : part.triangles) mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    }
    return mesh;
}

}  // namespace betamesh
