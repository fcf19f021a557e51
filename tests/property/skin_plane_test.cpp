// Properties of the curves of every planar cloud.

#include "base/parallel.h"
#include "base/random.h"
#include "base/union_find.h"
#include "betamesh/check.h"
#include "betamesh/error.h"
#include "betamesh/skin.h"
#include "exact/snapped_particles.h"
#include "mesh/enclosure.h"
#include "planar/disc_boundary.h"
#include "support/oracles.h"
#include "support/planar_clouds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

namespace betamesh {

namespace {

SkinParams paramsFor(const Cloud& cloud, SmoothingMethod smoothing = SmoothingMethod::coherent) {
    SkinParams params;
    params.radius = cloud.radius;
    params.smoothing = smoothing;
    if (smoothing == SmoothingMethod::paper) params.tessellation = Tessellation::paper;
    return params;
}

std::vector<SkinParams> everyWay(const Cloud& cloud) {
    std::vector<SkinParams> all;
    for (const SmoothingMethod smoothing : {SmoothingMethod::none, SmoothingMethod::coherent, SmoothingMethod::paper})
        all.push_back(paramsFor(cloud, smoothing));
    all.push_back(all.back());
    all.back().resolve_intersections = true;
    all.push_back(all[0]);
    all.back().arc_subdivisions = 1;
    all.push_back(all[0]);
    all.back().surface = SurfaceKind::alpha;
    all.push_back(all[0]);
    all.back().surface = SurfaceKind::union_;
    all.push_back(paramsFor(cloud));
    all.back().features.droplets = Droplets::points;
    all.back().features.droplet_particles = 3;
    all.back().features.bubbles = Bubbles::fill;
    all.back().features.bubble_volume = cloud.radius * cloud.radius;
    all.push_back(paramsFor(cloud));
    all.back().skin = 0;
    all.push_back(paramsFor(cloud, SmoothingMethod::none));
    all.back().skin = 0.3 * cloud.radius;
    all.push_back(paramsFor(cloud));
    all.back().features.bubbles = Bubbles::fill;
    all.back().features.bubble_gap = 2.7 * cloud.radius;
    return all;
}

// The largest distance of a vertex of either curve from the other curve.
double farthestApart(const Curves& one, const Curves& other) {
    double farthest = 0;
    for (const Vec3& p : one.position) farthest = std::max(farthest, distanceTo(other, p));
    for (const Vec3& p : other.position) farthest = std::max(farthest, distanceTo(one, p));
    return farthest;
}

void expectSame(const SkinnedPlane& one, const SkinnedPlane& other) {
    EXPECT_EQ(one.curves.position, other.curves.position);
    EXPECT_EQ(one.curves.velocity, other.curves.velocity);
    EXPECT_EQ(one.curves.edges, other.curves.edges);
    EXPECT_EQ(one.spheres.position, other.spheres.position);
    EXPECT_EQ(one.spheres.id, other.spheres.id);
}

}  // namespace

TEST(SkinPlane, CurvesAreClosedAndFinite) {
    forEveryPlanarCloud(150, [](const Cloud& cloud) {
        for (const SkinParams& params : everyWay(cloud)) {
            const SkinnedPlane plane = skinPlane(cloud.particles, params);
            EXPECT_EQ(measureCurves(plane.curves).unpaired_ends, 0u);
            for (const std::span<const Edge> line : linesOf(plane.curves)) EXPECT_EQ(line.front()[0], line.back()[1]);
            ASSERT_EQ(plane.curves.velocity.size(), plane.curves.position.size());
            for (const auto* rows : {&plane.curves.position, &plane.curves.velocity})
                for (const Vec3& p : *rows) ASSERT_TRUE(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
            for (const Vec3& p : plane.curves.position)
                ASSERT_EQ(static_cast<float>(p.z), cloud.particles.position[0].z);
        }
    });
}

TEST(SkinPlane, TurningNumbersAreThoseOfTheBoundaryBeforeSmoothing) {
    forEveryPlanarCloud(3000, [](const Cloud& cloud) {
        const DiscBoundary boundary = discBoundary(snapParticles(cloud.particles, cloud.radius));
        for (const int subdivisions : {0, 1}) {
            SkinParams params = paramsFor(cloud, SmoothingMethod::none);
            params.arc_subdivisions = subdivisions;
            const Curves curves = skinPlane(cloud.particles, params).curves;
            const auto lines = linesOf(curves);
            ASSERT_EQ(lines.size(), boundary.cycle.size() + boundary.isolated.size());
            for (const std::span<const Edge> line : lines) {
                Curves one;
                one.position = curves.position;
                one.edges.assign(line.begin(), line.end());
                const CurveMeasure measure = measureCurves(one);
                if (std::abs(measure.area) < 1e-6 * cloud.radius * cloud.radius) continue;  // a hole of a single point
                EXPECT_EQ(measure.turning, measure.area > 0 ? 1 : -1);
            }
        }
    });
}

TEST(SkinPlane, DoesNotDependOnOrderOrThreads) {
    forEveryPlanarCloud(25, [](const Cloud& cloud) {
        for (const SkinParams& params : everyWay(cloud)) {
            const SkinnedPlane one = skinPlane(cloud.particles, params);
            expectSame(one, skinPlane(shuffled(cloud.particles, 7), params));
            withThreads(1, [&] { expectSame(one, skinPlane(cloud.particles, params)); });
        }
    });
}

TEST(SkinPlane, AttributesAreMeansOfTheParticles) {
    forEveryPlanarCloud(200, [](const Cloud& cloud) {
        Particles particles = cloud.particles;
        const std::size_t n = particles.size();
        particles.attributes = {{"constant", 2, std::vector<float>(2 * n, 3.5f), {}}, {"row", 1, {}, {}}};
        for (std::size_t i = 0; i < n; ++i) particles.attributes[1].integer.push_back(static_cast<std::int32_t>(i));
        for (SkinParams params : everyWay(cloud)) {
            params.attributes = {"row", "constant"};
            const Curves curves = skinPlane(particles, params).curves;
            ASSERT_EQ(curves.attributes.size(), 2u);
            ASSERT_EQ(curves.attributes[0].integer.size(), curves.position.size());
            ASSERT_EQ(curves.attributes[1].real.size(), 2 * curves.position.size());
            for (const float value : curves.attributes[1].real) EXPECT_NEAR(value, 3.5f, 1e-5f);
            for (std::size_t v = 0; v < curves.position.size(); ++v) {
                const auto row = static_cast<std::size_t>(curves.attributes[0].integer[v]);
                EXPECT_LE((Vec3(particles.position[row]) - curves.position[v]).length(), 2 * cloud.radius);
            }
        }
    });
}

TEST(SkinPlane, WithoutDropletsTheCurvesAreThoseOfTheOtherParticles) {
    std::size_t left = 0;
    forEveryPlanarCloud(200, [&](const Cloud& cloud) {
        const SnappedParticles snapped = snapParticles(cloud.particles, cloud.radius);
        const std::size_t n = snapped.size();
        UnionFind groups(n);
        for (std::uint32_t a = 0; a < n; ++a)
            for (std::uint32_t b = 0; b < a; ++b)
                if ((snapped.position[a] - snapped.position[b]).length2() <= 4 * snapped.radius * snapped.radius)
                    groups.join(a, b);
        std::vector<std::size_t> members(n, 0);
        for (std::uint32_t i = 0; i < n; ++i) ++members[groups.find(i)];
        SkinParams params = paramsFor(cloud);
        params.features.droplet_particles = 4;
        Particles others;
        std::size_t small = 0;
        for (std::uint32_t i = 0; i < n; ++i) {
            const bool is_small = members[groups.find(i)] < 4;
            small += is_small;
            if (is_small) continue;
            others.position.push_back(cloud.particles.position[snapped.row[i]]);
            others.velocity.push_back(cloud.particles.velocity[snapped.row[i]]);
        }
        left += small;
        for (const Droplets droplets : {Droplets::points, Droplets::drop}) {
            params.features.droplets = droplets;
            const SkinnedPlane plane = skinPlane(cloud.particles, params);
            EXPECT_EQ(plane.report.droplet_particles, small);
            EXPECT_EQ(plane.spheres.size(), droplets == Droplets::points ? small : 0);
            if (others.size() > 0 && snapParticles(others, cloud.radius).quantum == snapped.quantum) {
                EXPECT_EQ(measureCurves(plane.curves).curves,
                          measureCurves(skinPlane(others, paramsFor(cloud)).curves).curves);
            }
            EXPECT_EQ(plane.curves.edges.empty(), others.size() == 0);
        }
    });
    EXPECT_GT(left, 100u);
}

TEST(SkinPlane, FillingRemovesTheSmallHolesAndTheirContents) {
    std::size_t filled = 0;
    forEveryPlanarCloud(1000, [&](const Cloud& cloud) {
        SkinParams params = paramsFor(cloud, SmoothingMethod::none);
        const Curves all = skinPlane(cloud.particles, params).curves;
        params.features.bubbles = Bubbles::fill;
        params.features.bubble_volume = 0.5 * cloud.radius * cloud.radius;
        const SkinnedPlane plane = skinPlane(cloud.particles, params);
        filled += plane.report.bubbles_filled;
        const auto placesOfLine = [](const Curves& curves, std::span<const Edge> line) {
            std::vector<std::pair<double, double>> places;
            for (const Edge& edge : line) places.emplace_back(curves.position[edge[0]].x, curves.position[edge[0]].y);
            return places;
        };
        const auto area = [](const std::vector<std::pair<double, double>>& p) {
            double twice = 0;
            for (std::size_t i = 0; i < p.size(); ++i) {
                const auto& [ax, ay] = p[i];
                const auto& [bx, by] = p[(i + 1) % p.size()];
                twice += (ax - p[0].first) * (by - p[0].second) - (ay - p[0].second) * (bx - p[0].first);
            }
            return twice / 2;
        };
        const auto turns = [](const std::vector<std::pair<double, double>>& p, const std::pair<double, double>& at) {
            double angle = 0;
            for (std::size_t i = 0; i < p.size(); ++i) {
                const Vec3 a(p[i].first - at.first, p[i].second - at.second, 0);
                const auto& [bx, by] = p[(i + 1) % p.size()];
                const Vec3 b(bx - at.first, by - at.second, 0);
                angle += std::atan2(crossZ(a, b), dot(a, b));
            }
            return std::abs(angle) > std::numbers::pi;
        };
        // Lines keep their order, so one sweep finds the removed ones.
        const auto rest = linesOf(plane.curves);
        std::size_t next = 0, small = 0;
        std::vector<std::vector<std::pair<double, double>>> holes, islands;
        for (const std::span<const Edge> line : linesOf(all)) {
            const auto places = placesOfLine(all, line);
            if (next < rest.size() && placesOfLine(plane.curves, rest[next]) == places) {
                ++next;
                EXPECT_TRUE(area(places) > 0 || area(places) <= -params.features.bubble_volume);
            } else if (area(places) <= 0.1 * cloud.radius * cloud.radius) {
                small += area(places) > -params.features.bubble_volume;
                holes.push_back(places);
            } else {
                islands.push_back(places);
            }
        }
        EXPECT_EQ(next, rest.size());
        EXPECT_EQ(small, plane.report.bubbles_filled);
        for (const auto& island : islands)
            EXPECT_TRUE(
                std::any_of(holes.begin(), holes.end(), [&](const auto& hole) { return turns(hole, island[0]); }));
    });
    EXPECT_GT(filled, 100u);
}

// Holes are kept if the larger disc fits: if a point at its radius from two particles is not nearer to any other.
TEST(SkinPlane, HolesAreKeptIfADiscAsWideAsTheGapFits) {
    std::size_t filled = 0, kept = 0;
    forEveryPlanarCloud(1000, [&](const Cloud& cloud) {
        SkinParams params = paramsFor(cloud, SmoothingMethod::none);
        const Curves all = skinPlane(cloud.particles, params).curves;
        params.features.bubbles = Bubbles::fill;
        params.features.bubble_gap = 2.34567 * cloud.radius;
        const double radius = params.features.bubble_gap / 2;
        const SkinnedPlane plane = skinPlane(cloud.particles, params);
        std::vector<Vec3> middles;
        for (const Vec3f& a : cloud.particles.position)
            for (const Vec3f& b : cloud.particles.position) {
                const Vec3 way(b - a), middle = Vec3(a) + way / 2;
                const double square = radius * radius - way.length2() / 4;
                if (!(way.length2() > 0) || square < 0) continue;
                const Vec3 centre = middle + Vec3(way.y, -way.x, 0).normalized() * std::sqrt(square);
                if (std::all_of(cloud.particles.position.begin(), cloud.particles.position.end(), [&](const Vec3f& p) {
                        return (Vec3(p) - centre).length() > radius - 1e-5 * cloud.radius;
                    }))
                    middles.push_back(centre);
            }
        // Lines keep their order, so one sweep finds the removed ones.
        const auto rest = linesOf(plane.curves);
        std::size_t next = 0, holes_filled = 0, others_gone = 0;
        for (const std::span<const Edge> line : linesOf(all)) {
            Curves one;
            one.position = all.position;
            one.edges.assign(line.begin(), line.end());
            const bool is_left =
                next < rest.size() && std::equal(line.begin(), line.end(), rest[next].begin(), rest[next].end(),
                                                 [&](const Edge& a, const Edge& b) {
                                                     return all.position[a[0]] == plane.curves.position[b[0]];
                                                 });
            next += is_left;
            const double area = measureCurves(one).area;
            if (area > 0.1 * cloud.radius * cloud.radius) {
                others_gone += !is_left;
                continue;
            }
            for (Edge& edge : one.edges) std::swap(edge[0], edge[1]);
            const std::vector<double> outside = distancesOutside(one, {}, middles);
            const bool has_room = std::count(outside.begin(), outside.end(), 0.0) > 0;
            EXPECT_TRUE(is_left == has_room || (has_room && others_gone > 0)) << area;
            holes_filled += !is_left;
            kept += is_left;
        }
        EXPECT_GE(holes_filled, plane.report.bubbles_filled);
        filled += plane.report.bubbles_filled;
    });
    EXPECT_GT(filled, 100u);
    EXPECT_GT(kept, 20u);
}

// The enclosed area per particle, squared spacings.
TEST(SkinPlane, TheSkinEnclosesTheAreaOfTheParticles) {
    const auto areaOf = [](const Particles& particles) {
        return measureCurves(skinPlane(particles, paramsFor({"", particles, 1.5})).curves).area /
               static_cast<double>(particles.size());
    };
    const auto lattice = [](int width, int height, double jitter, std::uint64_t seed) {
        Particles particles;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                particles.position.emplace_back(Vec3(x, y, 0) +
                                                Random(seed, particles.size()).cube() * Vec3(jitter, jitter, 0));
        return particles;
    };
    EXPECT_NEAR(areaOf(lattice(20, 20, 0, 0)), 1.01, 0.03);
    EXPECT_NEAR(areaOf(lattice(1, 1, 0, 0)), 1, 0.05);
    EXPECT_NEAR(areaOf(lattice(30, 1, 0, 0)), 1, 0.1);
    for (std::uint64_t seed = 0; seed < 8; ++seed) EXPECT_NEAR(areaOf(lattice(30, 1, 0.25, seed)), 1, 0.1) << seed;
    for (std::uint64_t seed = 0; seed < 4; ++seed) EXPECT_NEAR(areaOf(lattice(20, 20, 0.25, seed)), 1.01, 0.04) << seed;
}

// Down to a gap into which a disc of one spacing fits; the rolling disc has a radius of two.
TEST(SkinPlane, RowsThatComeNearStayThin) {
    const auto areaAt = [](double gap) {
        Random random(3);
        Particles rows;
        for (int row = 0; row < 2; ++row)
            for (int x = 0; x < 40; ++x)
                rows.position.emplace_back(Vec3(x, row * gap, 0) + random.cube() * Vec3(0.2, 0.2, 0));
        return measureCurves(skinPlane(rows, paramsFor({"", rows, 1.5})).curves).area;
    };
    const double apart = areaAt(8);
    for (double gap = 3.75; gap < 6; gap += 0.25) {
        SCOPED_TRACE(testing::Message() << "gap of " << gap);
        const double skin = 0.5, inside = std::max(skin, gap / 2 - std::sqrt(gap * gap / 4 - 2.25));
        EXPECT_LT(areaAt(gap), 1.1 * (skin + inside) / (2 * skin) * apart);
        EXPECT_GT(areaAt(gap), 0.98 * apart);
    }
}

TEST(SkinPlane, SkinsDoNotCrossAndEncloseEveryParticleInTheSameComponents) {
    forEveryPlanarCloud(60, [](const Cloud& cloud) {
        std::vector<SkinParams> all(5, paramsFor(cloud));
        all[1].arc_subdivisions = 1;
        all[2].skin = 0.3 * cloud.radius;
        all[3].skin = 0.7 * cloud.radius;
        all[3].smoothing = SmoothingMethod::none;
        all[4].skin = 0.02 * cloud.radius;
        for (const SkinParams& params : all) {
            SkinParams discs = params;
            discs.skin = 0;
            const Curves curves = skinPlane(cloud.particles, params).curves;
            EXPECT_EQ(linesOf(curves).size(), linesOf(skinPlane(cloud.particles, discs).curves).size());
            CheckParams check;
            check.tolerance = 1e-6 * cloud.radius;
            EXPECT_EQ(checkCurves(curves, check).crossings.count, 0u);
            for (const double distance :
                 distancesOutside(curves, {}, {cloud.particles.position.begin(), cloud.particles.position.end()}))
                EXPECT_LE(distance, 1e-6 * cloud.radius);
        }
    });
}

TEST(SkinPlane, WithoutSmoothingTheCurveIsOnTheDiscsUnlessASkinIsGiven) {
    const Cloud cloud{"", {{{0, 0, 0}, {1, 0, 0}}, {}, {}, {}}, 1.5};
    const auto farthest = [&](std::optional<double> skin) {
        SkinParams params = paramsFor(cloud, SmoothingMethod::none);
        params.skin = skin;
        double left = 0;
        for (const Vec3& p : skinPlane(cloud.particles, params).curves.position) left = std::max(left, -p.x);
        return left;
    };
    EXPECT_NEAR(farthest({}), 1.5, 1e-5);
    EXPECT_NEAR(farthest(0), 1.5, 1e-5);
    EXPECT_NEAR(farthest(0.5), 0.5, 0.01);
    EXPECT_NEAR(farthest(1.2), 1.2, 0.01);
    EXPECT_THROW(farthest(1.5), Error);
}

// A disc descends onto a jittered block in small steps: far from it, where it joins, and inside.
TEST(SkinPlane, ASkinMovesNoFasterThanItsParticlesInBulk) {
    constexpr double kStep = 0.0003;
    for (std::uint64_t seed = 0; seed < 3; ++seed) {
        Particles particles;
        for (int y = -7; y <= 0; ++y)
            for (int x = 0; x < 14; ++x)
                particles.position.emplace_back(Vec3(x, y, 0) +
                                                Random(seed, particles.size()).cube() * Vec3(0.2, 0.2, 0));
        particles.position.emplace_back(6.3F, 0.0F, 0.0F);
        for (const double height : {4.0, 1.5, 1.2, 0.9, 0.6}) {
            Curves before;
            for (int i = 0; i < 30; ++i) {
                particles.position.back().y = static_cast<float>(height - i * kStep);
                const Curves curves = skinPlane(particles, paramsFor({"", particles, 1.5})).curves;
                if (i > 0) {
                    EXPECT_LE(farthestApart(before, curves), 10 * kStep) << seed << ' ' << height << ' ' << i;
                }
                before = curves;
            }
        }
    }
}

// Three or four drops around a cavity that move apart, until the rolling disc suddenly fits between them.
TEST(SkinPlane, TheRollingDiscEntersCavitiesGradually) {
    for (const int drops : {3, 4}) {
        Random random(static_cast<std::uint64_t>(drops));
        std::vector<Vec3> directions;
        for (int k = 0; k < drops; ++k) {
            const double angle = 2 * std::numbers::pi * k / drops;
            directions.push_back(Vec3(std::cos(angle), std::sin(angle), 0) + random.cube() * Vec3(0.02, 0.02, 0));
        }
        constexpr double kStep = 5e-4;
        Curves before;
        for (double distance = 2.4; distance < 2.6; distance += kStep) {
            Particles particles;
            for (const Vec3& d : directions) particles.position.emplace_back(d * distance);
            const Curves curves = skinPlane(particles, paramsFor({"", particles, 1.5})).curves;
            if (!before.position.empty()) {
                EXPECT_LE(farthestApart(before, curves), 50 * kStep) << drops << ' ' << distance;
            }
            before = curves;
        }
    }
}

TEST(SkinPlane, IsolatedDiscsAndRingsKeepTheirSizeOnTheDiscs) {
    const auto areas = [](const Particles& particles) {
        Cloud cloud{"", particles, 1.5};
        SkinParams params = paramsFor(cloud);
        params.skin = 0;
        params.arc_subdivisions = 12;
        const double smooth = measureCurves(skinPlane(particles, params).curves).area;
        params.smoothing = SmoothingMethod::none;
        return smooth / measureCurves(skinPlane(particles, params).curves).area;
    };
    Particles one, row, ring;
    one.position = {{1, 2, 0}};
    for (int i = 0; i < 20; ++i) row.position.emplace_back(static_cast<float>(i), 0.0F, 0.0F);
    for (int y = -9; y <= 9; ++y)
        for (int x = -9; x <= 9; ++x)
            if (x * x + y * y <= 81 && x * x + y * y >= 25)
                ring.position.emplace_back(static_cast<float>(x), static_cast<float>(y), 0.0F);
    EXPECT_NEAR(areas(one), 1, 0.002);
    EXPECT_NEAR(areas(row), 1, 0.02);
    EXPECT_NEAR(areas(ring), 1, 0.02);
}

TEST(SkinPlane, ADropNearAPoolStaysRoundOnTheDiscs) {
    for (const double gap : {0.02, 0.1, 0.3, 0.6, 1.0}) {
        Particles particles;
        for (int y = -5; y <= 0; ++y)
            for (int x = -12; x <= 12; ++x)
                particles.position.emplace_back(static_cast<float>(x), static_cast<float>(y), 0.0F);
        const Vec3 drop(0.3, 3 + gap, 0);
        particles.position.emplace_back(drop);
        SkinParams params = paramsFor({"", particles, 1.5});
        params.skin = 0;
        const Curves curves = skinPlane(particles, params).curves;
        const auto lines = linesOf(curves);
        ASSERT_EQ(lines.size(), 2u);
        for (const Edge& edge : lines[1]) EXPECT_NEAR((curves.position[edge[0]] - drop).length(), 1.5, 0.2) << gap;
    }
}

// RMS angle to the plane of a slab jittered by a quarter of the spacing; 16° before smoothing.
TEST(SkinPlane, JitteredSlabsBecomeFlat) {
    for (const auto skin : {std::optional<double>(), std::optional(0.0)}) {
        double squares = 0, lengths = 0;
        for (std::uint64_t seed = 0; seed < 4; ++seed) {
            Particles particles;
            for (int y = -7; y <= 0; ++y)
                for (int x = 0; x < 60; ++x)
                    particles.position.emplace_back(Vec3(x, y, 0) +
                                                    Random(seed, particles.size()).cube() * Vec3(0.25, 0.25, 0));
            SkinParams params = paramsFor({"", particles, 1.5});
            params.skin = skin;
            const Curves curves = skinPlane(particles, params).curves;
            for (const Edge& edge : curves.edges) {
                const Vec3 &a = curves.position[edge[0]], way = curves.position[edge[1]] - a;
                if (a.y < 0 || a.x < 10 || a.x > 50 || way.length() < 1e-6) continue;
                const double angle = std::atan2(way.y, -way.x);
                squares += angle * angle * way.length();
                lengths += way.length();
            }
        }
        EXPECT_LE(std::sqrt(squares / lengths) * 180 / std::numbers::pi, skin ? 3 : 2.8);
    }
}

// Rows under a roof that turns by some degrees at x = 0; the direction of the curve in strips a quarter of a spacing
// wide.
TEST(SkinPlane, BluntBendsAreRound) {
    constexpr std::size_t kStrips = 32;
    for (const double radius : {1.5, 2.0})
        for (const int degrees : {40, 50, 60, 70, 80})
            for (const double offset : {0.0, 0.25, 0.5}) {
                Particles particles;
                for (int layer = 0; layer < 8; ++layer)
                    for (int x = -9; x <= 9; ++x) {
                        const double across = x + offset,
                                     height = -layer - std::tan(degrees * std::numbers::pi / 360) * std::abs(across);
                        particles.position.emplace_back(Vec3(across, height, 0) +
                                                        Random(1, particles.size()).cube() * Vec3(0.02, 0.02, 0));
                    }
                const Curves curves = skinPlane(particles, paramsFor({"", particles, radius})).curves;
                std::array<double, kStrips> length{}, angle{};  // angle: mean, in degrees, times length
                for (const Edge& edge : curves.edges) {
                    const Vec3 &a = curves.position[edge[0]], &b = curves.position[edge[1]];
                    const Vec3 way = b - a, middle = (a + b) / 2;
                    if (way.x > 0 || middle.y < -6 || std::abs(middle.x) >= 4) continue;
                    const auto strip = static_cast<std::size_t>((middle.x + 4) * 4);
                    length[strip] += way.length();
                    angle[strip] += std::atan2(way.y, -way.x) * 180 / std::numbers::pi * way.length();
                }
                std::optional<std::size_t> last;
                for (std::size_t i = 0; i < kStrips; ++i) {
                    if (!(length[i] > 0)) continue;
                    if (last) {
                        const double turn = angle[i] / length[i] - angle[*last] / length[*last];
                        ASSERT_LE(turn, 0.37 * degrees * static_cast<double>(i - *last)) << radius << ' ' << degrees;
                        ASSERT_GE(turn, -3) << radius << ' ' << degrees;
                    }
                    last = i;
                }
            }
}

// The remaining share of the height of a wave in a pool, half a spacing high.
TEST(SkinPlane, WavesAreKept) {
    const auto keptOf = [](double wavelength, std::optional<double> skin) {
        constexpr double kHeight = 0.5;
        Particles particles;
        for (int x = 0; x < 96; ++x)
            for (int y = 0; y < 10; ++y) {
                const double wave = kHeight * std::cos(2 * std::numbers::pi * x / wavelength);
                particles.position.emplace_back(Vec3(x, wave - y, 0) +
                                                Random(1, particles.size()).cube() * Vec3(0.1, 0.1, 0));
            }
        SkinParams params = paramsFor({"", particles, 1.5});
        params.skin = skin;
        const Curves curves = skinPlane(particles, params).curves;
        double sine = 0, cosine = 0, length = 0;
        for (const Edge& edge : curves.edges) {
            const Vec3 &a = curves.position[edge[0]], &b = curves.position[edge[1]], middle = (a + b) / 2;
            if (middle.y < -3 || middle.x < 16 || middle.x > 80) continue;
            const double phase = 2 * std::numbers::pi * middle.x / wavelength, way = a.x - b.x;
            sine += way * middle.y * std::sin(phase);
            cosine += way * middle.y * std::cos(phase);
            length += way;
        }
        return 2 * std::hypot(sine, cosine) / length / kHeight;
    };
    EXPECT_GE(keptOf(8, {}), 0.82);
    EXPECT_GE(keptOf(16, {}), 0.98);
    EXPECT_GE(keptOf(8, {}), keptOf(8, 0));
    EXPECT_GE(keptOf(16, {}), keptOf(16, 0));
}

TEST(SkinPlane, RefusesParticlesOutsideThePlaneAndNamesTheFirst) {
    Particles particles;
    particles.position = {{0, 0, 1}, {1, 0, 1}, {2, 0, 1.5F}, {3, 0, 2}};
    try {
        skinPlane(particles, paramsFor({"", {}, 1}));
        FAIL();
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("particle 2 is at z = 1.5"), std::string::npos) << error.what();
    }
}

}  // namespace betamesh
