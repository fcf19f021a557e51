// Properties of the boundary of balls of different radii.

#include "base/icosphere.h"
#include "base/random.h"
#include "base/union_find.h"
#include "betamesh/check.h"
#include "betamesh/error.h"
#include "exact/neighbour_finder.h"
#include "skin/arcs.h"
#include "skin/ball_boundary.h"
#include "skin/constants.h"
#include "skin/coverage.h"
#include "skin/face_points.h"
#include "skin/faces.h"
#include "skin/features.h"
#include "skin/narrow_gaps.h"
#include "skin/outer_boundary.h"
#include "skin/retract.h"
#include "skin/self_intersections.h"
#include "skin/skin_smoothing.h"
#include "skin/stage_settings.h"
#include "skin/tessellate.h"
#include "skin/velocity.h"
#include "skin/walls.h"
#include "support/clouds.h"
#include "support/oracles.h"

#include <gtest/gtest.h>

#include <cmath>

namespace betamesh {

namespace {

struct UnequalCloud {
    std::string name;
    Particles particles;
    std::vector<double> radius;  // of each ball
};

BallBoundary boundaryOf(const SnappedParticles& snapped) {
    BallBoundary boundary = ballBoundary(snapped, exposureCandidates(snapped));
    groupFaces(snapped, boundary);
    return boundary;
}

TriangleSet trianglesOfRows(const BallBoundary& boundary) {
    std::vector<Triangle> triangles;
    for (const Triangle& t : boundary.triangle)
        triangles.push_back({boundary.row[t[0]], boundary.row[t[1]], boundary.row[t[2]]});
    return canonical(triangles);
}

void forEveryUnequalCloud(std::uint64_t random_clouds, const std::function<void(const UnequalCloud&)>& check) {
    std::uint64_t seed = 0;
    forEveryCloud(random_clouds, [&](const Cloud& cloud) {
        if (cloud.particles.size() == 0 || cloud.particles.size() > 400) return;
        for (const RadiusPattern pattern : kRadiusPatterns) {
            if (testing::Test::HasFailure()) return;
            SCOPED_TRACE(testing::Message() << "radii " << static_cast<int>(pattern));
            check({cloud.name, cloud.particles, radiiFor(cloud, pattern, ++seed)});
        }
    });
}

/// A cloud of grid points with radii of half-integers: nearly every predicate is a tie, balls touch from inside and
/// outside, and centres coincide.
UnequalCloud tiedCloud(std::uint64_t seed) {
    UnequalCloud cloud;
    cloud.name = "seed " + std::to_string(seed);
    std::uint64_t state = seed * 7919 + 17;
    const auto next = [&](std::uint64_t below) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        return (state >> 33) % below;
    };
    const std::uint64_t count = 4 + next(6), side = 2 + next(3), flat = 1 + next(2), sizes = 2 + next(3);
    constexpr double kRadii[] = {1.0, 0.5, 1.5, 2.0, 2.5, 0.25};
    const std::uint64_t first = next(3);
    for (std::uint64_t i = 0; i < count; ++i) {
        cloud.particles.position.emplace_back(static_cast<float>(next(side)), static_cast<float>(next(side)),
                                              static_cast<float>(next(flat)));
        cloud.radius.push_back(kRadii[first + next(std::min<std::uint64_t>(sizes, 6 - first))]);
    }
    return cloud;
}

struct Tessellated {
    BallBoundary boundary;
    Mesh mesh;
};

Tessellated tessellated(const UnequalCloud& cloud, Appearance appearance, double angle) {
    const SnappedParticles snapped = snapParticles(cloud.particles, cloud.radius);
    const Icosphere directions = icosphereOf(angle);
    BallBoundary boundary = ballBoundary(snapped, exposureCandidates(snapped), directions.position);
    groupFaces(snapped, boundary);
    const std::vector<DualVec3> balls = ballCentres(boundary, cloud.particles);
    const ArcSubdivision subdivision{angle, 0, appearance};
    const ArcNetwork network =
        arcPoints(boundary, balls, boundaryVertices(cloud.particles, snapped, boundary, balls), subdivision);
    Mesh mesh = asMesh(
        completeTessellation(boundary, balls, network, facePoints(snapped, boundary, balls, directions), subdivision));
    return {std::move(boundary), std::move(mesh)};
}

/// The smoothed skin, with the default's lengths, laid against walls. spacing: of the particles with the largest balls;
/// their radius is 1.5 times that.
Mesh skinned(const UnequalCloud& cloud, double spacing, const std::vector<Wall>& walls = {}) {
    const SnappedParticles snapped = snapParticles(cloud.particles, cloud.radius);
    SkinParams params;
    params.radius = 1.5 * spacing;
    params.spacing = spacing;
    Icosphere directions = faceDirections(params);
    BallBoundary boundary = ballBoundary(snapped, exposureCandidates(snapped), directions.position);
    groupFaces(snapped, boundary);
    const std::vector<DualVec3> balls = ballCentres(boundary, cloud.particles);
    const ArcSubdivision subdivision = arcSubdivision(params);
    OuterSamples outer = outerSamples(cloud.particles, snapped, boundary, skinLengths(params), spacing);
    ArcNetwork network =
        arcPoints(boundary, balls, boundaryVertices(cloud.particles, snapped, boundary, balls), subdivision);
    FacePoints points = facePoints(snapped, boundary, balls, std::move(directions));
    addNarrowGaps(boundary, balls, network, points, skinLengths(params), spacing, outer);
    BetaMesh mesh = completeTessellation(boundary, balls, std::move(network), std::move(points), subdivision);
    mesh.rim_distance.clear();
    DeformingMesh surface(mesh, spacing);
    retract(outer, skinLengths(params), surface);
    const DualPoints on_balls = dualPoints(mesh.vertex);
    surface.writePositions();
    const DualPoints retracted = dualPoints(mesh.vertex);
    smoothSkin(surface, widestSkinFit(params), farthestSkinSmoothing(params), 1);
    surface.writePositions();
    if (resolveSelfIntersections(boundary, retracted, mesh, true, false) > 0)
        resolveSelfIntersections(boundary, on_balls, mesh, true);
    if (!walls.empty()) layAgainstWalls(walls, spacing, boundary, mesh);
    return asMesh(std::move(mesh));
}

double volumeOf(const Mesh& mesh) {
    double volume = 0;
    for (const auto& [a, b, c] : mesh.triangles)
        volume += dot(mesh.position[a], cross(mesh.position[b], mesh.position[c])) / 6;
    return volume;
}

/// Adds a block of particles with this spacing, `side` wide, from a corner on.
void addBlock(const Vec3& corner, double spacing, double side, double jitter, UnequalCloud& cloud) {
    Random random(cloud.radius.size());
    const int n = static_cast<int>(std::lround(side / spacing));
    for (int z = 0; z < n; ++z)
        for (int y = 0; y < n; ++y)
            for (int x = 0; x < n; ++x) {
                cloud.particles.position.emplace_back(corner +
                                                      (Vec3(x, y, z) + Vec3(0.5) + random.cube() * jitter) * spacing);
                cloud.radius.push_back(1.5 * spacing);
            }
}

void expectAClosedManifoldWithoutCrossings(const UnequalCloud& cloud) {
    for (const Appearance appearance : {Appearance::on_boundary, Appearance::gradual}) {
        const Tessellated made = tessellated(cloud, appearance, 0.25);
        CheckParams params;
        params.tolerance = 1e-6 * made.boundary.worldRadius();
        const MeshCheck check = checkMesh(made.mesh, params);
        EXPECT_EQ(check.open_edges.count, 0U);
        EXPECT_EQ(check.misoriented_edges.count, 0U);
        EXPECT_EQ(check.nonmanifold_edges.count, 0U);
        EXPECT_EQ(check.nonmanifold_vertices.count, 0U);
        EXPECT_EQ(check.repeated_vertices.count, 0U);
        EXPECT_EQ(check.euler, eulerCharacteristic(made.boundary));
        EXPECT_EQ(check.crossings.count, 0U) << "the deepest: " << check.deepest / made.boundary.worldRadius();
    }
}

}  // namespace

