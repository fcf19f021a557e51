// Properties of voids, which are filled depending on the largest empty ball that fits into them.

#include "skin/voids.h"
#include "base/index.h"
#include "base/random.h"
#include "betamesh/skin.h"
#include "mesh/components.h"
#include "skin/arcs.h"
#include "skin/ball_boundary.h"
#include "skin/coverage.h"
#include "skin/face_points.h"
#include "skin/faces.h"
#include "skin/tessellate.h"
#include "skin/velocity.h"
#include "support/clouds.h"
#include "support/oracles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

namespace betamesh {

namespace {

struct Tessellated {
    BallBoundary boundary;
    BetaMesh mesh;
};

Tessellated tessellated(const Particles& particles, const SnappedParticles& snapped, Appearance appearance,
                        double angle) {
    const Icosphere directions = icosphereOf(angle);
    BallBoundary boundary = ballBoundary(snapped, exposureCandidates(snapped), directions.position);
    groupFaces(snapped, boundary);
    const std::vector<DualVec3> balls = ballCentres(boundary, particles);
    const ArcSubdivision subdivision{angle, 0, appearance};
    const ArcNetwork network =
        arcPoints(boundary, balls, boundaryVertices(particles, snapped, boundary, balls), subdivision);
    BetaMesh mesh =
        completeTessellation(boundary, balls, network, facePoints(snapped, boundary, balls, directions), subdivision);
    return {std::move(boundary), std::move(mesh)};
}

Tessellated tessellated(const Particles& particles, double radius, Appearance appearance = Appearance::gradual,
                        double angle = 0.35) {
    return tessellated(particles, snapParticles(particles, radius), appearance, angle);
}

Features gapOf(double gap) {
    Features features;
    features.bubbles = Bubbles::fill;
    features.bubble_gap = gap;
    return features;
}

struct Filled {
    Mesh mesh;
    std::size_t count = 0;
};

Filled filled(const Tessellated& made, double gap, double reference_radius) {
    BetaMesh mesh = made.mesh;
    const std::size_t count = fillBubbles(mesh, made.boundary, gapOf(gap), reference_radius);
    return {asMesh(std::move(mesh)), count};
}

Filled filled(const Tessellated& made, double gap) { return filled(made, gap, made.boundary.worldRadius()); }

Filled filled(const Particles& particles, double radius, double gap) {
    return filled(tessellated(particles, radius), gap);
}

void add(Particles& to, const Particles& from, const Vec3& by = Vec3(0)) {
    for (const Vec3f& p : from.position) to.position.emplace_back(Vec3(p) + by);
}

// Layers of particles around an empty ball of this radius; no larger one fits.
Particles shell(double inner, double spacing = 0.7, int layers = 2) {
    Particles particles;
    for (int layer = 0; layer < layers; ++layer) {
        const double radius = inner + layer * spacing, across = 2 * radius / spacing;
        add(particles, spiralOnSphere(static_cast<std::size_t>(std::numbers::pi * across * across), radius));
    }
    return particles;
}

// A lattice without some of its points.
template <typename IsEmpty>
Particles blockWithout(int edge, double jitter, const IsEmpty& isEmpty) {
    Particles particles;
    for (int z = 0; z < edge; ++z)
        for (int y = 0; y < edge; ++y)
            for (int x = 0; x < edge; ++x)
                if (!isEmpty(Vec3(x, y, z)))
                    particles.position.emplace_back(
                        Vec3(x, y, z) + Random(3, static_cast<std::uint64_t>(x + 100 * (y + 100 * z))).cube() * jitter);
    return particles;
}

// The components of a mesh as separate meshes, and which contains which.
struct Anatomy {
    Mesh mesh;
    Components pieces;
    std::vector<Mesh> piece;
    std::vector<bool> is_void;
    std::vector<std::uint32_t> around;  // the void round each body, kInvalidIndex where there is none

