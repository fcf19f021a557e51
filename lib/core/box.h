// Boxes along the axes, and an order in which near ones are near each other.

#pragma once

#include "core/vec3.h"

#include <algorithm>
#include <limits>

namespace betamesh {

/// Holds its faces. As made, it holds nothing.
struct Box {
    Vec3 low{std::numeric_limits<double>::infinity()}, high{-std::numeric_limits<double>::infinity()};

    bool meets(const Box& other) const {
        return low.x <= other.high.x && other.low.x <= high.x && low.y <= other.high.y && other.low.y <= high.y &&
               low.z <= other.high.z && other.low.z <= high.z;
    }
    void extend(const Vec3& point) { extend(Box{point, point}); }
    void extend(const Box& other) {
        for (int k = 0; k < 3; ++k) {
            low[k] = std::min(low[k], other.low[k]);
            high[k] = std::max(high[k], other.high[k]);
        }
    }
    double squaredDistanceTo(const Vec3& p) const {
        double sum = 0;
        for (int k = 0; k < 3; ++k) {
            const double outside = std::max({low[k] - p[k], p[k] - high[k], 0.0});
            sum += outside * outside;
        }
        return sum;
    }
};

/// The place of a box's middle on Morton's curve through the whole, to 21 bits an axis.
inline std::uint64_t placeOnCurve(const Box& box, const Box& whole) {
    const auto spread = [](std::uint64_t x) {  // two zeros after each bit
        x = (x | x << 32) & 0x001f00000000ffffu;
        x = (x | x << 16) & 0x001f0000ff0000ffu;
        x = (x | x << 8) & 0x100f00f00f00f00fu;
        x = (x | x << 4) & 0x10c30c30c30c30c3u;
        return (x | x << 2) & 0x1249249249249249u;
    };
    std::uint64_t place = 0;
    for (int k = 0; k < 3; ++k) {
        const double extent = whole.high[k] - whole.low[k];
        const double middle = (box.low[k] / 2 + box.high[k] / 2) - whole.low[k];
        const double step = extent > 0 ? std::clamp(middle / extent, 0.0, 1.0) * 0x1fffff : 0;
        place |= spread(static_cast<std::uint64_t>(step)) << k;
    }
    return place;
}

}  // namespace betamesh
