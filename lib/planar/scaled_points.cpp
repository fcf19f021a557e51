#include "planar/scaled_points.h"

#include <cmath>
#include <map>
#include <numeric>

namespace betamesh {

std::vector<ScaleClass> scaleClasses(std::size_t n, std::span<const double> scale) {
    std::vector<ScaleClass> classes;
    if (scale.empty()) {
        classes.push_back({1, std::vector<std::uint32_t>(n)});
        std::iota(classes[0].row.begin(), classes[0].row.end(), 0U);
        return classes;
    }
    std::map<int, ScaleClass, std::greater<>> by_exponent;
    for (std::size_t i = 0; i < n; ++i) {
        ScaleClass& points = by_exponent.try_emplace(std::ilogb(scale[i]), ScaleClass{0, {}}).first->second;
        points.largest = std::max(points.largest, scale[i]);
        points.row.push_back(static_cast<std::uint32_t>(i));
    }
    for (auto& [exponent, points] : by_exponent) classes.push_back(std::move(points));
    return classes;
}

}  // namespace betamesh
