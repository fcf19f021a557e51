#include "skin/features.h"

#include "base/cell_grid.h"
#include "base/index.h"
#include "base/union_find.h"
#include "exact/neighbour_finder.h"
#include "mesh/components.h"
#include "skin/constants.h"
#include "skin/voids.h"

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

// Particles of rim cells. Their components continue among the particles left out, and are not small.
std::vector<bool> particlesOnRim(const SnappedParticles& particles) {
    std::vector<bool> on_rim(particles.size(), false);
    for (std::size_t c = 0; c < particles.is_incomplete.size(); ++c)
        if (particles.is_incomplete[c])
            std::fill(on_rim.begin() + particles.cell_begin[c], on_rim.begin() + particles.cell_begin[c + 1], true);
    return on_rim;
}

constexpr double kVolumeRounding = 0.999;  // factor that allows for rounding errors

double ballVolume(double radius) { return 4 * std::numbers::pi / 3 * radius * radius * radius; }

// Volume enclosed by each component, world units cubed; negative if it faces inwards.
template <typename PositionOf>
std::vector<double> volumesOf(const Components& components, const std::vector<Triangle>& triangles,
                              const PositionOf& positionOf) {
    std::vector<double> volume(components.count, 0);
    std::vector<std::uint32_t> origin(components.count, kInvalidIndex);
    for (const Triangle& t : triangles) {
        const std::uint32_t component = components.of_vertex[t[0]];
        if (origin[component] == kInvalidIndex) origin[component] = t[0];
        const Vec3 o = positionOf(origin[component]);
        volume[component] += signedVolume(positionOf(t[0]) - o, positionOf(t[1]) - o, positionOf(t[2]) - o);
    }
    return volume;
}

// The least radius of a ball that has triangles in each component, world units.
std::vector<double> smallestBalls(const BetaMesh& mesh, const BallBoundary& boundary, const Components& components) {
    std::vector<double> smallest(components.count, boundary.worldRadius());
    if (boundary.radius_of.empty()) return smallest;
    for (std::size_t ball = 0; ball < boundary.position.size(); ++ball) {
        const double radius = boundary.worldRadiusOf(ball).value;
        for (std::uint32_t t = mesh.ball_begin[ball]; t < mesh.ball_begin[ball + 1]; ++t) {
            double& least = smallest[components.of_vertex[mesh.triangles[t][0]]];
            least = std::min(least, radius);
        }
    }
    return smallest;
}

void removeComponents(BetaMesh& mesh, const Components& components, const std::vector<bool>& is_removed) {
    keepTriangles(mesh, [&](std::size_t t) { return !is_removed[components.of_vertex[mesh.triangles[t][0]]]; });
    std::vector<std::uint32_t> new_index(mesh.vertex.size());
    std::uint32_t vertices = 0;
    for (std::size_t v = 0; v < new_index.size(); ++v) {
        if (components.of_vertex[v] == kInvalidIndex || is_removed[components.of_vertex[v]]) continue;
        mesh.vertex[vertices] = mesh.vertex[v];
        if (!mesh.rim_distance.empty()) mesh.rim_distance[vertices] = mesh.rim_distance[v];
        if (!mesh.scale.empty()) mesh.scale[vertices] = mesh.scale[v];
        new_index[v] = vertices++;
    }
    mesh.vertex.resize(vertices);
    if (!mesh.rim_distance.empty()) mesh.rim_distance.resize(vertices);
    if (!mesh.scale.empty()) mesh.scale.resize(vertices);
    for (Triangle& t : mesh.triangles)
        for (std::uint32_t& v : t) v = new_index[v];
    const auto isGone = [&](const auto& listed) {
        const std::uint32_t component = components.of_vertex[listed.vertex];
        return component == kInvalidIndex || is_removed[component];
    };
    for (auto& group : mesh.fading) {
        std::erase_if(group, isGone);
        for (FadingVertex& fading : group) {
            fading.vertex = new_index[fading.vertex];
            for (std::uint32_t& v : fading.support) v = new_index[v];
        }
    }
    std::erase_if(mesh.volume_offsets, isGone);
    for (VolumeOffset& offset : mesh.volume_offsets) offset.vertex = new_index[offset.vertex];
}

