#include "base/sample_groups.h"

namespace betamesh {

namespace {

BETAMESH_EVERY_CPU
void markNear(const float* const (&low)[3], const float* const (&high)[3], std::size_t n, const Vec3f& from,
              const Vec3f& to, float squared_distance, std::uint32_t* is_near) {
    for (std::size_t i = 0; i < n; ++i) {
        float sum = 0;
        for (int k = 0; k < 3; ++k) {
            const float under = low[k][i] - to[k], over = from[k] - high[k][i];
            float gap = under > over ? under : over;
            gap = gap > 0 ? gap : 0;
            sum += gap * gap;
        }
        is_near[i] = sum < squared_distance ? 1 : 0;
    }
}

}  // namespace

Boxf boundsOf(std::span<const PointRow> points) {
    Boxf box;
    for (const PointRow& point : points) box.extendBy(point.position);
    return box;
}

std::size_t findNear(const Boxf& box, const Columns& low, const Columns& high, float squared_distance,
                     std::vector<std::uint32_t>& near) {
    const std::size_t n = low[0].size();
    if (near.size() < n) near.resize(n);
    const float* const lows[3] = {low[0].data(), low[1].data(), low[2].data()};
    const float* const highs[3] = {high[0].data(), high[1].data(), high[2].data()};
    markNear(lows, highs, n, box.min, box.max, squared_distance, near.data());
    std::size_t used = 0;
    for (std::uint32_t i = 0; i < n; ++i) {
        const std::uint32_t is_near = near[i];
        near[used] = i;
        used += is_near;
    }
    return used;
}

void sortIntoGroups(std::span<PointRow> points) {
    if (points.size() <= kLanes / 2) return;
    const Boxf box = boundsOf(points);
    const auto axis = static_cast<int>(box.majorAxis());
    const std::size_t groups = (points.size() + kLanes - 1) / kLanes;
    const std::size_t first = groups > 1 ? (groups + 1) / 2 * kLanes : kLanes / 2;
    std::nth_element(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(first), points.end(),
                     [&](const PointRow& a, const PointRow& b) { return a.position[axis] < b.position[axis]; });
    sortIntoGroups(points.first(first));
    sortIntoGroups(points.subspan(first));
}

}  // namespace betamesh
