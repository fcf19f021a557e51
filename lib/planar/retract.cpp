
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
constexpr double kLeastRolling = 0.4;    // radius of a disc in a gap, assumed for steps: bounds the rate of its change
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

double square(double a) { return a * a; }
Dual larger(Dual a, double b) { return a.value > b ? a : Dual(b); }
Dual clamped(Dual a, Dual low, Dual high) { return a.value < low.value ? low : a.value > high.value ? high : a; }

// The samples and corners of the outer boundary and the points in gaps, numbered consecutively. Offsets from them,
// distances and weights are divided by the scale there.
class OuterPoints {
public:
    OuterPoints(const OuterBoundary& boundary, double reach) : boundary_(boundary), reach_(reach) {
        for (const Dual& scale : boundary.scale) scale_.push_back(scale.value);
        if (!scale_.empty())
            for (const GapPoint& gap : boundary.gaps) scale_.push_back(gap.scale.value);
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
        return scale_.empty() ? offset : offset / scale(i);
    }
    // What is added to a square distance.
    Dual squaredOffset(std::size_t i) const {
        return i < onBoundary() ? boundary_.squared_offset[i] : gap(i).squared_offset;
    }
    // With that.
    double squaredDistance(const DualVec3& from, std::size_t i) const {
        const double square = (from.position - point(i).position).length2();
        return (scale_.empty() ? square : square / (scale_[i] * scale_[i])) + squaredOffset(i).value;
    }
    Dual weight(std::size_t i) const {
        if (i >= boundary_.samples.size() && i < onBoundary()) return 0;
        const Dual weight = i < onBoundary() ? boundary_.samples[i].weight : gap(i).weight;
        return scale_.empty() ? weight : weight / scale(i);
    }
    Dual scale(std::size_t i) const {
        return scale_.empty() ? 1 : i < onBoundary() ? boundary_.scale[i] : gap(i).scale;
    }

private:
    std::size_t onBoundary() const { return boundary_.samples.size() + boundary_.corners.size(); }
    std::size_t size() const { return onBoundary() + boundary_.gaps.size(); }
    const GapPoint& gap(std::size_t i) const { return boundary_.gaps[i - onBoundary()]; }
    const DualVec3& point(std::size_t i) const {
        if (i >= onBoundary()) return gap(i).position;
        const std::size_t samples = boundary_.samples.size();
        return i < samples ? boundary_.samples[i].position : boundary_.corners[i - samples];
    }

    const OuterBoundary& boundary_;
    double reach_;
    std::vector<double> scale_;           // empty: all 1
    std::optional<ScaledPoints> points_;  // where scales differ
};

// How far a vertex is from the skin, and in which direction.
struct Approach {
    DualVec3 inwards;   // unit vector away from the outer boundary; zero where that is out of reach
    Dual gap = 0;       // displacement along it that gives the right depth; negative where the vertex is too deep
    Dual in_reach = 0;  // 1, fading to 0 deep below the skin
};

// extra: depth of the skin there beyond the usual; near: outer points within reach and some beyond
Approach approachOf(const DualVec3& x, Dual extra, const CurveSkin& skin, const OuterPoints& outer,
                    std::span<const std::uint32_t> near) {
    double least = square(skin.reach());
    const std::uint32_t* nearest = nullptr;
    for (const std::uint32_t& i : near) {
        const double distance = outer.squaredDistance(x, i);
        if (distance < least) least = distance, nearest = &i;
    }
    if (nearest == nullptr) return {};
    const DualVec3 shortest = outer.offset(x, *nearest);
    const Dual nearest_square = dot(shortest, shortest) + outer.squaredOffset(*nearest);
    const Dual reached = squareRoot(nearest_square);
    Dual in_reach = 1 - smoothStep((reached - skin.rolling() + extra) / (kReachFade * skin.spacing));
    if (!(in_reach.value > 0)) return {};
    // The weight of an outer point falls from 1 at the distance of the nearest one to 0 one band farther.
    const double band = kDirectionBand * skin.spacing;
    const Dual span = band * band + reached * (2 * band);
    DualVec3 away;
    Dual weights = 0, by_scale = 0, offsets = 0;  // Σ weight, Σ weight / scale, Σ weight · squared offset
    for (const std::uint32_t i : near) {
        if (!(outer.squaredDistance(x, i) - nearest_square.value < span.value)) continue;
        const DualVec3 from_outer = outer.offset(x, i);
        const Dual squared_offset = outer.squaredOffset(i);
        const Dual t = 1 - (dot(from_outer, from_outer) + squared_offset - nearest_square) / span;
        const Dual weight = t * t * outer.weight(i);
        away = away + from_outer * weight;
        weights = weights + weight;
        by_scale = by_scale + weight / outer.scale(i);
        offsets = offsets + weight * squared_offset;
    }
    if (!(weights.value > 0)) return {};
    const Dual offset = offsets / weights, distance = squareRoot(larger(nearest_square - offset, 0));
    const double square_rolling = square(skin.rolling()),
                 least_square = square(std::min(kLeastRolling * skin.spacing, skin.rolling() / 2));
    const Dual rolling = squareRoot(larger(square_rolling - offset, least_square));  // radius of the disc here
    const Dual depth = rolling - extra - distance;
    if (depth.value < 0) in_reach = in_reach * (1 - smoothStep(offset / (square_rolling * kGapOffset)));
    return {normalized(away), depth * weights / by_scale, in_reach};
}

}  // namespace

double CurveSkin::reach() const { return rolling() + (kReachFade + kDirectionBand) * spacing; }

void retract(const OuterBoundary& boundary, const CurveSkin& skin,
             const std::function<Dual(const DualVec3& x)>& extra_skin, BetaCurve& curve) {
    const OuterPoints outer(boundary, skin.reach());
    for (const Step& step : stepsFor(skin)) {
        const double width = step.width * skin.spacing;
        std::vector<DualVec3> displacement(curve.vertex.size());
        outer.forVertices(curve.vertex, [&](std::uint32_t v, std::span<const std::uint32_t> near) {
            const Approach approach = approachOf(curve.vertex[v], extra_skin(curve.vertex[v]), skin, outer, near);
            const Dual longest = width * curve.scaleOf(v), share = approach.gap * step.share;
            displacement[v] =
                approach.inwards *
                (clamped(share, -kLongestOutwards * longest, kLongestInwards * longest) * approach.in_reach);
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