// The components with fewer than `least` particles. Components join units of particles, particlesOf(unit).
template <typename ParticlesOf>
SmallComponents smallAmong(const SnappedParticles& particles, UnionFind& components, std::uint32_t units,
                           const ParticlesOf& particlesOf, std::size_t least) {
    const std::vector<bool> on_rim = particlesOnRim(particles);
    std::vector<std::size_t> count(units, 0);
    for (std::uint32_t unit = 0; unit < units; ++unit)
        for (const std::uint32_t row : particlesOf(unit)) count[components.find(unit)] += on_rim[row] ? least : 1;
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

std::size_t fillBubbles(BetaMesh& mesh, const BallBoundary& boundary, const Features& features,
                        double reference_radius) {
    const double empty_radius = features.bubble_gap / 2;
    const bool by_gap = features.bubble_gap > 0;
    // Whether the reference radius is that of the largest balls, whose radius in quanta then counts.
    const bool is_of_largest = std::abs(reference_radius - boundary.worldRadius()) <= boundary.quantum;
    const double reference = is_of_largest ? boundary.worldRadius() : reference_radius;
    const double room = empty_radius - reference;  // radius of a ball that has to fit between those of the particles
    if (by_gap && room <= 0) return 0;
    const Components components = componentsOf(mesh.vertex.size(), mesh.triangles);
    const auto positionOf = [&](std::uint32_t v) -> const Vec3& { return mesh.vertex[v].position; };
    const std::vector<double> enclosed = volumesOf(components, mesh.triangles, positionOf);
    const std::vector<double> smallest = smallestBalls(mesh, boundary, components);
    const double smallest_of_all =
        smallest.empty() ? boundary.worldRadius() : *std::min_element(smallest.begin(), smallest.end());
    const double least_void = by_gap ? kVolumeRounding * ballVolume(room) : features.bubble_volume;
    std::vector<bool> is_removed(components.count), is_liquid(components.count);
    std::vector<std::uint32_t> large_voids;  // voids that could hold a liquid component
    std::vector<std::uint32_t> void_of(components.count, kInvalidIndex);
    bool any_undecided = false;
    for (std::uint32_t component = 0; component < components.count; ++component) {
        is_liquid[component] = enclosed[component] >= kMinLiquidVolume * ballVolume(smallest[component]);
        if (is_liquid[component]) continue;
        is_removed[component] = enclosed[component] > -least_void;
        if (enclosed[component] < -kMinLiquidVolume * ballVolume(smallest_of_all)) large_voids.push_back(component);
        if (by_gap && !is_removed[component]) any_undecided = true, void_of[component] = component;
    }
    std::sort(large_voids.begin(), large_voids.end(), [&](std::uint32_t a, std::uint32_t b) {
        return enclosed[a] != enclosed[b] ? enclosed[a] < enclosed[b] : a < b;
    });
    const std::vector<std::uint32_t> enclosing = enclosingVoids(mesh, boundary, components, large_voids, is_liquid);
    if (any_undecided) {
        for (std::uint32_t component = 0; component < components.count; ++component)
            if (enclosing[component] != kInvalidIndex) void_of[component] = void_of[enclosing[component]];
        const std::vector<bool> fits = voidsFittingBall(mesh, boundary, components, void_of,
                                                        is_of_largest ? empty_radius : boundary.worldRadius() + room);
        for (std::uint32_t component = 0; component < components.count; ++component)
            if (void_of[component] == component) is_removed[component] = !fits[component];
    }
    const auto filled = static_cast<std::size_t>(std::count(is_removed.begin(), is_removed.end(), true));
    for (std::uint32_t component = 0; component < components.count; ++component)
        if (enclosing[component] != kInvalidIndex) is_removed[component] = is_removed[enclosing[component]];
    if (filled > 0) removeComponents(mesh, components, is_removed);
    return filled;
}

void labelComponents(Mesh& mesh) {
    const Components components = componentsOf(mesh.position.size(), mesh.triangles);
    const auto positionOf = [&](std::uint32_t v) -> const Vec3& { return mesh.position[v]; };
    const std::vector<double> volume = volumesOf(components, mesh.triangles, positionOf);
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
