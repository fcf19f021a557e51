// Properties of the complete tessellation of every cloud.

#include "skin/tessellate.h"

#include "base/icosphere.h"
#include "base/random.h"
#include "betamesh/check.h"
#include "betamesh/skin.h"
#include "skin/arcs.h"
#include "skin/ball_boundary.h"
#include "skin/coverage.h"
#include "skin/face_points.h"
#include "skin/faces.h"
#include "skin/velocity.h"
#include "support/clouds.h"

#include <gtest/gtest.h>

#include <numbers>

namespace betamesh {

namespace {

struct Tessellated {
    BallBoundary boundary;
    Mesh mesh;
};

Mesh meshOf(const BetaMesh& beta) {
    Mesh mesh;
    std::vector<std::uint32_t> place(beta.vertex.size(), ~std::uint32_t{0});
    for (Triangle t : beta.triangles) {
        for (std::uint32_t& v : t) {
            if (place[v] == ~std::uint32_t{0}) {
                place[v] = static_cast<std::uint32_t>(mesh.position.size());
                mesh.position.push_back(beta.vertex[v].position);
            }
            v = place[v];
        }
        mesh.triangles.push_back(t);
    }
    return mesh;
}

Tessellated tessellated(const Particles& particles, double radius, Appearance appearance = Appearance::on_boundary,
                        double angle = 0.25, int segments = 0) {
    const SnappedParticles snapped = snapParticles(particles, radius);
    const Icosphere directions = icosphereOf(angle);
    BallBoundary boundary = ballBoundary(snapped, exposureCandidates(snapped), directions.position);
    groupFaces(snapped, boundary);
    const std::vector<DualVec3> balls = ballCentres(boundary, particles);
    const ArcSubdivision subdivision{angle, segments, appearance};
    const ArcNetwork network =
        arcPoints(boundary, balls, boundaryVertices(particles, snapped, boundary, balls), subdivision);
    Mesh mesh = meshOf(
        completeTessellation(boundary, balls, network, facePoints(snapped, boundary, balls, directions), subdivision));
    return {std::move(boundary), std::move(mesh)};
}

// Largest distance of a vertex from the boundary of the union, radii.
double farthestFromBoundary(const Particles& particles, const Mesh& mesh, double radius) {
    double farthest = 0;
    for (const Vec3& v : mesh.position) {
        double nearest = std::numeric_limits<double>::infinity();
        for (const Vec3f& p : particles.position) nearest = std::min(nearest, (Vec3(p) - v).length());
        farthest = std::max(farthest, std::abs(nearest - radius) / radius);
    }
    return farthest;
}

MeshCheck expectAClosedManifold(const Tessellated& made) {
    CheckParams params;
    params.tolerance = 1e-6 * made.boundary.worldRadius();
    MeshCheck check = checkMesh(made.mesh, params);
    EXPECT_EQ(check.open_edges.count, 0u);
    EXPECT_EQ(check.misoriented_edges.count, 0u);
    EXPECT_EQ(check.nonmanifold_edges.count, 0u);
    EXPECT_EQ(check.nonmanifold_vertices.count, 0u);
    EXPECT_EQ(check.repeated_vertices.count, 0u);
    EXPECT_EQ(check.euler, eulerCharacteristic(made.boundary));
    return check;
}

}  // namespace

TEST(CompleteMesh, IsAClosedManifoldWithoutCrossingsForEveryCloud) {
    forEveryCloud(400, [](const Cloud& cloud) {
        for (const Appearance appearance : {Appearance::on_boundary, Appearance::gradual}) {
            const MeshCheck check = expectAClosedManifold(tessellated(cloud.particles, cloud.radius, appearance));
            EXPECT_EQ(check.crossings.count, 0u) << "the deepest: " << check.deepest / cloud.radius << " radii";
        }
    });
}

TEST(CompleteMesh, IsAClosedManifoldWithoutCrossingsForEverySubdivision) {
    forEveryCloud(150, [](const Cloud& cloud) {
        for (const int segments : {1, 2, 5}) {
            const MeshCheck check = expectAClosedManifold(tessellated(
                cloud.particles, cloud.radius, Appearance::on_boundary, std::min(0.7, 0.75 / segments), segments));
            EXPECT_EQ(check.crossings.count, 0u) << segments << " segments, " << check.deepest / cloud.radius;
        }
    });
}

// Spheres that nearly share one point or two have arcs, lenses and gaps of all sizes down to rounding.
TEST(CompleteMesh, IsAClosedManifoldWhereBallsNearlyShareAPoint) {
    for (std::uint64_t seed = 0; seed < 1500; ++seed) {
        Random random(seed);
        const double radius = seed % 3 == 0 ? 1 : 0.3 + 0.75 * random.unit();
        const double off = std::pow(10, -1 - 14 * random.unit());
        const bool on_sphere = seed % 2 == 0;
        Particles particles;
        for (std::uint64_t i = 0; i < 3 + seed % 4; ++i) {
            Vec3 direction = random.ball();
            if (!on_sphere) direction.z = 0;
            particles.position.emplace_back(direction.normalized() * radius + random.ball() * off);
        }
        for (const Appearance appearance : {Appearance::on_boundary, Appearance::gradual}) {
            const MeshCheck check = expectAClosedManifold(tessellated(particles, 1, appearance));
            ASSERT_EQ(check.crossings.count, 0u) << "seed " << seed << ", the deepest: " << check.deepest;
        }
    }
}

// Each new ball touches an earlier one, apart from a gap or overlap of any size down to rounding; some touch twice at
// nearly the same point, some at a vertex of the mesh.
TEST(CompleteMesh, IsAClosedManifoldWhereBallsNearlyTouch) {
    const std::vector<Vec3> vertices = icosphere(4).position;
    for (std::uint64_t seed = 0; seed < 250; ++seed) {
        Random random(seed);
        Particles particles;
        particles.position.emplace_back(random.cube());
        for (std::uint64_t i = 0; i < 1 + seed % 12; ++i) {
            const Vec3 direction =
                random.unit() < 0.3 ? vertices[random.below(vertices.size())] : random.ball().normalized();
            const double off = std::pow(10, -0.5 - 8 * random.unit()) * (random.unit() < 0.7 ? 1 : -1);
            const std::uint64_t other = seed % 2 == 0 ? 0 : random.below(particles.size());
            particles.position.emplace_back(Vec3(particles.position[other]) + direction * (2 + off));
            if (random.unit() < 0.2)
                particles.position.emplace_back(Vec3(particles.position.back()) + random.ball() * std::abs(off));
        }
        const MeshCheck check = expectAClosedManifold(tessellated(particles, 1, Appearance::gradual));
        ASSERT_EQ(check.crossings.count, 0u) << "seed " << seed << ", the deepest: " << check.deepest;
        SkinParams params;
        params.radius = 1;
        CheckParams tolerance;
        tolerance.tolerance = 1e-6;
        const MeshCheck smooth = checkMesh(skinFrame(particles, params).mesh, tolerance);
        ASSERT_EQ(smooth.crossings.count, 0u) << "seed " << seed << ", smoothed, the deepest: " << smooth.deepest;
    }
}

TEST(CompleteMesh, IsOnTheBoundaryOfTheUnion) {
    forEveryCloud(300, [](const Cloud& cloud) {
        if (cloud.particles.size() > 1500) return;
        EXPECT_LE(farthestFromBoundary(cloud.particles, tessellated(cloud.particles, cloud.radius).mesh, cloud.radius),
                  1e-5);
    });
}

TEST(CompleteMesh, VolumeConvergesWithTheSquareOfTheAngle) {
    const auto relativeError = [](const Particles& particles, double exact, double angle) {
        const Mesh mesh = tessellated(particles, 1, Appearance::on_boundary, angle).mesh;
        return std::abs(measureMesh(mesh).volume / exact - 1);
    };
    const double ball = 4 * std::numbers::pi / 3;
    Particles drop, pair;
    drop.position = {{0, 0, 0}};
    pair.position = {{0, 0, 0}, {1, 0, 0}};
    const double half = 0.5, cap = std::numbers::pi * (1 - half) * (1 - half) * (2 + half) / 3;
    for (const auto& [particles, exact] : {std::pair(drop, ball), std::pair(pair, 2 * (ball - cap))}) {
        EXPECT_LE(relativeError(particles, exact, 0.25), 0.05);
        const double rough = relativeError(particles, exact, 0.25), fine = relativeError(particles, exact, 0.0625);
        EXPECT_NEAR(rough / fine, 16, 5);
    }
}

TEST(CompleteMesh, VolumeOfABlockIsThatOfTheUnion) {
    Random random(11);
    for (const int side : {4, 6, 8})
        for (const double jitter : {0.0, 0.25}) {
            Particles block;
            for (int i = 0; i < side * side * side; ++i)
                block.position.push_back(
                    Vec3f(Vec3(i % side, i / side % side, i / (side * side)) + random.cube() * jitter));
            const double rough = measureMesh(tessellated(block, 1.5).mesh).volume;
            const double fine = measureMesh(tessellated(block, 1.5, Appearance::on_boundary, 0.05).mesh).volume;
            EXPECT_NEAR(rough / fine, 1, 0.01) << side << " a side, jitter " << jitter;
        }
}

TEST(CompleteMesh, IncludesWhatThePaperOmits) {
    Particles particles;  // a drop, a pair, and a tendril
    particles.position = {{0, 0, 0}, {10, 0, 0}, {11, 0, 0}};
    for (int i = 0; i < 8; ++i) particles.position.emplace_back(20.0f, 1.8f * static_cast<float>(i), 0.0f);
    SkinParams params;
    params.radius = 1;
    const SkinnedFrame frame = skinFrame(particles, params);
    EXPECT_EQ(measureMesh(frame.mesh).components, 3u);
    EXPECT_EQ(measureMesh(frame.mesh).euler, 6);
    EXPECT_EQ(frame.spheres.size(), 0u);
}

}  // namespace betamesh
