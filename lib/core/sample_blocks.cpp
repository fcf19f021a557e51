#include "core/sample_blocks.h"

namespace betamesh {

BETAMESH_EVERY_CPU
void markNearBox(const float* x, const float* y, const float* z, std::size_t n, float half, float square,
                 std::uint32_t* is_near) {
    for (std::size_t i = 0; i < n; ++i) {
        const float px = std::abs(x[i]) - half, py = std::abs(y[i]) - half, pz = std::abs(z[i]) - half;
        const float bx = px > 0 ? px : 0, by = py > 0 ? py : 0, bz = pz > 0 ? pz : 0;
        is_near[i] = bx * bx + by * by + bz * bz < square ? 1 : 0;
    }
}

}  // namespace betamesh
