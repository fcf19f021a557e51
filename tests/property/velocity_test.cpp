// Velocities suit motion blur: no vertex is much faster than the liquid.

#include "base/random.h"
#include "base/rigid_motion.h"
#include "betamesh/skin.h"
#include "betamesh/skin_params.h"
#include "support/clouds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace betamesh {

namespace {

std::vector<std::uint32_t> within(double reach, const Vec3& point, const Particles& particles) {
    std::vector<std::uint32_t> near;
    for (std::uint32_t i = 0; i < particles.size(); ++i)
        if ((Vec3(particles.position[i]) - point).length() < reach) near.push_back(i);
    return near;
}

Particles splash(std::uint64_t seed) {  // drops, threads and a body of liquid, each particle with a velocity of its own
    Random random(seed);
    Particles particles;
    const auto add = [&](const Vec3& p) {
        particles.position.emplace_back(p + random.cube() * 0.25);
        particles.velocity.emplace_back(random.cube());
    };
    for (int x = 0; x < 7; ++x)
        for (int y = 0; y < 7; ++y)
            for (int z = 0; z < 4; ++z) add(Vec3(x, y, z));
    for (int i = 0; i < 12; ++i) add(Vec3(3, 3, 4 + i));
    for (int i = 0; i < 40; ++i) add(Vec3(3, 3, 9) + random.cube() * 6);
    return particles;
}

}  // namespace

TEST(Velocity, NoVertexIsMuchFasterThanTheRelativeMotionOfParticlesNearby) {
    forEveryCloud(60, [](const Cloud& cloud) {
        if (cloud.particles.size() > 400) return;
        SkinParams params;
        params.radius = cloud.radius;
        const double reach = std::max(3.5 * particleSpacing(params), 2 * cloud.radius);
        for (const bool has_skin : {true, false}) {
            if (!has_skin) params.passes = 0;
            const Mesh mesh = skinFrame(cloud.particles, params).mesh;
            for (std::size_t v = 0; v < mesh.position.size(); v += 5) {
                const std::vector<std::uint32_t> near = within(reach * 1.001, mesh.position[v], cloud.particles);
                ASSERT_FALSE(near.empty());
                double apart = 0, from_one = 1e30;
                for (const std::uint32_t i : near) {
                    const Vec3 velocity(cloud.particles.velocity[i]);
                    from_one = std::min(from_one, (mesh.velocity[v] - velocity).length());
                    for (const std::uint32_t j : near)
                        apart = std::max(apart, (velocity - Vec3(cloud.particles.velocity[j])).length());
                }
                ASSERT_LE(from_one, 9 * apart + 1e-5 * cloud.radius) << "vertex " << v;
            }
        }
    });
}

TEST(Velocity, DeviatesFromRigidMotionNoMoreThanParticlesDo) {
    for (std::uint64_t seed = 0; seed < 6; ++seed) {
        const Particles particles = splash(seed);
        SkinParams params;
        params.radius = 1.5;
        const Mesh mesh = skinFrame(particles, params).mesh;
        double worst = 0;
        for (std::size_t v = 0; v < mesh.position.size(); ++v) {
            const std::vector<std::uint32_t> near = within(3, mesh.position[v], particles);
            if (near.size() < 6) continue;  // hardly more than what any rigid motion explains
            RigidMotionFit fit;
            for (const std::uint32_t i : near) fit.add(Vec3(particles.position[i]), Vec3(particles.velocity[i]), 1);
            double most = 0;
            for (const std::uint32_t i : near)
                most = std::max(most,
                                (Vec3(particles.velocity[i]) - fit.velocityAt(Vec3(particles.position[i]))).length());
            worst = std::max(worst, (mesh.velocity[v] - fit.velocityAt(mesh.position[v])).length() / most);
        }
        EXPECT_LE(worst, 1.3) << "seed " << seed;
    }
}

}  // namespace betamesh
