#include "skin/keep_inside.h"

#include "base/cell_grid.h"
#include "base/index.h"
#include "base/octaves.h"
#include "base/parallel.h"
#include "mesh/enclosure.h"
#include "mesh/triangle_tree.h"
#include "mesh/vertex_normals.h"
#include "skin/constants.h"
#include "skin/coverage.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

namespace betamesh {

namespace {

double largestScale(const BetaMesh& mesh, const std::vector<std::uint32_t>& vertices) {
    double largest = 0;
    for (const std::uint32_t v : vertices) largest = std::max(largest, mesh.scaleOf(v));
    return largest;
}

// The particles beside vertices where the spacing is much larger than their own size. Elsewhere the surface is averaged
// over widths that suit them.
std::vector<ParticleAtRisk> besideLarger(const std::vector<ParticleAtRisk>& particles, double spacing,
                                         const BetaMesh& mesh) {
    std::vector<float> scale;
    for (const ParticleAtRisk& particle : particles) scale.push_back(static_cast<float>(particle.scale));
    const auto particles_of = byOctave(allRows(particles.size()), scale),
               vertices_of = byOctave(allRows(mesh.vertex.size()), mesh.scale);
    std::vector<std::uint8_t> is_beside(particles.size(), 0);
    for (std::size_t large = 0; large < vertices_of.size(); ++large) {
        const std::vector<std::uint32_t>& vertices = vertices_of[large];
        const double largest = largestScale(mesh, vertices), reach = kReachOfLarger * largest * spacing;
        for (std::size_t small = large; small < particles_of.size(); ++small) {
            std::vector<std::uint32_t> rows = particles_of[small];
            std::erase_if(rows, [&](std::uint32_t row) { return largest <= kMuchLarger * particles[row].scale; });
            if (rows.empty()) continue;
            const auto vertexAt = [&](std::size_t i) { return mesh.vertex[vertices[i]].position; };
            const CellGrid points(rows.size(), reach, [&](std::size_t i) { return particles[rows[i]].position; });
            const CellGrid around(vertices.size(), reach, vertexAt);
            forCellsAndNeighbours(
                reach, points, around, vertexAt, [&](std::uint32_t cell, std::span<const std::uint32_t> near) {
                    for (const std::uint32_t row : points.rowsOf(cell)) {
                        const ParticleAtRisk& particle = particles[rows[row]];
                        is_beside[rows[row]] |= std::any_of(near.begin(), near.end(), [&](std::uint32_t i) {
                            const double there = mesh.scaleOf(vertices[i]), within = kReachOfLarger * there * spacing;
                            return there > kMuchLarger * particle.scale &&
                                   (vertexAt(i) - particle.position).length2() < within * within;
                        });
                    }
                });
        }
    }
    std::vector<ParticleAtRisk> beside;
    for (std::size_t i = 0; i < particles.size(); ++i)
        if (is_beside[i]) beside.push_back(particles[i]);
    return beside;
}

// How far triangles may move before the tree over them is fitted again, spacings.
constexpr double kBumpMargin = 0.05;

// Where the surface has to move, and how far.
struct Bump {
    Vec3 centre, normal;
    double height, width;
};

// Whether a triangle may be nearer to a point than this distance.
bool mayBeNearer(const TriangleTree& tree, const Vec3& point, double distance) {
    bool any = false;
    tree.forTriangles([&](const Box& box) { return squaredDistance(box, point) < distance * distance; },
                      [&](std::uint32_t) {
                          any = true;
                          return false;
                      });
    return any;
}

// The bump over a particle; none, with height 0, where it is deep enough. at: of the triangle nearest to a particle
// nearby; set to that nearest to this one.
Bump bumpOver(const ParticleAtRisk& particle, bool is_enclosed, const TriangleTree& tree,
              const std::vector<Vec3>& normals, std::size_t& at) {
    if (is_enclosed && !mayBeNearer(tree, particle.position, particle.least_depth)) return {};
    const double distance = tree.distanceTo(particle.position, at);
    const double depth = is_enclosed ? distance : -distance;
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

// Whether each particle is inside.
std::vector<std::uint8_t> areEnclosed(const std::vector<ParticleAtRisk>& particles, const TriangleTree& tree) {
    std::vector<std::uint8_t> are(particles.size());
    parallelFor(are.size(), 64, [&](std::size_t i) { are[i] = isEnclosed(tree, particles[i].position); });
    return are;
}

// The bumps over particles that are not deep enough, which alone are kept in the list.
std::vector<Bump> bumpsOver(std::vector<ParticleAtRisk>& particles, const std::vector<std::uint8_t>& is_enclosed,
                            const TriangleTree& tree, const std::vector<Vec3>& normals) {
    std::vector<Bump> all(particles.size());
    constexpr std::size_t kPerTask = 64;  // fixed, as the triangle from which a search starts may change rounding
    parallelFor((all.size() + kPerTask - 1) / kPerTask, 1, [&](std::size_t task) {
        std::size_t nearest = 0;
        for (std::size_t i = task * kPerTask; i < std::min(all.size(), (task + 1) * kPerTask); ++i)
            all[i] = bumpOver(particles[i], is_enclosed[i] != 0, tree, normals, nearest);
    });
    std::vector<Bump> bumps;
    std::vector<ParticleAtRisk> rest;
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (!(all[i].height > 0)) continue;
        bumps.push_back(all[i]);
        rest.push_back(particles[i]);
    }
    particles = std::move(rest);
    return bumps;
}

// The part of a mesh near bumps, where alone vertices move.
class Neighbourhood {
public:
    /// tree: of the positions, with boxes that reach beyond their triangles by `margin`. All are referred to.
    Neighbourhood(const std::vector<Bump>& bumps, BetaMesh& mesh, std::vector<Vec3>& position,
                  const std::vector<Vec3>& normals, TriangleTree& tree, double margin)
        : mesh_(mesh), position_(position), normals_(normals), tree_(tree), margin_(margin) {
        for (const Bump& bump : bumps) widest_ = std::max(widest_, bump.width);
        const double reach = kBumpReach * widest_;
        const CellGrid centres(bumps.size(), reach, [&](std::size_t b) { return bumps[b].centre; });
        std::vector<std::uint8_t> is_near(position.size(), 0);
        parallelFor(position.size(), 1024, [&](std::size_t v) {
            centres.forRowsIn(position[v] - Vec3(reach), position[v] + Vec3(reach),
                              [&](std::uint32_t) { is_near[v] = 1; });
        });
        for (std::size_t group = 0; group < fading_.size(); ++group)
            std::ranges::copy_if(mesh.fading[group], std::back_inserter(fading_[group]), [&](const FadingVertex& v) {
                return is_near[v.vertex] || std::ranges::any_of(v.support, [&](std::uint32_t w) { return is_near[w]; });
            });
        vertices_ = indicesWhere(position.size(), [&](std::uint32_t v) { return is_near[v]; });
        sum_.resize(vertices_.size());
        weight_.resize(vertices_.size());
        displacement_.resize(position.size());
        cells_.emplace(vertices_.size(), widest_, [&](std::size_t i) { return position[vertices_[i]]; });
    }

