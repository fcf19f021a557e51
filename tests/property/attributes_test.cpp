// Particle attributes on the vertices of the mesh.

#include "betamesh/skin.h"

#include "base/random.h"
#include "betamesh/error.h"
#include "skin/attributes.h"
#include "support/clouds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <utility>

namespace betamesh {

namespace {

SkinParams carrying(double radius, std::vector<std::string> names) {
    SkinParams params;
    params.radius = radius;
    params.attributes = std::move(names);
    return params;
}

// Balls of different radii with the attributes "value" and "row", and vertices with local radii.
struct CarryCase {
    Particles particles;
    std::vector<DualVec3> balls;
    std::vector<Vec3> vertices;
    LocalRadii radii{1};

    void addBall(const Vec3& position, double scale, float value) {
        if (particles.attributes.empty()) particles.attributes = {{"value", 1, {}, {}}, {"row", 1, {}, {}}};
        particles.attributes[0].real.push_back(value);
        particles.attributes[1].integer.push_back(static_cast<std::int32_t>(particles.position.size()));
        particles.position.emplace_back(position);
        balls.push_back({Vec3(particles.position.back()), Vec3(0)});
        radii.ball_scale.push_back(static_cast<float>(scale));
    }
    void addVertex(const Vec3& position, double scale) {
        vertices.push_back(position);
        radii.vertex_scale.push_back(static_cast<float>(scale));
    }
    // Vertices all over a ball, of its own scale.
    void addVerticesOn(std::size_t ball) {
        const auto scale = static_cast<double>(radii.ball_scale[ball]);
        for (const Vec3f& p : spiralOnSphere(50, 1).position)
            addVertex(balls[ball].position + Vec3(p) * scale * radii.largest, scale);
    }
    // A block of n³ balls whose spacing is two thirds of their radius.
    void addBlock(const Vec3& corner, int n, double scale, float value) {
        for (int z = 0; z < n; ++z)
            for (int y = 0; y < n; ++y)
                for (int x = 0; x < n; ++x)
                    addBall(corner + Vec3(x, y, z) * (scale * radii.largest / 1.5), scale, value);
    }
    std::vector<Attribute> carried() const {
        std::vector<std::uint32_t> rows(balls.size());
        std::iota(rows.begin(), rows.end(), 0U);
        return carriedAttributes(particles, rows, balls, radii, {"value", "row"}, vertices);
    }
};

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

TEST(Attributes, OfBallsOfDifferentRadiiAreTheirMeansWithinBothReaches) {
    for (std::uint64_t seed = 0; seed < 30; ++seed) {
        Random random(seed);
        CarryCase c;
        c.radii.largest = random.between(0.1, 3);
        const auto scale = [&] {
            return seed % 3 == 0 ? std::ldexp(1, -static_cast<int>(5 * random.unit())) : std::pow(20, -random.unit());
        };
        for (int i = 0; i < 300; ++i)
            c.addBall(random.cube() * (4 * c.radii.largest), scale(), static_cast<float>(random.unit()));
        for (int i = 0; i < 300; ++i) c.addVertex(random.cube() * (4 * c.radii.largest), scale());
        const std::vector<Attribute> carried = c.carried();
        std::size_t reached = 0;
        for (std::size_t v = 0; v < c.vertices.size(); ++v) {
            double sum = 0, weights = 0, largest = 0;
            std::int32_t nearest = 0;
            for (std::size_t b = 0; b < c.balls.size(); ++b) {
                const double reach = c.radii.largest * (static_cast<double>(c.radii.ball_scale[b]) +
                                                        static_cast<double>(c.radii.vertex_scale[v]));
                const double t = 1 - (c.vertices[v] - c.balls[b].position).length2() / (reach * reach);
                if (t <= 0) continue;
                sum += t * t * static_cast<double>(c.particles.attributes[0].real[b]);
                weights += t * t;
                if (t > largest) nearest = static_cast<std::int32_t>(b);
                largest = std::max(largest, t);
            }
            ASSERT_NEAR(static_cast<double>(carried[0].real[v]), weights > 0 ? sum / weights : 0, 1e-5);
            ASSERT_EQ(carried[1].integer[v], nearest);
            reached += weights > 0;
        }
        EXPECT_GT(reached, 50U);
    }
}

TEST(Attributes, OfASmallDropBesideCoarseLiquidAreItsOwn) {
    for (const double fine : {0.25, 0.1, 0.05}) {
        CarryCase c;
        c.addBlock(Vec3(0), 4, 1, 0);
        const Vec3 last = c.balls.back().position;
        const std::size_t first = c.balls.size();
        c.addBlock(last + Vec3(1.3, 0, 0), 2, fine, 1);
        for (std::size_t b = first; b < c.balls.size(); ++b) c.addVerticesOn(b);
        const std::vector<Attribute> carried = c.carried();
        for (const float value : carried[0].real) EXPECT_GT(value, 0.9f);
    }
}

TEST(Attributes, OfCoarseLiquidAreNotChangedByFineLiquidFarAway) {
    CarryCase c;
    Random random(1);
    for (int i = 0; i < 200; ++i) c.addBall(random.cube() * 2, 1, static_cast<float>(random.unit()));
    for (std::size_t b = 0; b < c.balls.size(); ++b) c.addVerticesOn(b);
    CarryCase of_one_radius = c;
    of_one_radius.radii = {1};
    const std::size_t vertices = c.vertices.size();
    c.addBlock(Vec3(6, 0, 0), 10, 0.05, 7);
    for (std::size_t b = 200; b < c.balls.size(); ++b) c.addVerticesOn(b);
    std::vector<Attribute> both = c.carried();
    for (std::size_t v = vertices; v < c.vertices.size(); ++v) ASSERT_EQ(both[0].real[v], 7);
    both[0].real.resize(vertices);
    EXPECT_EQ(both[0].real, of_one_radius.carried()[0].real);
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

TEST(Attributes, MissingNamesAreFoundBeforeAnyStage) {
    int stages = 0;
    const Watch watch = [&](Stage) { ++stages; };
    for (const auto& skin : {std::function([&](const Particles&p, const SkinParams&s) { skinFrame(p, s, watch); }),
                             std::function([&](const Particles&p, const SkinParams&s) { skinPlane(p, s, watch); })}) {
        Particles particles;
        particles.position = {{0, 0, 0}, {1, 0, 0}};
        particles.attributes = {{"temperature", 1, {1, 2}, {}}, {"Cd", 3, {1, 0, 0, 0, 1, 0}, {}}};
        skin(particles, carrying(1, {"Cd", "temperature"}));
        EXPECT_GT(std::exchange(stages, 0), 0);
        try {
            skin(particles, carrying(1, {"Cd", "temprature"}));
            ADD_FAILURE() << "an attribute that does not exist was carried";
        } catch (const Error& error) {
            const std::string text = error.what();
            EXPECT_NE(text.find("temperature, Cd. Did you mean 'temperature'?"), std::string::npos) << text;
        }
        EXPECT_EQ(stages, 0);
    }
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