TEST(UnequalBalls, TiesAreBrokenAsForSlightlyDifferentRadii) {
    std::size_t triangles = 0;
    for (std::uint64_t seed = 0; seed < 600 && !testing::Test::HasFailure(); ++seed) {
        const UnequalCloud cloud = tiedCloud(seed);
        SCOPED_TRACE(cloud.name);
        const SnappedParticles snapped = snapParticles(cloud.particles, cloud.radius);
        const TriangleSet found = trianglesOfRows(boundaryOf(snapped));
        EXPECT_EQ(found, perturbedAlphaTriangles(snapped));
        triangles += found.size();
    }
    EXPECT_GT(triangles, 1000U);
}

TEST(UnequalBalls, AgreeWithBruteForceTriangleForTriangle) {
    forEveryUnequalCloud(500, [](const UnequalCloud& cloud) {
        if (cloud.particles.size() > 60) return;
        const SnappedParticles snapped = snapParticles(cloud.particles, cloud.radius);
        EXPECT_EQ(trianglesOfRows(boundaryOf(snapped)), bruteForceAlphaTriangles(snapped));
    });
}

/// Compares the neighbours of every ball with those that brute force finds.
void expectAllNeighbours(const SnappedParticles& snapped) {
    NeighbourFinder finder(snapped);
    std::vector<Neighbour> found;
    for (std::uint32_t i = 0; i < snapped.size(); ++i) {
        finder.find(i, found);
        std::size_t next = 0;
        for (std::uint32_t other = 0; other < snapped.size(); ++other) {
            const Vec3i offset = snapped.position[other] - snapped.position[i];
            const std::int64_t sum = snapped.radiusOf(i) + snapped.radiusOf(other),
                               difference = snapped.radiusOf(i) - snapped.radiusOf(other);
            const bool is_inside = difference > 0 && offset.length2() < difference * difference;
            if (other == i || offset.length2() > sum * sum || is_inside) continue;
            ASSERT_LT(next, found.size());
            ASSERT_EQ(found[next].particle, other);
            ASSERT_EQ(Vec3i(found[next].offset), offset);
            ASSERT_EQ(found[next].radius, snapped.radiusOf(other));
            ASSERT_EQ(found[next].power, static_cast<double>(offset.length2() + sum * difference));
            ++next;
        }
        ASSERT_EQ(next, found.size());
    }
}

