
#include "planar/retract.h"

#include "base/cell_grid.h"
#include "base/parallel.h"
#include "planar/curve_displacement.h"
#include "skin/constants.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

namespace betamesh {

namespace {

// Lengths in particle spacings.
constexpr double kFirstWidth = 1.3;                                     // smoothing width of the first steps
constexpr std::array<double, 5> kLastWidths{1.1, 0.95, 0.8, 0.7, 0.6};  // of the last steps
// Lengths of a step, in smoothing widths.
constexpr double kLongestInwards = 0.2, kLongestOutwards = 0.1;
constexpr double kPlannedInwards = 0.17;  // determines the number of first steps
constexpr double kMostSteps = 60;
constexpr double kIsolationReach = 1.5;  // radii; every point of the curve is within one of its particle

struct Step {
    double share;  // of the remaining distance
    double width;  // of the smoothing, spacings
};

std::vector<Step> stepsFor(const CurveSkin& skin) {
    const double planned = (skin.joining - skin.skin) / skin.spacing / (kPlannedInwards * kFirstWidth);
    const int first = static_cast<int>(std::clamp(std::ceil(planned), 3.0, kMostSteps));
    std::vector<Step> steps;
    for (int i = 0; i < first; ++i) steps.push_back({1.0 / (first - i), kFirstWidth});
    for (const double width : kLastWidths) steps.push_back({1, width});
    return steps;
}

Dual clamped(Dual a, Dual low, Dual high) { return a.value < low.value ? low : a.value > high.value ? high : a; }

// The samples and corners of the outer boundary, numbered consecutively. Offsets from them, distances and weights are
// divided by the scale there.
class OuterPoints {
public:
    OuterPoints(const OuterBoundary& boundary, double reach) : boundary_(boundary), reach_(reach) {
        for (const Dual& scale : boundary.scale) scale_.push_back(scale.value);
        if (!scale_.empty())
            points_.emplace(
                size(), reach_ / 4, [this](std::size_t i) { return point(i).position; }, scale_);
    }

    // Calls visit(vertex, outer points) for every vertex, with all outer points within reach and some beyond.
    template <typename Visit>
    void forVertices(const std::vector<DualVec3>& vertices, const Visit& visit) const {
        if (points_) {
            parallelRanges(vertices.size(), 64, [&](std::size_t begin, std::size_t end) {
                std::vector<std::uint32_t> near;
                for (auto v = static_cast<std::uint32_t>(begin); v < end; ++v) {
                    near.clear();
                    points_->forNear(vertices[v].position, reach_, 0, [&](std::uint32_t i) { near.push_back(i); });
                    visit(v, near);
                }
            });
            return;
        }
        const auto positionOf = [&](std::size_t i) -> const Vec3& { return point(i).position; };
        const CellGrid points(size(), reach_ / 4, positionOf);
        const CellGrid cells(vertices.size(), reach_ / 4, [&](std::size_t v) { return vertices[v].position; });
        forCellsAndNeighbours(reach_, cells, points, positionOf,
                              [&](std::uint32_t cell, std::span<const std::uint32_t> near) {
                                  for (const std::uint32_t v : cells.rowsOf(cell)) visit(v, near);
                              });
    }
    DualVec3 offset(const DualVec3& from, std::size_t i) const {
        const DualVec3 offset = from - point(i);
        return scale_.empty() ? offset : offset / boundary_.scale[i];
    }
    double squaredDistance(const DualVec3& from, std::size_t i) const {
        const double square = (from.position - point(i).position).length2();
        return scale_.empty() ? square : square / (scale_[i] * scale_[i]);
    }
    Dual weight(std::size_t i) const {
        if (i >= boundary_.samples.size()) return 0;
        const Dual weight = boundary_.samples[i].weight;
        return scale_.empty() ? weight : weight / boundary_.scale[i];
    }
    Dual scale(std::size_t i) const { return scale_.empty() ? 1 : boundary_.scale[i]; }

private:
    std::size_t size() const { return boundary_.samples.size() + boundary_.corners.size(); }
    const DualVec3& point(std::size_t i) const {
        const std::size_t samples = boundary_.samples.size();
        return i < samples ? boundary_.samples[i].position : boundary_.corners[i - samples];
    }

