// Properties of surfaces of particles with sizes of their own, given by an attribute.

#include "skin/particle_sizes.h"
#include "base/random.h"
#include "betamesh/check.h"
#include "betamesh/error.h"
#include "betamesh/skin.h"
#include "mesh/enclosure.h"
#include "skin/pipeline.h"
#include "support/clouds.h"
#include "support/oracles.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>

namespace betamesh {

namespace {

void addSizes(const std::vector<float>& sizes, Particles& particles, const char* name = "size") {
    particles.attributes.push_back({name, 1, sizes, {}});
}

SkinParams paramsFor(double radius) {
    SkinParams params;
    params.radius = radius;
    params.spacing = radius / 1.5;
    params.radius_attribute = "size";
    return params;
}

void addSizes(const Cloud& cloud, RadiusPattern pattern, std::uint64_t seed, Particles& particles) {
    std::vector<float> sizes;
    for (const double radius : radiiFor(cloud, pattern, seed)) sizes.push_back(static_cast<float>(radius / 1.5));
    addSizes(sizes, particles);
}

double volumeOf(const Mesh& mesh) {
    double volume = 0;
    for (const ComponentCheck& component : checkMesh(mesh, CheckParams{}).components) volume += component.volume;
    return volume;
}

double farthestOutside(const Mesh& mesh, const Particles& particles) {
    const std::vector<Vec3> points(particles.position.begin(), particles.position.end());
    const std::vector<double> distances = distancesOutside(mesh, {}, points);
    return *std::max_element(distances.begin(), distances.end());
}

Mesh skinned(const Particles& particles, const SkinParams& params) { return skinFrame(particles, params).mesh; }

/// A block of liquid, 1 larger in x than the edge, that is finer in its last 2: one surface around both.
Particles adaptiveBlock(double fine, std::uint64_t seed, double edge = 6) {
    Particles particles;
    std::vector<float> sizes;
    Random random(seed);
    const auto add = [&](double dx, double low, double high) {
        const int n = static_cast<int>(std::lround(edge / dx)), begin = static_cast<int>(std::lround(low / dx)),
                  end = static_cast<int>(std::lround(high / dx));
        for (int i = begin; i < end; ++i)
            for (int j = 0; j < n; ++j)
                for (int k = 0; k < n; ++k) {
                    const Vec3 centre = Vec3(i + 0.5, j + 0.5, k + 0.5) + random.cube() * 0.1;
                    particles.position.emplace_back(centre * dx);
                    sizes.push_back(static_cast<float>(dx));
                }
    };
    add(1, 0, edge - 1);
    add(fine, edge - 1, edge + 1);
    addSizes(sizes, particles);
    return particles;
}

// The flux of the surface's velocities over the rate of its volume, of particles whose sizes grow at these rates.
double fluxOverRate(const Particles& particles, const std::vector<float>& sizes, const std::vector<float>& rates) {
    constexpr float kStep = 1e-3F;
    SkinParams params = paramsFor(1.5);
    const auto volumeAfter = [&](float time) {
        std::vector<float> grown = sizes;
        for (std::size_t i = 0; i < grown.size(); ++i) grown[i] += rates[i] * time;
        Particles after = particles;
        addSizes(grown, after);
        return volumeOf(skinned(after, params));
    };
    Particles now = particles;
    now.velocity.assign(now.size(), Vec3f(0));
    addSizes(sizes, now);
    addSizes(rates, now, "growth");
    SkinParams moving = params;
    moving.radius_rate_attribute = "growth";
    const Mesh mesh = skinned(now, moving);
    double flux = 0;
    for (const Triangle& t : mesh.triangles) {
        const Vec3 &a = mesh.position[t[0]], &b = mesh.position[t[1]], &c = mesh.position[t[2]];
        flux += dot(cross(b - a, c - a) / 2, (mesh.velocity[t[0]] + mesh.velocity[t[1]] + mesh.velocity[t[2]]) / 3);
    }
    return flux * 2 * static_cast<double>(kStep) / (volumeAfter(kStep) - volumeAfter(-kStep));
}

}  // namespace

TEST(ParticleSizes, ThatAreEqualGiveTheBytesOfThatRadius) {
    forEveryCloud(5, [](const Cloud& cloud) {
        if (cloud.particles.size() == 0 || cloud.particles.size() > 400) return;
        SkinParams params;
        params.radius = cloud.radius;
        params.spacing = static_cast<double>(static_cast<float>(cloud.radius / 1.5));
        const Mesh plain = skinned(cloud.particles, params);
        params.radius_attribute = "size";
        Particles with_sizes = cloud.particles;
        addSizes(std::vector<float>(with_sizes.size(), static_cast<float>(params.spacing)), with_sizes);
        const Mesh each = skinned(with_sizes, params);
        EXPECT_EQ(plain.position, each.position);
        EXPECT_EQ(plain.triangles, each.triangles);
        EXPECT_EQ(plain.velocity, each.velocity);
    });
}

TEST(ParticleSizes, OfEveryCloudGiveClosedMeshesAroundAllParticles) {
    std::uint64_t seed = 0;
    std::size_t meshes = 0, crossing = 0;
    forEveryCloud(15, [&](const Cloud& cloud) {
        if (cloud.particles.size() == 0 || cloud.particles.size() > 100) return;
        if (cloud.name.ends_with("far from the origin")) return;  // floats round by much of the smallest balls' skin
        for (const RadiusPattern pattern : kRadiusPatterns) {
            SCOPED_TRACE(testing::Message() << "radii " << static_cast<int>(pattern));
            Particles particles = cloud.particles;
            addSizes(cloud, pattern, ++seed, particles);
            SkinParams params = paramsFor(cloud.radius);
            if (seed % 3 == 0) params.skin = 0.1 * params.spacing * static_cast<double>(1 + seed % 7);
            if (seed % 2 == 0) params.passes = static_cast<int>(seed % 5);
            const Mesh mesh = skinned(particles, params);
            const MeshCheck found = checkMesh(mesh, CheckParams{});
            EXPECT_EQ(found.open_edges.count + found.misoriented_edges.count + found.nonmanifold_edges.count +
                          found.nonmanifold_vertices.count,
                      0U);
            crossing += found.crossings.count > 0;
            EXPECT_EQ(farthestOutside(mesh, particles), 0);
            ++meshes;
            const Mesh other = skinned(shuffled(particles, seed), params);
            EXPECT_EQ(mesh.position, other.position);
            EXPECT_EQ(mesh.triangles, other.triangles);
        }
    });
    EXPECT_GT(meshes, 60U);
    EXPECT_LE(crossing, meshes / 100);  // where balls touch in exactly one point
}

// Nothing tells the volume of a drop but its own size, also if no two particles meet.
TEST(ParticleSizes, OfParticlesFarFromAllOthersAreTheEdgesOfCubesAsLargeAsTheirDrops) {
    for (const double size : {0.7, 0.5, 0.2, 0.05})
        for (const bool others_meet : {false, true}) {
            SCOPED_TRACE(testing::Message() << "size " << size << (others_meet ? ", others meet" : ""));
            Particles particles;
            particles.position = {Vec3f(0, 0, 0), Vec3f(0, 9, 0), Vec3f(9, 0, 0)};
            std::vector<float> sizes = {static_cast<float>(size), 1, 1};
            if (others_meet) particles.position.emplace_back(9, 1, 0), sizes.push_back(1);
            addSizes(sizes, particles);
            std::vector<double> volumes;
            for (const ComponentCheck& component :
                 checkMesh(skinned(particles, paramsFor(1.5)), CheckParams{}).components)
                volumes.push_back(component.volume);
            ASSERT_EQ(volumes.size(), 3U);
            EXPECT_NEAR(*std::min_element(volumes.begin(), volumes.end()) / (size * size * size), 1, 0.05);
            EXPECT_NEAR(volumeOf(skinned(particles, paramsFor(1.5))), size * size * size + (others_meet ? 3 : 2), 0.25);
        }
}

TEST(ParticleSizes, DoNotDependOnTheNumberOfThreads) {
    const Particles particles = adaptiveBlock(0.25, 3);
    const SkinParams params = paramsFor(1.5);
    const Mesh many = skinned(particles, params);
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    const Mesh single = skinned(particles, params);
    EXPECT_EQ(many.position, single.position);
    EXPECT_EQ(many.triangles, single.triangles);
}

TEST(ParticleSizes, NearTheSurfaceAreAllThatCounts) {
    const Particles particles = adaptiveBlock(0.5, 5, 40);
    const SkinParams params = paramsFor(1.5);
    NearSurfaceFinder finder(params);
    finder.add(particles.position, particleSizes(particles, params).radius);
    const NearSurface near = finder.find();
    EXPECT_GT(near.omitted(), 100U);
    Particles some;
    some.attributes.push_back({"size", 1, {}, {}});
    for (const std::uint32_t row : near.row) {
        some.position.push_back(particles.position[row]);
        some.attributes[0].real.push_back(particles.attributes[0].real[row]);
    }
    const Mesh all = skinned(particles, params), kept = skinFrame(some, near, params).mesh;
    EXPECT_EQ(all.position, kept.position);
    EXPECT_EQ(all.triangles, kept.triangles);
}

TEST(ParticleSizes, OfAnAdaptiveBlockKeepEveryParticleInside) {
    for (const double fine : {0.5, 0.25, 0.125}) {
        SCOPED_TRACE("fine particles of size " + std::to_string(fine));
        const Particles particles = adaptiveBlock(fine, 11);
        const Mesh mesh = skinned(particles, paramsFor(1.5));
        const MeshCheck found = checkMesh(mesh, CheckParams{});
        EXPECT_EQ(found.crossings.count, 0U);
        EXPECT_EQ(found.components.size(), 1U);
        EXPECT_EQ(farthestOutside(mesh, particles), 0);
        EXPECT_NEAR(volumeOf(mesh), 6.0 * 6 * 7, 0.03 * 6 * 6 * 7);
    }
}

TEST(ParticleSizes, ThatGrowMoveTheSurfaceOfDropsAtTheRateOfTheirVolume) {
    for (const double size : {0.3, 0.7, 1.0}) {
        Particles drop;
        drop.position = {Vec3f(1, 2, 3)};
        EXPECT_NEAR(fluxOverRate(drop, {static_cast<float>(size)}, {0.5F}), 1, 0.1) << size;
    }
    Particles drops;
    std::vector<float> sizes, rates;
    for (int i = 0; i < 20; ++i) {
        Random random(9, static_cast<std::uint64_t>(i));
        drops.position.emplace_back(Vec3(i % 5, i / 5, 0) * 10);
        sizes.push_back(static_cast<float>(random.between(0.4, 1)));
        rates.push_back(static_cast<float>(random.between(0.2, 1)));
    }
    EXPECT_NEAR(fluxOverRate(drops, sizes, rates), 1, 0.03);
}

TEST(ParticleSizes, ThatGrowMoveTheSurfaceOfABlockRoughlyAtTheRateOfItsVolume) {
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
        Random random(seed);
        Particles block;
        std::vector<float> sizes, rates;
        for (int i = 0; i < 512; ++i) {
            block.position.emplace_back(Vec3(i % 8, i / 8 % 8, i / 64) + random.cube() * 0.2);
            sizes.push_back(static_cast<float>(random.between(0.9, 1.1)));
            rates.push_back(sizes.back() * 0.4F);
        }
        EXPECT_NEAR(fluxOverRate(block, sizes, rates), 1.2, 0.1) << seed;
    }
}

