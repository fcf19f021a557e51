#include "skin/necks.h"

#include "skin/constants.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace betamesh {

namespace {

// Calls visit(neck, vertex, along, across) for the vertices near necks: how far from the neck's middle along the axis,
// and the offset from the axis, both in particle spacings there.
template <typename Visit>
void forVerticesNear(const std::vector<Neck>& necks, const std::vector<Vec3>& position, const DeformingMesh& surface,
                     const Visit& visit) {
    const PointGroups& groups = surface.groups();
    for (const Neck& neck : necks) {
        const Vec3 reach((kNeckLength + 1) * neck.spacing);  // smoothing moves vertices by less than 1
        groups.forGroupsNear(
            Box(neck.middle - reach, neck.middle + reach), [](double) { return 0.0; },
            [&](std::uint32_t group, std::uint32_t) {
                for (std::uint32_t v = groups.begin(group); v < groups.begin(group + 1); ++v) {
                    const Vec3 offset = (position[v] - neck.middle) / neck.spacing;
                    const double along = dot(offset, neck.axis);
                    const Vec3 across = offset - neck.axis * along;
                    if (std::abs(along) < kNeckLength && across.length2() < kNeckWidth * kNeckWidth)
                        visit(neck, v, along, across);
                }
            });
    }
}

// 1 up to half of the reach, then down to 0.
double within(double distance, double reach) { return 1 - smoothStep(2 * distance / reach - 1).value; }

}  // namespace

std::vector<Neck> thinNecks(const BallBoundary& boundary, const FacePoints& points, double spacing) {
    std::vector<Neck> necks;
    for (std::size_t ball = 0; ball < boundary.position.size(); ++ball)
        for (std::uint32_t p = points.begin[ball]; p < points.begin[ball + 1]; ++p) {
            const FacePoints::Contact* contact = points.contactOf(p);
            if (!contact) continue;
            const Vec3& axis = contact->direction.position;
            if (std::array{axis.x, axis.y, axis.z} < std::array{-axis.x, -axis.y, -axis.z})
                continue;  // the other ball has this contact, too
            const double radius = boundary.worldRadiusOf(ball).value, weight = contact->weight.value;
            const Vec3 centre = toDouble(boundary.position[ball]) * boundary.quantum;
            necks.push_back({centre + axis * (radius * (1 + (1 - weight) * kContactGap / 2)), axis,
                             spacing * boundary.scaleOf(ball), smoothStep(2 * weight - 1).value, 0});
        }
    for (const auto& [a, b] : boundary.circle) {
        const Vec3 from = toDouble(boundary.position[a]) * boundary.quantum,
                   to = toDouble(boundary.position[b]) * boundary.quantum;
        const double distance = (to - from).length(), r = boundary.worldRadiusOf(a).value,
                     other = boundary.worldRadiusOf(b).value;
        if (!(distance > 0)) continue;
        const double along = (distance + (r * r - other * other) / distance) / 2;
        const double there = spacing * std::min(boundary.scaleOf(a), boundary.scaleOf(b));
        const double radius = std::sqrt(std::max(0.0, r * r - along * along)) / there;
        const double thinness = within(radius, kThinNeck);
        if (!(thinness > 0)) continue;
        const Vec3 axis = (to - from) / distance;
        necks.push_back({from + axis * along, axis, there, thinness, std::min(kLeastNeck, radius / 2) * thinness});
    }
    return necks;
}

void keepNecksThick(const std::vector<Neck>& necks, const std::vector<Vec3>& retracted, DeformingMesh& surface) {
    if (necks.empty()) return;
    const std::vector<Vec3>& position = surface.position();
    std::vector<float> kept(surface.size(), 1);  // of the displacement by smoothing
    forVerticesNear(necks, retracted, surface,
                    [&](const Neck& neck, std::uint32_t v, double along, const Vec3& across) {
                        const double share = within(std::abs(along), kNeckLength) * within(across.length(), kNeckWidth);
                        kept[v] *= static_cast<float>(1 - neck.thinness * share);
                    });
    std::vector<Vec3f> step(surface.size(), Vec3f(0));
    for (std::size_t v = 0; v < kept.size(); ++v)
        if (kept[v] < 1) step[v] = Vec3f((retracted[v] - position[v]) / surface.spacing()) * (1 - kept[v]);
    surface.move(step);
    std::fill(step.begin(), step.end(), Vec3f(0));
    forVerticesNear(necks, position, surface, [&](const Neck& neck, std::uint32_t v, double along, const Vec3& across) {
        const double least = neck.least * within(std::abs(along), kNeckLength), r = across.length();
        if (!(r > 0)) return;
        const double pushed = std::sqrt(r * r + least * least) - r;
        step[v] += Vec3f(across * (pushed * within(r, kNeckWidth) / r * (neck.spacing / surface.spacing())));
    });
    surface.move(step);
    surface.measure();
}

}  // namespace betamesh
