// Properties of the ball boundary of every cloud.

#include "skin/ball_boundary.h"
#include "base/icosphere.h"
#include "base/random.h"
#include "betamesh/check.h"
#include "exact/neighbour_finder.h"
#include "skin/alpha_mesh.h"
#include "skin/coverage.h"
#include "skin/exposed_region.h"
#include "skin/face_points.h"
#include "skin/faces.h"
#include "support/clouds.h"
#include "support/oracles.h"

#include <gtest/gtest.h>

#include <map>
#include <numeric>
#include <random>

namespace betamesh {

namespace {

constexpr std::uint64_t kRandomClouds = 3000;

BallBoundary boundaryOf(const Particles& particles, double radius) {
    const SnappedParticles snapped = snapParticles(particles, radius);
    BallBoundary boundary = ballBoundary(snapped, exposureCandidates(snapped));
    groupFaces(snapped, boundary);
    return boundary;
}

std::vector<Triangle> trianglesOfRows(const BallBoundary& boundary) {
    std::vector<Triangle> triangles;
    for (const Triangle& t : boundary.triangle)
        triangles.push_back({boundary.row[t[0]], boundary.row[t[1]], boundary.row[t[2]]});
    return triangles;
}

void expectEveryEdgePaired(const std::vector<Triangle>& triangles) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> surplus;
    for (const Triangle& t : triangles)
        for (std::size_t m = 0; m < 3; ++m) {
            const std::uint32_t a = t[m], b = t[(m + 1) % 3];
            surplus[std::minmax(a, b)] += a < b ? 1 : -1;
        }
    for (const auto& [edge, count] : surplus)
        ASSERT_EQ(count, 0) << "edge " << edge.first << " - " << edge.second << " has no opposite";
}

// Particles within one radius (1) of each other.
Particles hugeCrowd() {
    constexpr std::size_t kParticles = 12000;
    Particles particles;
    for (std::size_t i = 0; i < kParticles; ++i) particles.position.push_back(Vec3f(Random(5, i).ball() * 0.4));
    return particles;
}

}  // namespace

TEST(BallBoundary, EveryOrientedEdgeOfTheAlphaMeshHasItsOpposite) {
    forEveryCloud(kRandomClouds, [](const Cloud& cloud) {
        expectEveryEdgePaired(trianglesOfRows(boundaryOf(cloud.particles, cloud.radius)));
    });
}

TEST(BallBoundary, AgreesWithBruteForceTriangleForTriangle) {
    forEveryCloud(kRandomClouds / 3, [](const Cloud& cloud) {
        if (cloud.particles.size() > 80) return;
        EXPECT_EQ(canonical(trianglesOfRows(boundaryOf(cloud.particles, cloud.radius))),
                  bruteForceAlphaTriangles(snapParticles(cloud.particles, cloud.radius)));
    });
}

TEST(BallBoundary, DirectionsAreExposedWhereNoOtherBallCoversThem) {
    constexpr double kInDoubt = 1e-5;  // of cosines in single precision
    const std::vector<Vec3> directions = icosphere(3).position;
    std::size_t exposed = 0, covered = 0;
    forEveryCloud(kRandomClouds / 3, [&](const Cloud& cloud) {
        if (cloud.particles.size() > 200) return;
        const SnappedParticles snapped = snapParticles(cloud.particles, cloud.radius);
        const BallBoundary boundary = ballBoundary(snapped, exposureCandidates(snapped), directions);
        const auto diameter = 2 * static_cast<double>(snapped.radius);
        ASSERT_EQ(boundary.exposed.size(), boundary.position.size());
        for (std::size_t b = 0; b < boundary.position.size(); ++b) {
            std::span<const ExposedDirection> listed = boundary.exposed[b];
            for (std::uint32_t d = 0; d < directions.size(); ++d) {
                double least = kMaxRimDistance;  // rim_distance, by its definition
                double least_of_cosines = 1;     // cos α - cos β
                for (const Vec3i& position : snapped.position) {
                    const Vec3 offset = toDouble(position - boundary.position[b]);
                    const double distance = offset.length(), cosine = distance / diameter;
                    if (distance == 0 || distance > diameter) continue;
                    const double sine = std::sqrt(1 - cosine * cosine);
                    if (sine < 1e-4) continue;  // hides next to nothing
                    const double apart = cosine - dot(offset, directions[d]) / distance;
                    least_of_cosines = std::min(least_of_cosines, apart);
                    least = std::min(least, apart / (sine * std::min(1.0, sine / kWideCapSine)));
                }
                const bool is_listed = !listed.empty() && listed.front().direction == d;
                if (std::abs(least_of_cosines) > kInDoubt) {
                    ASSERT_EQ(is_listed, least_of_cosines > 0) << cloud.name << ", ball " << b;
                }
                is_listed ? ++exposed : ++covered;
                if (!is_listed) continue;
                const double rounding = least * kInDoubt / std::max(least_of_cosines, kInDoubt);
                EXPECT_NEAR(listed.front().rim_distance, least, 1e-3 + rounding) << cloud.name << ", ball " << b;
                listed = listed.subspan(1);
            }
            ASSERT_TRUE(listed.empty()) << cloud.name << ", ball " << b;
        }
    });
    EXPECT_GT(exposed, 10000u);
    EXPECT_GT(covered, 10000u);
}

