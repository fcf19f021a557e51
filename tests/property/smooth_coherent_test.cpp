// Properties of coherent smoothing of the surface on the balls.

#include "betamesh/skin.h"

#include "betamesh/check.h"
#include "skin/arcs.h"
#include "skin/ball_boundary.h"
#include "skin/boundary_samples.h"
#include "skin/coverage.h"
#include "skin/face_points.h"
#include "skin/faces.h"
#include "skin/smooth_coherent.h"
#include "skin/tessellate.h"
#include "skin/velocity.h"
#include "support/clouds.h"
#include "support/oracles.h"
#include "support/slab_top.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

namespace betamesh {

namespace {

SkinParams withRadius(double radius, SmoothingMethod smoothing = SmoothingMethod::coherent) {
    SkinParams params;
    params.radius = radius;
    params.smoothing = smoothing;
    params.skin = 0;
    return params;
}

// Spacing 1, every coordinate jittered by up to a quarter of it, then raised by a wave along x of amplitude 1.
Particles slab(unsigned seed, double wavelength) {
    constexpr int kSide = 56, kLayers = 6;
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> jitter(-0.25f, 0.25f);
    Particles particles;
    for (int z = 0; z < kLayers; ++z)
        for (int y = 0; y < kSide; ++y)
            for (int x = 0; x < kSide; ++x) {
                Vec3f p(static_cast<float>(x) + jitter(random), static_cast<float>(y) + jitter(random),
                        static_cast<float>(z) + jitter(random));
                if (wavelength > 0) p.z += static_cast<float>(std::sin(2 * std::numbers::pi * p.x / wavelength));
                particles.position.push_back(p);
            }
    return particles;
}

// Area-weighted RMS angle to the plane, degrees. Triangles steeper than 60 degrees are ignored: they belong to gaps.
double roughness(const Mesh& mesh) {
    double sum = 0, area = 0;
    forTopOf(mesh, 9, 46, [&](const Vec3&, const Vec3& normal) {
        const double size = normal.length(), angle = std::acos(std::min(1.0, normal.z / size));
        if (angle > std::numbers::pi / 3) return;
        sum += angle * angle * size;
        area += size;
    });
    return std::sqrt(sum / area) * 180 / std::numbers::pi;
}

Particles box(int nx, int ny, int nz, unsigned seed, double jitter_size = 0.25) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> jitter(static_cast<float>(-jitter_size), static_cast<float>(jitter_size));
    Particles particles;
    for (int z = 0; z < nz; ++z)
        for (int y = 0; y < ny; ++y)
            for (int x = 0; x < nx; ++x)
                particles.position.emplace_back(static_cast<float>(x) + jitter(random),
                                                static_cast<float>(y) + jitter(random),
                                                static_cast<float>(z) + jitter(random));
    return particles;
}

// Signed distance along a line from a point to the nearest triangle; infinite if none is within reach.
double wayAlong(const Mesh& mesh, const Vec3& point, const Vec3& direction, double reach) {
    double best = std::numeric_limits<double>::infinity();
    for (const Triangle& t : mesh.triangles) {
        const Vec3 a = mesh.position[t[0]] - point, b = mesh.position[t[1]] - point, c = mesh.position[t[2]] - point;
        const double u = dot(direction, cross(b, c)), v = dot(direction, cross(c, a)), w = dot(direction, cross(a, b));
        if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) continue;
        const double sum = u + v + w;
        if (sum == 0) continue;
        const double way = dot(a * u + b * v + c * w, direction) / sum;
        if (std::abs(way) < std::min(reach, std::abs(best))) best = way;
    }
    return best;
}

std::vector<Vec3> normalsOf(const Mesh& mesh) {
    std::vector<Vec3> normals(mesh.position.size(), Vec3(0, 0, 0));
    for (const Triangle& t : mesh.triangles) {
        const Vec3 &a = mesh.position[t[0]], &b = mesh.position[t[1]], &c = mesh.position[t[2]];
        for (const std::uint32_t v : t) normals[v] += cross(b - a, c - a);
    }
    return normals;
}

}  // namespace

