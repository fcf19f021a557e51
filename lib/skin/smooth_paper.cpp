
#include "skin/smooth_paper.h"

#include "base/compressed_rows.h"
#include "base/parallel.h"

namespace betamesh {

namespace {

// Sum of edge midpoints of fans, weighted by edge length.
struct WeightedSum {
    DualVec3 sum;
    Dual weight;

    void add(const WeightedSum& other) {
        sum = sum + other.sum;
        weight = weight + other.weight;
    }
    // The mean, or a fallback where all edges have length zero.
    DualVec3 meanOr(const DualVec3& fallback) const { return weight.value > 0 ? sum / weight : fallback; }
};

WeightedSum sumOverFan(const PaperMesh& mesh, std::size_t f) {
    const auto ring = mesh.fan[f];
    WeightedSum total;
    for (std::size_t e = 0; e < mesh.fanEdges(f); ++e) {
        const DualVec3 &a = mesh.vertex[ring[e]], &b = mesh.vertex[ring[(e + 1) % ring.size()]];
        const Dual w = length(b - a);
        total.add({(a + b) * 0.5 * w, w});
    }
    return total;
}

// The fans at each pure beta vertex: the inverse of mesh.fan.
IndexRows fansOfVertices(const PaperMesh& mesh) {
    return sortedIntoRows<std::uint32_t>(mesh.pure, mesh.fan.size(), [&](std::size_t f, const auto& visit) {
        for (const std::uint32_t v : mesh.fan[f]) visit(v, static_cast<std::uint32_t>(f));
    });
}

}  // namespace

void smoothAsInPaper(PaperMesh& mesh, int passes) {
    const IndexRows fans = fansOfVertices(mesh);
    std::vector<WeightedSum> sums(mesh.fan.size());
    for (int pass = 0; pass < passes; ++pass) {
        parallelFor(sums.size(), 1024, [&](std::size_t f) { sums[f] = sumOverFan(mesh, f); });
        parallelFor(mesh.pure, 1024, [&](std::size_t v) {
            if (mesh.rim[v]) return;
            WeightedSum total;
            for (const std::uint32_t f : fans[v]) total.add(sums[f]);
            mesh.vertex[v] = total.meanOr(mesh.vertex[v]);
        });
        parallelFor(mesh.fan.size(), 1024, [&](std::size_t f) {
            if (mesh.fan_open[f]) return;
            DualVec3& vertex = mesh.vertex[mesh.alphabeta(f)];
            vertex = sumOverFan(mesh, f).meanOr(mesh.vertex[mesh.fan[f][0]]);
        });
    }
}

void resolveIntersections(const BallBoundary& boundary, const std::vector<DualVec3>& balls, PaperMesh& mesh) {
    parallelFor(mesh.pure, 1024, [&](std::size_t v) {
        const Triangle& t = boundary.triangle[v];
        const DualVec3 normal = cross(balls[t[1]] - balls[t[0]], balls[t[2]] - balls[t[0]]);
        const Dual squared = dot(normal, normal), height = dot(mesh.vertex[v] - balls[t[0]], normal);
        if (height.value < 0) mesh.vertex[v] = mesh.vertex[v] - normal * (height / squared);
    });
    parallelFor(mesh.fan.size(), 1024, [&](std::size_t f) {
        const auto ring = mesh.fan[f];
        const DualVec3& particle = balls[mesh.fan_ball[f]];
        DualVec3& vertex = mesh.vertex[mesh.alphabeta(f)];
        for (std::size_t e = 0; e < mesh.fanEdges(f); ++e) {
            const Vec3 a = mesh.vertex[ring[e]].position - vertex.position;
            const Vec3 b = mesh.vertex[ring[(e + 1) % ring.size()]].position - vertex.position;
            if (dot(cross(a, b), particle.position - vertex.position) > 0) {
                vertex = particle;
                return;
            }
        }
    });
}

}  // namespace betamesh
