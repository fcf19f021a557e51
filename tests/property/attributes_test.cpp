// Particle attributes on the vertices of the mesh.

#include "betamesh/skin.h"

#include "betamesh/error.h"
#include "support/clouds.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace betamesh {

namespace {

SkinParams carrying(double radius, std::vector<std::string> names) {
    SkinParams params;
    params.radius = radius;
    params.attributes = std::move(names);
    return params;
}

}  // namespace

TEST(Attributes, AreMeansOfTheParticles) {
    forEveryCloud(200, [](const Cloud& cloud) {
        Particles particles = cloud.particles;
        const std::size_t n = particles.size();
        particles.attributes = {
            {"constant", 2, std::vector<float>(2 * n, 3.5f), {}}, {"x", 1, {}, {}}, {"row", 1, {}, {}}};
        for (std::size_t i = 0; i < n; ++i) {
            particles.attributes[1].real.push_back(particles.position[i].x);
            particles.attributes[2].integer.push_back(static_cast<std::int32_t>(i));
        }
        for (const Tessellation tessellation : {Tessellation::complete, Tessellation::paper}) {
            SkinParams params = carrying(cloud.radius, {"row", "constant", "x"});
            params.tessellation = tessellation;
            const Mesh mesh = skinFrame(particles, params).mesh;
            ASSERT_EQ(mesh.attributes.size(), 3u);
            EXPECT_EQ(mesh.attributes[0].name, "row");
            ASSERT_EQ(mesh.attributes[0].integer.size(), mesh.position.size());
            ASSERT_EQ(mesh.attributes[1].real.size(), 2 * mesh.position.size());
            for (const float value : mesh.attributes[1].real) EXPECT_NEAR(value, 3.5f, 1e-5f);
            for (std::size_t v = 0; v < mesh.position.size(); ++v) {
                const auto x = static_cast<double>(mesh.attributes[2].real[v]);
                EXPECT_LE(std::abs(x - mesh.position[v].x), 2 * cloud.radius * (1 + 1e-5));
                const auto row = static_cast<std::size_t>(mesh.attributes[0].integer[v]);
                EXPECT_LE((Vec3(particles.position[row]) - mesh.position[v]).length(), 2 * cloud.radius);
            }
        }
    });
}

TEST(Attributes, DoNotDependOnParticleOrder) {
    for (std::uint64_t seed = 0; seed < 50; ++seed) {
        Cloud cloud = randomCloud(seed);
        Attribute heat{"heat", 1, {}, {}};
        for (const Vec3f& p : cloud.particles.position) heat.real.push_back(p.x + 2 * p.y);
        cloud.particles.attributes = {heat};
        const SkinParams params = carrying(cloud.radius, {"heat"});
        EXPECT_EQ(skinFrame(cloud.particles, params).mesh.attributes[0].real,
                  skinFrame(shuffled(cloud.particles, 5), params).mesh.attributes[0].real);
    }
}

TEST(Attributes, MissingNamesAreAnError) {
    Particles particles;
    particles.position = {{0, 0, 0}};
    particles.attributes = {{"Cd", 3, {1, 0, 0}, {}}};
    try {
        skinFrame(particles, carrying(1, {"colour"}));
        FAIL() << "an attribute that does not exist was carried";
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("'colour'"), std::string::npos);
        EXPECT_NE(std::string(error.what()).find("Cd"), std::string::npos);
    }
    EXPECT_TRUE(skinFrame(Particles{}, carrying(1, {"colour"})).mesh.attributes.empty());
}

TEST(Attributes, AccelerationsAreCarriedWithoutBeingRequested) {
    Particles particles;
    particles.position = {{0, 0, 0}};
    particles.attributes = {{"accel", 3, {0, -9.81f, 0}, {}}};
    const Mesh mesh = skinFrame(particles, carrying(1, {})).mesh;
    ASSERT_EQ(mesh.attributes.size(), 1u);
    EXPECT_EQ(mesh.attributes[0].name, "accel");
    EXPECT_FLOAT_EQ(mesh.attributes[0].real[1], -9.81f);
}

}  // namespace betamesh
