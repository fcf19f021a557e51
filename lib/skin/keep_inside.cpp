#include "skin/keep_inside.h"

#include "base/cell_grid.h"
#include "base/octaves.h"
#include "base/parallel.h"
#include "mesh/enclosure.h"
#include "mesh/triangle_tree.h"
#include "mesh/vertex_normals.h"
#include "skin/constants.h"
#include "skin/coverage.h"

#include <algorithm>
#include <cmath>

namespace betamesh {

namespace {

// The particles beside vertices where the spacing is much larger than their own size. Elsewhere the surface is averaged
// over widths that suit them.
std::vector<DeepParticle> besideLarger(const std::vector<DeepParticle>& particles, double spacing,
                                       const BetaMesh& mesh) {
    std::vector<float> scale;
    for (const DeepParticle& particle : particles) scale.push_back(static_cast<float>(particle.scale));
    const auto particles_of = byOctave(allRows(particles.size()), scale),
               vertices_of = byOctave(allRows(mesh.vertex.size()), mesh.scale);
    std::vector<std::uint8_t> is_beside(particles.size(), 0);
    for (std::size_t large = 0; large < vertices_of.size(); ++large)
        for (std::size_t small = large; small < particles_of.size(); ++small) {
            const std::vector<std::uint32_t>&vertices = vertices_of[large], &rows = particles_of[small];
            if (vertices.empty() || rows.empty()) continue;
            const double reach = kReachOfLarger * largestOfOctave(large) * spacing;
            const auto vertexAt = [&](std::size_t i) { return mesh.vertex[vertices[i]].position; };
            const CellGrid points(rows.size(), reach, [&](std::size_t i) { return particles[rows[i]].position; });
            const CellGrid around(vertices.size(), reach, vertexAt);
            forCellsAndNeighbours(
                reach, points, around, vertexAt, [&](std::uint32_t cell, std::span<const std::uint32_t> near) {
                    for (const std::uint32_t row : points.rowsOf(cell)) {
                        const DeepParticle& particle = particles[rows[row]];
                        is_beside[rows[row]] |= std::any_of(near.begin(), near.end(), [&](std::uint32_t i) {
                            const double there = mesh.scaleOf(vertices[i]), within = kReachOfLarger * there * spacing;
                            return there > kMuchLarger * particle.scale &&
                                   (vertexAt(i) - particle.position).length2() < within * within;
                        });
                    }
                });
        }
    std::vector<DeepParticle> beside;
    for (std::size_t i = 0; i < particles.size(); ++i)
        if (is_beside[i]) beside.push_back(particles[i]);
    return beside;
}

// Where the surface has to move, and how far.
struct Bump {
    Vec3 centre, normal;
    double height, width;
};

// The bump over a particle; none, with height 0, where it is deep enough.
Bump bumpOver(const DeepParticle& particle, double outside, const TriangleTree& tree,
              const std::vector<Vec3>& normals) {
    std::size_t at = 0;
    const double distance = tree.distanceTo(particle.position, at), depth = outside > 0 ? -outside : distance;
    Bump bump{particle.position, Vec3(0), particle.least_depth - depth, 0};
    if (!(bump.height > 0)) return {};
    const Triangle& nearest = tree.triangles()[tree.triangleAt(at)];
    double farthest = 0;
    for (const std::uint32_t v : nearest) {
        bump.normal += normals[v];
        farthest = std::max(farthest, (tree.position()[v] - particle.position).length());
    }
    bump.normal = bump.normal.normalized();
    bump.centre += bump.normal * depth;
    bump.width = kBumpWidth * std::max(farthest, bump.height);
    return bump;
}

// The bumps over particles that are not deep enough, which alone are kept in the list.
std::vector<Bump> bumpsOver(std::vector<DeepParticle>& particles, const Mesh& mesh, const std::vector<Vec3>& normals) {
    std::vector<Vec3> position;
    for (const DeepParticle& particle : particles) position.push_back(particle.position);
    const std::vector<double> outside = distancesOutside(mesh, {}, position);
    const TriangleTree tree(mesh.position, mesh.triangles);
    std::vector<Bump> all(particles.size());
    parallelFor(all.size(), 64, [&](std::size_t i) { all[i] = bumpOver(particles[i], outside[i], tree, normals); });
    std::vector<Bump> bumps;
    std::vector<DeepParticle> rest;
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (!(all[i].height > 0)) continue;
        bumps.push_back(all[i]);
        rest.push_back(particles[i]);
    }
    particles = std::move(rest);
    return bumps;
}

// The displacement of each vertex: a mean over the bumps that reach it, each as high as its weight there.
std::vector<DualVec3> displacements(const std::vector<Bump>& bumps, const BetaMesh& mesh,
                                    const std::vector<Vec3>& normals) {
    double widest = 0;
    for (const Bump& bump : bumps) widest = std::max(widest, bump.width);
    const CellGrid cells(mesh.vertex.size(), widest, [&](std::size_t v) { return mesh.vertex[v].position; });
    std::vector<Vec3> sum(mesh.vertex.size(), Vec3(0));
    std::vector<double> weight(mesh.vertex.size(), 0);
    for (const Bump& bump : bumps)
        cells.forRowsIn(bump.centre - Vec3(bump.width), bump.centre + Vec3(bump.width), [&](std::uint32_t v) {
            const double t = 1 - (mesh.vertex[v].position - bump.centre).length2() / (bump.width * bump.width);
            const double facing = dot(normals[v], bump.normal);
            if (!(t > 0) || !(facing > 0)) return;
            const double w = t * t * std::sqrt(facing);
            sum[v] += bump.normal * (bump.height * w * w);
            weight[v] += w;
        });
    std::vector<DualVec3> displacement(mesh.vertex.size());
    for (std::size_t v = 0; v < sum.size(); ++v)
        if (weight[v] > 0) displacement[v].position = sum[v] / weight[v];
    return displacement;
}

}  // namespace

std::vector<DeepParticle> smallParticles(const SnappedParticles& snapped, double skin) {
    std::vector<DeepParticle> small;
    if (!snapped.size_classes) return small;
    for (const std::uint32_t i : notAmongAlike(snapped)) {
        if (snapped.radiusOf(i) == snapped.radius) continue;
        const double scale = static_cast<double>(snapped.radiusOf(i)) / static_cast<double>(snapped.radius);
        small.push_back(
            {toDouble(snapped.position[i]) * snapped.quantum, scale, (1 - kMaxSkinSmoothing) * skin * scale});
    }
    return small;
}

void keepInside(const std::vector<DeepParticle>& all, double spacing, BetaMesh& mesh) {
    if (all.empty()) return;
    std::vector<DeepParticle> particles = besideLarger(all, spacing, mesh);
    for (int round = 0; round < kBumpRounds && !particles.empty(); ++round) {
        const std::vector<Vec3> normals = vertexNormals(mesh);
        Mesh plain;
        plain.triangles = mesh.triangles;
        for (const DualVec3& vertex : mesh.vertex) plain.position.push_back(vertex.position);
        const std::vector<Bump> bumps = bumpsOver(particles, plain, normals);
        if (bumps.empty()) return;
        std::vector<DualVec3> displacement = displacements(bumps, mesh, normals);
        blendFading(mesh.fading, displacement);
        for (std::size_t v = 0; v < displacement.size(); ++v) mesh.vertex[v] = mesh.vertex[v] + displacement[v];
    }
}

}  // namespace betamesh
