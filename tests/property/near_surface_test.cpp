// Particles that nearSurface() omits before a frame is skinned do not change the result.

#include "skin/near_surface.h"

#include "base/random.h"
#include "skin/pipeline.h"
#include "support/clouds.h"
#include "support/file_checks.h"
#include "support/oracles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace betamesh {
namespace {

// The selected particles of a lattice of n³, jittered; with velocity, id and an attribute.
Cloud block(const std::string& name, int n, double jitter, const std::function<bool(const Vec3&)>& kept,
            std::uint64_t seed) {
    Cloud cloud{name, {}, 1.5};
    Particles& particles = cloud.particles;
    particles.attributes.push_back({"heat", 1, {}, {}});
    for (int i = 0; i < n * n * n; ++i) {
        const Vec3 place(i % n, i / n % n, i / (n * n));
        Random random(seed, static_cast<std::uint64_t>(i));
        const Vec3 moved = place + random.cube() * jitter;
        if (!kept(place)) continue;
        particles.position.emplace_back(moved);
        particles.velocity.emplace_back(random.cube());
        particles.id.push_back(static_cast<std::uint64_t>(i));
        particles.attributes[0].real.push_back(static_cast<float>(random.between(0, 1)));
    }
    return cloud;
}

// The particles with some of them duplicated; the copies have other ids and velocities.
void addDuplicates(Cloud& cloud, std::size_t every) {
    Particles& particles = cloud.particles;
    for (std::size_t row = 0, n = particles.size(); row < n; row += every) {
        particles.position.push_back(particles.position[row]);
        particles.velocity.push_back(particles.velocity[row] * 2.0F);
        particles.id.push_back(particles.id[row] + (row % 2 == 0 ? 1000000 : 0));
        particles.attributes[0].real.push_back(2);
    }
}

// Large enough to have particles deep inside.
std::vector<Cloud> blocks() {
    const auto everything = [](const Vec3&) { return true; };
    const auto outside = [](const Vec3& p, const Vec3& centre, double radius) {
        return (p - centre).length() > radius;
    };
    const Vec3 middle(22, 22, 22);
    std::vector<Cloud> made;
    made.push_back(block("lattice", 36, 0, everything, 1));
    made.push_back(block("jittered", 45, 0.25, everything, 2));
    made.push_back(block(
        "bubble", 45, 0.25, [&](const Vec3& p) { return outside(p, middle, 4); }, 3));
    made.push_back(block(
        "drop in a bubble", 45, 0.25, [&](const Vec3& p) { return outside(p, middle, 7) || !outside(p, middle, 1.2); },
        4));
    made.push_back(block(
        "holes", 45, 0.3,
        [&](const Vec3& p) {
            return outside(p, {22, 22, p.z}, 3) && outside(p, {p.x, 8, 8}, 2.5);
        },
        5));
    made.push_back(block("far from the origin", 40, 0.25, everything, 6));
    for (Vec3f& p : made.back().particles.position) p -= Vec3f(300, 4000, -77);
    made.push_back(block(
        "drops above a ball", 45, 0.25,
        [&](const Vec3& p) {
            const bool drop = p.z == 42 && static_cast<int>(p.x) % 6 < 2 && static_cast<int>(p.y) % 7 < 2;
            return drop || !outside(p, {22, 22, 18}, 19);
        },
        7));
    for (std::size_t i = 0; i < 3; ++i) {
        made.push_back(made[1 + i]);
        made.back().name += i == 0 ? ", every particle twice" : ", with duplicates";
        addDuplicates(made.back(), i == 0 ? 1 : 17);
    }
    return made;
}

NearSurface nearOf(const Particles& particles, const SkinParams& params, std::size_t rows_at_once) {
    NearSurfaceFinder finder(params);
    const std::span<const Vec3f> all(particles.position);
    for (std::size_t row = 0; row < all.size(); row += rows_at_once)
        finder.add(all.subspan(row, std::min(rows_at_once, all.size() - row)));
    return finder.find();
}

NearSurface everything(const Particles& particles) {
    NearSurface near;
    near.particles = particles.size();
    return near;
}

void expectSame(const SkinnedFrame& one, const SkinnedFrame& other) {
    EXPECT_EQ(one.mesh.position, other.mesh.position);
    EXPECT_EQ(one.mesh.velocity, other.mesh.velocity);
    EXPECT_EQ(one.mesh.triangles, other.mesh.triangles);
    ASSERT_EQ(one.mesh.attributes.size(), other.mesh.attributes.size());
    for (std::size_t a = 0; a < one.mesh.attributes.size(); ++a)
        EXPECT_EQ(one.mesh.attributes[a].real, other.mesh.attributes[a].real);
    EXPECT_EQ(one.spheres.position, other.spheres.position);
    EXPECT_EQ(one.spheres.velocity, other.spheres.velocity);
    EXPECT_EQ(one.spheres.id, other.spheres.id);
    const SkinReport &r = one.report, &s = other.report;
    EXPECT_EQ(std::tuple(r.particles, r.distinct_particles, r.alpha_triangles, r.double_sided_triangles,
                         r.degenerate_edges, r.isolated_particles, r.alpha_vertices, r.droplets, r.droplet_particles),
              std::tuple(s.particles, s.distinct_particles, s.alpha_triangles, s.double_sided_triangles,
                         s.degenerate_edges, s.isolated_particles, s.alpha_vertices, s.droplets, s.droplet_particles));
}

// From memory and from files read in blocks of several sizes, compared with the frame that omits nothing.
void expectNothingChanges(const Cloud& cloud, const SkinParams& params, std::size_t* left_out) {
    const SkinnedFrame expected = skinFrame(cloud.particles, everything(cloud.particles), params);
    expectSame(skinFrame(cloud.particles, params), expected);
    for (const std::size_t rows_at_once : {std::size_t{7777}, std::numeric_limits<std::size_t>::max() / 2}) {
        const NearSurface near = nearOf(cloud.particles, params, rows_at_once);
        expectSame(skinFrame(rowsOf(cloud.particles, near.row), near, params), expected);
        *left_out += near.omitted();
    }
}

TEST(NearSurface, DoesNotChangeTheFrameOfAnyBlock) {
    for (const Cloud& cloud : blocks()) {
        SCOPED_TRACE(cloud.name);
        SkinParams params;
        params.radius = cloud.radius;
        params.arc_subdivisions = 1;
        params.attributes = {"heat"};
        std::size_t left_out = 0;
        expectNothingChanges(cloud, params, &left_out);
        params.surface = SurfaceKind::alpha;
        for (const int least : {1, 28}) {
            params.features.droplets = Droplets::points;
            params.features.droplet_particles = least;
            expectNothingChanges(cloud, params, &left_out);
        }
        EXPECT_EQ(left_out > 0, cloud.name.find("every particle twice") == std::string::npos);
        EXPECT_EQ(nearOf(shuffled(cloud.particles, 1), params, 10000).omitted(),
                  nearOf(cloud.particles, params, 10000).omitted());
    }
}

TEST(NearSurface, DoesNotChangeTheFrameOfAnyCloud) {
    forEveryCloud(100, [](const Cloud& cloud) {
        SkinParams params;
        params.radius = cloud.radius;
        std::size_t left_out = 0;
        expectNothingChanges(cloud, params, &left_out);
        params.surface = SurfaceKind::alpha;
        params.features.droplets = Droplets::drop;
        expectNothingChanges(cloud, params, &left_out);
    });
}

}  // namespace
}  // namespace betamesh
