// Axis-aligned boxes: squared distances, and the Morton order that keeps nearby boxes close in memory.

#pragma once

#include "betamesh/vec3.h"

#include <algorithm>

namespace betamesh {

/// Squared distance from a point to a box; 0 inside. Rounding is monotone: the computed distance to a box never exceeds
/// the computed distance to a point or box inside it, so it is safe for culling.
inline double squaredDistance(const Box& box, const Vec3& p) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
        const double outside = std::max({box.min[k] - p[k], p[k] - box.max[k], 0.0});
        sum += outside * outside;
    }
    return sum;
}

/// Squared distance between two boxes; 0 where they overlap. Monotone in the same way.
inline double squaredDistance(const Box& a, const Box& b) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
        const double gap = std::max({a.min[k] - b.max[k], b.min[k] - a.max[k], 0.0});
        sum += gap * gap;
    }
    return sum;
}

/// Squared distances of n points (x[i], y[i], z[i]) to a box, computed in vector registers.
void squaredDistances(const Box& box, const double* x, const double* y, const double* z, std::size_t n,
                      double* squared);

/// Morton code of a box's centre within the bounds of all boxes, 21 bits per axis.
template <typename T>
std::uint64_t placeOnCurve(const Imath::Box<Imath::Vec3<T>>& box, const Imath::Box<Imath::Vec3<T>>& bounds) {
    const auto spreadBits = [](std::uint64_t x) {  // inserts two zeros after each bit
        x = (x | x << 32) & 0x001f00000000ffffu;
        x = (x | x << 16) & 0x001f0000ff0000ffu;
        x = (x | x << 8) & 0x100f00f00f00f00fu;
        x = (x | x << 4) & 0x10c30c30c30c30c3u;
        return (x | x << 2) & 0x1249249249249249u;
    };
    std::uint64_t code = 0;
    for (int k = 0; k < 3; ++k) {
        const double low = bounds.min[k], extent = bounds.max[k] - low;
        const double middle = (static_cast<double>(box.min[k]) / 2 + static_cast<double>(box.max[k]) / 2) - low;
        const double scaled = extent > 0 ? std::clamp(middle / extent, 0.0, 1.0) * 0x1fffff : 0;
        code |= spreadBits(static_cast<std::uint64_t>(scaled)) << k;
    }
    return code;
}

}  // namespace betamesh