TEST(CoherentSmoothing, IsFlatAndKeepsWaves) {
    for (const unsigned seed : {1u, 2u}) {
        EXPECT_LE(roughness(skinFrame(slab(seed, 0), withRadius(1.5)).mesh), 2.05);
        EXPECT_GE(waveKept(skinFrame(slab(seed, 8), withRadius(1.5)).mesh, 8, 8, 48), 0.83);
        EXPECT_GE(waveKept(skinFrame(slab(seed, 16), withRadius(1.5)).mesh, 16, 11.5, 43.5), 0.955);
    }
}

// The directions of samples are fixed, so results could depend on the axis.
TEST(CoherentSmoothing, SheetsAreAsFlatAlongEveryAxis) {
    const Particles sheet = box(56, 56, 1, 1);
    for (const Vec3& towards : {Vec3(0, 0, 1), Vec3(1, 1, 1), Vec3(1, 1, 0), Vec3(1, 2, 3)}) {
        const Vec3 n = towards.normalized(), u = cross(n, Vec3(0.8, -0.6, 0)).normalized(), v = cross(n, u);
        Particles turned;
        for (const Vec3f& p : sheet.position) turned.position.emplace_back(u * p.x + v * p.y + n * p.z);
        Mesh mesh = skinFrame(turned, withRadius(1.5)).mesh;
        for (Vec3& p : mesh.position) p = {dot(p, u), dot(p, v), dot(p, n) + 5};
        const double angle = roughness(mesh);
        EXPECT_LE(angle, 2.75) << towards;
        EXPECT_GE(angle, 2.3) << towards;
    }
}

TEST(CoherentSmoothing, KeepsTheVolumeOfDropsAndBlocks) {
    Particles drop, tetrahedron;
    drop.position = {{0, 0, 0}};
    tetrahedron.position = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const auto ratio = [](const Particles& particles) {
        SkinParams fine = withRadius(1.5, SmoothingMethod::none);
        fine.arc_subdivisions = 12;
        return measureMesh(skinFrame(particles, withRadius(1.5)).mesh).volume /
               measureMesh(skinFrame(particles, fine).mesh).volume;
    };
    EXPECT_NEAR(ratio(drop), 1, 0.005);
    EXPECT_NEAR(ratio(tetrahedron), 1, 0.03);
    EXPECT_NEAR(ratio(box(6, 6, 4, 1)), 1, 0.05);
    EXPECT_NEAR(ratio(box(16, 16, 1, 1)), 1, 0.05);
    EXPECT_NEAR(ratio(box(24, 1, 1, 1)), 1, 0.1);
}

TEST(CoherentSmoothing, LeavesEveryParticleInside) {
    forEveryCloud(200, [](const Cloud& cloud) {
        if (cloud.particles.size() > 500) return;
        for (const int passes : {1, 3}) {
            SkinParams params = withRadius(cloud.radius);
            params.passes = passes;
            const Mesh mesh = skinFrame(cloud.particles, params).mesh;
            for (const Vec3f& p : cloud.particles.position) EXPECT_GT(windingNumber(mesh, Vec3(p)), 0.5);
        }
    });
}

TEST(CoherentSmoothing, LeavesAMeshClosedAndFinite) {
    forEveryCloud(300, [](const Cloud& cloud) {
        const Mesh mesh = skinFrame(cloud.particles, withRadius(cloud.radius)).mesh;
        const MeshMeasure measure = measureMesh(mesh);
        EXPECT_EQ(measure.unpaired_edges, 0u);
        for (const Vec3& p : mesh.position) ASSERT_TRUE(std::isfinite(p.x + p.y + p.z));
        for (const Vec3& v : mesh.velocity) ASSERT_TRUE(std::isfinite(v.x + v.y + v.z));
    });
}