TEST(UnequalBalls, HaveAllWhoseSpheresMeetTheirsAsNeighbours) {
    forEveryUnequalCloud(150, [](const UnequalCloud& cloud) {
        const SnappedParticles snapped = snapParticles(cloud.particles, cloud.radius);
        if (!snapped.radius_of.empty()) expectAllNeighbours(snapped);
    });
}

// Cells with many balls are divided, and a few are far away.
TEST(UnequalBalls, HaveAllTheirNeighboursWhereManyMeet) {
    Random random(3);
    for (const double least : {0.9, 0.4, 0.05}) {
        Particles particles;
        std::vector<double> radius;
        for (int i = 0; i < 1200; ++i) {
            const Vec3 at(random.between(-2, 2), random.between(-2, 2), random.between(-2, 2));
            particles.position.emplace_back(i % 100 == 0 ? at * 500 : at);
            radius.push_back(random.between(least, 1));
        }
        expectAllNeighbours(snapParticles(particles, radius));
    }
}

// As where a simulation refines most of a liquid: very many small balls fit into the space of a large one.
TEST(UnequalBalls, MayBeManyInTheSpaceOfALargeOne) {
    constexpr int kSide = 56;
    Particles particles;
    std::vector<double> radius;
    for (int i = 0; i < kSide * kSide * kSide; ++i) {
        particles.position.emplace_back(Vec3f(static_cast<float>(i % kSide), static_cast<float>(i / kSide % kSide),
                                              static_cast<float>(i / (kSide * kSide))));
        radius.push_back(1.5);
    }
    EXPECT_THROW(snapParticles(particles, 30), Error);
    radius.front() = 30;
    EXPECT_EQ(snapParticles(particles, radius).size(), particles.size());
}

