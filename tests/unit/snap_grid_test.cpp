#include "exact/snapped_particles.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace betamesh {
namespace {

TEST(SnapGrid, RoundsToTheNearestPointHalvesAwayFromZero) {
    const SnapGrid grid(1);
    std::mt19937 random(3);
    std::vector<float> coordinates = {0, -0.0F, 0x1p-149F, 0x1p29F, std::nextafter(0x1p29F, 0.0F)};
    for (int k = -40; k < 50; ++k)  // quanta, and the numbers next to a half
        for (const double quanta : {0.5, 1.5, 2.0, 1023.5})
            for (const float direction : {-1e9F, 1e9F}) {
                const auto x = static_cast<float>((k + quanta) / grid.perUnit());
                coordinates.insert(coordinates.end(), {x, std::nextafter(x, direction)});
            }
    for (int i = 0; i < 100000; ++i) {
        const auto mantissa = std::uniform_real_distribution<float>(-1, 1)(random);
        coordinates.push_back(std::ldexp(mantissa, std::uniform_int_distribution<int>(-40, 29)(random)));
    }
    for (const float x : coordinates) {
        const std::int64_t nearest = std::llround(x * grid.perUnit());
        EXPECT_EQ(grid.at({x, 0, -x}), Vec3i(nearest, 0, -nearest)) << x;
    }
}

TEST(SnapGrid, CellsBeginAtMultiplesOfTheirEdge) {
    std::mt19937 random(4);
    for (const double radius : {1.0, 1.5, 0.7000123, 1 - 1e-9, 3e-11, 7e12}) {
        const SnapGrid grid(radius);
        const std::int64_t edge = 2 * grid.radius(), farthest = (std::int64_t{1} << 50) / edge;
        for (int i = 0; i < 20000; ++i) {
            const std::int64_t limit = std::min<std::int64_t>(farthest, std::int64_t{1} << random() % 31);
            const std::int64_t cell = std::uniform_int_distribution<std::int64_t>(-limit, limit - 1)(random);
            const std::int64_t inside = std::uniform_int_distribution<std::int64_t>(0, edge - 1)(random);
            EXPECT_EQ(grid.cellOf({cell * edge, cell * edge + inside, (cell + 1) * edge - 1}), Vec3i(cell));
        }
    }
}

}  // namespace
}  // namespace betamesh
