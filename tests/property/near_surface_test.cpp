// Particles that NearSurfaceFinder omits before a frame is skinned do not change the result.

#include "skin/near_surface.h"

#include "base/random.h"
#include "skin/coverage.h"
#include "skin/faces.h"
#include "skin/features.h"
#include "skin/outer_boundary.h"
#include "skin/particle_sizes.h"
#include "skin/pipeline.h"
#include "skin/stage_settings.h"
#include "support/clouds.h"
#include "support/file_checks.h"
#include "support/oracles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
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

void expectSame(const NearSurface& one, const NearSurface& other) {
    EXPECT_EQ(std::tuple(one.particles, one.largest, one.is_unequal, one.all),
              std::tuple(other.particles, other.largest, other.is_unequal, other.all));
    EXPECT_EQ(one.row, other.row);
    EXPECT_EQ(one.cell_of, other.cell_of);
    EXPECT_EQ(one.is_covered, other.is_covered);
    EXPECT_EQ(one.cell, other.cell);
    EXPECT_EQ(one.is_incomplete, other.is_incomplete);
}

// From memory and from files read in blocks of several sizes, compared with the frame that omits nothing.
void expectNothingChanges(const Cloud& cloud, const SkinParams& params, std::size_t* left_out) {
    const SkinnedFrame expected = skinFrame(cloud.particles, everything(cloud.particles), params);
    expectSame(skinFrame(cloud.particles, params), expected);
    const NearSurface near = nearOf(cloud.particles, params, 7777);
    expectSame(skinFrame(rowsOf(cloud.particles, near.row), near, params), expected);
    expectSame(nearOf(cloud.particles, params, std::numeric_limits<std::size_t>::max() / 2), near);
    *left_out += near.omitted();
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
    forEveryCloud(50, [](const Cloud& cloud) {
        SkinParams params;
        params.radius = cloud.radius;
        std::size_t left_out = 0;
        expectNothingChanges(cloud, params, &left_out);
        params.surface = SurfaceKind::alpha;
        params.features.droplets = Droplets::drop;
        expectNothingChanges(cloud, params, &left_out);
    });
}

// Particles with a ball radius each.
struct SizedCloud {
    std::string name;
    Particles particles;
    std::vector<double> radius;
};

using RadiusOf = std::function<double(const Vec3&, Random&)>;

SizedCloud sized(const Cloud& cloud, const RadiusOf& radiusOf) {
    SizedCloud made{cloud.name, cloud.particles, {}};
    for (std::size_t i = 0; i < made.particles.size(); ++i) {
        Random random(i);
        made.radius.push_back(radiusOf(Vec3(made.particles.position[i]), random));
    }
    return made;
}

RadiusOf twoRadii(double large, double small) {
    return [=](const Vec3&, Random& random) { return random.unit() < 0.5 ? large : small; };
}
RadiusOf ratioOf20(double largest) {
    return [=](const Vec3&, Random& random) { return largest * std::pow(20, -random.unit()); };
}
RadiusOf wave(double largest, double depth) {
    return [=](const Vec3& p, Random&) { return largest * (1 - depth + depth * std::sin(p.x / (4 * largest))); };
}

// A block of n³ particles with spacing 1 below, and one of spacing 1 / 2 on top of it.
SizedCloud twoBlocks(int n, int n_above) {
    const auto everything = [](const Vec3&) { return true; };
    SizedCloud made = sized(block("", n, 0.2, everything, 11), [](const Vec3&, Random&) { return 1.5; });
    const Particles above = block("", n_above, 0.2, everything, 12).particles;
    for (std::size_t i = 0; i < above.size(); ++i) {
        made.particles.position.push_back(above.position[i] * 0.5F + Vec3f(0, 0, static_cast<float>(n)));
        made.particles.velocity.push_back(above.velocity[i]);
        made.particles.id.push_back(1000000 + i);
        made.radius.push_back(0.75);
    }
    made.particles.attributes.clear();
    return made;
}

// With small balls between the others, most of them inside one.
SizedCloud withSmallBallsAdded(SizedCloud cloud) {
    Particles& particles = cloud.particles;
    for (std::size_t row = 0, n = particles.size(); row < n; row += 9) {
        Random random(row);
        particles.position.emplace_back(Vec3(particles.position[row]) + random.ball());
        particles.velocity.push_back(particles.velocity[row] * 2.0F);
        particles.id.push_back(particles.id[row] + 1000000);
        particles.attributes[0].real.push_back(2);
        cloud.radius.push_back(0.2 + 0.3 * random.unit());
    }
    return cloud;
}