TEST(UnequalBalls, AreConnectedWhereTheyMeetOrContainEachOther) {
    std::size_t left_out = 0;
    forEveryUnequalCloud(150, [&](const UnequalCloud& cloud) {
        constexpr std::size_t kLeast = 4;
        const SnappedParticles snapped = snapParticles(cloud.particles, cloud.radius);
        UnionFind groups(snapped.size());
        for (std::uint32_t i = 0; i < snapped.size(); ++i)
            for (std::uint32_t k = 0; k < i; ++k) {
                const std::int64_t sum = snapped.radiusOf(i) + snapped.radiusOf(k);
                if ((snapped.position[i] - snapped.position[k]).length2() <= sum * sum) groups.join(i, k);
            }
        std::vector<std::size_t> size(snapped.size(), 0);
        for (std::uint32_t i = 0; i < snapped.size(); ++i) ++size[groups.find(i)];
        std::vector<std::uint32_t> expected;
        for (std::uint32_t i = 0; i < snapped.size(); ++i)
            if (size[groups.find(i)] < kLeast) expected.push_back(i);
        const SmallComponents small = smallComponents(snapped, kLeast);
        EXPECT_EQ(small.particle, expected);
        left_out += expected.size();

        const SnappedParticles rest = withoutRows(snapped, expected);
        ASSERT_EQ(rest.size(), snapped.size() - expected.size());
        for (std::size_t i = 0; i < rest.size(); ++i)
            EXPECT_EQ(static_cast<double>(rest.radiusOf(i)), std::round(cloud.radius[rest.row[i]] / rest.quantum));
    });
    EXPECT_GT(left_out, 1000U);
}

TEST(UnequalBalls, OfOneRadiusAreThoseOfThatRadius) {
    forEveryCloud(100, [](const Cloud& cloud) {
        const SnappedParticles one = snapParticles(cloud.particles, cloud.radius);
        const SnappedParticles each =
            snapParticles(cloud.particles, std::vector<double>(cloud.particles.size(), cloud.radius));
        EXPECT_EQ(one.position, each.position);
        EXPECT_EQ(one.row, each.row);
        EXPECT_TRUE(each.radius_of.empty());
    });
}

TEST(UnequalBalls, ArcsPairUpAndEveryComponentIsAClosedSurface) {
    const auto check = [](const UnequalCloud& cloud) {
        const SnappedParticles snapped = snapParticles(cloud.particles, cloud.radius);
        const BallBoundary boundary = boundaryOf(snapped);
        for (std::uint32_t h = 0; h < boundary.twin.size(); ++h) {
            const std::uint32_t t = boundary.twin[h];
            ASSERT_EQ(boundary.twin[t], h);
            ASSERT_EQ(boundary.triangle[h / 3][h % 3], boundary.triangle[t / 3][(t + 1) % 3]);
        }
        ASSERT_EQ(boundary.cycle.item.size(), boundary.twin.size());
        for (std::size_t c = 0; c < boundary.cycle.size(); ++c)
            for (const std::uint32_t h : boundary.cycle[c])
                ASSERT_EQ(boundary.triangle[h / 3][h % 3],
                          boundary.triangle[boundary.cycle[c][0] / 3][boundary.cycle[c][0] % 3]);
        expectClosedSurfaces(boundary);
    };
    forEveryUnequalCloud(600, check);
    for (std::uint64_t seed = 0; seed < 2000 && !testing::Test::HasFailure(); ++seed) {
        SCOPED_TRACE("tied cloud " + std::to_string(seed));
        check(tiedCloud(seed));
    }
}

TEST(UnequalBalls, VerticesAreOnThreeSpheresAndInsideNone) {
    forEveryUnequalCloud(200, [](const UnequalCloud& cloud) {
        const SnappedParticles snapped = snapParticles(cloud.particles, cloud.radius);
        const BallBoundary boundary = boundaryOf(snapped);
        for (std::size_t v = 0; v < boundary.vertex.size(); ++v)
            for (std::uint32_t p = 0; p < snapped.size(); ++p) {
                const double distance = (boundary.vertex[v] - toDouble(snapped.position[p]) * snapped.quantum).length();
                EXPECT_GE(distance, static_cast<double>(snapped.radiusOf(p)) * snapped.quantum * (1 - 1e-6) -
                                        1e-6 * boundary.worldRadius());
            }
    });
}