TEST(BallBoundary, TiesAreBrokenAsForSlightlyDifferentRadii) {
    // points of small grids: nearly every predicate is a tie
    const auto compare = [](const Particles& particles, double radius) {
        EXPECT_EQ(canonical(trianglesOfRows(boundaryOf(particles, radius))),
                  perturbedAlphaTriangles(snapParticles(particles, radius)));
    };
    for (std::uint64_t seed = 0; seed < 150 && !testing::Test::HasFailure(); ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        std::uint64_t state = seed * 7919 + 17;
        const auto next = [&](std::uint64_t below) {
            state = state * 6364136223846793005u + 1442695040888963407u;
            return (state >> 33) % below;
        };
        const std::uint64_t count = 4 + next(6), side = 2 + next(3);
        Particles particles;
        for (std::uint64_t i = 0; i < count; ++i)
            particles.position.emplace_back(static_cast<float>(next(side)), static_cast<float>(next(side)),
                                            static_cast<float>(next(2)));
        constexpr double kRadii[] = {0.5, 1.0, 1.5, 1.25, 2.0, 0.75};
        compare(particles, kRadii[next(6)]);
    }
    Particles pythagoras;  // circles of radius 5 through many whole-numbered points
    for (const auto& [x, y] : {std::pair{5, 0}, {3, 4}, {4, 3}, {0, 5}, {-3, 4}, {-5, 0}, {0, -5}, {4, -3}})
        pythagoras.position.emplace_back(static_cast<float>(x), static_cast<float>(y), 0.0f);
    compare(pythagoras, 5.0);
    compare(pythagoras, 6.0);
}

TEST(BallBoundary, ArcsPairUpAndCyclesCloseOnOneBall) {
    forEveryCloud(kRandomClouds / 3, [](const Cloud& cloud) {
        const BallBoundary boundary = boundaryOf(cloud.particles, cloud.radius);
        ASSERT_EQ(boundary.twin.size(), 3 * boundary.triangle.size());
        for (std::uint32_t h = 0; h < boundary.twin.size(); ++h) {
            const std::uint32_t t = boundary.twin[h];
            ASSERT_EQ(boundary.twin[t], h);
            ASSERT_EQ(boundary.triangle[h / 3][h % 3], boundary.triangle[t / 3][(t + 1) % 3]);
        }
        for (std::size_t c = 0; c < boundary.cycle.size(); ++c) {
            const auto cycle = boundary.cycle[c];
            ASSERT_GE(cycle.size(), 2u);
            for (const std::uint32_t h : cycle)
                ASSERT_EQ(boundary.triangle[h / 3][h % 3], boundary.triangle[cycle[0] / 3][cycle[0] % 3]);
        }
        ASSERT_EQ(boundary.cycle.item.size(), boundary.twin.size());
    });
}

TEST(BallBoundary, EveryComponentIsAClosedSurface) {
    forEveryCloud(kRandomClouds,
                  [](const Cloud& cloud) { expectClosedSurfaces(boundaryOf(cloud.particles, cloud.radius)); });
}