    const OuterBoundary& boundary_;
    double reach_;
    std::vector<double> scale_;           // empty: all 1
    std::optional<ScaledPoints> points_;  // where scales differ
};

}  // namespace

double CurveSkin::reach() const { return rolling() + (kReachFade + kDirectionBand) * spacing; }

void retract(const OuterBoundary& boundary, const CurveSkin& skin,
             const std::function<Dual(const DualVec3& x)>& extra_skin, BetaCurve& curve) {
    const double band = kDirectionBand * skin.spacing, too_deep = kReachFade * skin.spacing;
    const double reach = skin.reach();
    const OuterPoints outer(boundary, reach);
    for (const Step& step : stepsFor(skin)) {
        const double width = step.width * skin.spacing;
        std::vector<DualVec3> displacement(curve.vertex.size());
        outer.forVertices(curve.vertex, [&](std::uint32_t v, std::span<const std::uint32_t> near) {
            const DualVec3& x = curve.vertex[v];
            double least = reach * reach;
            const std::uint32_t* nearest = nullptr;
            for (const std::uint32_t& i : near) {
                const double square = outer.squaredDistance(x, i);
                if (square < least) least = square, nearest = &i;
            }
            if (nearest == nullptr) return;
            const DualVec3 shortest = outer.offset(x, *nearest);
            const Dual nearest_square = dot(shortest, shortest), depth = length(shortest);
            const Dual target = skin.rolling() - extra_skin(x), fade = 1 - smoothStep((depth - target) / too_deep);
            if (!(fade.value > 0)) return;
            // The weight of an outer point falls from 1 at the distance of the nearest one to 0 one band farther.
            const Dual span = band * band + depth * (2 * band);
            DualVec3 away;
            Dual weights = 0, by_scale = 0;  // Σ weight, Σ weight / scale
            for (const std::uint32_t i : near) {
                const double square = outer.squaredDistance(x, i);
                if (!(square - nearest_square.value < span.value)) continue;
                const DualVec3 offset = outer.offset(x, i);
                const Dual t = 1 - (dot(offset, offset) - nearest_square) / span, weight = t * t * outer.weight(i);
                away = away + offset * weight;
                weights = weights + weight;
                by_scale = by_scale + weight / outer.scale(i);
            }
            const Dual scale = weights.value > 0 ? weights / by_scale : 1, longest = width * curve.scaleOf(v);
            const Dual distance = clamped((target - depth) * (step.share * scale), -kLongestOutwards * longest,
                                          kLongestInwards * longest);
            displacement[v] = normalized(away) * (distance * fade);
        });
        moveWithoutCrossings(curve, smoothedValues(displacement, curve, width), skin.spacing * curve.leastScale());
    }
}

IsolationField::IsolationField(const std::vector<DualVec3>& particles, double radius, double wide_radius,
                               std::vector<double> scale)
    : particles_(particles),
      scale_(std::move(scale)),
      reach_(kIsolationReach * radius),
      cells_(
          particles.size(), radius, [&](std::size_t i) { return particles[i].position; }, scale_),
      isolation_(particles.size()) {
    parallelFor(particles_.size(), 256, [&](std::size_t i) {
        Dual isolation = 1;
        cells_.forNear(particles_[i].position, wide_radius, wide_radius * scaleOf(i), [&](std::uint32_t j) {
            if (j == i || isolation.value == 0) return;
            const double scales = scaleOf(i) + scaleOf(j), touching = radius * scales, far = wide_radius * scales;
            isolation = isolation * smoothStep((length(particles_[j] - particles_[i]) - touching) / (far - touching));
        });
        isolation_[i] = isolation;
    });
}

Dual IsolationField::at(const DualVec3& x) const {
    Dual sum = 0, total = 0;
    cells_.forNear(x.position, reach_, 0, [&](std::uint32_t i) {
        const DualVec3 offset = particles_[i] - x;
        const double reach = reach_ * scaleOf(i);
        const Dual t = 1 - dot(offset, offset) / (reach * reach), weight = t.value > 0 ? t * t : Dual(0);
        sum = sum + isolation_[i] * weight;
        total = total + weight;
    });
    return total.value > 0 ? sum / total : Dual(0);
}

}  // namespace betamesh
