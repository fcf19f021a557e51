// What is true of droplets, tendrils, bubbles and components of every cloud.

#include "skin/features.h"

#include "base/parallel.h"
#include "base/union_find.h"
#include "betamesh/check.h"
#include "betamesh/error.h"
#include "betamesh/skin.h"
#include "mesh/components.h"
#include "mesh/enclosure.h"
#include "skin/ball_boundary.h"
#include "skin/coverage.h"
#include "support/clouds.h"
#include "support/file_checks.h"
#include "support/oracles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <numbers>
#include <set>

namespace betamesh {

namespace {

constexpr double kEveryBubble = std::numeric_limits<double>::infinity();

SkinParams withFeatures(const Cloud& cloud, Droplets droplets, Tendrils tendrils = Tendrils::mesh,
                        Bubbles bubbles = Bubbles::mesh) {
    SkinParams params;
    params.radius = cloud.radius;
    params.skin = 0;  // what leaves is decided on the balls
    params.features.droplets = droplets;
    params.features.tendrils = tendrils;
    params.features.bubbles = bubbles;
    params.features.bubble_volume = kEveryBubble;
    return params;
}

void forEveryCombination(const Cloud& cloud, const std::function<void(const SkinParams&)>& check) {
    for (const Droplets droplets : {Droplets::mesh, Droplets::points, Droplets::drop})
        for (const Tendrils tendrils : {Tendrils::mesh, Tendrils::points})
            for (const Bubbles bubbles : {Bubbles::mesh, Bubbles::fill}) {
                SCOPED_TRACE("droplets " + std::to_string(static_cast<int>(droplets)) + ", tendrils " +
                             std::to_string(static_cast<int>(tendrils)) + ", bubbles " +
                             std::to_string(static_cast<int>(bubbles)));
                check(withFeatures(cloud, droplets, tendrils, bubbles));
            }
}

// The component of each distinct particle, by comparing all with all, and how many each has.
struct BallComponents {
    std::vector<std::uint32_t> of;
    std::map<std::uint32_t, std::size_t> size;
};

BallComponents bruteForceComponents(const SnappedParticles& snapped) {
    const auto n = static_cast<std::uint32_t>(snapped.size());
    UnionFind sets(n);
    for (std::uint32_t a = 0; a < n; ++a)
        for (std::uint32_t b = 0; b < a; ++b)
            if ((snapped.position[a] - snapped.position[b]).length2() <= 4 * snapped.radius * snapped.radius)
                sets.join(a, b);
    BallComponents components;
    for (std::uint32_t a = 0; a < n; ++a) ++components.size[components.of.emplace_back(sets.find(a))];
    return components;
}

void expectSame(const SkinnedFrame& one, const SkinnedFrame& other) {
    EXPECT_EQ(one.mesh.position, other.mesh.position);
    EXPECT_EQ(one.mesh.velocity, other.mesh.velocity);
    EXPECT_EQ(one.mesh.triangles, other.mesh.triangles);
    EXPECT_EQ(one.mesh.component, other.mesh.component);
    EXPECT_EQ(one.spheres.position, other.spheres.position);
    EXPECT_EQ(one.spheres.velocity, other.spheres.velocity);
    EXPECT_EQ(one.spheres.radius, other.spheres.radius);
    EXPECT_EQ(one.spheres.id, other.spheres.id);
}

// The mesh without some of its pieces, numbered as componentsOf does.
Mesh withoutPieces(const Mesh& mesh, const Components& pieces, const std::set<std::uint32_t>& gone) {
    Mesh rest;
    std::vector<std::uint32_t> place(mesh.position.size());
    for (std::size_t v = 0; v < place.size(); ++v) {
        if (gone.contains(pieces.of_vertex[v])) continue;
        place[v] = static_cast<std::uint32_t>(rest.position.size());
        rest.position.push_back(mesh.position[v]);
        if (!mesh.velocity.empty()) rest.velocity.push_back(mesh.velocity[v]);
    }
    for (const Triangle& t : mesh.triangles)
        if (!gone.contains(pieces.of_vertex[t[0]])) rest.triangles.push_back({place[t[0]], place[t[1]], place[t[2]]});
    return rest;
}

Mesh piece(const Mesh& mesh, const Components& pieces, std::uint32_t wanted) {
    std::set<std::uint32_t> others;
    for (std::uint32_t p = 0; p < pieces.count; ++p)
        if (p != wanted) others.insert(p);
    return withoutPieces(mesh, pieces, others);
}

double ballVolume(double radius) { return 4 * std::numbers::pi / 3 * radius * radius * radius; }

// Spacing 1: a block with holes of several sizes in it, one of them with a drop inside.
Cloud swissCheese() {
    Cloud cloud{"cheese", {}, 1.5};
    const std::vector<std::pair<Vec3, double>> holes{
        {{7, 7, 7}, 2.1}, {{7, 7, 21}, 2.6}, {{7, 21, 7}, 3.2}, {{21, 7, 7}, 4.2}, {{20, 20, 19}, 6.2}};
    for (int z = 0; z < 29; ++z)
        for (int y = 0; y < 29; ++y)
            for (int x = 0; x < 29; ++x) {
                const Vec3 p(x, y, z);
                const bool empty = std::any_of(holes.begin(), holes.end(), [&](const auto& hole) {
                    return (p - hole.first).length() < hole.second;
                });
                if (!empty || p == holes.back().first) cloud.particles.position.emplace_back(p);
            }
    return cloud;
}

}  // namespace

TEST(Features, DropletsAreTheComponentsOfFewParticlesOfEveryCloud) {
    forEveryCloud(2000, [](const Cloud& cloud) {
        const SnappedParticles snapped = snapParticles(cloud.particles, cloud.radius);
        const BallComponents components = bruteForceComponents(snapped);
        for (const std::size_t least : {1u, 2u, 3u, 8u, 30u, 100000u}) {
            const SmallComponents small = smallComponents(snapped, least);
            std::vector<std::uint32_t> expected;
            std::size_t count = 0;
            for (std::uint32_t i = 0; i < snapped.size(); ++i)
                if (components.size.at(components.of[i]) < least) expected.push_back(i);
            for (const auto& [component, size] : components.size) count += size < least;
            EXPECT_EQ(small.particle, expected);
            EXPECT_EQ(small.count, count);
        }
    });
}

TEST(Features, WithoutDropletsTheMeshIsThatOfTheOtherParticles) {
    forEveryCloud(300, [](const Cloud& cloud) {
        const SnappedParticles snapped = snapParticles(cloud.particles, cloud.radius);
        const BallComponents components = bruteForceComponents(snapped);
        std::vector<std::uint32_t> small, large;
        for (std::uint32_t i = 0; i < snapped.size(); ++i)
            (components.size.at(components.of[i]) < 8 ? small : large).push_back(snapped.row[i]);
        SkinnedFrame expected = skinFrame(rowsOf(cloud.particles, large), withFeatures(cloud, Droplets::mesh));
        const SkinnedFrame dropped = skinFrame(cloud.particles, withFeatures(cloud, Droplets::drop));
        expectSame(dropped, expected);

        const SkinnedFrame kept = skinFrame(cloud.particles, withFeatures(cloud, Droplets::points));
        const Particles spheres = rowsOf(cloud.particles, small);
        expected.spheres.position.assign(spheres.position.begin(), spheres.position.end());
        expected.spheres.velocity.assign(spheres.velocity.begin(), spheres.velocity.end());
        expected.spheres.id = spheres.id;
        const double radius = static_cast<double>(snapped.radius) * snapped.quantum;
        EXPECT_NEAR(radius, cloud.radius, 1e-6 * cloud.radius);
        expected.spheres.radius.assign(small.size(), static_cast<float>(radius));
        expectSame(kept, expected);
        EXPECT_EQ(kept.report.droplet_particles, small.size());
        EXPECT_EQ(kept.report.distinct_particles, small.size() + large.size());
    });
}

TEST(Features, WithoutTendrilsTheMeshIsThatOfTheOtherParticlesAndHasNone) {
    std::size_t tendrils = 0;
    forEveryCloud(600, [&](const Cloud& cloud) {
        const SkinnedFrame frame = skinFrame(cloud.particles, withFeatures(cloud, Droplets::mesh, Tendrils::points));
        const std::set<std::uint64_t> apart(frame.spheres.id.begin(), frame.spheres.id.end());
        const SnappedParticles snapped = snapParticles(cloud.particles, cloud.radius);
        std::vector<std::uint32_t> others;
        for (const std::uint32_t row : snapped.row)
            if (!apart.contains(cloud.particles.id[row])) others.push_back(row);
        EXPECT_EQ(others.size() + frame.spheres.size(), snapped.size());
        EXPECT_EQ(frame.report.tendril_particles, frame.spheres.size());
        tendrils += frame.spheres.size();

        const Particles rest = rowsOf(cloud.particles, others);
        SkinnedFrame expected = skinFrame(rest, withFeatures(cloud, Droplets::mesh));
        expected.spheres = frame.spheres;
        expectSame(frame, expected);
        const SnappedParticles snapped_rest = snapParticles(rest, cloud.radius);
        EXPECT_TRUE(tendrilParticles(ballBoundary(snapped_rest, exposureCandidates(snapped_rest))).empty());

        // None left that would have been in a triangle: those of the alpha mesh are there with and without tendrils.
        const SnappedParticles all = snapParticles(cloud.particles, cloud.radius);
        const BallBoundary boundary = ballBoundary(all, exposureCandidates(all));
        for (const Triangle& t : boundary.triangle)
            for (const std::uint32_t ball : t) EXPECT_FALSE(apart.contains(cloud.particles.id[boundary.row[ball]]));
    });
    EXPECT_GT(tendrils, 500u);
}

TEST(Features, EveryParticleIsInsideTheMeshOrOneOfTheSpheres) {
    forEveryCloud(150, [](const Cloud& cloud) {
        if (cloud.particles.size() > 400) return;
        const std::vector<Vec3> points(cloud.particles.position.begin(), cloud.particles.position.end());
        forEveryCombination(cloud, [&](const SkinParams& params) {
            if (params.features.droplets == Droplets::drop) return;
            const SkinnedFrame frame = skinFrame(cloud.particles, params);
            for (const double distance : distancesOutside(frame.mesh, frame.spheres, points))
                EXPECT_LE(distance, 1e-5 * cloud.radius);
        });
    });
}

TEST(Features, TheMeshIsAClosedManifoldUnderEveryCombination) {
    forEveryCloud(20, [](const Cloud& cloud) {
        if (cloud.particles.size() > 400) return;
        forEveryCombination(cloud, [&](SkinParams params) {
            if (cloud.particles.size() < 60) params.skin.reset();
            const SkinnedFrame frame = skinFrame(cloud.particles, params);
            CheckParams check_params;
            check_params.tolerance = cloud.radius;  // crossings are not the question
            const MeshCheck check = checkMesh(frame.mesh, check_params);
            EXPECT_TRUE(check.closed());
            EXPECT_TRUE(check.oriented());
            EXPECT_TRUE(check.edgeManifold());
            EXPECT_TRUE(check.vertexManifold());
            EXPECT_EQ(check.repeated_vertices.count, 0u);
            EXPECT_EQ(check.unused_vertices.count, 0u);
        });
    });
}

TEST(Features, ComponentsOfTheUnsmoothedMeshAreBubblesOrHoldMostOfABall) {
    forEveryCloud(500, [](const Cloud& cloud) {
        for (const int segments : {0, 1}) {
            SkinParams params = withFeatures(cloud, Droplets::mesh);
            params.smoothing = SmoothingMethod::none;
            params.arc_subdivisions = segments;
            for (const ComponentCheck& component : checkMesh(skinFrame(cloud.particles, params).mesh).components) {
                const double balls = component.volume / ballVolume(cloud.radius);
                EXPECT_TRUE(balls < 1e-9 || balls > 0.5) << balls;
            }
        }
    });
}

TEST(Features, FillingRemovesTheBubblesBelowTheThresholdAndNothingElse) {
    std::size_t filled = 0;
    const auto check = [&](const Cloud& cloud) {
        SkinParams params = withFeatures(cloud, Droplets::mesh);
        params.smoothing = SmoothingMethod::none;
        const Mesh all = skinFrame(cloud.particles, params).mesh;
        const Components pieces = componentsOf(all.position.size(), all.triangles);
        std::vector<Mesh> piece_meshes;
        for (std::uint32_t p = 0; p < pieces.count; ++p) piece_meshes.push_back(piece(all, pieces, p));
        for (const double balls : {0.02, 0.5, 3.0, kEveryBubble}) {
            const double threshold = balls * ballVolume(cloud.radius);
            std::set<std::uint32_t> gone;
            std::size_t bubbles = 0;
            for (std::uint32_t p = 0; p < pieces.count; ++p) {
                const double volume = measureMesh(piece_meshes[p]).volume;
                if (volume >= 1e-9 * ballVolume(cloud.radius) || volume <= -threshold) continue;
                ++bubbles;
                gone.insert(p);
                for (std::uint32_t q = 0; q < pieces.count; ++q)  // and what is inside
                    if (q != p && windingNumber(piece_meshes[p], piece_meshes[q].position[0]) < -0.5) gone.insert(q);
            }
            params.features.bubbles = Bubbles::fill;
            params.features.bubble_volume = threshold;
            const SkinnedFrame frame = skinFrame(cloud.particles, params);
            const Mesh expected = withoutPieces(all, pieces, gone);
            EXPECT_EQ(frame.mesh.position, expected.position);
            EXPECT_EQ(frame.mesh.velocity, expected.velocity);
            EXPECT_EQ(frame.mesh.triangles, expected.triangles);
            EXPECT_EQ(frame.report.bubbles_filled, bubbles);
            filled += bubbles;
        }
    };
    forEveryCloud(300, [&](const Cloud& cloud) {
        if (cloud.name.find("sparse") == std::string::npos) check(cloud);
    });
    check(swissCheese());
    EXPECT_GT(filled, 100u);
}

// The skin is smoothed as if what was filled had never been there.
TEST(Features, FillingChangesNoOtherVertexOfTheMeshSmoothedOnTheBalls) {
    const Cloud cheese = swissCheese();
    SkinParams params = withFeatures(cheese, Droplets::mesh);
    const Mesh all = skinFrame(cheese.particles, params).mesh;
    const Components pieces = componentsOf(all.position.size(), all.triangles);
    ASSERT_EQ(pieces.count, 7u);
    params.features.bubbles = Bubbles::fill;
    for (const auto& [volume, left] : {std::pair(0.0, 7u), {8.0, 6u}, {100.0, 4u}, {1000.0, 1u}}) {
        params.features.bubble_volume = volume;
        const SkinnedFrame frame = skinFrame(cheese.particles, params);
        const Components pieces_left = componentsOf(frame.mesh.position.size(), frame.mesh.triangles);
        EXPECT_EQ(pieces_left.count, left) << volume;
        std::set<std::uint32_t> gone;
        for (std::uint32_t p = 0; p < pieces.count; ++p) gone.insert(p);
        const std::set<std::tuple<double, double, double>> kept = [&] {
            std::set<std::tuple<double, double, double>> positions;
            for (const Vec3& p : frame.mesh.position) positions.emplace(p.x, p.y, p.z);
            return positions;
        }();
        for (std::size_t v = 0; v < all.position.size(); ++v)
            if (kept.contains({all.position[v].x, all.position[v].y, all.position[v].z}))
                gone.erase(pieces.of_vertex[v]);
        EXPECT_EQ(frame.mesh.position, withoutPieces(all, pieces, gone).position);
        EXPECT_EQ(frame.mesh.triangles, withoutPieces(all, pieces, gone).triangles);
    }
}

TEST(Features, AreTheSameForEveryParticleOrderAndThreadCount) {
    forEveryCloud(10, [](const Cloud& cloud) {
        if (cloud.particles.size() > 400) return;
        forEveryCombination(cloud, [&](SkinParams params) {
            params.components = true;
            const SkinnedFrame one = skinFrame(cloud.particles, params);
            SkinnedFrame other;
            withThreads(1, [&] { other = skinFrame(shuffled(cloud.particles, 5), params); });
            expectSame(one, other);
            EXPECT_EQ(one.report.droplets, other.report.droplets);
            EXPECT_EQ(one.report.tendril_particles, other.report.tendril_particles);
            EXPECT_EQ(one.report.bubbles_filled, other.report.bubbles_filled);
        });
    });
}

TEST(Features, ComponentsAreThePiecesOfTheMeshTheLargestFirst) {
    forEveryCloud(300, [](const Cloud& cloud) {
        for (const SurfaceKind kind : {SurfaceKind::beta, SurfaceKind::alpha}) {
            SkinParams params = withFeatures(cloud, Droplets::mesh);
            params.surface = kind;
            const Mesh plain = skinFrame(cloud.particles, params).mesh;
            EXPECT_FALSE(plain.component);
            params.components = true;
            const Mesh mesh = skinFrame(cloud.particles, params).mesh;
            EXPECT_EQ(mesh.triangles, plain.triangles);
            ASSERT_TRUE(mesh.component);
            ASSERT_EQ(mesh.component->size(), mesh.triangles.size());
            const Components pieces = componentsOf(mesh.position.size(), mesh.triangles);
            std::map<std::int32_t, std::uint32_t> piece_of;
            for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
                const std::uint32_t here = pieces.of_vertex[mesh.triangles[t][0]];
                EXPECT_EQ(piece_of.emplace((*mesh.component)[t], here).first->second, here);
            }
            ASSERT_EQ(piece_of.size(), pieces.count);
            double before = std::numeric_limits<double>::infinity();
            std::int32_t number = 0;
            if (pieces.count > 40) return;
            for (const auto& [component, p] : piece_of) {
                EXPECT_EQ(component, number++);
                const double volume = measureMesh(piece(mesh, pieces, p)).volume;
                EXPECT_LE(volume, before + 1e-9 * ballVolume(cloud.radius));
                before = volume;
            }
        }
    });
}