    explicit Anatomy(Mesh given, double radius) : mesh(std::move(given)) {
        pieces = componentsOf(mesh.position.size(), mesh.triangles);
        piece.resize(pieces.count);
        std::vector<std::uint32_t> place(mesh.position.size());
        for (std::uint32_t v = 0; v < place.size(); ++v) {
            Mesh& own = piece[pieces.of_vertex[v]];
            place[v] = static_cast<std::uint32_t>(own.position.size());
            own.position.push_back(mesh.position[v]);
        }
        for (const Triangle& t : mesh.triangles)
            piece[pieces.of_vertex[t[0]]].triangles.push_back({place[t[0]], place[t[1]], place[t[2]]});
        std::vector<double> volume;
        for (const Mesh& own : piece) {
            volume.push_back(0);
            for (const Triangle& t : own.triangles)
                volume.back() +=
                    signedVolume(own.position[t[0]] - own.position[0], own.position[t[1]] - own.position[0],
                                 own.position[t[2]] - own.position[0]);
            is_void.push_back(volume.back() < 1e-9 * radius * radius * radius);
        }
        for (std::uint32_t p = 0; p < pieces.count; ++p) {
            around.push_back(kInvalidIndex);
            for (std::uint32_t q = 0; q < pieces.count && !is_void[p]; ++q)
                if (is_void[q] && volume[q] < -volume[p] &&
                    std::abs(windingNumber(piece[q], piece[p].position[0])) > 0.5 &&
                    (around[p] == kInvalidIndex || volume[q] > volume[around[p]]))
                    around[p] = q;
        }
    }
    // The void that contains a point farther than a radius from all particles, or kInvalidIndex.
    std::uint32_t voidAt(const Vec3& point) const {
        for (std::uint32_t q = 0; q < pieces.count; ++q) {
            if (!is_void[q]) continue;
            double winding = windingNumber(piece[q], point);
            for (std::uint32_t p = 0; p < pieces.count; ++p)
                if (around[p] == q) winding += windingNumber(piece[p], point);
            if (std::abs(winding) > 0.5) return q;
        }
        return kInvalidIndex;
    }
    Mesh without(const std::set<std::uint32_t>& gone) const {
        Mesh rest;
        std::vector<std::uint32_t> place(mesh.position.size());
        for (std::size_t v = 0; v < place.size(); ++v) {
            if (gone.contains(pieces.of_vertex[v])) continue;
            place[v] = static_cast<std::uint32_t>(rest.position.size());
            rest.position.push_back(mesh.position[v]);
        }
        for (const Triangle& t : mesh.triangles)
            if (!gone.contains(pieces.of_vertex[t[0]]))
                rest.triangles.push_back({place[t[0]], place[t[1]], place[t[2]]});
        return rest;
    }
    // The voids missing from a mesh that equals this one except for filled voids and the drops in them.
    std::set<std::uint32_t> voidsFilledIn(const Filled& other) const {
        std::set<std::tuple<double, double, double>> left;
        for (const Vec3& p : other.mesh.position) left.emplace(p.x, p.y, p.z);
        std::set<std::uint32_t> voids, gone;
        for (std::uint32_t p = 0; p < pieces.count; ++p) {
            const std::vector<Vec3>& points = piece[p].position;
            if (std::all_of(points.begin(), points.end(), [&](const Vec3& v) {
                    return left.contains({v.x, v.y, v.z});
                }))
                continue;
            if (is_void[p]) voids.insert(p);
        }
        gone = voids;
        for (std::uint32_t p = 0; p < pieces.count; ++p)
            if (around[p] != kInvalidIndex && voids.contains(around[p])) gone.insert(p);
        const Mesh expected = without(gone);
        EXPECT_EQ(other.mesh.position, expected.position);
        EXPECT_EQ(other.mesh.triangles, expected.triangles);
        EXPECT_EQ(other.count, voids.size());
        return voids;
    }
};

double distanceToNearest(const Particles& particles, const Vec3& point) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Vec3f& p : particles.position) nearest = std::min(nearest, (Vec3(p) - point).length2());
    return std::sqrt(nearest);
}

// How often voids were expected to be kept, and to be filled, and drops were in voids.
struct Searched {
    std::size_t kept = 0, gone = 0, with_drops = 0;
};

