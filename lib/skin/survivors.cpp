#include "skin/survivors.h"

#include "core/parallel.h"
#include "exact/buried.h"

namespace betamesh {

std::vector<std::uint32_t> survivors(const SnappedParticles& particles) {
    std::vector<PlaceInCell> place(particles.size());
    std::vector<std::uint8_t> open(particles.cell.size());
    parallelFor(open.size(), 64, [&](std::size_t c) {
        const Vec3i corner = particles.cell[c] * (2 * particles.radius);
        for (std::uint32_t i = particles.cell_begin[c]; i < particles.cell_begin[c + 1]; ++i)
            place[i] = placeInCell(particles.position[i] - corner, particles.radius);
        open[c] = particles.cell_role.empty() || particles.cell_role[c] == CellRole::open;
    });
    const std::vector<std::uint8_t> is_buried = buried(particles.cell, particles.cell_begin, place, open);
    return rowsWhere(is_buried.size(), [&](std::uint32_t i) { return !is_buried[i]; });
}

}  // namespace betamesh