    /// Moves vertices: each by a mean over the bumps that reach it, each as high as its weight there.
    void raise(const std::vector<Bump>& bumps) {
        std::ranges::fill(sum_, Vec3(0));
        std::ranges::fill(weight_, 0.0);
        for (const Bump& bump : bumps) add(bump);
        for (std::size_t i = 0; i < vertices_.size(); ++i)
            displacement_[vertices_[i]].position = weight_[i] > 0 ? sum_[i] / weight_[i] : Vec3(0);
        blendFading(fading_, displacement_);
        double farthest = 0;
        const auto move = [&](std::uint32_t v) {
            DualVec3& by = displacement_[v];
            farthest = std::max(farthest, by.position.length());
            mesh_.vertex[v] = mesh_.vertex[v] + by;
            position_[v] = mesh_.vertex[v].position;
            by = {};
        };
        for (const std::uint32_t v : vertices_) move(v);
        for (const std::vector<FadingVertex>& group : fading_)
            for (const FadingVertex& v : group) move(v.vertex);
        moved_ += farthest;
        since_fit_ += farthest;
        if (since_fit_ < margin_) return;
        tree_.refit();
        since_fit_ = 0;
    }

private:
    void add(const Bump& bump) {
        const double width = std::min(bump.width, widest_);
        const Vec3 reach(width + moved_);
        cells_->forRowsIn(bump.centre - reach, bump.centre + reach, [&](std::uint32_t i) {
            const std::uint32_t v = vertices_[i];
            const double t = 1 - (position_[v] - bump.centre).length2() / (width * width);
            const double facing = dot(normals_[v], bump.normal);
            if (!(t > 0) || !(facing > 0)) return;
            const double w = t * t * std::sqrt(facing);
            sum_[i] += bump.normal * (bump.height * w * w);
            weight_[i] += w;
        });
    }

    static constexpr double kBumpReach = 3;  // of the part, widths; displacements are blended over short distances