// Compares the voids that are filled with a search for the largest ball between those of the particles.
void searchEmptyBalls(const Cloud& cloud, const std::vector<double>& radii, Appearance appearance, Searched& found) {
    const Particles& particles = cloud.particles;
    const double radius = cloud.radius;
    const Tessellated made = tessellated(particles, snapParticles(particles, radii), appearance, 0.35);
    const Anatomy anatomy(asMesh(BetaMesh(made.mesh)), *std::min_element(radii.begin(), radii.end()));
    if (std::count(anatomy.is_void.begin(), anatomy.is_void.end(), true) == 0) return;
    const auto roomAt = [&](const Vec3& point) {
        double room = std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < particles.size(); ++i)
            room = std::min(room, (Vec3(particles.position[i]) - point).length() - radii[i]);
        return room;
    };
    // The largest empty ball centred at a grid point in each void; others are larger by at most half a cell diagonal.
    constexpr int kSteps = 24;
    std::vector<double> room(anatomy.pieces.count, 0), slack = room;
    for (std::uint32_t q = 0; q < anatomy.pieces.count; ++q) {
        if (!anatomy.is_void[q]) continue;
        Box box;
        for (const Vec3& p : anatomy.piece[q].position) box.extendBy(p);
        const Vec3 step = box.size() / kSteps;
        slack[q] = step.length() / 2;
        for (int z = 0; z < kSteps; ++z)
            for (int y = 0; y < kSteps; ++y)
                for (int x = 0; x < kSteps; ++x) {
                    const Vec3 point = box.min + Vec3(x + 0.5, y + 0.5, z + 0.5) * step;
                    const double here = roomAt(point);
                    if (here > std::max(room[q], 1e-4 * radius) && anatomy.voidAt(point) == q) room[q] = here;
                }
    }
    std::vector<double> sizes{0.05 * radius, 0.2 * radius, 0.5 * radius};
    for (std::uint32_t q = 0; q < anatomy.pieces.count; ++q)
        if (room[q] > 0)
            sizes.insert(sizes.end(), {0.999 * room[q] - 1e-5 * radius, 1.001 * (room[q] + slack[q]) + 1e-5 * radius});
    for (const double size : sizes) {
        if (size <= 1e-4 * radius) continue;
        SCOPED_TRACE(size / radius);
        // Only gap - 2 reference counts.
        const double reference = radius * (found.kept % 2 == 0 ? 1 : 0.7);
        const std::set<std::uint32_t> voids = anatomy.voidsFilledIn(filled(made, 2 * (reference + size), reference));
        for (std::uint32_t q = 0; q < anatomy.pieces.count; ++q) {
            if (!anatomy.is_void[q]) continue;
            if (room[q] > size) {
                EXPECT_FALSE(voids.contains(q)) << "room for " << room[q] / radius;
                ++found.kept;
            } else if (room[q] + slack[q] < size) {
                EXPECT_TRUE(voids.contains(q)) << "room for " << room[q] / radius;
                ++found.gone;
            }
        }
        found.with_drops += static_cast<std::size_t>(std::count_if(anatomy.around.begin(), anatomy.around.end(),
                                                                   [](std::uint32_t q) { return q != kInvalidIndex; }));
    }
}

// A box full of particles; some are crowded round a ball, of these some with a drop in it.
Cloud crowdedBox(std::uint64_t seed) {
    Random random(seed);
    Cloud cloud{"box " + std::to_string(seed), {}, random.between(0.85, 1.3)};
    for (int i = 0; i < (seed % 4 == 3 ? 450 : 300); ++i) {
        Vec3 p = random.cube() * 3.4;
        if (seed % 2 == 1) p *= std::max(1.0, 3.2 / p.length());
        if (seed % 4 == 3 && i < 4) p = random.ball() * 0.3;
        cloud.particles.position.emplace_back(p);
    }
    return cloud;
}

bool enclosesOrigin(const Mesh& mesh) { return std::abs(windingNumber(mesh, Vec3(0))) > 0.5; }

}  // namespace

