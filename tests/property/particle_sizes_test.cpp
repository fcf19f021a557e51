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

/// Sizes of a cloud with this spacing: two of them, a continuous range up to a ratio of 20, or a wave.
std::vector<float> sizesFor(const Cloud& cloud, std::uint64_t kind, std::uint64_t seed) {
    Random random(seed);
    std::vector<float> sizes;
    for (const Vec3f& p : cloud.particles.position) {
        const double u = random.unit();
        const double factor = kind == 0   ? (u < 0.5 ? 1 : 0.25)
                              : kind == 1 ? std::pow(20, -u)
                              : kind == 2 ? 0.625 + 0.375 * std::sin(p.x / cloud.radius)
                                          : 1;
        sizes.push_back(static_cast<float>(factor * cloud.radius / 1.5));
    }
    return sizes;
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

Particles shuffled(const Particles& particles) {
    Random random(7);
    std::vector<std::size_t> order(particles.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
    Particles other;
    other.attributes.push_back({"size", 1, {}, {}});
    for (const std::size_t i : order) {
        other.position.push_back(particles.position[i]);
        if (!particles.velocity.empty()) other.velocity.push_back(particles.velocity[i]);
        other.attributes[0].real.push_back(particles.attributes[0].real[i]);
    }
    return other;
}

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
    std::size_t meshes = 0, crossing = 0, outside = 0;
    forEveryCloud(15, [&](const Cloud& cloud) {
        if (cloud.particles.size() == 0 || cloud.particles.size() > 100) return;
        if (cloud.name.ends_with("far from the origin")) return;  // floats round by much of the smallest balls' skin
        for (std::uint64_t kind = 0; kind < 4; ++kind) {
            SCOPED_TRACE("sizes " + std::to_string(kind));
            Particles particles = cloud.particles;
            addSizes(sizesFor(cloud, kind, ++seed), particles);
            const SkinParams params = paramsFor(cloud.radius);
            const Mesh mesh = skinned(particles, params);
            const MeshCheck found = checkMesh(mesh, CheckParams{});
            EXPECT_EQ(found.open_edges.count + found.misoriented_edges.count + found.nonmanifold_edges.count +
                          found.nonmanifold_vertices.count,
                      0U);
            crossing += found.crossings.count > 0;
            const double far = farthestOutside(mesh, particles);
            outside += far > 0;
            EXPECT_LE(far, 0.03 * cloud.radius);
            ++meshes;
            const Mesh other = skinned(shuffled(particles), params);
            EXPECT_EQ(mesh.position, other.position);
            EXPECT_EQ(mesh.triangles, other.triangles);
        }
    });
    EXPECT_GT(meshes, 60U);
    EXPECT_LE(crossing, meshes / 100);  // where balls touch in exactly one point
    EXPECT_LE(outside, meshes / 50);    // at sheets of large and small particles in turn
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

// The surface takes up the growth: the flux of its velocities is the rate of the volume.
TEST(ParticleSizes, ThatGrowMoveTheSurfaceAtTheRateOfItsVolume) {
    constexpr double kStep = 1e-3;
    const auto at = [](double time, bool with_rate) {
        Random random(5);
        Particles particles;
        std::vector<float> sizes, rates;
        for (int i = 0; i < 40; ++i) {
            particles.position.emplace_back(random.cube() * 2);
            particles.velocity.emplace_back(0, 0, 0);
            const double size = random.between(0.4, 1), rate = random.between(0.2, 1);
            sizes.push_back(static_cast<float>(size + rate * time));
            rates.push_back(static_cast<float>(rate));
        }
        addSizes(sizes, particles);
        if (with_rate) addSizes(rates, particles, "growth");
        return particles;
    };
    SkinParams params = paramsFor(1.5);
    const double rate =
        (volumeOf(skinned(at(kStep, false), params)) - volumeOf(skinned(at(-kStep, false), params))) / (2 * kStep);
    params.radius_rate_attribute = "growth";
    const Mesh mesh = skinned(at(0, true), params);
    double flux = 0;
    for (const Triangle& t : mesh.triangles) {
        const Vec3 &a = mesh.position[t[0]], &b = mesh.position[t[1]], &c = mesh.position[t[2]];
        flux += dot(cross(b - a, c - a) / 2, (mesh.velocity[t[0]] + mesh.velocity[t[1]] + mesh.velocity[t[2]]) / 3);
    }
    EXPECT_GT(rate, 1);
    EXPECT_NEAR(flux / rate, 1, 0.15);
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
