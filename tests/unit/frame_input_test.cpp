// The particles of a frame near its surface, read from files that need not fit into memory.

#include "batch/job/frame_input.h"

#include "skin/particle_sizes.h"
#include "support/file_checks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace betamesh {
namespace {

/// A block of n³ particles with spacing 1, and the size of each as the attribute pscale.
Particles blockWithSizes(int n) {
    Particles particles;
    particles.attributes.push_back({"pscale", 1, {}, {}});
    for (int i = 0; i < n * n * n; ++i) {
        particles.position.emplace_back(static_cast<float>(i % n), static_cast<float>(i / n % n),
                                        static_cast<float>(i / (n * n)));
        particles.attributes[0].real.push_back(i % 3 == 0 ? 1.0F : 0.95F);
    }
    return particles;
}

FrameInput readNear(const std::string& file, const Plan& plan) {
    FrameTask task;
    task.input = file;
    FileIdentity identity;
    return readInput(task, plan, true, identity, [](const std::string&) {});
}

TEST(FrameInput, CoordinatesThatFloatsRoundCoarselyGiveAWarning) {
    for (const float distance : {0.0F, 1e3F, 1e4F, -4e4F, 1e6F}) {
        FrameInput liquid{blockWithSizes(8), {}, {}};
        for (Vec3f& p : liquid.particles.position) p.y += distance;
        const std::vector<InputRemark> remarks = remarksOn(liquid, {});
        const auto found = std::ranges::find(remarks, "coordinates", &InputRemark::kind);
        EXPECT_EQ(found != remarks.end(), std::abs(distance) > 2e4F) << distance;
        if (found == remarks.end()) continue;
        EXPECT_TRUE(found->is_warning);
        EXPECT_NE(found->text.find("--origin x,y,z (input.origin)"), std::string::npos) << found->text;
    }
}

TEST(FrameInput, ParticlesWhoseVerticesFloatsRoundCoarselyGiveAWarningWhereverTheOthersAre) {
    for (const int far : {0, 1, 255, 256, 511}) {
        for (const float distance : {1e3F, 1.6e4F, 1.8e4F, -4e4F, 1e6F, 1e9F}) {
            SCOPED_TRACE(std::to_string(far) + " at " + std::to_string(distance));
            FrameInput liquid{blockWithSizes(8), {}, {}};
            for (int i = 0; i < far; ++i) liquid.particles.position[static_cast<std::size_t>(i)].z += distance;
            Plan plan;
            plan.spacing = 1;
            const std::vector<InputRemark> remarks = remarksOn(liquid, plan);
            const auto found = std::ranges::find(remarks, "coordinates", &InputRemark::kind);
            ASSERT_EQ(found != remarks.end(), far > 0 && std::abs(distance) > 1.7e4F);
            if (found == remarks.end()) continue;
            EXPECT_TRUE(found->is_warning);
            EXPECT_TRUE(found->text.starts_with(std::to_string(far) + " of 512 particles are so far")) << found->text;
            EXPECT_NE(found->text.find("--box (input.box)"), std::string::npos) << found->text;
            EXPECT_EQ(found->text.find("--origin x,y,z") != std::string::npos, far > 256) << found->text;
        }
    }
}

TEST(FrameInput, AFewSizesThatSwallowOtherParticlesGiveAWarning) {
    const auto warningOn = [](const std::vector<float>& sizes, const Vec3f& place, double scale = 1) -> std::string {
        FrameInput liquid{blockWithSizes(8), {}, {}};
        liquid.summary.particles_read = liquid.particles.size();
        for (std::size_t i = 0; i < sizes.size(); ++i) liquid.particles.attributes[0].real[100 + i] = sizes[i];
        liquid.particles.position[100] = place;
        Plan plan;
        plan.skin.radius = 1.5;
        plan.skin.spacing = 1;
        plan.skin.radius_attribute = "pscale";
        plan.skin.radius_scale = scale;
        const std::vector<InputRemark> remarks = remarksOn(liquid, plan);
        const auto found = std::ranges::find(remarks, "sizes", &InputRemark::kind);
        return found != remarks.end() && found->is_warning ? found->text : "none";
    };
    const Vec3f inside(4, 4, 4);
    EXPECT_EQ(
        warningOn({100}, inside),
        "particle 100 has pscale = 100, 105.263 times the median, 0.95: its ball swallows 511 other particles. If "
        "that is a mistake, leave it out with --where 'pscale <= 19' (input.where)");
    EXPECT_NE(warningOn({100, 30, 30}, inside).find(", and 2 more particles are as unusual."), std::string::npos);
    EXPECT_NE(warningOn({30}, inside, 0.1).find("swallows"), std::string::npos);
    EXPECT_EQ(warningOn({}, inside), "none");
    EXPECT_EQ(warningOn({18}, inside), "none");
    EXPECT_EQ(warningOn({100}, Vec3f(1e4F, 0, 0)), "none");             // covers nothing
    EXPECT_EQ(warningOn({100}, inside, 0.01), "none");                  // likewise
    EXPECT_EQ(warningOn(std::vector<float>(20, 100), inside), "none");  // too many for a mistake
}

TEST(FrameInput, VerticesOfPolygonsGiveAWarningWhereTheyAreTakenAsParticles) {
    const TemporaryFolder folder;
    const auto warningOn = [&](const std::string& name) -> std::string {
        auto [particles, summary] = readSummarised(folder / name, {});
        EXPECT_EQ(particles.size(), 9U) << name;
        const std::vector<InputRemark> remarks = remarksOn({std::move(particles), {}, std::move(summary)}, {});
        const auto found = std::ranges::find(remarks, "polygons", &InputRemark::kind);
        return found != remarks.end() && found->is_warning ? found->text : "none";
    };
    for (const char* name : {"a.ply", "a.bgeo", "a.bhclassic", "a.vtp", "a.usda", "a.abc"}) {
        writeMesh(folder / name, withComponents(sampleMesh(9, true, true)));
        EXPECT_EQ(warningOn(name), "contains 7 polygons: its vertices are taken as particles") << name;
        writeParticles(folder / name, sampleParticles(9, true, true, true));
        EXPECT_EQ(warningOn(name), "none") << name;
    }
    // Points that are cells, a triangle, a line and a strip.
    write(folder / "a.vtk", "# vtk DataFile Version 3.0\n\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 9 float\n" +
                                std::string("0 0 0 1 0 0 0 1 0 1 1 0 0 0 1 1 0 1 0 1 1 1 1 1 2 2 2\n") +
                                "CELLS 5 18\n1 8\n3 0 1 2\n2 0 3\n4 0 1 2 3\n3 5 6 7\nCELL_TYPES 5\n1 5 3 6 2\n");
    EXPECT_EQ(warningOn("a.vtk"), "contains 2 polygons: its vertices are taken as particles");
    const auto geometry = [&](const std::string& primitives) {
        write(folder / "a.geo",
              "[\"pointcount\",9,\"vertexcount\",4,\"primitivecount\",2,\"topology\",[\"pointref\",[\"indices\",[0,1,2,"
              "3]]],"
              "\"attributes\",[\"pointattributes\",[[[\"scope\",\"public\",\"type\",\"numeric\",\"name\",\"P\"],["
              "\"size\",3,"
              "\"storage\",\"fpreal32\",\"values\",[\"size\",3,\"storage\",\"fpreal32\",\"tuples\",[[0,0,0],[1,0,0],"
              "[0,1,0],[1,1,0],[0,0,1],[1,0,1],[0,1,1],[1,1,1],[2,2,2]]]]]]],\"primitives\",[" +
                  primitives + "]]");
        return warningOn("a.geo");
    };
    EXPECT_EQ(geometry("[[\"type\",\"Poly\"],[\"vertex\",[0,1,2],\"closed\",true]]"),
              "contains 1 polygon: its vertices are taken as particles");
    EXPECT_EQ(geometry("[[\"type\",\"run\",\"runtype\",\"Poly\",\"varyingfields\",[\"vertex\"],\"uniformfields\","
                       "[\"closed\",true]],[[[0,1,2]],[[1,2,3]]]]"),
              "contains 2 polygons: its vertices are taken as particles");
    EXPECT_EQ(geometry("[[\"type\",\"Poly\"],[\"vertex\",[0,1,2],\"closed\",false]]"), "none");
    EXPECT_EQ(
        geometry("[[\"type\",\"PolygonCurve_run\"],[\"startvertex\",0,\"nprimitives\",2,\"nvertices_rle\",[2,2]]]"),
        "none");
}

TEST(FrameInput, SizesOfParticlesAreReadWithTheirPositions) {
    const TemporaryFolder folder;
    Plan plan;
    plan.skin.radius = 0.3;  // of other particles
    plan.skin.radius_attribute = "pscale";
    plan.skin.skin = 0;
    Particles particles = blockWithSizes(30);
    NearSurfaceFinder finder(plan.skin);
    finder.add(particles.position, particleSizes(particles, plan.skin).radius);
    const NearSurface expected = finder.find();
    EXPECT_GT(expected.omitted(), 1000U);
    EXPECT_NEAR(expected.largest, 1.5, 1e-6);
    for (const char* name : {"a.ply", "a.bgeo.sc", "a.vdb", "a.vtp", "a.csv"}) {
        SCOPED_TRACE(name);
        writeParticles(folder / name, particles);
        const Particles all = readParticles(folder / name);  // a .vdb has another order
        NearSurfaceFinder again(plan.skin);
        again.add(all.position, particleSizes(all, plan.skin).radius);
        const NearSurface near = again.find();
        const FrameInput liquid = readNear(folder / name, plan);
        ASSERT_TRUE(liquid.near.has_value());
        EXPECT_EQ(liquid.near->omitted(), expected.omitted());
        EXPECT_EQ(liquid.near->largest, expected.largest);
        EXPECT_TRUE(liquid.near->is_unequal);
        EXPECT_EQ(liquid.near->row, near.row);
        EXPECT_EQ(liquid.particles.position, rowsOf(all, near.row).position);
    }
    particles.attributes[0].real[20000] = 0;
    writeParticles(folder / "bad.ply", particles);
    expectError([&] { readNear(folder / "bad.ply", plan); }, {"particle 20000 has pscale = 0", "above 0"});
    plan.config.input.where = "pscale > 0";
    EXPECT_EQ(readNear(folder / "bad.ply", plan).near->particles, particles.size() - 1);
    plan.skin.radius_attribute = "size";
    expectError([&] { readNear(folder / "bad.ply", plan); }, {"no attribute 'size'", "pscale"});
}

}  // namespace
}  // namespace betamesh
