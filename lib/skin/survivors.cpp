#include "skin/survivors.h"

#include "core/parallel.h"
#include "core/simd.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace betamesh {

namespace {

constexpr float kSlack = 1e-5f;  // far above the rounding of the dot products it guards
constexpr std::size_t kCellsPerTask = 16;

// Patches still to be covered, packed to the front: their midpoints, and -1 where covered.
struct OpenPatches {
    alignas(64) std::array<float, kPatches> x, y, z;
    alignas(64) std::array<std::int32_t, kPatches> covered;
    std::array<std::uint16_t, kPatches> patch;
    std::size_t count;

    void reset() {
        const DirectionPatches& all = directionPatches();
        x = all.x, y = all.y, z = all.z;
        covered.fill(0);
        std::iota(patch.begin(), patch.end(), std::uint16_t{0});
        count = kPatches;
    }
    void pack() {
        std::size_t left = 0;
        for (std::size_t p = 0; p < count; ++p) {
            if (covered[p]) continue;
            x[left] = x[p], y[left] = y[p], z[left] = z[p], patch[left] = patch[p], covered[left++] = 0;
        }
        count = left;
    }
};

// Marks the patches whose midpoints m have offset·m >= least; true when none is left uncovered.
BETAMESH_EVERY_CPU bool cover(OpenPatches& patches, float x, float y, float z, float least) {
    std::int32_t all = -1;
    for (std::size_t p = 0; p < patches.count; ++p) {
        const float along = x * patches.x[p] + y * patches.y[p] + z * patches.z[p];
        patches.covered[p] |= along >= least ? -1 : 0;
        all &= patches.covered[p];
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

// The cap that a neighbour at squared distance d² <= 4r² covers: half-angle acos(d / 2r). A patch is inside
// where offset·midpoint >= least; false where the cap is too small for any patch.
bool leastAlong(const DirectionPatches& patches, float squared, float diameter, float& least) {
    const float distance = std::sqrt(squared), cos_cap = distance / diameter;
    if (cos_cap >= patches.cos_angle - kSlack) return false;
    const float sin_cap = std::sqrt(1 - cos_cap * cos_cap);
    least = distance * (cos_cap * patches.cos_angle + sin_cap * patches.sin_angle + kSlack);
    return true;
}

// Leaves the patches of one particle's sphere that no single candidate covers.
void coverPatches(const Candidates& candidates, const Vec3f& p, float diameter, OpenPatches& open) {
    constexpr std::size_t kPackEvery = 32;  // neighbours
    const DirectionPatches& patches = directionPatches();
    const float near = diameter * diameter / 4;  // most buried particles are buried by what is this near
    open.reset();
    const auto coverBetween = [&](float nearest, float farthest) {
        std::size_t used = 0;
        float least = 0;
        for (std::size_t k = 0; k < candidates.x.size(); ++k) {
            const float squared = candidates.squared[k];
            if (!(squared > nearest && squared <= farthest) || !leastAlong(patches, squared, diameter, least)) continue;
            if (cover(open, candidates.x[k] - p.x, candidates.y[k] - p.y, candidates.z[k] - p.z, least)) break;
            if (++used % kPackEvery == 0) open.pack();
        }
        open.pack();
    };
    coverBetween(0, near);
    if (open.count > 0) coverBetween(near, diameter * diameter);
}

}  // namespace

Survivors survivors(const SnappedParticles& particles) {
    const auto diameter = static_cast<float>(2 * particles.radius);
    const std::size_t cells = particles.cell.size(), tasks = (cells + kCellsPerTask - 1) / kCellsPerTask;
    std::vector<Survivors> found(tasks);
    parallelFor(tasks, 1, [&](std::size_t task) {
        Candidates candidates;
        OpenPatches open;
        for (std::size_t c = task * kCellsPerTask; c < std::min(cells, (task + 1) * kCellsPerTask); ++c) {
            candidates.gather(particles, c);
            const Vec3i corner = particles.cell[c] * (2 * particles.radius);
            for (std::uint32_t i = particles.cell_begin[c]; i < particles.cell_begin[c + 1]; ++i) {
                const Vec3f p(particles.position[i] - corner);
                squaredDistances(candidates.x.data(), candidates.y.data(), candidates.z.data(), candidates.x.size(),
                                 p.x, p.y, p.z, candidates.squared.data());
                coverPatches(candidates, p, diameter, open);
                if (open.count == 0) continue;
                PatchMask uncovered{};
                for (std::size_t k = 0; k < open.count; ++k)
                    uncovered[open.patch[k] / 64] |= std::uint64_t{1} << (open.patch[k] % 64);
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
