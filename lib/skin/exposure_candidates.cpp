
#include "skin/exposure_candidates.h"

#include "base/parallel.h"
#include "skin/covered.h"

namespace betamesh {

std::vector<std::uint32_t> exposureCandidates(const SnappedParticles& particles) {
    const auto notBuried = [](const std::vector<std::uint8_t>& is_buried) {
        return indicesWhere(is_buried.size(), [&](std::uint32_t i) { return !is_buried[i]; });
    };
    if (!particles.is_buried.empty()) return notBuried(particles.is_buried);
    std::vector<PlaceInCell> place(particles.size());
    parallelFor(particles.cell.size(), 64, [&](std::size_t c) {
        const Vec3i corner = particles.cell[c] * (2 * particles.radius);
        for (std::uint32_t i = particles.cell_begin[c]; i < particles.cell_begin[c + 1]; ++i)
            place[i] = placeInCell(particles.position[i] - corner, particles.radius);
    });
    return notBuried(coveredParticles(particles.cell, particles.cell_begin, place));
}

}  // namespace betamesh
