
#include "base/sample_groups.h"

namespace betamesh {

namespace {

BETAMESH_EVERY_CPU
void markNear(const float* x, const float* y, const float* z, std::size_t n, const float (&low)[3],
              const float (&high)[3], float square, std::uint32_t* is_near) {
    const auto beyond = [&](float at, int axis) {
        const float under = low[axis] - at, over = at - high[axis], out = under > over ? under : over;
        return out > 0 ? out : 0;
    };
    for (std::size_t i = 0; i < n; ++i) {
        const float bx = beyond(x[i], 0), by = beyond(y[i], 1), bz = beyond(z[i], 2);
        is_near[i] = bx * bx + by * by + bz * bz < square ? 1 : 0;
    }
}

}  // namespace

Boxf boxOf(std::span<const PlacedRow> points) {
    Boxf box;
    for (const PlacedRow& point : points) box.extendBy(point.place);
    return box;
}

std::size_t findNear(const Boxf& box, const std::array<std::vector<float>, 3>& places, float square,
                     std::vector<std::uint32_t>& near) {
    const auto [low, high] = box;
    const std::size_t n = places[0].size();
    markNear(places[0].data(), places[1].data(), places[2].data(), n, {low.x, low.y, low.z}, {high.x, high.y, high.z},
             square, near.data());
    std::size_t used = 0;
    for (std::uint32_t i = 0; i < n; ++i) {
        const std::uint32_t is_near = near[i];
        near[used] = i;
        used += is_near;
    }
    return used;
}

void groupTogether(std::span<PlacedRow> points) {
    if (points.size() <= kLanes / 2) return;
    const Boxf box = boxOf(points);
    const auto axis = static_cast<int>(box.majorAxis());
    const std::size_t groups = (points.size() + kLanes - 1) / kLanes;
    const std::size_t first = groups > 1 ? (groups + 1) / 2 * kLanes : kLanes / 2;
    std::nth_element(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(first), points.end(),
                     [&](const PlacedRow& a, const PlacedRow& b) { return a.place[axis] < b.place[axis]; });
    groupTogether(points.first(first));
    groupTogether(points.subspan(first));
}

}  // namespace betamesh
