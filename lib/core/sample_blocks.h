// Points, and the samples round them sixteen at a time: what sums over a neighbourhood go through.

#pragma once

#include "core/cell_order.h"
#include "core/simd.h"

#include <array>
#include <cstring>

namespace betamesh {

/// Samples as sums take them: field f of sixteen samples. The first three fields are positions; samples that only fill
/// up the last block are zero in all fields.
template <std::size_t kFields>
struct alignas(kLanes * sizeof(float)) SampleBlock {
    Lanes field[kFields];
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
/// cell        edge of the cells of points that share their blocks: small ones make visit's work less, large ones ours
/// cost        O(points + samples), and what visit does
template <std::size_t kFields, typename SampleAt, typename FieldsOf, typename PointAt, typename Visit>
void forPointsAmongSamples(std::size_t samples, const SampleAt& sampleAt, const FieldsOf& fieldsOf, std::size_t points,
                           const PointAt& pointAt, double reach, double cell, double unit, const Visit& visit) {
    using Fields = std::array<float, kFields - 3>;
    using Block = SampleBlock<kFields>;
    const double scale = 1 / unit;
    const CellOrder far(samples, reach / 1.5, sampleAt), near(points, cell, pointAt);
    std::array<std::vector<float>, 3> position;  // in the order of cells, from the lowest corner of each
    for (auto& axis : position) axis.resize(samples);
    std::vector<Fields> fields(samples);
    parallelFor(samples, 4096, [&](std::size_t i) {
        const CellOrder::Entry& entry = far.entries()[i];
        const Vec3 place = (sampleAt(entry.row) - far.lowestCorner(entry)) * scale;
        for (std::size_t k = 0; k < 3; ++k) position[k][i] = static_cast<float>(place[static_cast<int>(k)]);
        fields[i] = fieldsOf(entry.row);
    });

    const auto half = static_cast<float>(near.edge() * scale / 2);
    const auto square = static_cast<float>(reach * scale * reach * scale);
    parallelRanges(near.cells().size() - 1, 16, [&](std::size_t first, std::size_t last) {
        std::vector<Block> blocks;
        std::array<std::vector<float>, 3> place;  // of candidates
        std::vector<std::uint32_t> candidate, near_enough;
        for (std::size_t g = first; g < last; ++g) {
            const auto here = std::span(near.entries()).subspan(near.cells()[g], near.cells()[g + 1] - near.cells()[g]);
            const Vec3 low = near.lowestCorner(here[0]), high = low + Vec3(near.edge()), middle = (low + high) / 2;
            std::size_t n = 0;
            far.forCellsIn(low - Vec3(reach), high + Vec3(reach), [&](std::uint32_t begin, std::uint32_t end) {
                const std::size_t more = n + end - begin;
                const Vec3f corner((far.lowestCorner(far.entries()[begin]) - middle) * scale);
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
            if (count > 0) blocks[count - 1] = {};
            for (std::size_t u = 0; u < used; ++u) {
                auto& field = blocks[u / kLanes].field;
                const std::uint32_t i = near_enough[u];
                for (std::size_t k = 0; k < 3; ++k) field[k][u % kLanes] = place[k][i];
                for (std::size_t k = 3; k < kFields; ++k) field[k][u % kLanes] = fields[candidate[i]][k - 3];
            }
            for (const CellOrder::Entry& entry : here)
                visit(entry.row, Vec3f((pointAt(entry.row) - middle) * scale),
                      std::span<const Block>(blocks.data(), count));
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