TEST(UnequalBalls, AreExposedWhereNoOtherBallCoversThem) {
    constexpr double kInDoubt = 2e-5;  // of cosines in single precision
    const std::vector<Vec3> directions = icosphere(3).position;
    std::size_t exposed = 0, covered = 0;
    forEveryUnequalCloud(300, [&](const UnequalCloud& cloud) {
        if (cloud.particles.size() > 200) return;
        const SnappedParticles snapped = snapParticles(cloud.particles, cloud.radius);
        const BallBoundary boundary = ballBoundary(snapped, exposureCandidates(snapped), directions);
        ASSERT_EQ(boundary.exposed.size(), boundary.position.size());
        for (std::size_t b = 0; b < boundary.position.size(); ++b) {
            std::span<const ExposedDirection> listed = boundary.exposed[b];
            const auto own = static_cast<double>(boundary.radiusOf(b));
            for (std::uint32_t d = 0; d < directions.size(); ++d) {
                double least = 1;  // cos α - cos β, of caps of half-angle α that the direction is at β from
                for (std::uint32_t p = 0; p < snapped.size(); ++p) {
                    const Vec3 offset = toDouble(snapped.position[p] - boundary.position[b]);
                    const double distance = offset.length(), radius = static_cast<double>(snapped.radiusOf(p));
                    if (distance == 0 || distance > own + radius || distance < own - radius) continue;
                    const double cosine = (distance * distance + own * own - radius * radius) / (2 * distance * own);
                    const bool is_negligible = 1 - cosine * cosine < 1e-8;
                    if (is_negligible && cosine > 0) continue;    // hides next to nothing
                    if (is_negligible && cosine < 0) least = -1;  // hides next to everything
                    least = std::min(least, cosine - dot(offset, directions[d]) / distance);
                }
                const bool is_listed = !listed.empty() && listed.front().direction == d;
                if (std::abs(least) > kInDoubt) {
                    ASSERT_EQ(is_listed, least > 0) << "ball " << b;
                }
                is_listed ? ++exposed : ++covered;
                if (is_listed) listed = listed.subspan(1);
            }
            ASSERT_TRUE(listed.empty()) << "ball " << b;
        }
    });
    EXPECT_GT(exposed, 10000U);
    EXPECT_GT(covered, 10000U);
}

TEST(UnequalBalls, AreMeshedClosedAndWithoutCrossings) {
    forEveryUnequalCloud(25, expectAClosedManifoldWithoutCrossings);
    for (std::uint64_t seed = 0; seed < 40 && !testing::Test::HasFailure(); ++seed) {
        SCOPED_TRACE("tied cloud " + std::to_string(seed));
        expectAClosedManifoldWithoutCrossings(tiedCloud(seed));
    }
}

TEST(UnequalBalls, AreMeshedWithTheVolumeOfTheirUnion) {
    for (std::uint64_t seed = 0; seed < 12; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        UnequalCloud cloud;
        for (int i = 0; i < 12; ++i) {
            cloud.particles.position.emplace_back(random.cube());
            cloud.radius.push_back(random.between(0.05, 1));
        }
        const Mesh mesh = tessellated(cloud, Appearance::on_boundary, 0.05).mesh;
        const double volume = volumeOf(mesh);
        constexpr int kPoints = 1000000;
        int inside = 0;
        for (int i = 0; i < kPoints; ++i) {
            const Vec3 point = random.cube() * 2;
            for (std::size_t b = 0; b < cloud.radius.size(); ++b)
                if ((point - Vec3(cloud.particles.position[b])).length() < cloud.radius[b]) {
                    ++inside;
                    break;
                }
        }
        const double expected = 64.0 * inside / kPoints;
        EXPECT_NEAR(volume, expected, 0.02 * expected);
    }
}