TEST(Voids, OfHollowSpheresAreKeptFromTheirDiameterOnForAnyRadius) {
    for (const double inner : {1.6, 2.5, 4.1})
        for (const double radius : {0.8, 1.2, 1.5, 2.0, 3.0}) {
            if (radius >= inner) continue;
            SCOPED_TRACE("inner " + std::to_string(inner) + ", radius " + std::to_string(radius));
            for (const Vec3& place : {Vec3(0), Vec3(300.7, -41.3, 77)}) {
                Particles particles;
                add(particles, shell(inner), place);
                const Tessellated made = tessellated(particles, radius);
                const std::uint32_t pieces = Anatomy(asMesh(BetaMesh(made.mesh)), radius).pieces.count;
                EXPECT_EQ(pieces, 2u);
                for (const double share : {0.2, 0.9, 0.9995}) {
                    EXPECT_EQ(filled(made, 2 * inner * share).count, 0u) << share;
                }
                for (const double share : {1.0005, 1.01, 1.4, 3.0, 1e6, std::numeric_limits<double>::infinity()}) {
                    const Filled full = filled(made, 2 * inner * share);
                    EXPECT_EQ(full.count, radius < inner * share ? 1u : 0u) << share;
                    EXPECT_TRUE(enclosesOrigin(full.mesh) || place != Vec3(0));
                }
            }
        }
}

TEST(Voids, AreAllKeptIfTheGapIsNoWiderThanABall) {
    forEveryCloud(100, [](const Cloud& cloud) {
        if (cloud.particles.size() > 400) return;
        const Tessellated made = tessellated(cloud.particles, cloud.radius);
        const Mesh all = asMesh(BetaMesh(made.mesh));
        const Filled kept = filled(made, 2 * made.boundary.worldRadius());
        EXPECT_EQ(kept.mesh.position, all.position);
        EXPECT_EQ(kept.mesh.triangles, all.triangles);
        EXPECT_EQ(kept.count, 0u);
    });
}

TEST(Voids, DropsInsideReduceTheLargestEmptyBall) {
    for (const double radius : {0.8, 1.2, 1.5}) {
        SCOPED_TRACE(radius);
        const Particles hollow = shell(6);
        Particles with_drop = hollow;
        with_drop.position.emplace_back(0.02, -0.01, 0.03);
        EXPECT_EQ(filled(hollow, radius, 6.8).count, 0u);
        const Filled kept = filled(with_drop, radius, 5.8), full = filled(with_drop, radius, 6.8);
        EXPECT_EQ(kept.count, 0u);
        EXPECT_EQ(componentsOf(kept.mesh.position.size(), kept.mesh.triangles).count, 3u);
        EXPECT_EQ(full.count, 1u);
        EXPECT_EQ(componentsOf(full.mesh.position.size(), full.mesh.triangles).count, 1u);
    }
}

// A cup in a void: the only ball that fits touches nothing but the cup.
TEST(Voids, AreKeptIfAnEmptyBallFitsIntoAComponentInside) {
    Particles cup, particles = shell(5.6, 0.5);
    for (const Vec3f& p : shell(3.3, 0.5, 1).position)
        if (p.z < 2.4F) cup.position.push_back(p);
    add(particles, cup);
    const double radius = 0.7;
    const Anatomy anatomy(asMesh(BetaMesh(tessellated(particles, radius).mesh)), radius);
    EXPECT_EQ(anatomy.pieces.count, 3u);
    EXPECT_EQ(std::count(anatomy.is_void.begin(), anatomy.is_void.end(), true), 1);
    EXPECT_EQ(filled(particles, radius, 6.4).count, 0u);
    EXPECT_EQ(filled(particles, radius, 7.6).count, 1u);
}

TEST(Voids, InsideDropsInVoidsAreFilledIndependently) {
    Particles particles = shell(7.2, 0.6, 2);
    add(particles, shell(4, 0.6, 2));
    const double radius = 0.8;
    const Tessellated made = tessellated(particles, radius);
    const Anatomy anatomy(asMesh(BetaMesh(made.mesh)), radius);
    ASSERT_EQ(anatomy.pieces.count, 4u);
    for (const auto& [gap, pieces] : {std::pair(2.0, 4u), {6.0, 2u}, {9.0, 1u}}) {
        const Filled result = filled(made, gap);
        EXPECT_EQ(componentsOf(result.mesh.position.size(), result.mesh.triangles).count, pieces) << gap;
        EXPECT_EQ(enclosesOrigin(result.mesh), pieces == 1) << gap;
        anatomy.voidsFilledIn(result);
    }
}

