#include "core/ball_boundary.h"

namespace betamesh {

std::uint32_t reverseSide(const BallBoundary& boundary, std::uint32_t v) {
    const auto reversed = [&](std::size_t other) {
        const Triangle &a = boundary.triangle[v], &b = boundary.triangle[other];
        return a[0] == b[0] && a[1] == b[2] && a[2] == b[1];
    };
    if (v > 0 && reversed(v - 1)) return v - 1;
    if (v + 1 < boundary.triangle.size() && reversed(v + 1)) return v + 1;
    return v;
}

std::int64_t eulerCharacteristic(const BallBoundary& boundary) {
    const auto vertices = static_cast<std::int64_t>(boundary.vertex.size());
    std::int64_t faces = 0;  // a face with c cycles is a sphere with c holes; full circles add nothing
    for (std::size_t f = 0; f < boundary.face.size(); ++f)
        faces += 2 - static_cast<std::int64_t>(boundary.face[f].size());
    return vertices - 3 * vertices / 2 + faces;
}

}  // namespace betamesh