std::vector<SizedCloud> sizedBlocks() {
    const auto outside = [](const Vec3& p, const Vec3& centre, double radius) {
        return (p - centre).length() > radius;
    };
    const Vec3 middle(21, 21, 21);
    const Cloud bubble = block(
        "bubble", 34, 0.1,
        [&](const Vec3& p) {
            return outside(p, {6, 6, 6}, 2.2);
        },
        3);
    Cloud drops = block(
        "drops above a ball", 46, 0.1,
        [&](const Vec3& p) {
            const bool drop = p.z == 44 && static_cast<int>(p.x) % 6 < 2 && static_cast<int>(p.y) % 7 < 2;
            return drop || !outside(p, middle, 21);
        },
        7);
    std::vector<SizedCloud> made;
    made.push_back(sized(bubble, [](const Vec3&, Random&) { return 1.35; }));
    made.push_back(sized(bubble, twoRadii(1.4, 1.3)));
    made.push_back(sized(bubble, wave(1.4, 0.03)));
    made.push_back(withSmallBallsAdded(made[0]));
    made.push_back(sized(drops, twoRadii(1.4, 1.3)));
    made.push_back(sized(drops, [](const Vec3& p, Random& random) {  // tiny drops
        return p.z > 43 ? 0.07 : 1.35 - 0.05 * random.unit();
    }));
    made.push_back(sized(drops, [&](const Vec3& p, Random& random) {  // the largest ball is deep inside
        return outside(p, middle, 2) ? 1.35 - 0.05 * random.unit() : 1.45;
    }));
    for (Vec3f& p : drops.particles.position) p += Vec3f(3000, -400, 77);
    addDuplicates(drops, 7);
    made.push_back(sized(drops, twoRadii(1.4, 1.3)));
    for (std::size_t i = 0; i < made.size(); ++i) made[i].name += ", radii " + std::to_string(i);
    return made;
}

NearSurface nearOf(const SizedCloud& cloud, const SkinParams& params, std::size_t rows_at_once) {
    NearSurfaceFinder finder(params);
    const std::span<const Vec3f> all(cloud.particles.position);
    const std::span<const double> radii(cloud.radius);
    for (std::size_t row = 0; row < all.size(); row += rows_at_once) {
        const std::size_t count = std::min(rows_at_once, all.size() - row);
        finder.add(all.subspan(row, count), radii.subspan(row, count));
    }
    return finder.find();
}

// What the surface is made from.
struct SizedStructure {
    BallBoundary boundary;
    OuterSamples outer;
    Spheres droplets;
    std::size_t distinct = 0;
    RemovedDroplets left_out;
};

SizedStructure structureOf(const Particles& particles, SnappedParticles snapped, const SkinParams& params) {
    SizedStructure made;
    made.distinct = snapped.size();
    made.left_out = removeDroplets(particles, params.features, snapped, made.droplets);
    made.boundary = ballBoundary(snapped, exposureCandidates(snapped), faceDirections(params).position);
    groupFaces(snapped, made.boundary);
    if (hasSkin(params) && snapped.size() > 0) {
        made.outer = outerSamples(particles, snapped, made.boundary, skinLengths(params), particleSpacing(params));
    }
    return made;
}

void expectSame(const SizedStructure& one, const SizedStructure& other) {
    const BallBoundary &a = one.boundary, &b = other.boundary;
    EXPECT_EQ(one.distinct, other.distinct);
    EXPECT_EQ(std::tuple(one.left_out.droplets, one.left_out.particles),
              std::tuple(other.left_out.droplets, other.left_out.particles));
    EXPECT_EQ(one.droplets.position, other.droplets.position);
    EXPECT_EQ(one.droplets.radius, other.droplets.radius);
    EXPECT_EQ(std::tuple(a.quantum, a.radius), std::tuple(b.quantum, b.radius));
    EXPECT_EQ(a.position, b.position);
    EXPECT_EQ(a.radius_of, b.radius_of);
    EXPECT_EQ(a.row, b.row);
    EXPECT_EQ(a.triangle, b.triangle);
    EXPECT_EQ(a.vertex, b.vertex);
    EXPECT_EQ(a.twin, b.twin);
    EXPECT_EQ(a.circle, b.circle);
    EXPECT_EQ(a.isolated, b.isolated);
    EXPECT_EQ(a.cycle.item, b.cycle.item);
    EXPECT_EQ(a.face.item, b.face.item);
    ASSERT_EQ(one.outer.point.size(), other.outer.point.size());
    for (std::size_t i = 0; i < one.outer.point.size(); ++i) {
        ASSERT_EQ(one.outer.point[i].position, other.outer.point[i].position);
        ASSERT_EQ(one.outer.point[i].velocity, other.outer.point[i].velocity);
    }
    EXPECT_EQ(one.outer.weight, other.outer.weight);
    EXPECT_EQ(one.outer.exposure, other.outer.exposure);
    EXPECT_EQ(one.outer.scale, other.outer.scale);
}

