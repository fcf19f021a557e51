#include "planar/gap_points.h"

#include "base/angles.h"
#include "base/cell_grid.h"
#include "skin/constants.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

namespace betamesh {

namespace {

constexpr double kRaySpacing = 0.2;  // of rays on discs, spacings

Dual square(Dual a) { return a * a; }
Dual smaller(Dual a, Dual b) { return b.value < a.value ? b : a; }

class GapPointFinder {
public:
    GapPointFinder(const DiscBoundary& boundary, const std::vector<DualVec3>& discs, const CurveSkin& skin)
        : boundary_(boundary), discs_(discs), skin_(skin) {}

    // The end of the ray from a point on a disc; full_weight: the length of arc of points that are not new.
    std::optional<GapPoint> end(const BoundarySample& from, std::uint32_t disc, double full_weight,
                                std::span<const std::uint32_t> near) const {
        const Dual scale = boundary_.movingScaleOf(disc), radius = radiusOf(disc),
                   square_rolling = square(scale * skin_.rolling());
        const DualVec3 direction = normalized(from.direction);
        Dual length = squareRoot(square(radius) + square_rolling) - radius;
        std::optional<std::uint32_t> other;
        for (const std::uint32_t d : near) {
            if (d == disc) continue;
            const DualVec3 offset = from.position - discs_[d];
            const Dual power = dot(offset, offset) - square(radiusOf(d)), approach = radius - dot(direction, offset);
            if (power.value > 0 && power.value < 2 * length.value * approach.value)
                length = power / (approach * 2), other = d;
        }
        if (!other) return std::nullopt;
        const DualVec3 end = from.position + direction * length;
        const Dual root = squareRoot(length * (length + radius * 2)), unit = scale * skin_.spacing;
        const Dual largest = smaller(scale, boundary_.movingScaleOf(*other)) * skin_.rolling();
        const Dual part = smaller(root / largest, 1);
        const Dual is_gap = smoothStep(from.weight / full_weight) *
                            smoothStep((root / unit - kTightGap) / (kWideGap - kTightGap)) *
                            opposition(end, direction, root, unit, near);
        if (!(is_gap.value > 0)) return std::nullopt;
        const Dual reduction = 1 - smoothStep((part - kGapEndBegins) / (1 - kGapEndBegins)) * kGapEnd;
        // A disc of this square radius is out of reach of every vertex that another one reaches.
        const Dual reach_fade = unit * kReachFade;
        const Dual none = reach_fade * (squareRoot(square_rolling) * -2 - reach_fade);
        const Dual square_radius = is_gap * reduction * square(part * largest) + (1 - is_gap) * none;
        return GapPoint{end, from.weight, (square_rolling - square_radius) / square(scale), scale};
    }

private:
    Dual radiusOf(std::uint32_t disc) const { return boundary_.worldRadiusOf(disc); }
    // 0 … 1: whether some disc that is hardly farther away than the nearest is opposite.
    Dual opposition(const DualVec3& point, const DualVec3& direction, Dual root, Dual unit,
                    std::span<const std::uint32_t> near) const {
        Dual most = 0;
        for (const std::uint32_t d : near) {
            const DualVec3 offset = point - discs_[d];
            const Dual along = dot(direction, offset) / length(offset);
            if (!(along.value < kOppositeBegins)) continue;
            const Dual excess = squareRoot(dot(offset, offset) - square(radiusOf(d))) - root;
            const Dual here = smoothStep((along - kOppositeBegins) / (kOppositeFull - kOppositeBegins)) *
                              (1 - smoothStep(excess / (unit * kOppositeExcess)));
            if (here.value > most.value) most = here;
        }
        return most;
    }

    const DiscBoundary& boundary_;
    const std::vector<DualVec3>& discs_;
    const CurveSkin& skin_;
};

}  // namespace

std::vector<GapPoint> gapPoints(const DiscBoundary& boundary, const std::vector<DualVec3>& discs,
                                const std::vector<DualVec3>& vertices, const CurveSkin& skin) {
    const double directions = std::ceil(kTwoPi * skin.joining / (kRaySpacing * skin.spacing));
    const DiscSamples from = boundarySamples(boundary, discs, vertices, static_cast<int>(directions));
    const GapPointFinder finder(boundary, discs, skin);
    const double reach = 2 * skin.outer() - skin.joining;
    const auto centreOf = [&](std::size_t d) { return discs[d].position; };
    const CellGrid origins(from.sample.size(), reach / 2,
                           [&](std::size_t i) { return from.sample[i].position.position; });
    const CellGrid around(discs.size(), reach / 2, centreOf);
    std::vector<std::vector<GapPoint>> found(origins.cells());
    forCellsAndNeighbours(reach, origins, around, centreOf,
                          [&](std::uint32_t cell, std::span<const std::uint32_t> near) {
                              for (const std::uint32_t i : origins.rowsOf(cell)) {
                                  const std::uint32_t disc = from.disc[i];
                                  const double full_weight = boundary.worldRadiusOf(disc).value * kTwoPi / directions;
                                  if (const auto point = finder.end(from.sample[i], disc, full_weight, near))
                                      found[cell].push_back(*point);
                              }
                          });
    return concatenate(found);
}

}  // namespace betamesh