// Every particle moves radially away from a point, like liquid around a growing bubble.
TEST(Voids, ThatGrowAreFilledUntilTheirEmptyBallReachesTheGap) {
    const Particles block = blockWithout(15, 0.2, [](const Vec3& p) { return (p - Vec3(7)).length() > 7; });
    const double gap = 5;
    std::vector<int> first_kept;
    for (const double radius : {1.1, 1.5, 2.0}) {
        int kept = -1;
        for (int frame = 0; frame < 60; ++frame) {
            const double a = 0.08 * frame;
            Particles particles;
            for (const Vec3f& p : block.position) {
                const Vec3 offset = Vec3(p) - Vec3(7.03, 6.98, 7.01);
                const double r = offset.length();
                particles.position.emplace_back(offset * (std::cbrt(r * r * r + a * a * a) / r));
            }
            double room = 0;
            for (int i = 0; i < 4000; ++i) {
                const Vec3 near_middle = Random(9, static_cast<std::uint64_t>(i)).ball() * 1.2;
                room = std::max(room, distanceToNearest(particles, near_middle));
            }
            const bool is_void = !enclosesOrigin(filled(particles, radius, gap).mesh);
            if (is_void && kept < 0) kept = frame;
            EXPECT_EQ(is_void, kept >= 0) << "radius " << radius << ", frame " << frame;
            if (room > gap / 2) {
                EXPECT_TRUE(is_void) << "radius " << radius << ", frame " << frame;
            }
            if (room < gap / 2 - 0.1) {
                EXPECT_FALSE(is_void) << "radius " << radius << ", frame " << frame;
            }
        }
        first_kept.push_back(kept);
    }
    EXPECT_GT(first_kept[0], 0);
    EXPECT_EQ(first_kept, std::vector<int>(3, first_kept[0]));
}

TEST(Voids, AreFilledOneByOneAndNothingElseChanges) {
    const std::vector<std::pair<Vec3, double>> holes{
        {{7, 7, 7}, 2.1}, {{7, 7, 21}, 2.6}, {{7, 21, 7}, 3.2}, {{21, 7, 7}, 4.2}, {{20, 20, 19}, 6.2}};
    const Particles cheese = blockWithout(29, 0.05, [&](const Vec3& p) {
        return std::any_of(holes.begin(), holes.end(), [&](const auto& hole) {
            return (p - hole.first).length() < hole.second && p != holes.back().first;
        });
    });
    const double radius = 1.5;
    const Tessellated made = tessellated(cheese, radius);
    const Anatomy anatomy(asMesh(BetaMesh(made.mesh)), radius);
    ASSERT_EQ(anatomy.pieces.count, 7u);
    for (const auto& [gap, count] : {std::pair(3.2, 0u), {4.95, 1u}, {5.8, 2u}, {7.3, 4u}, {9.0, 5u}}) {
        SCOPED_TRACE(gap);
        const Filled result = filled(made, gap);
        EXPECT_EQ(anatomy.voidsFilledIn(result).size(), count);
    }
}

TEST(Voids, AgreeWithBruteForceSearchForEmptyBalls) {
    Searched found;
    const auto check = [&](const Cloud& cloud, Appearance appearance) {
        searchEmptyBalls(cloud, std::vector<double>(cloud.particles.size(), cloud.radius), appearance, found);
    };
    forEveryCloud(300, [&](const Cloud& cloud) {
        if (cloud.particles.size() == 0 || cloud.particles.size() > 400) return;
        for (const Appearance appearance : {Appearance::on_boundary, Appearance::gradual}) check(cloud, appearance);
    });
    for (std::uint64_t seed = 0; seed < 80 && !testing::Test::HasFailure(); ++seed) {
        const Cloud cloud = crowdedBox(seed);
        SCOPED_TRACE(cloud.name);
        check(cloud, Appearance::gradual);
    }
    EXPECT_GT(std::min(found.kept, found.gone), 300u);
    EXPECT_GT(found.with_drops, 30u);
}