TEST(BallBoundary, VerticesAreOnThreeSpheresAndInsideNone) {
    forEveryCloud(200, [](const Cloud& cloud) {
        const BallBoundary boundary = boundaryOf(cloud.particles, cloud.radius);
        const SnappedParticles snapped = snapParticles(cloud.particles, cloud.radius);
        const double radius = boundary.worldRadius();
        for (std::size_t v = 0; v < boundary.vertex.size(); ++v)
            for (std::uint32_t p = 0; p < snapped.size(); ++p) {
                const double distance = (boundary.vertex[v] - toDouble(snapped.position[p]) * snapped.quantum).length();
                ASSERT_GE(distance, radius * (1 - 1e-5));
                for (const std::uint32_t ball : boundary.triangle[v])
                    if (boundary.snapped_row[ball] == p) {
                        ASSERT_LE(distance, radius * (1 + 1e-5));
                    }
            }
    });
}

TEST(BallBoundary, DoesNotDependOnParticleOrder) {
    forEveryCloud(300, [](const Cloud& cloud) {
        const BallBoundary one = boundaryOf(cloud.particles, cloud.radius);
        const BallBoundary other = boundaryOf(shuffled(cloud.particles, 7), cloud.radius);
        EXPECT_EQ(one.triangle, other.triangle);
        EXPECT_EQ(one.vertex, other.vertex);
        EXPECT_EQ(one.twin, other.twin);
        EXPECT_EQ(one.circle, other.circle);
        EXPECT_EQ(one.isolated, other.isolated);
        EXPECT_EQ(one.face.item, other.face.item);
    });
}

TEST(BallBoundary, IsTheSameWithoutCoveredParticlesOfADenseCell) {
    const Particles crowd = hugeCrowd();
    const BallBoundary all = boundaryOf(crowd, 1);
    std::vector<std::uint32_t> rows = all.row;
    std::sort(rows.begin(), rows.end());
    Particles exposed;
    for (const std::uint32_t row : rows) exposed.position.push_back(crowd.position[row]);
    const BallBoundary some = boundaryOf(exposed, 1);
    EXPECT_EQ(all.triangle, some.triangle);
    EXPECT_LT(exposed.size(), crowd.size() / 10);
}

TEST(BallBoundary, IsClosedWhereThousandsOfSpheresNearlyShareAPoint) {
    constexpr std::size_t kParticles = 8000;
    const BallBoundary boundary = boundaryOf(spiralOnSphere(kParticles, 1.5), 1.5);
    expectEveryEdgePaired(boundary.triangle);
    EXPECT_EQ(boundary.position.size(), kParticles);
}

TEST(NeighbourFinder, SamplesADenseCell) {
    const SnappedParticles snapped = snapParticles(hugeCrowd(), 1);
    NeighbourFinder finder(snapped);
    std::vector<Neighbour> some, all;
    for (std::uint32_t i = 0; i < snapped.size(); i += 97) {
        ASSERT_TRUE(finder.findSomeInDenseCell(i, some) && finder.findInDenseCell(i, all));
        EXPECT_GT(some.size(), 100U);
        EXPECT_LT(some.size(), 1000U);
        for (const Neighbour& n : some)
            EXPECT_TRUE(std::any_of(all.begin(), all.end(), [&](const Neighbour& a) {
                return a.particle == n.particle && a.offset == n.offset && a.power == n.power;
            }));
    }
}

TEST(NeighbourFinder, FindsAllWithinReach) {
    std::size_t in_crowds = 0;
    forEveryCloud(300, [&](const Cloud& cloud) {
        const SnappedParticles snapped = snapParticles(cloud.particles, cloud.radius);
        NeighbourFinder finder(snapped);
        std::vector<Neighbour> found;
        const auto expectAllWithin = [&](std::int64_t radii, std::uint32_t i) {
            const auto reach = static_cast<double>(radii * snapped.radius);
            std::size_t next = 0;
            for (std::uint32_t k = 0; k < snapped.size(); ++k) {
                const Vec3 offset = toDouble(snapped.position[k] - snapped.position[i]);
                if (k == i || offset.length2() > reach * reach) continue;
                ASSERT_LT(next, found.size()) << "of particle " << i;
                ASSERT_EQ(found[next].particle, k) << "of particle " << i;
                ASSERT_EQ(found[next].offset, offset);
                ASSERT_EQ(found[next].power, offset.length2());
                ++next;
            }
            ASSERT_EQ(next, found.size()) << "of particle " << i;
        };
        for (std::uint32_t i = 0; i < snapped.size(); ++i) {
            if (finder.findInDenseCell(i, found)) {
                ++in_crowds;
                expectAllWithin(1, i);
            }
            finder.find(i, found);
            expectAllWithin(2, i);
        }
    });
    EXPECT_GT(in_crowds, 100U);  // which are looked at in parts
}

