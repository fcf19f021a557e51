
#include "planar/retract.h"

#include "base/cell_order.h"
#include "planar/curve_means.h"
#include "planar/uncrossed_curve.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace betamesh {

namespace {

// All in particle spacings.
constexpr double kBand = 0.25;   // so much farther than the nearest outer point others count, too
constexpr double kBeyond = 0.3;  // vertices that are so much too deep stay
constexpr double kFirstWidth = 1.3;
constexpr std::array<double, 5> kLastWidths{1.1, 0.95, 0.8, 0.7, 0.6};
constexpr double kLongestInwards = 0.2, kLongestOutwards = 0.1;  // of a step, in widths of the mean
constexpr double kUsualInwards = 0.17;                           // of the first steps; several follow
constexpr double kMostSteps = 60;

struct Step {
    double share;  // of the way that is left
    double width;  // of the mean, spacings
};

std::vector<Step> stepsFor(const CurveSkin& skin) {
    const double way = (skin.joining - skin.skin) / skin.spacing / (kUsualInwards * kFirstWidth);
    const int first = static_cast<int>(std::clamp(std::ceil(way), 3.0, kMostSteps));
    std::vector<Step> steps;
    for (int i = 0; i < first; ++i) steps.push_back({1.0 / (first - i), kFirstWidth});
    for (const double width : kLastWidths) steps.push_back({1, width});
    return steps;
}

Dual clamped(Dual a, double low, double high) { return a.value < low ? low : a.value > high ? high : a; }

// The boundary's samples and corners, by place.
class Outer {
public:
    Outer(const OuterBoundary& boundary, double reach) : boundary_(boundary), reach_(reach) {}

    // Calls visit(vertex, outer points within reach of it or little farther).
    template <typename Visit>
    void forVertices(const std::vector<DualVec3>& vertices, const Visit& visit) const {
        const auto placeOf = [&](std::size_t i) -> const Vec3& { return point(i).position; };
        const CellOrder points(boundary_.samples.size() + boundary_.corners.size(), reach_ / 4, placeOf);
        const CellOrder cells(vertices.size(), reach_ / 4, [&](std::size_t v) { return vertices[v].position; });
        forCellsWithin(reach_, cells, points, placeOf, [&](std::uint32_t cell, std::span<const std::uint32_t> near) {
            for (const std::uint32_t v : cells.rowsOf(cell)) visit(v, near);
        });
    }
    const DualVec3& point(std::size_t i) const {
        const std::size_t samples = boundary_.samples.size();
        return i < samples ? boundary_.samples[i].position : boundary_.corners[i - samples];
    }
    Dual weight(std::size_t i) const { return i < boundary_.samples.size() ? boundary_.samples[i].weight : 0; }

private:
    const OuterBoundary& boundary_;
    double reach_;
};

}  // namespace

double CurveSkin::reach() const { return rolling() + (kBeyond + kBand) * spacing; }

void retract(const OuterBoundary& boundary, const CurveSkin& skin, const std::function<Dual(const DualVec3& x)>& swelling,
             BetaCurve& curve) {
    const double band = kBand * skin.spacing, beyond = kBeyond * skin.spacing;
    const double reach = skin.reach();
    const Outer outer(boundary, reach);
    for (const Step& step : stepsFor(skin)) {
        const double width = step.width * skin.spacing;
        std::vector<DualVec3> way(curve.vertex.size());
        outer.forVertices(curve.vertex, [&](std::uint32_t v, std::span<const std::uint32_t> near) {
            const DualVec3& x = curve.vertex[v];
            double least = reach * reach;
            const std::uint32_t* nearest = nullptr;
            for (const std::uint32_t& i : near) {
                const double square = (x.position - outer.point(i).position).length2();
                if (square < least) least = square, nearest = &i;
            }
            if (nearest == nullptr) return;
            const DualVec3 shortest = x - outer.point(*nearest);
            const Dual nearest_square = dot(shortest, shortest), depth = length(shortest);
            const Dual target = skin.rolling() - swelling(x), fade = 1 - smoothStep((depth - target) / beyond);
            if (!(fade.value > 0)) return;
            // 1 at the nearest point, 0 a band farther off.
            const Dual span = band * band + depth * (2 * band);
            DualVec3 away;
            for (const std::uint32_t i : near) {
                const double square = (x.position - outer.point(i).position).length2();
                if (!(square - nearest_square.value < span.value)) continue;
                const DualVec3 offset = x - outer.point(i);
                const Dual t = 1 - (dot(offset, offset) - nearest_square) / span;
                away = away + offset * (t * t * outer.weight(i));
            }
            const Dual size =
                clamped((target - depth) * step.share, -kLongestOutwards * width, kLongestInwards * width);
            way[v] = normalized(away) * (size * fade);
        });
        moveUncrossed(curve, meansOf(way, curve, width), skin.spacing);
    }
}

}  // namespace betamesh
