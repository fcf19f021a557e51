// What is asked of boxes along the axes, and an order in which near ones are near each other.

#pragma once

#include "betamesh/vec3.h"

#include <algorithm>

namespace betamesh {

/// Rounding is monotone: what is computed of the distance to a box is never more than what is computed of that to a
/// point or a box in it.
inline double squaredDistance(const Box& box, const Vec3& p) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
        const double outside = std::max({box.min[k] - p[k], p[k] - box.max[k], 0.0});
        sum += outside * outside;
    }
    return sum;
}

inline double squaredDistance(const Box& a, const Box& b) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
        const double apart = std::max({a.min[k] - b.max[k], b.min[k] - a.max[k], 0.0});
        sum += apart * apart;
    }
    return sum;
}

/// Of n points from a box, many at once.
void squaredDistances(const Box& box, const double* x, const double* y, const double* z, std::size_t n,
                      double* squared);

/// The place of a box's middle on Morton's curve through the whole, to 21 bits an axis.
template <typename T>
std::uint64_t placeOnCurve(const Imath::Box<Imath::Vec3<T>>& box, const Imath::Box<Imath::Vec3<T>>& whole) {
    const auto spread = [](std::uint64_t x) {  // two zeros after each bit
        x = (x | x << 32) & 0x001f00000000ffffu;
        x = (x | x << 16) & 0x001f0000ff0000ffu;
        x = (x | x << 8) & 0x100f00f00f00f00fu;
        x = (x | x << 4) & 0x10c30c30c30c30c3u;
        return (x | x << 2) & 0x1249249249249249u;
    };
    std::uint64_t place = 0;
    for (int k = 0; k < 3; ++k) {
        const double low = whole.min[k], extent = whole.max[k] - low;
        const double middle = (static_cast<double>(box.min[k]) / 2 + static_cast<double>(box.max[k]) / 2) - low;
        const double step = extent > 0 ? std::clamp(middle / extent, 0.0, 1.0) * 0x1fffff : 0;
        place |= spread(static_cast<std::uint64_t>(step)) << k;
    }
    return place;
}

}  // namespace betamesh