TEST(ParticleSizes, AreRefusedWhereTheyAreNone) {
    Particles particles;
    particles.position = {Vec3f(0, 0, 0), Vec3f(1, 0, 0)};
    SkinParams params = paramsFor(1.5);
    const auto message = [&] {
        try {
            skinFrame(particles, params);
        } catch (const Error& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    EXPECT_NE(message().find("no attribute 'size'"), std::string::npos);
    for (const float bad : {0.0F, -1.0F, std::nanf(""), std::numeric_limits<float>::infinity()}) {
        particles.attributes.clear();
        addSizes({1, bad}, particles);
        EXPECT_NE(message().find("particle 1 has size = "), std::string::npos) << message();
    }
    particles.attributes.clear();
    addSizes({1, 1e-4F}, particles);
    EXPECT_NE(message().find("particle 1 has a ball of radius"), std::string::npos) << message();
    particles.attributes = {{"size", 3, std::vector<float>(6, 1), {}}};
    EXPECT_NE(message().find("3 numbers per particle"), std::string::npos) << message();
    particles.attributes.clear();
    addSizes({1, 0.5F}, particles);
    params.tessellation = Tessellation::paper;
    EXPECT_NE(message().find("complete tessellation"), std::string::npos) << message();
    params = paramsFor(1.5);
    params.radius_scale = 0;
    EXPECT_NE(message().find("above 0"), std::string::npos) << message();
}

}  // namespace betamesh