TEST(ExposedRegion, NamesEveryBallThatClipsIt) {
    const Icosphere sphere = icosphere(5);
    forEveryCloud(1000, [&](const Cloud& cloud) {
        if (cloud.particles.size() > 400) return;
        const SnappedParticles snapped = snapParticles(cloud.particles, cloud.radius);
        const auto radius = static_cast<double>(snapped.radius);
        NeighbourFinder finder(snapped);
        ExposedRegion region;
        std::vector<Neighbour> neighbours;
        for (std::uint32_t i = 0; i < snapped.size(); ++i) {
            finder.find(i, neighbours);
            const bool covered = region.isCoveredBy(neighbours, snapped.radius);
            region.construct(neighbours, snapped.radius);
            for (const Vec3& direction : sphere.position) {
                const Vec3 point = direction * radius;
                const auto hides = [&](const Neighbour& n) {
                    return (point - n.offset).length() < radius * (1 - 1e-9);
                };
                const auto hidesFromAny = [&](const std::vector<Neighbour>& some) {
                    return std::any_of(some.begin(), some.end(), hides);
                };
                const bool exposed = !hidesFromAny(neighbours);
                if (exposed) {
                    ASSERT_TRUE(!region.empty() && !covered) << "particle " << i;
                }
                if (!region.empty()) {
                    ASSERT_EQ(exposed, !hidesFromAny(region.neighbours())) << "particle " << i;
                }
            }
        }
    });
}

TEST(ExposureCandidates, IncludeEveryExposedParticle) {
    forEveryCloud(500, [](const Cloud& cloud) {
        if (cloud.particles.size() > 400) return;  // without the cull, pairs of neighbours are many
        const SnappedParticles snapped = snapParticles(cloud.particles, cloud.radius);
        std::vector<std::uint32_t> all(snapped.size());  // without any cull
        std::iota(all.begin(), all.end(), 0U);
        const BallBoundary fast = ballBoundary(snapped, exposureCandidates(snapped)), slow = ballBoundary(snapped, all);
        EXPECT_EQ(fast.triangle, slow.triangle);
        EXPECT_EQ(fast.circle, slow.circle);
        EXPECT_EQ(fast.isolated, slow.isolated);
    });
}

TEST(BallFaces, ABallBetweenTwoDenseClustersIsExposedInOneRing) {
    std::mt19937 random(17);
    std::uniform_real_distribution<float> apart(0, 0.02F);
    Particles particles;
    particles.position.emplace_back(0, 0, 0);
    for (int i = 0; i < 400; ++i)
        particles.position.emplace_back((i % 2 == 0 ? 1.8F : -1.8F) + apart(random), apart(random), apart(random));
    const SnappedParticles snapped = snapParticles(particles, 1.5);
    BallBoundary boundary = ballBoundary(snapped, exposureCandidates(snapped));
    groupFaces(snapped, boundary);
    std::vector<std::size_t> cycles;  // of each face of the ball between them
    for (std::size_t f = 0; f < boundary.face.size(); ++f)
        if (boundary.row[boundary.face_ball[f]] == 0) cycles.push_back(boundary.face[f].size());
    EXPECT_EQ(cycles, std::vector<std::size_t>{2});
}

// A slab thinner than a cell: every ball reaches into empty cells, and more than half of the balls are deep enough to
// be culled.
TEST(ExposureCandidates, ExcludeMostOfADenseSlabBesideEmptyCells) {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> along(0, 10), across(0, 2);
    Particles slab;
    for (int i = 0; i < 4000; ++i) slab.position.emplace_back(along(random), along(random), across(random));
    const SnappedParticles snapped = snapParticles(slab, 1.5);
    std::vector<std::uint32_t> all(snapped.size());
    std::iota(all.begin(), all.end(), 0U);
    const std::vector<std::uint32_t> stay = exposureCandidates(snapped);
    EXPECT_LT(stay.size(), all.size() * 3 / 4);
    EXPECT_EQ(ballBoundary(snapped, stay).triangle, ballBoundary(snapped, all).triangle);
}

}  // namespace betamesh