TEST(Features, WorkWithFloatPredicatesAndThePapersTessellation) {
    for (std::uint64_t seed = 0; seed < 100; ++seed) {
        const Cloud cloud = randomCloud(seed);
        SCOPED_TRACE(cloud.name);
        SkinParams params = withFeatures(cloud, Droplets::points, Tendrils::points);
        params.retries = 20;
        params.tolerance = 1e-3;
        const SkinnedFrame exact = skinFrame(cloud.particles, params);
        params.predicates = PredicateKind::floating;
        const SkinnedFrame floating = skinFrame(cloud.particles, params);
        EXPECT_EQ(measureMesh(floating.mesh).unpaired_edges, 0u);
        if (floating.report.perturbation_retries == 0) {
            EXPECT_EQ(floating.spheres.id, exact.spheres.id);
        }

        params.predicates = PredicateKind::exact;
        params.tessellation = Tessellation::paper;
        params.smoothing = SmoothingMethod::paper;
        const SkinnedFrame paper = skinFrame(cloud.particles, params);
        EXPECT_EQ(measureMesh(paper.mesh).unpaired_edges, 0u);
        EXPECT_EQ(std::set(paper.spheres.id.begin(), paper.spheres.id.end()).size(), paper.spheres.size());
        params.features.bubbles = Bubbles::fill;
        EXPECT_THROW(skinFrame(cloud.particles, params), Error);
    }
}

}  // namespace betamesh
