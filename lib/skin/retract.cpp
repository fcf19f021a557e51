#include "skin/retract.h"
#include "skin/skin_smoothing.h"
#include "skin/tune.h"

#include "core/parallel.h"

#include <algorithm>
#include <cmath>

namespace betamesh {

namespace {

// All lengths in particle spacings.
const double kBand = tune("band", 0.25);          // beyond the nearest outer point others have a say, too
constexpr double kBeyond = 0.3;         // deeper than this below the skin, outer points do not matter
const double kLongestInwards = tune("maxstep", 0.35), kLongestOutwards = 0.1;  // of a step

const double kLip = tune("lip", 0.2);
struct Step {
    double share;  // of the way that is left
    double width;  // of the mean
};

enum OuterField { kX, kY, kZ, kVx, kVy, kVz, kWeight, kExtra, kFading, kOuterFields };

// Away from the nearest outer points, how far these are, and how they move.
struct SumOuter {
    std::span<const SampleFields<kOuterFields>> samples;
    float band;
    const Lanes (&point)[3];
    Lanes (&sums)[9];  // x - y, velocity, weight; squared distance; extra

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()(std::size_t first) const {
        using Some = Floats<kWidth>;
        Some x[3];
        getLanes<kWidth>(point, first, x);
        const Some zero{}, one = zero + 1.0F;
        Some nearest = zero + 1e30F;
        for (const auto& f : samples) {
            const Some px = x[0] - f[kX], py = x[1] - f[kY], pz = x[2] - f[kZ];
            const Some square = px * px + py * py + pz * pz + f[kFading];
            nearest = square < nearest ? square : nearest;
        }
        // 1 at the nearest, 0 a band farther off, linear in the square: root is close enough to the distance.
        Some root = (nearest + one) * 0.5F;
        for (int i = 0; i < 3; ++i) root = (root + nearest / root) * 0.5F;
        const Some inverse = one / (band * band + 2 * band * root);
        Some sum[9] = {};
        for (const auto& f : samples) {
            const Some px = x[0] - f[kX], py = x[1] - f[kY], pz = x[2] - f[kZ];
            const Some square = px * px + py * py + pz * pz + f[kFading];
            Some t = one - (square - nearest) * inverse;
            t = t > 0 ? t : zero;
            const Some w = t * t * f[kWeight];
            sum[0] += w * px;
            sum[1] += w * py;
            sum[2] += w * pz;
            sum[3] += w * f[kVx];
            sum[4] += w * f[kVy];
            sum[5] += w * f[kVz];
            sum[6] += w;
            sum[8] += w * f[kExtra];
        }
        sum[7] = nearest;
        setLanes<kWidth>(sums, first, sum);
    }
};

}  // namespace

namespace {

// Where each vertex would go by itself: towards the skin, units; and how that moves.
struct Approach {
    Vec3f away;  // from the outer boundary, unit vector; zero where that is out of reach
    float gap = 0, fade = 0;
    Vec3f velocity;
};

std::vector<Approach> approaches(const OuterSamples& outer, const std::vector<float>& extra,
                                 const std::vector<Vec3>& outer_at, const CellOrder& order, double rolling, MovedSurface& surface, double width) {
    const double reach = rolling + kBeyond + kBand;
    std::vector<Approach> approach(surface.size());
    const PointGroups& groups = surface.vicinity(width).groups;
    const Rows near = surface.near(order, outer_at, reach);
    forGroups<kOuterFields>(
        groups, surface.position(), near, outer_at, surface.unit(),
        [&](std::uint32_t i, SampleFields<kOuterFields>& f) {
            const Vec3f v(outer.point[i].velocity);
            f[kVx] = v.x, f[kVy] = v.y, f[kVz] = v.z, f[kWeight] = outer.weight[i], f[kExtra] = extra[i];
            f[kFading] = outer.fading[i] * static_cast<float>(tune("pen", 0.3));
        },
        [&](const GroupLanes& group, std::span<const SampleFields<kOuterFields>> samples) {
            Lanes sums[9];
            forLanes(SumOuter{samples, static_cast<float>(kBand), group.place, sums});
            for (std::size_t lane = 0; lane < group.size; ++lane) {
                const std::uint32_t v = group.row[lane];
                Approach& a = approach[v];
                a.away = a.velocity = Vec3f(0);
                const double distance = std::sqrt(static_cast<double>(sums[7][lane]));
                const double fade = 1 - smoothStep((distance - rolling) / kBeyond).value;
                if (!(fade > 0) || !(sums[6][lane] > 0)) continue;
                a.away = Vec3f(sums[0][lane], sums[1][lane], sums[2][lane]).normalized();
                a.gap = static_cast<float>(rolling - distance) - sums[8][lane] / sums[6][lane];
                a.fade = static_cast<float>(fade);
                a.velocity = Vec3f(sums[3][lane], sums[4][lane], sums[5][lane]) / sums[6][lane];
            }
        });
    return approach;
}

}  // namespace

void retract(const OuterSamples& outer, const SkinLengths& lengths, MovedSurface& surface) {
    const double unit = surface.unit(), rolling = lengths.rolling();
    std::vector<Vec3> outer_at(outer.point.size());
    parallelFor(outer_at.size(), 8192, [&](std::size_t i) { outer_at[i] = outer.point[i].position; });
    const CellOrder order(outer_at.size(), tune("outercell", 0.7) * unit,
                          [&](std::size_t i) -> const Vec3& { return outer_at[i]; });
    std::vector<float> extra(outer.point.size(), 0);
    if (lengths.volume_true)
        parallelFor(extra.size(), 8192, [&](std::size_t i) {
            const double lone = outer.lone[i];
            extra[i] = static_cast<float>(tune("xthread", 0.05) * smoothStep((lone - 0.1) / 0.1).value + tune("xdrop", 0.03) * smoothStep((lone - 0.8) / 0.2).value);
        });
    const double first_width = tune("sigma", 1.3);
    std::vector<Approach> approach = approaches(outer, extra, outer_at, order, rolling, surface, first_width);
    for (std::size_t round = 0; round < static_cast<std::size_t>(tune("rounds", 0)); ++round) {
        const double longest = tune("long", 0.9), bend = tune("bend", 0.5);
        surface.refine(round, [&](std::uint32_t a, std::uint32_t b) {
            const auto there = [&](std::uint32_t v) {
                return surface.position()[v] / unit + Vec3(approach[v].away * (approach[v].gap * approach[v].fade));
            };
            const double length = (there(a) - there(b)).length();
            const double turn = (approach[a].away - approach[b].away).length();
            return length / (longest - (longest - bend) * smoothStep((turn - tune("turn0", 0.15)) / tune("turn1", 0.35)).value);
        });
        approach = approaches(outer, extra, outer_at, order, rolling, surface, first_width);
    }
    std::vector<Step> steps;
    const int main_steps = static_cast<int>(tune("steps", 4));
    for (int i = 0; i < main_steps; ++i) steps.push_back({1.0 / (main_steps - i), first_width});
    for (const double w : {tune("w1", 1.0), tune("w2", 0.8), tune("w3", 0.6)}) steps.push_back({1, w});
    for (const Step& step : steps) {
        const bool last = &step == &steps.back();
        if (const auto at = &step - steps.data(); tune("late", 1) > 0 && at >= main_steps && at < main_steps + static_cast<int>(tune("lates", 2))) {
            const std::vector<float> wanted = wantedLengths(surface);
            surface.refine(static_cast<std::size_t>(at - main_steps), [&](std::uint32_t a, std::uint32_t b) {
                const double length = (surface.position()[a] - surface.position()[b]).length() / unit;
                return length * 2 / (wanted[a] + wanted[b]);
            });
        }
        if (&step != steps.data()) approach = approaches(outer, extra, outer_at, order, rolling, surface, step.width);
        std::vector<std::array<float, 6>> values(surface.size());  // step and velocity
        parallelFor(values.size(), 4096, [&](std::size_t v) {
            const Approach& a = approach[v];
            const Vec3f own(surface.mesh().vertex[v].velocity);
            const double way = std::clamp(a.gap * step.share, -std::min(kLongestOutwards, kLip * step.width),
                                          std::min(kLongestInwards, kLip * step.width)) *
                               a.fade;
            const Vec3f along = a.away * static_cast<float>(way), velocity = own + (a.velocity - own) * a.fade;
            values[v] = {along.x, along.y, along.z, velocity.x, velocity.y, velocity.z};
        });
        values = meansOf<6>(surface, step.width, values);
        std::vector<Vec3f> way(surface.size());
        if (last) {
            parallelFor(way.size(), 8192, [&](std::size_t v) { way[v] = {values[v][3], values[v][4], values[v][5]}; });
            surface.setVelocities(way);
        }
        parallelFor(way.size(), 8192, [&](std::size_t v) { way[v] = {values[v][0], values[v][1], values[v][2]}; });
        surface.move(way);
    }
}

}  // namespace betamesh
