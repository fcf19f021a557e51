// The boundary of balls of different radii, compared with CGAL's weighted alpha shapes.

#include "base/random.h"
#include "skin/ball_boundary.h"
#include "skin/coverage.h"
#include "support/cgal_alpha_shape.h"
#include "support/clouds.h"
#include "support/oracles.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Fixed_alpha_shape_3.h>
#include <CGAL/Fixed_alpha_shape_cell_base_3.h>
#include <CGAL/Fixed_alpha_shape_vertex_base_3.h>
#include <CGAL/Regular_triangulation_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

namespace betamesh {

namespace {

// What a union of balls exposes, by rows of SnappedParticles.
struct Exposed {
    TriangleSet triangles;
    std::set<std::array<std::uint32_t, 2>> circles;  // pairs of balls in ascending order
    std::set<std::uint32_t> isolated;
};

// The same integers as the exact predicates get, which CGAL's predicates decide exactly, too: the union of balls has
// the shape of alpha 0, with squared radii as weights.
Exposed exposedByCgal(const SnappedParticles& snapped) {
    using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
    using Numbered = CGAL::Triangulation_vertex_base_with_info_3<std::uint32_t, Kernel,
                                                                 CGAL::Regular_triangulation_vertex_base_3<Kernel>>;
    using Vertex = CGAL::Fixed_alpha_shape_vertex_base_3<Kernel, Numbered>;
    using Cell = CGAL::Fixed_alpha_shape_cell_base_3<Kernel, CGAL::Regular_triangulation_cell_base_3<Kernel>>;
    using Triangulation = CGAL::Regular_triangulation_3<Kernel, CGAL::Triangulation_data_structure_3<Vertex, Cell>>;
    using AlphaShape = CGAL::Fixed_alpha_shape_3<Triangulation>;
    std::vector<std::pair<Kernel::Weighted_point_3, std::uint32_t>> balls;
    for (std::uint32_t i = 0; i < snapped.size(); ++i) {
        const Vec3 p = toDouble(snapped.position[i]);
        const auto radius = static_cast<double>(snapped.radiusOf(i));
        balls.emplace_back(Kernel::Weighted_point_3(Kernel::Point_3(p.x, p.y, p.z), radius * radius), i);
    }
    Triangulation triangulation(balls.begin(), balls.end());
    const AlphaShape shape(triangulation, 0);
    Exposed exposed;
    exposed.triangles = canonical(exposedTriangles(shape));
    for (auto edge = shape.finite_edges_begin(); edge != shape.finite_edges_end(); ++edge) {
        if (shape.classify(*edge) != AlphaShape::SINGULAR) continue;
        const std::uint32_t a = edge->first->vertex(edge->second)->info(), b = edge->first->vertex(edge->third)->info();
        exposed.circles.insert({std::min(a, b), std::max(a, b)});
    }
    for (auto vertex = shape.finite_vertices_begin(); vertex != shape.finite_vertices_end(); ++vertex)
        if (shape.classify(vertex) == AlphaShape::SINGULAR) exposed.isolated.insert(vertex->info());
    return exposed;
}

Exposed exposedByBoundary(const SnappedParticles& snapped) {
    const BallBoundary boundary = ballBoundary(snapped, exposureCandidates(snapped));
    Exposed exposed;
    std::vector<Triangle> triangles = boundary.triangle;
    for (Triangle& t : triangles)
        for (std::uint32_t& corner : t) corner = boundary.snapped_row[corner];
    exposed.triangles = canonical(triangles);
    for (const auto& [a, b] : boundary.circle)
        exposed.circles.insert({boundary.snapped_row[a], boundary.snapped_row[b]});
    for (const std::uint32_t ball : boundary.isolated) exposed.isolated.insert(boundary.snapped_row[ball]);
    return exposed;
}

struct UnequalCloud {
    Particles particles;
    std::vector<double> radii;
};

// Adds a cube of particles with a spacing, n along each edge, every coordinate moved by up to `jitter` spacings.
void addBlock(const Vec3& corner, int n, double spacing, double jitter,
              const std::function<double(const Vec3&)>& radius, UnequalCloud& cloud) {
    Random random(7, cloud.radii.size());
    for (int z = 0; z < n; ++z)
        for (int y = 0; y < n; ++y)
            for (int x = 0; x < n; ++x) {
                const Vec3 p = corner + (Vec3(x, y, z) + random.cube() * jitter) * spacing;
                cloud.particles.position.emplace_back(p);
                cloud.radii.push_back(radius(p));
            }
}

// Compares a cloud and returns the number of its triangles.
std::size_t compared(const UnequalCloud& cloud) {
    const SnappedParticles snapped = snapParticles(cloud.particles, cloud.radii);
    EXPECT_FALSE(snapped.radius_of.empty());
    const Exposed expected = exposedByCgal(snapped), found = exposedByBoundary(snapped);
    EXPECT_EQ(found.triangles.size(), expected.triangles.size());
    EXPECT_TRUE(found.triangles == expected.triangles);
    EXPECT_TRUE(found.circles == expected.circles) << found.circles.size() << " and " << expected.circles.size();
    EXPECT_TRUE(found.isolated == expected.isolated) << found.isolated.size() << " and " << expected.isolated.size();
    return found.triangles.size();
}

}  // namespace

// Radii of two sizes, of a range with a ratio of 20, and in waves. The largest have their usual radius, which leaves
// few pores, or a smaller one, which leaves many, and balls that meet one other or none.
TEST(Cgal, FindsTheSameTrianglesOfBallsOfDifferentRadii) {
    constexpr int kEdge = 37;
    std::size_t triangles = 0;
    for (const RadiusPattern pattern : {RadiusPattern::two, RadiusPattern::twentieth, RadiusPattern::wave})
        for (const double largest : {1.5, 0.8, 0.65}) {
            SCOPED_TRACE(testing::Message() << "radii " << static_cast<int>(pattern) << ", largest radius " << largest);
            Random random(static_cast<std::uint64_t>(pattern));
            UnequalCloud cloud;
            addBlock(
                Vec3(0), kEdge, 1, 0.4, [&](const Vec3& p) { return largest * relativeRadius(pattern, p, random); },
                cloud);
            triangles += compared(cloud);
        }
    RecordProperty("triangles", static_cast<int>(triangles));
    EXPECT_GT(triangles, 400000U);
}

// Coarse liquid beside liquid of a twentieth of its size.
TEST(Cgal, FindsTheSameTrianglesWhereCoarseAndFineLiquidMeet) {
    UnequalCloud cloud;
    constexpr double kFine = 0.05;
    addBlock(
        Vec3(0), 8, 1, 0.4, [](const Vec3&) { return 1.5; }, cloud);
    addBlock(
        Vec3(8, 2, 2), 37, kFine, 0.4, [](const Vec3&) { return 1.5 * kFine; }, cloud);
    EXPECT_GT(compared(cloud), 5000U);
}

}  // namespace betamesh