TEST(UnequalBalls, HaveASkinThatIsClosedAndWithoutCrossings) {
    std::size_t crossing = 0, clouds = 0;
    const auto check = [&](const UnequalCloud& cloud) {
        if (cloud.particles.size() > 100) return;                 // takes too long
        if (cloud.name.ends_with("far from the origin")) return;  // floats round by much of the smallest balls' skin
        const double largest = *std::max_element(cloud.radius.begin(), cloud.radius.end());
        const MeshCheck found = checkMesh(skinned(cloud, largest / 1.5), CheckParams{});
        EXPECT_EQ(found.open_edges.count, 0U);
        EXPECT_EQ(found.misoriented_edges.count, 0U);
        EXPECT_EQ(found.nonmanifold_edges.count, 0U);
        EXPECT_EQ(found.nonmanifold_vertices.count, 0U);
        EXPECT_LE(found.deepest, 1e-5 * largest);
        crossing += found.crossings.count > 0;
        ++clouds;
    };
    forEveryUnequalCloud(10, check);
    for (std::uint64_t seed = 0; seed < 100 && !testing::Test::HasFailure(); ++seed) {
        SCOPED_TRACE("tied cloud " + std::to_string(seed));
        check(tiedCloud(seed));
    }
    EXPECT_LE(crossing, clouds / 200) << "of " << clouds << " clouds";  // where balls touch in exactly one point
}

// Two blocks far from each other, each with the volume of its liquid.
TEST(UnequalBalls, HaveASkinAtTheDistanceOfTheirSize) {
    for (const double fine : {1.0, 0.5, 0.25}) {
        SCOPED_TRACE("spacing " + std::to_string(fine));
        UnequalCloud cloud;
        addBlock(Vec3(0), 1, 10, 0.1, cloud);
        const double alone = volumeOf(skinned(cloud, 1));
        addBlock(Vec3(40, 0, 0), fine, 10 * fine, 0.1, cloud);
        const double both = volumeOf(skinned(cloud, 1));
        EXPECT_NEAR(alone / 1000, 1.01, 0.03);
        EXPECT_NEAR((both - alone) / (1000 * fine * fine * fine), 1.01, 0.03);
    }
}

// A fine and a coarse block, far from each other, on the floor: lengths near a wall are those of the particles there.
TEST(UnequalBalls, AreLaidAgainstWallsWithinTheirSize) {
    constexpr double kFine = 0.25, kSide = 10;
    UnequalCloud cloud;
    addBlock(Vec3(0), 1, kSide, 0.25, cloud);
    addBlock(Vec3(40, 0, 0), kFine, kFine * kSide, 0.25, cloud);
    const Mesh free = skinned(cloud, 1), mesh = skinned(cloud, 1, {{Vec3(0, 0, -1), 0}});
    ASSERT_EQ(mesh.triangles, free.triangles);
    std::array<std::size_t, 2> on_wall{}, unmoved{};
    double farthest_free = 0;
    for (std::size_t v = 0; v < free.position.size(); ++v) {
        const bool is_fine = free.position[v].x > 30;
        const double spacing = is_fine ? kFine : 1;
        const Vec3 at = (free.position[v] - Vec3(is_fine ? 40 : 0, 0, 0)) / spacing;  // in the block's own spacings
        if (at.z > 2) {
            EXPECT_EQ(mesh.position[v], free.position[v]);
            ++unmoved[is_fine];
        }
        if (at.z > 1 || std::min(at.x, at.y) < 3 || std::max(at.x, at.y) > kSide - 3) continue;
        EXPECT_LE(std::abs(mesh.position[v].z), 0.01 * spacing);
        if (is_fine) farthest_free = std::max(farthest_free, std::abs(at.z));
        ++on_wall[is_fine];
    }
    EXPECT_GE(farthest_free, 0.05);
    for (const std::size_t kind : {0U, 1U}) {
        EXPECT_GT(on_wall[kind], 50U);
        EXPECT_GT(unmoved[kind], 500U);
    }
}

// Coarse and fine particles side by side, with one surface around both.
TEST(UnequalBalls, OfABlockThatIsCoarseOnOneSideEncloseItsVolume) {
    UnequalCloud cloud;
    addBlock(Vec3(0), 1, 12, 0.1, cloud);
    addBlock(Vec3(12, 0, 0), 0.25, 12, 0.1, cloud);
    const Mesh mesh = skinned(cloud, 1);
    EXPECT_NEAR(volumeOf(mesh) / (2 * 12 * 12 * 12), 1.01, 0.03);
}

}  // namespace betamesh