TEST(CoherentSmoothing, MorePassesAndAWiderKernelAreSmoother) {
    const Particles particles = slab(3, 0);
    const double once = roughness(skinFrame(particles, withRadius(1.5)).mesh);
    SkinParams params = withRadius(1.5);
    params.passes = 2;
    EXPECT_LE(roughness(skinFrame(particles, params).mesh), 0.8 * once);
    params.passes = 1;
    params.smoothing_width = 5.25;
    EXPECT_LE(roughness(skinFrame(particles, params).mesh), 0.8 * once);
}

TEST(CoherentSmoothing, MakesNoCrossings) {
    const auto expectNoCrossings = [](const Cloud& cloud, int subdivisions) {
        SkinParams params = withRadius(cloud.radius);
        params.arc_subdivisions = subdivisions;
        CheckParams check;
        check.tolerance = 1e-6 * cloud.radius;
        const MeshCheck found = checkMesh(skinFrame(cloud.particles, params).mesh, check);
        EXPECT_EQ(found.crossings.count, 0u)
            << "subdivisions " << subdivisions << ", depth " << found.deepest / cloud.radius;
    };
    forEveryCloud(400, [&](const Cloud& cloud) { expectNoCrossings(cloud, 0); });
    forEveryCloud(500, [&](const Cloud& cloud) { expectNoCrossings(cloud, 1); });
}

TEST(CoherentSmoothing, VelocitiesAreTheRatesAtWhichVerticesMove) {
    int compared = 0;
    std::vector<double> errors, of_rising;
    for (unsigned seed = 0; seed < 120; ++seed) {
        Particles particles = seed < 40 ? box(4, 4, 4, seed) : box(2, 1, 2, seed);
        std::mt19937 random(seed + 100);
        std::normal_distribution<float> speed(0, 1);
        for (std::size_t i = 0; i < particles.size(); ++i)
            particles.velocity.emplace_back(speed(random), speed(random), speed(random));
        constexpr double kStep = 2e-4;
        // Angular velocities are ignored: vertices are matched by number, in fixed directions.
        const auto moved = [&](double time) {
            Particles later = particles;
            for (std::size_t i = 0; i < particles.size(); ++i)
                later.position[i] += particles.velocity[i] * static_cast<float>(time);
            const SnappedParticles snapped = snapParticles(later, 1.5);
            const Icosphere directions = icosphereOf(0.37);
            BallBoundary boundary = ballBoundary(snapped, exposureCandidates(snapped), directions.position);
            groupFaces(snapped, boundary);
            const std::vector<DualVec3> balls = ballCentres(boundary, later);
            const ArcSubdivision subdivision{0.235, 0, Appearance::gradual};
            const ArcNetwork network =
                arcPoints(boundary, balls, boundaryVertices(later, snapped, boundary, balls), subdivision);
            const FacePoints points = facePoints(snapped, boundary, balls, directions);
            BetaMesh mesh = completeTessellation(boundary, balls, network, points, subdivision);
            CoherentSmoother(boundarySamples(boundary, balls, network, points), {1.5, 4.2, 1}).smooth(mesh);
            return std::pair(std::pair(boundary.triangle, network.arc_begin), mesh);
        };
        const auto [names, now] = moved(0);
        const auto [names_before, before] = moved(-kStep);
        const auto [names_after, after] = moved(kStep);
        if (names != names_before || names != names_after) continue;
        ++compared;
        const auto errorOf = [&](std::size_t v) {
            const Vec3 difference = (after.vertex[v].position - before.vertex[v].position) / (2 * kStep);
            return (now.vertex[v].velocity - difference).length();
        };
        const bool same_faces = now.triangles == before.triangles && now.triangles == after.triangles;
        const std::size_t followed = same_faces ? now.vertex.size() : names.second.back();  // others come and go
        for (std::size_t v = 0; v < followed; ++v) errors.push_back(errorOf(v));
        for (const auto& group : now.fading)
            for (const FadingVertex& fading : group)
                if (fading.vertex >= names.second.back() && fading.vertex < followed)
                    of_rising.push_back(errorOf(fading.vertex));
    }
    EXPECT_GE(compared, 3);
    EXPECT_GE(of_rising.size(), 20u);
    std::sort(of_rising.begin(), of_rising.end());
    EXPECT_LE(of_rising[of_rising.size() * 9 / 10], 0.05);
    std::sort(errors.begin(), errors.end());  // particles move at about 1.7; the worst vertices are damped on purpose
    EXPECT_LE(errors[errors.size() / 2], 0.01);
    EXPECT_LE(errors[errors.size() * 95 / 100], 0.05);
}