TEST(Voids, AgreeWithBruteForceSearchForEmptyBallsBetweenBallsOfDifferentRadii) {
    Searched found;
    const auto check = [&](const Cloud& cloud, std::uint64_t seed, Appearance appearance) {
        std::vector<double> radii;
        for (std::size_t i = 0; i < cloud.particles.size(); ++i) {
            const double u = Random(seed + i).unit();
            radii.push_back(cloud.radius * (seed % 3 == 0   ? (u < 0.5 ? 1 : 0.6)
                                            : seed % 3 == 1 ? (u < 0.7 ? 1 : std::pow(20, -u))
                                                            : 0.7 + 0.5 * u));
        }
        searchEmptyBalls(cloud, radii, appearance, found);
    };
    std::uint64_t seed = 0;
    forEveryCloud(200, [&](const Cloud& cloud) {
        if (cloud.particles.size() == 0 || cloud.particles.size() > 400) return;
        ++seed;
        check(cloud, seed, seed % 2 == 0 ? Appearance::on_boundary : Appearance::gradual);
    });
    for (std::uint64_t box = 0; box < 60 && !testing::Test::HasFailure(); ++box) {
        const Cloud cloud = crowdedBox(box);
        SCOPED_TRACE(cloud.name);
        check(cloud, box, Appearance::gradual);
    }
    EXPECT_GT(std::min(found.kept, found.gone), 200u);
    EXPECT_GT(found.with_drops, 20u);
}

TEST(Voids, AreTheSameForEveryParticleOrderAndThreadCount) {
    std::set<std::size_t> counts;
    for (std::uint64_t seed = 0; seed < 12; ++seed) {
        Random random(seed);
        Particles particles;
        for (std::uint64_t i = 0; i < 1500; ++i) particles.position.emplace_back(random.cube() * 5.8);
        const double radius = random.between(0.85, 1.2);
        for (const double gap : {2.2 * radius, 2.5 * radius, 3 * radius}) {
            const Filled one = filled(particles, radius, gap);
            Filled other;
            withThreads(1, [&] { other = filled(shuffled(particles, seed + 5), radius, gap); });
            EXPECT_EQ(one.mesh.position, other.mesh.position);
            EXPECT_EQ(one.mesh.triangles, other.mesh.triangles);
            EXPECT_EQ(one.count, other.count);
            counts.insert(one.count);
        }
    }
    EXPECT_GT(counts.size(), 5u);
}

TEST(Voids, AreFilledInWholeFrames) {
    const Particles hollow = shell(2.5);
    for (const auto& [gap, count] : {std::pair(4.9, 0u), {5.1, 1u}}) {
        SkinParams params;
        params.radius = 1.5;
        params.features = gapOf(gap);
        const SkinnedFrame frame = skinFrame(hollow, params);
        EXPECT_EQ(frame.report.bubbles_filled, count);
        EXPECT_EQ(componentsOf(frame.mesh.position.size(), frame.mesh.triangles).count, 2 - count);
    }
}

TEST(Voids, WithManyDropsAreFilledWithAllOfThem) {
    const Particles hollow = shell(30, 0.8, 1);
    Particles particles = hollow;
    for (int z = -10; z <= 10; ++z)
        for (int y = -10; y <= 10; ++y)
            for (int x = -10; x <= 10; ++x)
                if (Vec3(x, y, z).length() < 9.5) particles.position.emplace_back(Vec3(x, y, z) * 2.9);
    const Tessellated made = tessellated(particles, 1.2, Appearance::gradual, 0.7);
    const std::uint32_t pieces = componentsOf(made.mesh.vertex.size(), made.mesh.triangles).count;
    EXPECT_GT(pieces, 2000u);
    const Filled kept = filled(made, 4.5), full = filled(made, 9);
    EXPECT_EQ(componentsOf(kept.mesh.position.size(), kept.mesh.triangles).count, pieces);
    EXPECT_EQ(full.count, 1u);
    EXPECT_EQ(componentsOf(full.mesh.position.size(), full.mesh.triangles).count, 1u);
}

}  // namespace betamesh