// Returns how many particles are left out.
std::size_t expectNothingChanges(const SizedCloud& cloud, const SkinParams& nominal) {
    const SkinParams params = withRadius(nominal, *std::max_element(cloud.radius.begin(), cloud.radius.end()));
    const SizedStructure expected = structureOf(cloud.particles, snapParticles(cloud.particles, cloud.radius), params);
    const NearSurface near = nearOf(cloud, nominal, 7777);
    EXPECT_EQ(near.largest, params.radius);
    const Particles kept = rowsOf(cloud.particles, near.row);
    std::vector<double> radii;
    for (const std::uint32_t row : near.row) radii.push_back(cloud.radius[row]);
    SizedStructure made = structureOf(kept, snapParticles(kept, radii, near), params);
    made.distinct += near.omitted();
    for (std::uint32_t& row : made.boundary.row) row = near.row[row];
    expectSame(made, expected);
    return near.omitted();
}

SkinParams paramsOf(double radius, bool skin) {
    SkinParams params;
    params.radius = radius;
    params.radius_attribute = "size";
    params.skin = skin ? 0.8 * radius : 0;
    return params;
}

TEST(NearSurface, OfDifferentRadiiDoesNotChangeTheStructureOfAnyBlock) {
    for (const SizedCloud& cloud : sizedBlocks()) {
        SCOPED_TRACE(cloud.name);
        const bool has_drops = cloud.name.starts_with("drops");
        SkinParams params = paramsOf(has_drops ? 0.3 : 2, !has_drops);
        if (has_drops) params.features.droplets = Droplets::points;
        params.features.droplet_particles = 6;
        EXPECT_GT(expectNothingChanges(cloud, params), 0U);
    }
}

TEST(NearSurface, OfDifferentRadiiDoesNotChangeTheStructureOfAnyCloud) {
    std::uint64_t clouds = 0;
    forEveryCloud(60, [&](const Cloud& cloud) {
        if (cloud.particles.size() == 0 || cloud.particles.size() > 400) return;
        const double radius = cloud.radius;
        for (const RadiusOf& radiusOf : {twoRadii(radius, radius / 2), ratioOf20(radius), wave(radius, 0.25)}) {
            SkinParams params = paramsOf(radius * 0.7, ++clouds % 3 == 0);
            if (clouds % 2 == 0) params.features.droplets = Droplets::drop;
            expectNothingChanges(sized(cloud, radiusOf), params);
        }
    });
}

TEST(NearSurface, OfTwoBlocksOfDifferentRadiiLeavesOutWhatIsDeepInBoth) {
    const SkinParams params = paramsOf(1, false);
    EXPECT_GT(expectNothingChanges(twoBlocks(24, 48), params), 3000U);
    const SizedCloud large = twoBlocks(64, 96);
    const NearSurface near = nearOf(large, params, 1000000);
    EXPECT_GT(near.omitted(), large.particles.size() * 2 / 5);
    EXPECT_EQ(nearOf(large, params, 12345).row, near.row);
}

TEST(NearSurface, OfEqualRadiiIsThatOfOneRadius) {
    for (const Cloud& cloud : {block(
             "jittered", 30, 0.25, [](const Vec3&) { return true; }, 2)}) {
        const SkinParams params = paramsOf(1.5, false);
        const NearSurface one = nearOf(cloud.particles, params, 5000);
        const NearSurface each = nearOf(sized(cloud, [](const Vec3&, Random&) { return 1.5; }), params, 5000);
        EXPECT_GT(one.omitted(), 0U);
        EXPECT_FALSE(each.is_unequal);
        EXPECT_EQ(one.row, each.row);
        EXPECT_EQ(one.cell_of, each.cell_of);
        EXPECT_EQ(one.is_covered, each.is_covered);
        EXPECT_EQ(one.is_incomplete, each.is_incomplete);
    }
}

}  // namespace
}  // namespace betamesh
