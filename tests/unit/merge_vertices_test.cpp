// What is true of meshes whose coincident vertices have been merged.

#include "skin/merge_vertices.h"

#include "base/icosphere.h"
#include "base/random.h"
#include "betamesh/check.h"
#include "betamesh/skin.h"

#include <gtest/gtest.h>

namespace betamesh {
namespace {

Mesh sphere() {
    const Icosphere ball = icosphere(4);
    return {ball.position, {}, ball.triangles, {}, {}};
}

// Edges of a sphere shrink to points, some of them next to one another.
TEST(MergeVertices, KeepsTheSurfaceAndLeavesNoEdgeWithoutLength) {
    std::size_t merged = 0;
    for (std::uint64_t seed = 0; seed < 50; ++seed) {
        Mesh mesh = sphere();
        Random random(seed);
        for (const Triangle& t : mesh.triangles)
            if (random.unit() < 0.02 * static_cast<double>(seed % 5)) mesh.position[t[0]] = mesh.position[t[1]];
        const MeshCheck before = checkMesh(mesh);
        BetaMesh beta = asBetaMesh(mesh);
        mergeCoincidentVertices(beta);
        const Mesh after = asMesh(std::move(beta));
        const MeshCheck check = checkMesh(after);
        EXPECT_TRUE(check.closed() && check.edgeManifold() && check.vertexManifold()) << seed;
        EXPECT_EQ(check.euler, 2) << seed;
        EXPECT_NEAR(check.volume, before.volume, 1e-12) << seed;
        EXPECT_NEAR(check.area, before.area, 1e-12) << seed;
        EXPECT_LE(check.zero_area.count, before.zero_area.count / 10) << seed;
        merged += mesh.triangles.size() - after.triangles.size();
    }
    EXPECT_GE(merged, 1000u);
}

TEST(MergeVertices, LeavesMeshesWithoutSuchEdgesAlone) {
    const Mesh mesh = sphere();
    BetaMesh beta = asBetaMesh(mesh);
    mergeCoincidentVertices(beta);
    EXPECT_EQ(beta.triangles, mesh.triangles);
}

// Merging the ends of an edge of a tetrahedron would leave two triangles back to back; merging those of an edge that
// closes a ring around a tube would pinch it.
TEST(MergeVertices, KeepsTheTopology) {
    Mesh tetrahedron{
        {{0, 0, 0}, {0, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}, {}, {}};
    BetaMesh beta = asBetaMesh(tetrahedron);
    mergeCoincidentVertices(beta);
    EXPECT_EQ(beta.triangles, tetrahedron.triangles);

    Mesh tube;  // prisms on triangles; the ring in the middle has an edge of no length
    for (int ring = 0; ring < 3; ++ring)
        for (const Vec3& corner : {Vec3(0, 0, 0), Vec3(ring == 1 ? 0 : 1, 0, 0), Vec3(0, 1, 0)})
            tube.position.push_back(corner + Vec3(0, 0, ring));
    for (std::uint32_t ring = 0; ring < 6; ring += 3)
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::uint32_t a = ring + k, b = ring + (k + 1) % 3;
            tube.triangles.push_back({a, b, b + 3});
            tube.triangles.push_back({a, b + 3, a + 3});
        }
    tube.triangles.push_back({0, 2, 1});
    tube.triangles.push_back({6, 7, 8});
    ASSERT_TRUE(checkMesh(tube).closed());
    beta = asBetaMesh(tube);
    mergeCoincidentVertices(beta);
    EXPECT_EQ(beta.triangles, tube.triangles);
}

TEST(MergeVertices, VerticesFadeInFromThoseThatRemain) {
    const Mesh mesh = sphere();
    BetaMesh beta = asBetaMesh(mesh);
    const auto [a, b, c] = mesh.triangles[0];
    const std::uint32_t stays = std::min(a, b), goes = std::max(a, b);
    beta.vertex[goes].position = beta.vertex[stays].position;
    beta.fading[kOnEdges].push_back({c, {goes, stays, stays, stays}, {0.5, 0.5, 0, 0}, 0.5, {}});
    mergeCoincidentVertices(beta);
    EXPECT_EQ(beta.triangles.size(), mesh.triangles.size() - 2);
    EXPECT_EQ(beta.fading[kOnEdges][0].support[0], stays);
}

// Each ball of a grid meets eight others in one point.
TEST(MergeVertices, RegularGridsHaveNoTriangleWithoutArea) {
    for (const double radius : {1.2, 1.5, 2.0})
        for (const bool has_skin : {true, false})
            for (const auto& [nx, ny, nz] : {std::array{8, 8, 8}, std::array{9, 9, 1}, std::array{7, 5, 3}}) {
                Particles grid;
                for (int z = 0; z < nz; ++z)
                    for (int y = 0; y < ny; ++y)
                        for (int x = 0; x < nx; ++x) grid.position.emplace_back(x, y, z);
                SkinParams params;
                params.radius = radius;
                params.spacing = 1;
                if (!has_skin) params.skin = 0;
                const MeshCheck check = checkMesh(skinFrame(grid, params).mesh);
                EXPECT_EQ(check.zero_area.count, 0u) << radius << ' ' << nx;
                EXPECT_EQ(check.coincident_vertices.count, 0u) << radius << ' ' << nx;
            }
}

}  // namespace
}  // namespace betamesh
