// Real simulation frames, and what CGAL's fixed alpha shape says of them.

#include "io/particle_file.h"
#include "measure/mesh_measure.h"
#include "skin/skin_frame.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <fstream>

namespace betamesh {

namespace {

const std::filesystem::path kShared = BETAMESH_SHARED;

// Snapping moves particles by up to 1e-6 radii, which may decide a near-tie the other way.
void expectWithinOneInTenThousand(std::size_t found, std::size_t expected, const char* what) {
    EXPECT_NEAR(static_cast<double>(found), static_cast<double>(expected), 1e-4 * static_cast<double>(expected))
        << what;
}

}  // namespace

TEST(RealFrames, AlphaCountsAreThoseOfCgal) {
    std::ifstream file(kShared / "oracle/alpha_counts.json");
    if (!file) GTEST_SKIP() << "no recorded alpha counts at " << kShared / "oracle";
    const auto oracle = nlohmann::json::parse(file);
    for (const auto& [name, expected] : oracle.at("frames").items()) {
        SCOPED_TRACE(name);
        const Particles particles = readParticles(kShared / "data" / name);
        ASSERT_EQ(particles.size(), expected.at("particles"));
        SkinParams params;
        params.radius = expected.at("radius");
        params.surface = SurfaceKind::alpha;
        const SkinnedFrame frame = skinFrame(particles, params);
        EXPECT_EQ(frame.report.distinct_particles, expected.at("distinct"));
        expectWithinOneInTenThousand(frame.report.alpha_triangles, expected.at("alpha_triangles"), "alpha triangles");
        expectWithinOneInTenThousand(frame.report.double_sided_triangles, expected.at("double_sided"), "double-sided");
        expectWithinOneInTenThousand(frame.report.degenerate_edges, expected.at("degenerate_edges"),
                                     "degenerate edges");
        expectWithinOneInTenThousand(frame.report.isolated_particles, expected.at("isolated_particles"), "isolated");
        EXPECT_EQ(measureMesh(frame.mesh).unpaired_edges, 0u);
        EXPECT_EQ(frame.mesh.velocity.size(), particles.velocity.empty() ? 0 : frame.mesh.position.size());
    }
}

}  // namespace betamesh
