#include "skin/features.h"

#include "base/cell_grid.h"
#include "base/index.h"
#include "base/union_find.h"
#include "exact/neighbour_finder.h"
#include "mesh/components.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <tuple>

namespace betamesh {

namespace {

// Occupied cells in order, so small that the balls of any two particles in one cell meet. Particles whose balls meet
// are at most two cells apart.
class MeetingCells {
public:
    explicit MeetingCells(const SnappedParticles& particles)
        : particles_(particles),
          reach_(4 * particles.radius * particles.radius),
          order_(particles.size(), std::floor(2 * static_cast<double>(particles.radius) / std::numbers::sqrt3),
                 [&](std::size_t i) { return toDouble(particles.position[i]); }) {}

    std::uint32_t size() const { return order_.cells(); }
    std::span<const std::uint32_t> operator[](std::uint32_t cell) const { return order_.rowsOf(cell); }
    bool meet(std::uint32_t a, std::uint32_t b) const {
        for (const std::uint32_t p : (*this)[a])
            for (const std::uint32_t q : (*this)[b])
                if ((particles_.position[p] - particles_.position[q]).length2() <= reach_) return true;
        return false;
    }

    // Calls visit(cell, other) for all pairs in which the other is dy rows and dz layers on, and `first` to `last`
    // columns. One sweep: both cells only advance.
    template <typename Visit>
    void forPairs(std::int32_t dz, std::int32_t dy, std::int32_t first, std::int32_t last, const Visit& visit) const {
        std::uint32_t begin = 0;
        for (std::uint32_t cell = 0; cell < size(); ++cell) {
            const auto [z, y, x] = order_.cell(cell);
            const GridCell from{z + dz, y + dy, x + first}, to{z + dz, y + dy, x + last};
            while (begin < size() && order_.cell(begin) < from) ++begin;
            for (std::uint32_t other = begin; other < size() && order_.cell(other) <= to; ++other) visit(cell, other);
        }
    }

private:
    const SnappedParticles& particles_;
    std::int64_t reach_;
    CellGrid order_;
};

// Particles of cells beside which particles were left out. Their components may continue there, and are not small.
std::vector<bool> particlesBesideOmitted(const SnappedParticles& particles) {
    std::vector<bool> may_continue(particles.size(), false);
    for (std::size_t c = 0; c < particles.is_incomplete.size(); ++c)
        if (particles.is_incomplete[c])
            std::fill(may_continue.begin() + particles.cell_begin[c],
                      may_continue.begin() + particles.cell_begin[c + 1], true);
    return may_continue;
}

// The components with fewer than `least` particles. Components join units of particles, particlesOf(unit).
template <typename ParticlesOf>
SmallComponents smallAmong(const SnappedParticles& particles, UnionFind& components, std::uint32_t units,
                           const ParticlesOf& particlesOf, std::size_t least) {
    const std::vector<bool> may_continue = particlesBesideOmitted(particles);
    std::vector<std::size_t> count(units, 0);
    for (std::uint32_t unit = 0; unit < units; ++unit)
        for (const std::uint32_t row : particlesOf(unit)) count[components.find(unit)] += may_continue[row] ? least : 1;
    SmallComponents small;
    for (std::uint32_t unit = 0; unit < units; ++unit) {
        const std::uint32_t component = components.find(unit);
        if (count[component] >= least) continue;
        small.count += component == unit;
        const auto own = particlesOf(unit);
        small.particle.insert(small.particle.end(), own.begin(), own.end());
    }
    parallelSort(small.particle, std::less<>());
    return small;
}

// The same as smallComponents() for balls of different radii, neighbour by neighbour.
SmallComponents smallComponentsOfUnequal(const SnappedParticles& particles, std::size_t least) {
    const auto n = static_cast<std::uint32_t>(particles.size());
    UnionFind components(n);
    NeighbourFinder finder(particles);
    std::vector<Neighbour> neighbours;
    for (std::uint32_t i = 0; i < n; ++i) {
        finder.find(i, neighbours);  // a ball inside another does not count as its neighbour, but the reverse does
        for (const Neighbour& neighbour : neighbours) components.join(i, neighbour.particle);
    }
    return smallAmong(
        particles, components, n, [](std::uint32_t i) { return std::array{i}; }, least);
}

}  // namespace

SmallComponents smallComponents(const SnappedParticles& particles, std::size_t least) {
    if (particles.size() == 0) return {};
    if (particles.size_classes) return smallComponentsOfUnequal(particles, least);
    const MeetingCells cells(particles);
    UnionFind components(cells.size());
    for (std::int32_t dz = 0; dz <= 2; ++dz)
        for (std::int32_t dy = dz == 0 ? 0 : -2; dy <= 2; ++dy)
            cells.forPairs(dz, dy, dz == 0 && dy == 0 ? 1 : -2, 2, [&](std::uint32_t a, std::uint32_t b) {
                if (components.find(a) != components.find(b) && cells.meet(a, b)) components.join(a, b);
            });
    return smallAmong(
        particles, components, cells.size(), [&](std::uint32_t cell) { return cells[cell]; }, least);
}

SnappedParticles withoutRows(const SnappedParticles& particles, const std::vector<std::uint32_t>& rows) {
    SnappedParticles rest;
    rest.quantum = particles.quantum;
    rest.radius = particles.radius;
    rest.most_halvings = particles.most_halvings;
    auto next_removed = rows.begin();
    for (std::size_t cell = 0; cell < particles.cell.size(); ++cell) {
        const auto first = static_cast<std::uint32_t>(rest.position.size());
        for (std::uint32_t i = particles.cell_begin[cell]; i < particles.cell_begin[cell + 1]; ++i) {
            if (next_removed != rows.end() && *next_removed == i) {
                ++next_removed;
                continue;
            }
            rest.position.push_back(particles.position[i]);
            rest.row.push_back(particles.row[i]);
            if (!particles.is_covered.empty()) rest.is_covered.push_back(particles.is_covered[i]);
            if (!particles.radius_of.empty()) rest.radius_of.push_back(particles.radius_of[i]);
        }
        if (rest.position.size() == first) continue;
        rest.cell.push_back(particles.cell[cell]);
        if (!particles.is_incomplete.empty()) rest.is_incomplete.push_back(particles.is_incomplete[cell]);
        rest.cell_begin.push_back(first);
    }
    rest.cell_begin.push_back(static_cast<std::uint32_t>(rest.position.size()));
    listSizeClasses(rest);
    return rest;
}

void addSpheres(const Particles& particles, const SnappedParticles& snapped, const std::vector<std::uint32_t>& rows,
                Spheres& spheres) {
    for (const std::uint32_t i : rows) {
        const std::uint32_t row = snapped.row[i];
        spheres.particle.push_back(row);
        spheres.position.emplace_back(particles.position[row]);
        if (!particles.velocity.empty()) spheres.velocity.emplace_back(particles.velocity[row]);
        if (!particles.id.empty()) spheres.id.push_back(particles.id[row]);
        spheres.radius.push_back(static_cast<float>(static_cast<double>(snapped.radiusOf(i)) * snapped.quantum));
    }
}

RemovedDroplets removeDroplets(const Particles& particles, const Features& features, SnappedParticles& snapped,
                               Spheres& apart) {
    if (features.droplets == Droplets::mesh) return {};
    const auto least = static_cast<std::size_t>(std::max(1, features.droplet_particles));
    const SmallComponents small = smallComponents(snapped, least);
    if (features.droplets == Droplets::points) addSpheres(particles, snapped, small.particle, apart);
    snapped = withoutRows(snapped, small.particle);
    return {small.count, small.particle.size()};
}

std::vector<std::uint32_t> tendrilParticles(const BallBoundary& boundary) {
    std::vector<bool> in_triangle(boundary.position.size(), false), in_circle = in_triangle;
    for (const Triangle& t : boundary.triangle)
        for (const std::uint32_t ball : t) in_triangle[ball] = true;
    for (const auto& circle : boundary.circle)
        for (const std::uint32_t ball : circle) in_circle[ball] = true;
    std::vector<std::uint32_t> rows;
    for (std::size_t ball = 0; ball < in_circle.size(); ++ball)
        if (in_circle[ball] && !in_triangle[ball]) rows.push_back(boundary.snapped_row[ball]);
    return rows;
}

void labelComponents(Mesh& mesh) {
    const Components components = componentsOf(mesh.position.size(), mesh.triangles);
    const auto positionOf = [&](std::uint32_t v) -> const Vec3& { return mesh.position[v]; };
    const std::vector<double> volume = enclosedVolumes(components, mesh.triangles, positionOf);
    const auto sortKey = [&](std::uint32_t v) {
        const Vec3& p = mesh.position[v];
        return std::tuple(p.x, p.y, p.z, v);
    };
    std::vector<std::uint32_t> first(components.count, kInvalidIndex);
    for (std::uint32_t v = 0; v < components.of_vertex.size(); ++v) {
        if (components.of_vertex[v] == kInvalidIndex) continue;
        std::uint32_t& best = first[components.of_vertex[v]];
        if (best == kInvalidIndex || sortKey(v) < sortKey(best)) best = v;
    }
    std::vector<std::uint32_t> order(components.count);
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return volume[a] != volume[b] ? volume[a] > volume[b] : sortKey(first[a]) < sortKey(first[b]);
    });
    std::vector<std::int32_t> label(components.count);
    for (std::size_t i = 0; i < order.size(); ++i) label[order[i]] = static_cast<std::int32_t>(i);
    std::vector<std::int32_t>& labels = mesh.component.emplace();
    labels.reserve(mesh.triangles.size());
    for (const Triangle& t : mesh.triangles) labels.push_back(label[components.of_vertex[t[0]]]);
}

}  // namespace betamesh
