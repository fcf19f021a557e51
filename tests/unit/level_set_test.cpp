// Meshes as level sets: distances, cavities, the same bytes for any number of threads, limits.

#include "io/level_set.h"

#include "base/icosphere.h"
#include "base/parallel.h"
#include "io/file_info.h"
#include "io/mesh_file.h"
#include "mesh/triangle_tree.h"
#include "support/file_checks.h"

#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/VolumeToMesh.h>

#include <cmath>
#include <map>
#include <sstream>

namespace betamesh {
namespace {

/// Adds a sphere of triangles; inward: it faces its centre.
void addSphere(Mesh& mesh, const Vec3& centre, double radius, bool inward = false) {
    const Icosphere sphere = icosphere(12);
    const auto first = static_cast<std::uint32_t>(mesh.position.size());
    for (const Vec3& p : sphere.position) {
        mesh.position.push_back(centre + p * radius);
        mesh.velocity.push_back(Vec3(1, 0, 0) + p * 2.0);
    }
    for (const Triangle& t : sphere.triangles)
        mesh.triangles.push_back({first + t[0], first + t[inward ? 2 : 1], first + t[inward ? 1 : 2]});
}

LevelSetOptions voxelsOf(double voxel) {
    LevelSetOptions options;
    options.voxel = voxel;
    return options;
}

std::map<std::string, openvdb::GridBase::Ptr> gridsOf(const std::string& bytes) {
    std::istringstream in(bytes);
    openvdb::io::Stream stream(in);
    std::map<std::string, openvdb::GridBase::Ptr> grids;
    const openvdb::GridPtrVecPtr all = stream.getGrids();
    for (const auto& grid : *all) grids[grid->getName()] = grid;
    return grids;
}

openvdb::FloatGrid::Ptr surfaceOf(const std::string& bytes) {
    return openvdb::gridPtrCast<openvdb::FloatGrid>(gridsOf(bytes).at("surface"));
}

double distanceAt(const openvdb::FloatGrid& grid, const Vec3& p) {
    return openvdb::tools::BoxSampler::sample(grid.tree(), grid.worldToIndex(openvdb::Vec3d(p.x, p.y, p.z)));
}

/// The level set as a mesh again.
Mesh meshOf(const openvdb::FloatGrid& grid) {
    std::vector<openvdb::Vec3s> points;
    std::vector<openvdb::Vec4I> quads;
    openvdb::tools::volumeToMesh(grid, points, quads);
    Mesh mesh;
    for (const auto& p : points) mesh.position.emplace_back(p.x(), p.y(), p.z());
    for (const auto& q : quads) {  // which face inward
        mesh.triangles.push_back({q[0], q[2], q[1]});
        mesh.triangles.push_back({q[0], q[3], q[2]});
    }
    return mesh;
}

/// Largest distance of a vertex of one mesh from the other.
double farthest(const Mesh& from, const Mesh& to) {
    const TriangleTree tree(to.position, to.triangles);
    double most = 0;
    for (const Vec3& p : from.position) most = std::max(most, tree.distanceTo(p));
    return most;
}

TEST(LevelSet, DistancesAreThoseOfTheMesh) {
    Mesh mesh;
    addSphere(mesh, Vec3(0.3, -0.2, 5), 1);
    const auto grid = surfaceOf(encodeLevelSet(mesh, "a.vdb", voxelsOf(0.05)));
    EXPECT_EQ(grid->getGridClass(), openvdb::GRID_LEVEL_SET);
    EXPECT_NEAR(grid->background(), 0.15, 1e-7);
    EXPECT_NEAR(grid->voxelSize().x(), 0.05, 1e-12);
    const TriangleTree tree(mesh.position, mesh.triangles);
    std::size_t voxels = 0;
    for (auto voxel = grid->cbeginValueOn(); voxel; ++voxel, ++voxels) {
        const openvdb::Vec3d world = grid->indexToWorld(voxel.getCoord());
        const Vec3 p(world.x(), world.y(), world.z());
        const double sign = (p - Vec3(0.3, -0.2, 5)).length() < 1 ? -1 : 1, distance = tree.distanceTo(p);
        // Farther out OpenVDB takes the nearest triangle of a neighbour.
        ASSERT_NEAR(std::abs(*voxel), distance, (distance < 0.05 ? 0.001 : 0.33) * 0.05);
        if (distance > 0.01) {  // the mesh is inside of the sphere by less
            ASSERT_EQ(*voxel < 0, sign < 0);
        }
    }
    EXPECT_GT(voxels, 6 * 4 * 3.14 / (0.05 * 0.05) * 0.9);
    EXPECT_LT(distanceAt(*grid, Vec3(0.3, -0.2, 5)), 0);  // far inside, beyond the band
    EXPECT_GT(distanceAt(*grid, Vec3(9, 9, 9)), 0);
    const Mesh back = meshOf(*grid);
    EXPECT_LT(farthest(back, mesh), 0.025);
    EXPECT_LT(farthest(mesh, back), 0.025);
}

// OpenVDB alone would fill the cavity and what is in it.
TEST(LevelSet, CavitiesAndWhatIsInThemArePreserved) {
    Mesh mesh;
    addSphere(mesh, Vec3(0, 0, 0), 2);
    addSphere(mesh, Vec3(0, 0, 0), 1.5, true);
    addSphere(mesh, Vec3(0, 0, 0), 1);
    addSphere(mesh, Vec3(0, 0, 0), 0.5, true);
    addSphere(mesh, Vec3(5, 0, 0), 1);
    for (const bool turned : {false, true}) {
        if (turned)
            for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
        const auto grid = surfaceOf(encodeLevelSet(mesh, "a.vdb", voxelsOf(0.05)));
        for (const auto& [x, inside] : std::map<double, bool>{{0, false},
                                                              {0.4, false},
                                                              {0.6, true},
                                                              {0.9, true},
                                                              {1.1, false},
                                                              {1.4, false},
                                                              {1.6, true},
                                                              {2.2, false},
                                                              {5, true}})
            EXPECT_EQ(distanceAt(*grid, Vec3(x, 0, 0)) < 0, inside) << x;
        const Mesh back = meshOf(*grid);
        EXPECT_LT(farthest(back, mesh), 0.025);
        EXPECT_LT(farthest(mesh, back), 0.025);
    }
}

TEST(LevelSet, BytesDoNotDependOnThreads) {
    Mesh mesh;
    for (int i = 0; i < 20; ++i)
        addSphere(mesh, Vec3(0.31 * i, std::sin(3.0 * i), std::cos(7.0 * i)), 0.3 + 0.01 * i, i % 7 == 3);
    LevelSetOptions options = voxelsOf(0.06);
    options.velocity = true;
    std::string first;
    for (const int threads : {1, 2, 3, 8, 1, 8}) {
        std::string bytes;
        withThreads(threads, [&] { bytes = encodeLevelSet(mesh, "a.vdb", options); });
        if (first.empty()) first = bytes;
        EXPECT_EQ(bytes, first) << threads;
    }
}

TEST(LevelSet, VelocitiesAreThoseOfTheNearestPoint) {
    Mesh mesh;
    addSphere(mesh, Vec3(0, 0, 0), 1);
    LevelSetOptions options = voxelsOf(0.1);
    options.velocity = true;
    const auto grids = gridsOf(encodeLevelSet(mesh, "a.vdb", options));
    ASSERT_EQ(grids.size(), 2U);
    const auto velocity = openvdb::gridPtrCast<openvdb::Vec3SGrid>(grids.at("v"));
    EXPECT_EQ(velocity->activeVoxelCount(), grids.at("surface")->activeVoxelCount());
    for (auto voxel = velocity->cbeginValueOn(); voxel; ++voxel) {
        const openvdb::Vec3d world = velocity->indexToWorld(voxel.getCoord());
        const openvdb::Vec3d expected = openvdb::Vec3d(1, 0, 0) + world / world.length() * 2;
        ASSERT_LT((openvdb::Vec3d(*voxel) - expected).length(), 0.1);
    }
    mesh.velocity.clear();
    const auto still =
        openvdb::gridPtrCast<openvdb::Vec3SGrid>(gridsOf(encodeLevelSet(mesh, "a.vdb", options)).at("v"));
    for (auto voxel = still->cbeginValueOn(); voxel; ++voxel) ASSERT_EQ(*voxel, openvdb::Vec3s(0));
}

TEST(LevelSet, ExtentCostsNothing) {
    Mesh mesh;
    addSphere(mesh, Vec3(0, 0, 0), 1);
    const std::size_t one = encodeLevelSet(mesh, "a.vdb", voxelsOf(0.1)).size();
    addSphere(mesh, Vec3(1e6, -1e6, 3e6), 1);
    EXPECT_LT(encodeLevelSet(mesh, "a.vdb", voxelsOf(0.1)).size(), 5 * one);
}

TEST(LevelSet, VoxelsThatAreTooSmallAreErrors) {
    Mesh mesh;
    addSphere(mesh, Vec3(100, 0, 0), 1);
    expectError([&] { encodeLevelSet(mesh, "a.vdb", voxelsOf(1e-8)); },
                {"a.vdb: voxels of 1e-08 are too small for coordinates up to 101", "output.voxel"});
    expectError([&] { encodeLevelSet(mesh, "a.vdb", voxelsOf(1e-6)); },
                {"would need about", "GB of memory", "output.voxel"});
    for (const double voxel : {1.2e38, 1e39, 1e300})
        expectError([&] { encodeLevelSet(mesh, "a.vdb", voxelsOf(voxel)); }, {"are too large", "--voxel"});
    encodeLevelSet(mesh, "a.vdb", voxelsOf(1.1e38));
    LevelSetOptions limited = voxelsOf(0.001);
    limited.memory_limit = 100000000;
    expectError([&] { encodeLevelSet(mesh, "a.vdb", limited); }, {"but 0.1 GB are the limit"});
    EXPECT_THROW(encodeLevelSet(mesh, "a.vdb", limited), MemoryError);
}

TEST(LevelSet, WhatItDoesNotShowIsTold) {
    Mesh mesh;
    addSphere(mesh, Vec3(0.5, 0.5, 0.5), 0.1);
    std::vector<std::string> warnings;
    const auto warn = [&](const std::string& text) { warnings.push_back(text); };
    encodeLevelSet(mesh, "a.vdb", voxelsOf(0.05), warn);
    EXPECT_TRUE(warnings.empty());
    encodeLevelSet(mesh, "a.vdb", voxelsOf(1), warn);  // centres of voxels are at whole numbers
    ASSERT_EQ(warnings.size(), 1U);
    EXPECT_NE(warnings[0].find("no voxel of 1 is inside the mesh. Choose smaller voxels"), std::string::npos);
    encodeLevelSet({}, "a.vdb", voxelsOf(1), warn);
    EXPECT_EQ(warnings.size(), 1U);

    Mesh sheet;
    sheet.position = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    sheet.triangles = {{0, 1, 2}};
    encodeLevelSet(sheet, "a.vdb", voxelsOf(0.1), warn);
    ASSERT_EQ(warnings.size(), 2U);
    EXPECT_TRUE(warnings[1].starts_with(kNoInside)) << warnings[1];
    EXPECT_NE(warnings[1].find("3 edges without a triangle on one side"), std::string::npos);
    addSphere(sheet, Vec3(5, 0, 0), 1);
    sheet.velocity.clear();
    encodeLevelSet(sheet, "a.vdb", voxelsOf(0.1), warn);
    ASSERT_EQ(warnings.size(), 3U);
    EXPECT_NE(warnings[2].find("open parts of the mesh may be missing"), std::string::npos);
}

TEST(LevelSet, EmptyMeshesGiveEmptyGrids) {
    LevelSetOptions options;
    options.velocity = true;
    const auto grids = gridsOf(encodeLevelSet({}, "a.vdb", options));
    EXPECT_EQ(grids.size(), 2U);
    EXPECT_EQ(grids.at("surface")->activeVoxelCount(), 0U);
    EXPECT_EQ(grids.at("surface")->getGridClass(), openvdb::GRID_LEVEL_SET);
}

TEST(LevelSet, InfoDescribesItAndReadingSaysWhatToDo) {
    const TemporaryFolder folder;
    const std::string file = folder / "a.vdb";
    Mesh mesh;
    addSphere(mesh, Vec3(1, 2, 3), 1);
    writeMesh(file, mesh);  // voxels of the median length of the edges
    const FileInfo info = inspectFile(file);
    ASSERT_EQ(info.volumes.size(), 1U);
    EXPECT_EQ(info.volumes[0].name, "surface");
    EXPECT_EQ(info.volumes[0].kind, "level set");
    EXPECT_GT(info.volumes[0].voxel, 0.05);
    EXPECT_LT(info.volumes[0].voxel, 0.15);
    EXPECT_NEAR(info.volumes[0].upper.y, 3 + 3 * info.volumes[0].voxel, info.volumes[0].voxel);
    expectError([&] { readMesh(file); }, {"a.vdb", "vdb_tool -read in.vdb -ls2mesh -write out.ply"});
    expectError([&] { readParticles(file); }, {"contains no point grid (found 'surface')"});
}

}  // namespace
}  // namespace betamesh
