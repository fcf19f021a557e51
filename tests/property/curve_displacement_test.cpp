// Displacements that would make edges of a curve cross are shortened until they do not.

#include "planar/curve_displacement.h"
#include "base/random.h"
#include "betamesh/check.h"
#include "betamesh/skin.h"
#include "support/planar_clouds.h"

#include <gtest/gtest.h>

namespace betamesh {
namespace {

BetaCurve curveOf(const Cloud& cloud) {
    SkinParams params;
    params.radius = cloud.radius;
    params.smoothing = SmoothingMethod::none;
    const Curves curves = skinPlane(cloud.particles, params).curves;
    BetaCurve curve;
    for (const std::span<const Edge> line : linesOf(curves)) {
        for (const Edge& edge : line) curve.add({curves.position[edge[0]], Vec3(0)}, false);
        curve.endLine();
    }
    return curve;
}

std::size_t crossingsOf(const BetaCurve& curve, double radius) {
    Curves curves;
    for (const DualVec3& v : curve.vertex) curves.position.push_back(v.position);
    forEveryVertex(curve, [&](std::uint32_t, std::uint32_t v, std::uint32_t after) {
        curves.edges.push_back({v, after});
    });
    CheckParams params;
    params.tolerance = 1e-8 * radius;
    return checkCurves(curves, params).crossings.count;
}

TEST(CurveDisplacement, RandomDisplacementsMakeNoCrossings) {
    std::size_t would_cross = 0;
    forEveryPlanarCloud(100, [&](const Cloud& cloud) {
        for (const double size : {0.05, 0.5, 2.0}) {
            BetaCurve curve = curveOf(cloud), moved = curve;
            std::vector<DualVec3> step(curve.vertex.size());
            for (std::size_t v = 0; v < step.size(); ++v) {
                step[v].position = Random(3, v).cube() * Vec3(1, 1, 0) * (size * cloud.radius);
                moved.vertex[v] = moved.vertex[v] + step[v];
            }
            would_cross += crossingsOf(moved, cloud.radius) > 0;
            moveWithoutCrossings(curve, step, cloud.radius);
            EXPECT_EQ(crossingsOf(curve, cloud.radius), 0u);
        }
    });
    EXPECT_GT(would_cross, 100u);
}

TEST(CurveDisplacement, HarmlessDisplacementsAreNotShortened) {
    forEveryPlanarCloud(100, [](const Cloud& cloud) {
        const BetaCurve before = curveOf(cloud);
        BetaCurve curve = before;
        const DualVec3 step{Vec3(0.3, -0.2, 0) * cloud.radius, Vec3(1, 2, 0)};
        moveWithoutCrossings(curve, std::vector<DualVec3>(curve.vertex.size(), step), cloud.radius);
        for (std::size_t v = 0; v < curve.vertex.size(); ++v) {
            EXPECT_EQ(curve.vertex[v].position, before.vertex[v].position + step.position);
            EXPECT_EQ(curve.vertex[v].velocity, step.velocity);
        }
    });
}

}  // namespace
}  // namespace betamesh
