// Points, and the samples round them sixteen at a time: what sums over a neighbourhood go through.

#pragma once

#include "core/cell_order.h"
#include "core/simd.h"

#include <array>
#include <cstring>
#include <memory>

namespace betamesh {

/// Samples as sums take them: field f of sixteen samples. The first three fields are positions; samples that only fill
/// up the last block are zero in all fields.
template <std::size_t kFields>
struct alignas(kLanes * sizeof(float)) SampleBlock {
    Lanes field[kFields];

    /// Sets fields first to first + 3, as far as there are so many, of four samples from `lane` on.
    void set(std::size_t first, std::size_t lane, const Quad (&samples)[4]) {
        const Quad low01 = __builtin_shufflevector(samples[0], samples[1], 0, 4, 1, 5),
                   low23 = __builtin_shufflevector(samples[2], samples[3], 0, 4, 1, 5),
                   high01 = __builtin_shufflevector(samples[0], samples[1], 2, 6, 3, 7),
                   high23 = __builtin_shufflevector(samples[2], samples[3], 2, 6, 3, 7);
        const Quad fields[4] = {
            __builtin_shufflevector(low01, low23, 0, 1, 4, 5), __builtin_shufflevector(low01, low23, 2, 3, 6, 7),
            __builtin_shufflevector(high01, high23, 0, 1, 4, 5), __builtin_shufflevector(high01, high23, 2, 3, 6, 7)};
        for (std::size_t k = 0; k < 4 && first + k < kFields; ++k)
            std::memcpy(reinterpret_cast<float*>(&field[first + k]) + lane, &fields[k], sizeof(Quad));
    }
};

/// 1 where a place is less than sqrt(square) away from the box of that half edge round the origin, else 0.
void markNearBox(const float* x, const float* y, const float* z, std::size_t n, float half, float square,
                 std::uint32_t* is_near);

/// Calls visit(row of a point, its place, blocks) for every point, on several threads, where the blocks hold at least
/// all samples within reach of it, in an order that depends on nothing but their places and rows: what becomes of a
/// point does not depend on other points. Places and the positions in blocks count from one place near both, in units
/// of `unit`, which keeps them exact enough as floats.
///
/// fieldsOf    sample's row -> its fields after the position, kFields - 3 floats
/// edge        of the cells of points that share their blocks: small ones make visit's work less, large ones ours
/// cost        O(points + samples), and what visit does
template <std::size_t kFields, typename SampleAt, typename FieldsOf, typename PointAt, typename Visit>
void forPointsAmongSamples(std::size_t samples, const SampleAt& sampleAt, const FieldsOf& fieldsOf, std::size_t points,
                           const PointAt& pointAt, double reach, double edge, double unit, const Visit& visit) {
    constexpr std::size_t kQuads = (kFields - 3 + 3) / 4;  // of fields after the position
    using Block = SampleBlock<kFields>;
    const double scale = 1 / unit;
    const CellOrder far(samples, reach / 1.5, sampleAt), near(points, edge, pointAt);
    std::array<std::unique_ptr<float[]>, 3> position;  // in the order of cells, from the lowest corner of each
    for (auto& axis : position) axis = std::make_unique_for_overwrite<float[]>(samples);
    using Fields = std::array<Quad, kQuads>;
    const auto fields = std::make_unique_for_overwrite<Fields[]>(samples + 1);
    fields[samples] = {};
    parallelFor(far.cells(), 256, [&](std::size_t c) {
        const auto cell = static_cast<std::uint32_t>(c);
        for (std::uint32_t i = far.begin(cell); i < far.begin(cell + 1); ++i) {
            const std::uint32_t row = far.rows()[i];
            const Vec3 place = (sampleAt(row) - far.lowestCorner(cell)) * scale;
            for (std::size_t k = 0; k < 3; ++k) position[k][i] = static_cast<float>(place[static_cast<int>(k)]);
            const std::array<float, kFields - 3> given = fieldsOf(row);
            fields[i] = {};
            std::memcpy(&fields[i], given.data(), sizeof given);
        }
    });

    const auto half = static_cast<float>(near.edge() * scale / 2);
    const auto square = static_cast<float>(reach * scale * reach * scale);
    parallelRanges(near.cells(), 16, [&](std::size_t first, std::size_t last) {
        std::vector<Block> blocks;
        std::array<std::vector<float>, 3> place;  // of candidates
        std::vector<std::uint32_t> candidate, near_enough;
        for (auto cell = static_cast<std::uint32_t>(first); cell < last; ++cell) {
            const Vec3 low = near.lowestCorner(cell), high = low + Vec3(near.edge()), middle = (low + high) / 2;
            std::size_t n = 0;
            far.forCellsIn(low - Vec3(reach), high + Vec3(reach), [&](std::uint32_t other) {
                const std::uint32_t begin = far.begin(other), end = far.begin(other + 1);
                const std::size_t more = n + end - begin;
                const Vec3f corner((far.lowestCorner(other) - middle) * scale);
                for (std::size_t k = 0; k < 3; ++k) {
                    if (more > place[k].size()) place[k].resize(2 * more);
                    for (std::uint32_t i = begin; i < end; ++i)
                        place[k][n + i - begin] = position[k][i] + corner[static_cast<int>(k)];
                }
                if (more > candidate.size()) candidate.resize(2 * more), near_enough.resize(2 * more);
                for (std::uint32_t i = begin; i < end; ++i) candidate[n + i - begin] = i;
                n = more;
            });
            markNearBox(place[0].data(), place[1].data(), place[2].data(), n, half, square, near_enough.data());
            std::size_t used = 0;  // the numbers of those that are, moved to the front
            for (std::uint32_t i = 0; i < n; ++i) {
                const std::uint32_t is_near = near_enough[i];
                near_enough[used] = i;
                used += is_near;
            }
            const std::size_t count = (used + kLanes - 1) / kLanes;
            if (count > blocks.size()) blocks.resize(2 * count);
            for (std::size_t u = 0; u < count * kLanes; u += 4) {
                Block& block = blocks[u / kLanes];
                const Fields* sample[4];
                for (std::size_t s = 0; s < 4; ++s) {
                    const bool exists = u + s < used;
                    const std::uint32_t i = exists ? near_enough[u + s] : 0;
                    for (std::size_t k = 0; k < 3; ++k) block.field[k][u % kLanes + s] = exists ? place[k][i] : 0;
                    sample[s] = &fields[exists ? candidate[i] : samples];
                }
                for (std::size_t m = 0; m < kQuads; ++m)
                    block.set(3 + 4 * m, u % kLanes,
                              {(*sample[0])[m], (*sample[1])[m], (*sample[2])[m], (*sample[3])[m]});
            }
            for (const std::uint32_t row : near.rowsOf(cell))
                visit(row, Vec3f((pointAt(row) - middle) * scale), std::span<const Block>(blocks.data(), count));
        }
    });
}

/// The sums of all lanes of several: halves onto halves.
template <std::size_t n>
__attribute__((always_inline)) inline void addUpLanes(const Lanes (&lanes)[n], double* sums) {
    float part[n][kLanes];
    std::memcpy(part, lanes, sizeof part);
    for (std::size_t s = 0; s < n; ++s) {
        for (std::size_t l = 0; l < 8; ++l) part[s][l] += part[s][l + 8];
        for (std::size_t l = 0; l < 4; ++l) part[s][l] += part[s][l + 4];
        sums[s] = static_cast<double>((part[s][0] + part[s][2]) + (part[s][1] + part[s][3]));
    }
}

}  // namespace betamesh
