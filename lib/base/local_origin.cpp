#include "base/local_origin.h"

#include <algorithm>
#include <cmath>

namespace betamesh {
namespace {

constexpr double kFloatRounding = 0x1p-24;   // largest relative error of rounding to single precision
constexpr double kTolerableRounding = 1e-3;  // of the spacing: far below what smoothing leaves of the particles' noise
constexpr double kFarAway = 16;              // largest coordinate in sides of the bounding box

}  // namespace

Vec3 localOrigin(const Box& box, std::size_t particles) {
    const Vec3 size = box.size();
    const double extent = std::max({size.x, size.y, size.z});
    const double side = extent > 0 ? extent : 1;  // a single position tells no scale
    double largest = 0;
    for (int axis = 0; axis < 3; ++axis)
        largest = std::max({largest, std::abs(box.min[axis]), std::abs(box.max[axis])});
    const double spacing = side / std::cbrt(static_cast<double>(particles));
    if (!isCoarselyRounded(largest, spacing) || !(largest > kFarAway * side)) return {0, 0, 0};
    const double step = std::pow(10, std::ceil(std::log10(side)));
    const Vec3 centre = box.center();
    return {std::round(centre.x / step) * step, std::round(centre.y / step) * step, std::round(centre.z / step) * step};
}

bool isCoarselyRounded(double coordinate, double spacing) {
    return std::abs(coordinate) * kFloatRounding > kTolerableRounding * spacing;
}

}  // namespace betamesh