    BetaMesh& mesh_;
    std::vector<Vec3>& position_;
    const std::vector<Vec3>& normals_;
    TriangleTree& tree_;
    double margin_, widest_ = 0, moved_ = 0, since_fit_ = 0;
    FadingVertices fading_;
    std::vector<std::uint32_t> vertices_;
    std::optional<CellGrid> cells_;       // of these vertices, where they were at first
    std::vector<Vec3> sum_;               // of each of these
    std::vector<double> weight_;          // likewise
    std::vector<DualVec3> displacement_;  // of all vertices, 0 between calls
};

}  // namespace

ParticlesAtRisk particlesAtRisk(const SnappedParticles& snapped, double skin, bool all_are_at_risk) {
    ParticlesAtRisk found{{}, all_are_at_risk};
    if (!found.all_are_at_risk && !snapped.size_classes) return found;
    for (const std::uint32_t i : snapped.size_classes ? notAmongAlike(snapped) : exposureCandidates(snapped)) {
        if (!found.all_are_at_risk && snapped.radiusOf(i) == snapped.radius) continue;
        const double scale = static_cast<double>(snapped.radiusOf(i)) / static_cast<double>(snapped.radius);
        found.particle.push_back(
            {toDouble(snapped.position[i]) * snapped.quantum, scale, (1 - kMaxSkinSmoothing) * skin * scale});
    }
    return found;
}

InsideKeeper::InsideKeeper(const ParticlesAtRisk& at_risk, double spacing, BetaMesh& mesh)
    : particles_(at_risk.all_are_at_risk ? at_risk.particle : besideLarger(at_risk.particle, spacing, mesh)),
      mesh_(mesh),
      margin_(kBumpMargin * spacing) {
    if (particles_.empty()) return;
    for (const DualVec3& vertex : mesh.vertex) position_.push_back(vertex.position);
    tree_.emplace(position_, mesh.triangles, margin_);
}

void InsideKeeper::raise() {
    if (!tree_) return;
    tested_ = position_;
    is_enclosed_ = areEnclosed(particles_, *tree_);
    const std::vector<Vec3> normals = vertexNormals(mesh_);
    std::vector<ParticleAtRisk> particles = particles_;
    std::vector<Bump> bumps = bumpsOver(particles, is_enclosed_, *tree_, normals);
    if (bumps.empty()) return;
    Neighbourhood near(bumps, mesh_, position_, normals, *tree_, margin_);
    for (int round = 1; round <= kBumpRounds && !bumps.empty(); ++round) {
        near.raise(bumps);
        if (round < kBumpRounds) bumps = bumpsOver(particles, areEnclosed(particles, *tree_), *tree_, normals);
    }
}

// Whether the surface may have passed a point since raise() tested which particles it encloses: a triangle that moves
// on a straight path stays in the box around where it was and where it is.
bool InsideKeeper::mayHavePassed(const Vec3& point) const {
    bool any = false;
    tree_->forTriangles([&](const Box& box) { return box.intersects(point); },
                        [&](std::uint32_t triangle) {
                            for (const std::uint32_t v : mesh_.triangles[triangle])
                                any = any || position_[v] != tested_[v];
                            return !any;
                        });
    return any;
}

bool InsideKeeper::restore(const DualPoints& from) {
    if (!tree_) return false;
    parallelFor(position_.size(), 8192, [&](std::size_t v) { position_[v] = mesh_.vertex[v].position; });
    tree_->refit(tested_);
    std::vector<std::uint8_t> is_enclosed = is_enclosed_;
    parallelFor(particles_.size(), 64, [&](std::size_t i) {
        if (mayHavePassed(particles_[i].position)) is_enclosed[i] = isEnclosed(*tree_, particles_[i].position);
    });
    const std::vector<std::uint32_t> outside =
        indicesWhere(particles_.size(), [&](std::uint32_t i) { return is_enclosed[i] == 0; });
    if (outside.empty()) return false;
    std::vector<double> reach(outside.size());
    for (std::size_t i = 0; i < outside.size(); ++i) {
        const ParticleAtRisk& particle = particles_[outside[i]];
        reach[i] = restored_reach_ * (tree_->distanceTo(particle.position) + particle.least_depth);
    }
    restored_reach_ *= 2;
    const double farthest = *std::max_element(reach.begin(), reach.end());
    const CellGrid grid(outside.size(), farthest, [&](std::size_t i) { return particles_[outside[i]].position; });
    parallelFor(position_.size(), 1024, [&](std::size_t v) {
        double kept = 1;
        grid.forRowsIn(position_[v] - Vec3(farthest), position_[v] + Vec3(farthest), [&](std::uint32_t i) {
            const double distance = (position_[v] - particles_[outside[i]].position).length();
            kept = std::min(kept, smoothStep(2 * distance / reach[i] - 1).value);
        });
        if (kept < 1) mesh_.vertex[v] = from[v] + (mesh_.vertex[v] - from[v]) * kept;
    });
    return true;
}

}  // namespace betamesh
