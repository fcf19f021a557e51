#include "skin/survivors.h"

#include "core/parallel.h"
#include "core/simd.h"

#include <algorithm>
#include <cmath>

namespace betamesh {

namespace {

constexpr float kSlack = 1e-5f;  // far above the rounding of the dot products it guards
constexpr std::size_t kCellsPerTask = 16;

using Covered = std::array<std::int32_t, kPatches>;  // -1 where covered, 0 elsewhere

// Marks the patches whose midpoints m have offset·m >= least; true when none is left uncovered.
BETAMESH_EVERY_CPU bool cover(const DirectionPatches& patches, float x, float y, float z, float least,
                              Covered& covered) {
    std::int32_t all = -1;
    for (std::size_t p = 0; p < kPatches; ++p) {
        const float along = x * patches.x[p] + y * patches.y[p] + z * patches.z[p];
        covered[p] |= along >= least ? -1 : 0;
        all &= covered[p];
    }
    return all == -1;
}

// Squared distances from one particle to all candidates.
BETAMESH_EVERY_CPU void squaredDistances(const float* x, const float* y, const float* z, std::size_t n, float px,
                                         float py, float pz, float* squared) {
    for (std::size_t k = 0; k < n; ++k) {
        const float dx = x[k] - px, dy = y[k] - py, dz = z[k] - pz;
        squared[k] = dx * dx + dy * dy + dz * dz;
    }
}

// The candidates round one cell, relative to the cell's corner: integers below 2^24, exact as floats.
struct Candidates {
    std::vector<float> x, y, z, squared;

    void gather(const SnappedParticles& particles, std::size_t cell) {
        x.clear(), y.clear(), z.clear();
        const Vec3i corner = particles.cell[cell] * (2 * particles.radius);
        std::array<CellRange, 9> buffer;
        for (const CellRange range : rangesAround(particles, cell, buffer))
            for (std::uint32_t k = range.begin; k < range.end; ++k) {
                const Vec3i offset = particles.position[k] - corner;
                x.push_back(static_cast<float>(offset.x));
                y.push_back(static_cast<float>(offset.y));
                z.push_back(static_cast<float>(offset.z));
            }
        squared.resize(x.size());
    }
};

// Covers what the candidates at squared distances in (nearest, farthest] cover; true when nothing is left.
bool coverBetween(const Candidates& candidates, const Vec3f& p, float nearest, float farthest, float diameter,
                  const DirectionPatches& patches, Covered& covered) {
    for (std::size_t k = 0; k < candidates.x.size(); ++k) {
        const float squared = candidates.squared[k];
        if (!(squared > nearest && squared <= farthest)) continue;
        const float distance = std::sqrt(squared);
        const float cos_cap = distance / diameter;  // the cap's half-angle is acos(d / 2r)
        if (cos_cap >= patches.cos_angle - kSlack) continue;
        const float sin_cap = std::sqrt(1 - cos_cap * cos_cap);
        const float least = distance * (cos_cap * patches.cos_angle + sin_cap * patches.sin_angle + kSlack);
        if (cover(patches, candidates.x[k] - p.x, candidates.y[k] - p.y, candidates.z[k] - p.z, least, covered))
            return true;
    }
    return false;
}

}  // namespace

Survivors survivors(const SnappedParticles& particles) {
    const DirectionPatches& patches = directionPatches();
    const auto diameter = static_cast<float>(2 * particles.radius);
    const float near = diameter * diameter / 4;  // most buried particles are buried by what is this near

    const std::size_t cells = particles.cell.size(), tasks = (cells + kCellsPerTask - 1) / kCellsPerTask;
    std::vector<Survivors> found(tasks);
    parallelFor(tasks, 1, [&](std::size_t task) {
        Candidates candidates;
        Covered covered;
        for (std::size_t c = task * kCellsPerTask; c < std::min(cells, (task + 1) * kCellsPerTask); ++c) {
            candidates.gather(particles, c);
            const Vec3i corner = particles.cell[c] * (2 * particles.radius);
            for (std::uint32_t i = particles.cell_begin[c]; i < particles.cell_begin[c + 1]; ++i) {
                const Vec3f p(particles.position[i] - corner);
                squaredDistances(candidates.x.data(), candidates.y.data(), candidates.z.data(), candidates.x.size(),
                                 p.x, p.y, p.z, candidates.squared.data());
                covered.fill(0);
                if (coverBetween(candidates, p, 0, near, diameter, patches, covered) ||
                    coverBetween(candidates, p, near, diameter * diameter, diameter, patches, covered))
                    continue;
                PatchMask uncovered{};
                for (std::size_t patch = 0; patch < kPatches; ++patch)
                    if (!covered[patch]) uncovered[patch / 64] |= std::uint64_t{1} << (patch % 64);
                found[task].particle.push_back(i);
                found[task].uncovered.push_back(uncovered);
            }
        }
    });

    Survivors all;
    for (const Survivors& part : found) {
        all.particle.insert(all.particle.end(), part.particle.begin(), part.particle.end());
        all.uncovered.insert(all.uncovered.end(), part.uncovered.begin(), part.uncovered.end());
    }
    return all;
}

}  // namespace betamesh