TEST(SurfaceVelocity, MovesEveryVertexWithTheSurface) {
    double error = 0, size = 0;
    for (unsigned seed = 0; seed < 4; ++seed) {
        Particles particles = box(5, 5, 4, seed);
        for (const Vec3f& p : particles.position)  // swells that run through the liquid
            particles.velocity.emplace_back(std::sin(0.7f * p.y), std::sin(0.8f * p.z), std::sin(0.9f * p.x));
        SkinParams params = withRadius(1.5);
        constexpr double kStep = 1e-3;
        const auto moved = [&](double time) {
            Particles later = particles;
            for (std::size_t i = 0; i < particles.size(); ++i)
                later.position[i] += particles.velocity[i] * static_cast<float>(time);
            return skinFrame(later, params).mesh;
        };
        const Mesh now = moved(0), before = moved(-kStep), after = moved(kStep);
        const std::vector<Vec3> normals = normalsOf(now);
        for (std::size_t v = 0; v < now.position.size(); v += 3) {
            const double weight = normals[v].length();
            if (!(weight > 0)) continue;
            const Vec3 normal = normals[v] / weight;
            const Vec3 way = Vec3(now.velocity[v]) * kStep;
            const double ahead = wayAlong(after, now.position[v] + way, normal, 20 * kStep),
                         behind = wayAlong(before, now.position[v] - way, normal, 20 * kStep);
            if (!std::isfinite(ahead) || !std::isfinite(behind)) continue;  // another surface, or none
            if (std::abs(ahead + behind) > 0.1 * kStep) continue;           // an event
            const double off = (ahead - behind) / (2 * kStep), speed = dot(normal, now.velocity[v]);
            error += weight * off * off;
            size += weight * speed * speed;
        }
    }
    // Where the surface moves relative to the balls faster than they do relative to each other, its velocity is
    // limited.
    EXPECT_LE(std::sqrt(error / size), 0.06);
}

TEST(SurfaceVelocity, OfAnIsolatedDropIsThatOfItsParticle) {
    Particles drop;
    drop.position = {{1, 2, 3}};
    drop.velocity.emplace_back(4.0F, -5.0F, 6.0F);
    for (const Vec3& v : skinFrame(drop, withRadius(0.5)).mesh.velocity) EXPECT_LE((v - Vec3(4, -5, 6)).length(), 1e-6);
}

TEST(SurfaceVelocity, OfARigidBodyIsThatOfTheBody) {
    const Vec3 turn(0.3, -0.7, 0.5), drift(1, 2, -0.5);
    for (Particles particles : {box(6, 6, 6, 1), box(9, 9, 1, 2), box(3, 2, 2, 3), box(20, 2, 1, 4)}) {
        for (const Vec3f& p : particles.position) particles.velocity.emplace_back(drift + cross(turn, Vec3(p)));
        const Mesh mesh = skinFrame(particles, withRadius(1.5)).mesh;
        double worst = 0, fastest = 0;
        for (std::size_t v = 0; v < mesh.position.size(); ++v) {
            const Vec3 expected = drift + cross(turn, mesh.position[v]);
            worst = std::max(worst, (mesh.velocity[v] - expected).length());
            fastest = std::max(fastest, expected.length());
        }
        EXPECT_LE(worst, 1e-4 * fastest);
    }
}

}  // namespace betamesh
