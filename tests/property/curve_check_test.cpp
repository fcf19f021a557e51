// checkCurves() on good and on broken curves.

#include "base/random.h"
#include "betamesh/check.h"
#include "betamesh/skin.h"
#include "support/planar_clouds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace betamesh {
namespace {

using Faults = std::vector<std::string_view>;

Curves square(double low, double high) {
    Curves curves;
    curves.position = {{low, low, 0}, {high, low, 0}, {high, high, 0}, {low, high, 0}};
    curves.edges = {{0, 1}, {1, 2}, {2, 3}, {3, 0}};
    return curves;
}

Curves concatenate(Curves one, const Curves& other) {
    const auto first = static_cast<std::uint32_t>(one.position.size());
    one.position.insert(one.position.end(), other.position.begin(), other.position.end());
    for (const Edge& edge : other.edges) one.edges.push_back({edge[0] + first, edge[1] + first});
    return one;
}

Curves reversed(Curves curves) {
    std::reverse(curves.edges.begin(), curves.edges.end());
    for (Edge& edge : curves.edges) std::swap(edge[0], edge[1]);
    return curves;
}

TEST(CurveCheck, DistinguishesComponentsAndHoles) {
    const CurveCheck check =
        checkCurves(concatenate(concatenate(square(0, 4), reversed(square(1, 2))), square(6, 7)), {});
    EXPECT_EQ(faultsOf(check, true), Faults{});
    EXPECT_EQ(check.measure.curves, 3U);
    EXPECT_EQ(check.measure.turning, 1);
    EXPECT_DOUBLE_EQ(check.measure.area, 16);
    EXPECT_DOUBLE_EQ(check.measure.length, 24);
}

TEST(CurveCheck, NamesTheFaults) {
    EXPECT_EQ(faultsOf(checkCurves(reversed(square(0, 1)), {})), Faults{"inside_out"});
    Curves open = square(0, 1);
    open.edges.pop_back();
    EXPECT_EQ(faultsOf(checkCurves(open, {})), Faults{"open_ends"});
    EXPECT_EQ(checkCurves(open, {}).open_ends.count, 2U);
    Curves bad = square(0, 1);
    bad.position[2].x = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(faultsOf(checkCurves(bad, {})), (Faults{"not_finite", "open_ends"}));
    bad = square(0, 1);
    bad.edges[1] = {1, 1};
    EXPECT_EQ(faultsOf(checkCurves(bad, {})), (Faults{"repeated_vertices", "open_ends"}));
    bad = square(0, 1);
    bad.velocity.assign(4, Vec3(0));
    bad.velocity[3].y = std::numeric_limits<double>::infinity();
    EXPECT_EQ(faultsOf(checkCurves(bad, {})), Faults{"velocity_not_finite"});
    bad = square(0, 1);
    bad.position.emplace_back(0, 0, 1);
    EXPECT_EQ(faultsOf(checkCurves(bad, {})), Faults{});
    EXPECT_EQ(faultsOf(checkCurves(bad, {}), true), (Faults{"off_plane", "unused_vertices"}));
}

TEST(CurveCheck, MeasuresTheDepthOfCrossings) {
    const Curves both = concatenate(square(0, 2), square(1.75, 4));  // two edges cross, by a quarter each
    const CurveCheck check = checkCurves(both, {});
    EXPECT_EQ(faultsOf(check), Faults{"crossings"});
    EXPECT_EQ(check.crossings.count, 2U);
    EXPECT_DOUBLE_EQ(check.deepest, 0.25);
    CheckParams tolerant;
    tolerant.tolerance = 0.3;
    EXPECT_EQ(faultsOf(checkCurves(both, tolerant)), Faults{});
    EXPECT_EQ(faultsOf(checkCurves(concatenate(square(0, 2), square(2, 4)), {})), Faults{});  // they touch
}

// Integer coordinates, so that brute force is exact, too; many edges touch or are collinear.
TEST(CurveCheck, FindsTheCrossingsThatBruteForceFinds) {
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        Curves curves;
        const auto n = static_cast<std::uint32_t>(3 + random.below(20));
        for (std::uint32_t i = 0; i < n; ++i) {
            curves.position.emplace_back(static_cast<double>(random.below(8)), static_cast<double>(random.below(8)), 0);
            curves.edges.push_back({i, (i + 1) % n});
        }
        std::size_t crossings = 0;
        const auto side = [&](const Edge& e, std::uint32_t v) {
            const Vec3& a = curves.position[e[0]];
            const double z = crossZ(curves.position[e[1]] - a, curves.position[v] - a);
            return (z > 0) - (z < 0);
        };
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t j = 0; j < i; ++j) {
                const Edge &e = curves.edges[i], &f = curves.edges[j];
                crossings += side(e, f[0]) * side(e, f[1]) < 0 && side(f, e[0]) * side(f, e[1]) < 0;
            }
        EXPECT_EQ(checkCurves(curves, {}).crossings.count, crossings);
    }
}

TEST(CurveCheck, DistancesOutsideAreThoseToTheNearestEdge) {
    const Curves ring = concatenate(square(0, 4), reversed(square(1, 2)));
    Spheres beside;
    beside.position = {{10, 0, 0}};
    beside.radius = {1};
    const std::vector<Vec3> points{{3, 3, 0}, {0, 2, 0},    {4, 4, 7},  {1.5, 1.75, 0},
                                   {7, 8, 0}, {10.5, 0, 0}, {2, 1.5, 0}};
    EXPECT_EQ(distancesOutside(ring, beside, points), (std::vector<double>{0, 0, 0, 0.25, 5, 0, 0}));
}

TEST(CurveCheck, CurvesOfEveryCloudAreValidBeforeSmoothingAndEncloseAllParticlesAfter) {
    forEveryPlanarCloud(400, [](const Cloud& cloud) {
        SkinParams params;
        params.radius = cloud.radius;
        params.smoothing = SmoothingMethod::none;
        CheckParams tolerance;
        tolerance.tolerance = 1e-5 * cloud.radius;  // arcs between vertices that coincide but for rounding
        const Curves before = skinPlane(cloud.particles, params).curves;
        EXPECT_EQ(faultsOf(checkCurves(before, tolerance)), Faults{});
        params.smoothing = SmoothingMethod::coherent;
        const Curves after = skinPlane(cloud.particles, params).curves;
        const std::vector<Vec3> points(cloud.particles.position.begin(), cloud.particles.position.end());
        for (const double outside : distancesOutside(after, {}, points)) EXPECT_EQ(outside, 0);
        EXPECT_LE(checkCurves(after, tolerance).deepest, 0.1 * cloud.radius);
    });
}

}  // namespace
}  // namespace betamesh
