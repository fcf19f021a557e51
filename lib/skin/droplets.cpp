
#include "skin/droplets.h"

#include "base/cell_order.h"
#include "base/union_find.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace betamesh {

namespace {

// Occupied cells so small that any two particles in one of them meet, in order. Particles that meet are at most two
// cells apart.
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

    // Calls visit(cell, other) for all pairs in which the other is dy rows and dz layers farther on, dx columns from
    // first to last: one sweep, both cells only ever advance.
    template <typename Visit>
    void forPairs(std::int32_t dz, std::int32_t dy, std::int32_t first, std::int32_t last, const Visit& visit) const {
        std::uint32_t begin = 0;
        for (std::uint32_t cell = 0; cell < size(); ++cell) {
            const auto [z, y, x] = order_.place(cell);
            const CellPlace from{z + dz, y + dy, x + first}, to{z + dz, y + dy, x + last};
            while (begin < size() && order_.place(begin) < from) ++begin;
            for (std::uint32_t other = begin; other < size() && order_.place(other) <= to; ++other) visit(cell, other);
        }
    }

private:
    const SnappedParticles& particles_;
    std::int64_t reach_;
    CellOrder order_;
};

// What they belong to goes on where particles were left out, and is not small.
std::vector<bool> particlesOnRim(const SnappedParticles& particles) {
    std::vector<bool> on_rim(particles.size(), false);
    for (std::size_t c = 0; c < particles.is_rim.size(); ++c)
        if (particles.is_rim[c])
            std::fill(on_rim.begin() + particles.cell_begin[c], on_rim.begin() + particles.cell_begin[c + 1], true);
    return on_rim;
}

}  // namespace

SmallComponents smallComponents(const SnappedParticles& particles, std::size_t least) {
    SmallComponents small;
    if (particles.size() == 0) return small;
    const MeetingCells cells(particles);
    UnionFind components(cells.size());
    for (std::int32_t dz = 0; dz <= 2; ++dz)
        for (std::int32_t dy = dz == 0 ? 0 : -2; dy <= 2; ++dy)
            cells.forPairs(dz, dy, dz == 0 && dy == 0 ? 1 : -2, 2, [&](std::uint32_t a, std::uint32_t b) {
                if (components.find(a) != components.find(b) && cells.meet(a, b)) components.join(a, b);
            });

    const std::vector<bool> on_rim = particlesOnRim(particles);
    std::vector<std::size_t> particles_of(cells.size(), 0);
    for (std::uint32_t cell = 0; cell < cells.size(); ++cell) {
        std::size_t& count = particles_of[components.find(cell)];
        for (const std::uint32_t row : cells[cell]) count += on_rim[row] ? least : 1;
    }
    for (std::uint32_t cell = 0; cell < cells.size(); ++cell) {
        const std::uint32_t component = components.find(cell);
        if (particles_of[component] >= least) continue;
        small.count += component == cell;
        small.particle.insert(small.particle.end(), cells[cell].begin(), cells[cell].end());
    }
    parallelSort(small.particle, std::less<>());
    return small;
}

SnappedParticles without(const SnappedParticles& particles, const std::vector<std::uint32_t>& rows) {
    SnappedParticles rest;
    rest.quantum = particles.quantum;
    rest.radius = particles.radius;
    auto leaving = rows.begin();
    for (std::size_t cell = 0; cell < particles.cell.size(); ++cell) {
        const auto first = static_cast<std::uint32_t>(rest.position.size());
        for (std::uint32_t i = particles.cell_begin[cell]; i < particles.cell_begin[cell + 1]; ++i) {
            if (leaving != rows.end() && *leaving == i) {
                ++leaving;
                continue;
            }
            rest.position.push_back(particles.position[i]);
            rest.row.push_back(particles.row[i]);
            if (!particles.is_buried.empty()) rest.is_buried.push_back(particles.is_buried[i]);
        }
        if (rest.position.size() == first) continue;
        rest.cell.push_back(particles.cell[cell]);
        if (!particles.is_rim.empty()) rest.is_rim.push_back(particles.is_rim[cell]);
        rest.cell_begin.push_back(first);
    }
    rest.cell_begin.push_back(static_cast<std::uint32_t>(rest.position.size()));
    return rest;
}

void addSpheres(const Particles& particles, const SnappedParticles& snapped, const std::vector<std::uint32_t>& rows,
                Spheres& spheres) {
    for (const std::uint32_t i : rows) {
        const std::uint32_t row = snapped.row[i];
        spheres.position.emplace_back(particles.position[row]);
        if (!particles.velocity.empty()) spheres.velocity.emplace_back(particles.velocity[row]);
        if (!particles.id.empty()) spheres.id.push_back(particles.id[row]);
        spheres.radius.push_back(static_cast<float>(static_cast<double>(snapped.radius) * snapped.quantum));
    }
}

LeftOut leaveOutDroplets(const Particles& particles, const Features& features, SnappedParticles& snapped,
                         Spheres& apart) {
    if (features.droplets == Droplets::mesh) return {};
    const auto least = static_cast<std::size_t>(std::max(1, features.droplet_particles));
    const SmallComponents small = smallComponents(snapped, least);
    if (features.droplets == Droplets::points) addSpheres(particles, snapped, small.particle, apart);
    snapped = without(snapped, small.particle);
    return {small.count, small.particle.size()};
}

}  // namespace betamesh
