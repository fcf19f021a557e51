// Properties of the skin: it encloses the volume of the liquid, is smooth, closed and free of crossings, and keeps all
// components.

#include "betamesh/skin.h"

#include "base/parallel.h"
#include "base/random.h"
#include "betamesh/check.h"
#include "betamesh/coherence.h"
#include "mesh/components.h"
#include "mesh/enclosure.h"
#include "mesh/vertex_normals.h"
#include "sample/sample.h"
#include "skin/skin_lengths.h"
#include "skin/stage_settings.h"
#include "support/clouds.h"
#include "support/oracles.h"
#include "support/slab_top.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <random>

namespace betamesh {
namespace {

SkinParams withSpacing(double spacing, double radius = 1.5) {
    SkinParams params;
    params.radius = radius * spacing;
    params.spacing = spacing;
    return params;
}

// nx · ny · nz particles with spacing 1, every coordinate moved by up to `jitter`.
Particles box(int nx, int ny, int nz, double jitter, unsigned seed, double wavelength = 0) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> off(-1, 1);
    Particles particles;
    for (int z = 0; z < nz; ++z)
        for (int y = 0; y < ny; ++y)
            for (int x = 0; x < nx; ++x) {
                Vec3 p(x + jitter * off(random), y + jitter * off(random), z + jitter * off(random));
                if (wavelength > 0) p.z += std::sin(2 * std::numbers::pi * p.x / wavelength);
                particles.position.emplace_back(p);
            }
    return particles;
}

double volumePerParticle(const Particles& particles) {
    return measureMesh(skinFrame(particles, withSpacing(1)).mesh).volume / static_cast<double>(particles.size());
}

TEST(Skin, EnclosesTheVolumeOfTheLiquid) {
    const auto between = [](double volume, double low, double high, const char* what) {
        EXPECT_GE(volume, low) << what;
        EXPECT_LE(volume, high) << what;
    };
    between(volumePerParticle(box(20, 20, 20, 0, 1)), 0.98, 1.04, "block");
    between(volumePerParticle(box(1, 1, 1, 0, 1)), 0.95, 1.10, "drop of one particle");
    for (const unsigned seed : {1u, 2u, 3u}) {
        between(volumePerParticle(box(60, 1, 1, 0.25, seed)), 0.90, 1.10, "thread");
        between(volumePerParticle(box(40, 40, 1, 0.25, seed)), 0.90, 1.10, "sheet");
    }
}

double degreesOffThePlane(const Mesh& mesh) {
    double sum = 0, area = 0;
    forTopOf(mesh, 9, 46, [&](const Vec3&, const Vec3& normal) {
        const double size = normal.length(), angle = std::acos(std::min(1.0, normal.z / size));
        sum += angle * angle * size;
        area += size;
    });
    return std::sqrt(sum / area) * 180 / std::numbers::pi;
}

TEST(Skin, IsFlatWhereTheLiquidIsAndKeepsWaves) {
    double kept_of_8 = 0, kept_of_16 = 0;
    for (const unsigned seed : {1u, 2u, 3u, 4u}) {  // a wave of 16 differs by 0.005 from one to another
        const auto slab = [&](double wavelength) {
            return skinFrame(box(56, 56, 6, 0.25, seed, wavelength), withSpacing(1)).mesh;
        };
        EXPECT_LE(degreesOffThePlane(slab(0)), 1.8);
        kept_of_8 += waveKept(slab(8), 8, 8, 48) / 4;
        kept_of_16 += waveKept(slab(16), 16, 11.5, 43.5) / 4;
    }
    EXPECT_GE(kept_of_8, 0.86);
    EXPECT_GE(kept_of_16, 0.975);
}

TEST(Skin, MorePassesAreSmootherAndKeepTheVolume) {
    const Particles slab = box(56, 56, 6, 0.25, 3);
    SkinParams params = withSpacing(1);
    const Mesh once = skinFrame(slab, params).mesh;
    params.passes = 3;
    const Mesh thrice = skinFrame(slab, params).mesh;
    EXPECT_LT(degreesOffThePlane(thrice), degreesOffThePlane(once));
    EXPECT_NEAR(measureMesh(thrice).volume / measureMesh(once).volume, 1, 0.02);
}

// Points on the boundary of the union of balls around particles, by brute force.
std::vector<Vec3> unionBoundary(const Particles& particles, double radius) {
    constexpr int kPoints = 800;  // of each sphere
    std::vector<Vec3> boundary;
    for (const Vec3f& centre : particles.position)
        for (int i = 0; i < kPoints; ++i) {
            const double z = 1 - (2 * i + 1.0) / kPoints, r = std::sqrt(1 - z * z), turn = 2.399963229728653 * i;
            const Vec3 p = Vec3(centre) + Vec3(r * std::cos(turn), r * std::sin(turn), z) * radius;
            if (std::ranges::none_of(particles.position, [&](const Vec3f& other) {
                    return other != centre && (Vec3(other) - p).length2() < radius * radius;
                }))
                boundary.push_back(p);
        }
    return boundary;
}

// Before smoothing, no vertex stays behind outside, not even on the rims of small holes.
TEST(Skin, RetractsToWhereARollingBallTouchesIt) {
    SkinParams params = withSpacing(1);
    params.skin = 0.55;
    params.passes = 0;
    const SkinLengths lengths{params.radius, *params.skin};
    for (const unsigned seed : {1u, 2u, 3u, 4u}) {
        Particles sheet = box(18, 18, 1, 0.25, seed);
        std::mt19937 random(seed + 9);
        std::erase_if(sheet.position, [&](const Vec3f&) { return random() % 4 == 0; });
        const std::vector<Vec3> boundary = unionBoundary(sheet, lengths.outer());
        for (const Vec3& vertex : skinFrame(sheet, params).mesh.position) {
            double nearest = std::numeric_limits<double>::infinity();
            for (const Vec3& p : boundary) nearest = std::min(nearest, (p - vertex).length2());
            ASSERT_GE(std::sqrt(nearest), lengths.rolling() - 0.09) << seed << ' ' << vertex;
        }
    }
}

// The least and the greatest width of a section across the x axis.
std::array<double, 2> widthsOfSection(const Mesh& mesh, double x) {
    std::vector<Vec3> section;
    for (const Triangle& t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3 &a = mesh.position[t[k]], &b = mesh.position[t[(k + 1) % 3]];
            if ((a.x < x) != (b.x < x)) section.push_back(a + (b - a) * ((x - a.x) / (b.x - a.x)));
        }
    std::array<double, 2> widths{std::numeric_limits<double>::infinity(), 0};
    for (int i = 0; i < 36; ++i) {
        const double turn = std::numbers::pi * i / 36;
        double low = std::numeric_limits<double>::infinity(), high = -low;
        for (const Vec3& p : section) {
            const double along = p.y * std::cos(turn) + p.z * std::sin(turn);
            low = std::min(low, along), high = std::max(high, along);
        }
        widths = {std::min(widths[0], high - low), std::max(widths[1], high - low)};
    }
    return widths;
}

// Six drops around a cavity that move apart, until the rolling ball suddenly fits between them.
TEST(Skin, TheRollingBallEntersCavitiesGradually) {
    const double outer = skinLengths(withSpacing(1)).outer();
    for (const std::uint64_t seed : {1, 2, 3}) {
        Random random(seed);
        const Vec3 x = random.ball().normalized(), y = cross(x, random.ball()).normalized(), z = cross(x, y);
        std::vector<Vec3> directions;
        for (const Vec3& axis : {x, y, z})
            for (const double side : {-1, 1}) directions.push_back(axis * side + random.ball() * 0.02);
        const auto skinAt = [&](double distance) {
            Particles drops;
            for (const Vec3& d : directions) drops.position.emplace_back(d * distance);
            return skinFrame(drops, withSpacing(1)).mesh;
        };
        constexpr double kStep = 0.001;
        Mesh before = skinAt(outer * 0.985);
        for (double distance = outer * 0.985 + kStep; distance < outer * 1.015; distance += kStep) {
            Mesh now = skinAt(distance);
            EXPECT_LE(surfaceDistance(before, now).max, 0.06) << seed << ' ' << distance;
            before = std::move(now);
        }
    }
}

// However close two particles are to parting, what connects them is no hair and no ribbon.
TEST(Skin, NecksAreRoundAndNoHairs) {
    for (const int passes : {0, 1, 2})
        for (int i = 0; i < 24; ++i) {
            const double gap = std::pow(10, -4 + i / 8.0), distance = 3 - gap;
            std::mt19937 random(static_cast<unsigned>(i));
            std::uniform_real_distribution<double> any(-1, 1);
            const Vec3 axis = Vec3(any(random), any(random), any(random)).normalized(),
                       across = cross(axis, Vec3(any(random), any(random), any(random))).normalized();
            Particles pair;
            pair.position = {Vec3f(0, 0, 0), Vec3f(axis * distance)};
            SkinParams params = withSpacing(1);
            params.passes = passes;
            params.skin = 0.55;
            Mesh mesh = skinFrame(pair, params).mesh;
            for (Vec3& p : mesh.position) p = {dot(p, axis), dot(p, across), dot(p, cross(axis, across))};
            double thin = 0;
            constexpr int kSections = 100;
            for (int k = 0; k < kSections; ++k) {
                const double from = 0.3, step = (distance - 2 * from) / kSections;
                const auto [least, greatest] = widthsOfSection(mesh, from + (k + 0.5) * step);
                EXPECT_GE(least, 0.01) << passes << ' ' << gap;
                EXPECT_GE(least, 0.4 * greatest) << passes << ' ' << gap;
                thin += least < 0.05 ? step : 0;
            }
            EXPECT_LE(thin, 0.4) << passes << ' ' << gap;
        }
}

// The number of vertices whose triangles have angles that sum up to less than this, radians.
std::size_t countTips(const Mesh& mesh, double sharp) {
    std::vector<double> sum(mesh.position.size(), 0);
    for (const Triangle& t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3& tip = mesh.position[t[k]];
            const Vec3 a = mesh.position[t[(k + 1) % 3]] - tip, b = mesh.position[t[(k + 2) % 3]] - tip;
            sum[t[k]] += std::atan2(cross(a, b).length(), dot(a, b));
        }
    return static_cast<std::size_t>(std::ranges::count_if(sum, [&](double angle) { return angle < sharp; }));
}

// Rims recede with every pass, until particles near them would be left outside. What stays behind are no spikes.
TEST(Skin, ManyPassesLeaveNoSpikesOnRims) {
    std::size_t once = 0, often = 0;
    for (unsigned seed = 1; seed <= 12; ++seed) {
        Particles sheet = box(24, 24, 1, 0.3, seed);
        std::mt19937 random(seed);
        std::erase_if(sheet.position, [&](const Vec3f&) { return random() % 3 != 0; });
        SkinParams params = withSpacing(1);
        once += countTips(skinFrame(sheet, params).mesh, 4);
        params.passes = 5;
        often += countTips(skinFrame(sheet, params).mesh, 4);
    }
    EXPECT_LE(often, 4 * once);
}

// Edges between triangles that face up and down are the outline along z; for holes in a sheet these are the rims.
TEST(Skin, RimsOfHolesAreRound) {
    double all = 0, over_3 = 0, over_4 = 0;  // lengths: of all, and of edges over 0.3 and 0.4
    for (const double radius : {1.7, 2.2, 3.0, 4.5})
        for (const unsigned seed : {1u, 2u, 3u}) {
            Particles sheet = box(24, 24, 1, 0.2, seed);
            const Vec3 middle(12.3, 11.8, 0);
            std::erase_if(sheet.position,
                          [&](const Vec3f& p) { return std::hypot(p.x - middle.x, p.y - middle.y) < radius; });
            const Mesh mesh = skinFrame(sheet, withSpacing(1)).mesh;
            std::map<std::pair<std::uint32_t, std::uint32_t>, int> facing_up;  // of the triangles at each edge
            for (const auto& [a, b, c] : mesh.triangles) {
                const std::vector<Vec3>& p = mesh.position;
                const int up = cross(p[b] - p[a], p[c] - p[a]).z > 0;
                for (const auto& [from, to] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)})
                    facing_up[std::minmax(from, to)] += up;
            }
            for (const auto& [edge, up] : facing_up) {
                const Vec3 &from = mesh.position[edge.first], &to = mesh.position[edge.second];
                const Vec3 off = (from + to) / 2 - middle;
                if (up != 1 || std::hypot(off.x, off.y) > radius + 0.8) continue;
                const double length = (to - from).length();
                all += length;
                over_3 += length > 0.3 ? length : 0;
                over_4 += length > 0.4 ? length : 0;
            }
        }
    EXPECT_GT(all, 150);
    EXPECT_LE(over_3, 0.13 * all);
    EXPECT_LE(over_4, 0.03 * all);
}

// A roof of rows along z that turns by some degrees at x = 0; offset: of the rows from the crest.
Particles roof(double degrees, double offset, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> off(-0.02, 0.02);
    const double slope = std::tan(degrees * std::numbers::pi / 360);
    Particles particles;
    for (int z = 0; z < 16; ++z)
        for (int x = -9; x <= 9; ++x)
            for (int layer = 0; layer < 8; ++layer) {
                const double across = x + offset, height = -layer - slope * std::abs(across);
                particles.position.emplace_back(Vec3(across + off(random), height + off(random), z + off(random)));
            }
    return particles;
}

TEST(Skin, BluntEdgesAreRoundAndHaveNoCreases) {
    constexpr std::size_t kStrips = 32;  // along the edge, a quarter of a spacing wide
    for (const double radius : {1.5, 2.0})
        for (const int degrees : {30, 40, 50, 60})
            for (const double offset : {0.0, 0.5}) {
                const Mesh mesh = skinFrame(roof(degrees, offset, 1), withSpacing(1, radius)).mesh;
                std::array<double, kStrips> area{}, slope{};  // slope: in degrees, times area
                for (const auto& [a, b, c] : mesh.triangles) {
                    const std::vector<Vec3>& p = mesh.position;
                    const Vec3 normal = cross(p[b] - p[a], p[c] - p[a]), at = (p[a] + p[b] + p[c]) / 3;
                    if (std::abs(at.x) >= 4 || at.z < 5 || at.z > 10 || normal.y < 0 || at.y < -5) continue;
                    const auto strip = static_cast<std::size_t>((at.x + 4) * 4);
                    area[strip] += normal.length();
                    slope[strip] += std::atan2(normal.x, normal.y) * 180 / std::numbers::pi * normal.length();
                }
                std::optional<std::size_t> last;
                for (std::size_t i = 0; i < kStrips; ++i) {
                    if (!(area[i] > 0)) continue;
                    if (last) {
                        const double turn = slope[i] / area[i] - slope[*last] / area[*last];
                        ASSERT_LE(turn, degrees / 4.0 * static_cast<double>(i - *last)) << radius << ' ' << degrees;
                        ASSERT_GE(turn, -2) << radius << ' ' << degrees;
                    }
                    last = i;
                }
            }
}

TEST(Skin, NoTriangleOfAPoolIsUpsideDown) {
    SampleParams drop;
    drop.name = "drop";
    Sample sample(drop);
    const double spacing = sample.spacing();
    for (int frame = 20; frame <= 26; ++frame) {
        const Mesh mesh = skinFrame(sample.frame(frame), withSpacing(spacing, 1.5)).mesh;
        const std::vector<Vec3> normal =
            vertexNormals(mesh.position.size(), mesh.triangles, [&](std::uint32_t v) { return mesh.position[v]; });
        double largest = 0;  // area that faces the wrong way
        for (const auto& [a, b, c] : mesh.triangles) {
            const Vec3 area = cross(mesh.position[b] - mesh.position[a], mesh.position[c] - mesh.position[a]) / 2;
            largest = std::max(largest, -dot(area, (normal[a] + normal[b] + normal[c]).normalized()));
        }
        EXPECT_LT(largest, 1e-3 * spacing * spacing) << "frame " << frame;
    }
}

// The circle between two particles that are too close to have a neck between them.
TEST(Skin, ClosePairsHaveNoGrooveWhateverTheSegments) {
    for (const int segments : {0, 2, 3, 4, 5, 8}) {
        Particles pair;
        pair.position = {Vec3f(-0.25F, 0, 0), Vec3f(0.25F, 0, 0)};
        SkinParams params = withSpacing(1);
        params.arc_subdivisions = segments;
        double widest = 0, groove = 1e30;
        for (const Vec3& p : skinFrame(pair, params).mesh.position) {
            const double across = std::hypot(p.y, p.z);
            widest = std::max(widest, across);
            if (std::abs(p.x) < 0.05) groove = std::min(groove, across);
        }
        EXPECT_GE(groove, 0.93 * widest) << segments;
        EXPECT_LE(groove, widest) << segments;
    }
}

TEST(Skin, OneSegmentPerArcMakesMeshesSmall) {
    const Particles block = box(10, 10, 10, 0.25, 3);
    SkinParams params = withSpacing(1);
    const std::size_t triangles = skinFrame(block, params).mesh.triangles.size();
    params.arc_subdivisions = 1;
    EXPECT_LE(skinFrame(block, params).mesh.triangles.size(), 0.8 * static_cast<double>(triangles));
}

TEST(Skin, OfEveryCloudIsClosedWithoutCrossingsAndHasTheComponentsOfTheBalls) {
    forEveryCloud(80, [](const Cloud& cloud) {
        if (cloud.particles.size() > 1000) return;
        SkinParams params = withSpacing(cloud.radius / 1.5);
        const Mesh skin = skinFrame(cloud.particles, params).mesh;
        const MeshCheck check = checkMesh(skin);
        EXPECT_EQ(faultsOf(check), std::vector<std::string_view>{});
        params.skin = 0;
        const Mesh balls = skinFrame(cloud.particles, params).mesh;
        EXPECT_EQ(componentsOf(skin.position.size(), skin.triangles).count,
                  componentsOf(balls.position.size(), balls.triangles).count);
        for (const Vec3& p : skin.position) ASSERT_TRUE(std::isfinite(p.x + p.y + p.z));
        for (const Vec3f& p : cloud.particles.position) EXPECT_GT(windingNumber(skin, Vec3(p)), 0.5);
    });
}

// All are exposed, and rounding decides which neighbours of a particle are seen beside it.
TEST(Skin, OfAShellIsASphereHoweverSmallTheShellIs) {
    Random random(29);
    for (int n = 0; n < 24; ++n) {
        const double spacing = random.between(0.5, 2), shell = std::pow(10, random.between(-5, -0.5)) * spacing;
        const Vec3 centre = random.cube() * 3;
        Particles particles;
        for (int i = 0; i < 250; ++i) {
            Vec3 direction = random.ball();
            while (direction.length2() < 0.01) direction = random.ball();
            particles.position.emplace_back(centre + direction.normalized() * shell);
        }
        SkinParams params = withSpacing(spacing);
        const double skin = 0.55 * spacing;
        params.skin = skin;
        const SkinnedFrame frame = skinFrame(particles, params);
        const MeshMeasure measure = measureMesh(frame.mesh);
        EXPECT_EQ(measure.unpaired_edges, 0u) << n;
        EXPECT_EQ(measure.components, 1u) << n;
        EXPECT_EQ(measure.euler, 2) << n;
        for (const Vec3& p : frame.mesh.position) ASSERT_NEAR((p - centre).length(), shell + skin, 0.06 * spacing) << n;
    }
}

// n particles on a ring, a line, in a disc or in a ball, of this size.
void addClump(int n, double size, Random& random, Particles& particles) {
    const Vec3 middle = random.cube() * 2;
    const std::uint64_t kind = random.below(4);
    for (int i = 0; i < n; ++i) {
        Vec3 p = random.ball();
        if (kind == 0) p = Vec3(p.x, p.y, 0).normalized();
        if (kind == 1) p = Vec3(p.x, 1e-3 * p.y, 0);
        if (kind == 2) p.z = 0;
        particles.position.emplace_back(middle + p * size);
    }
}

TEST(Skin, OfTightClumpsIsWithoutCrossingsOrSaysSo) {
    std::size_t crossing = 0;
    for (std::uint64_t seed = 0; seed < 100; ++seed) {
        Random random(seed);
        Particles particles;
        for (std::uint64_t clump = 0; clump < 1 + seed % 4; ++clump)
            addClump(10 + static_cast<int>(random.below(40)), std::pow(10, random.between(-6, -1)), random, particles);
        const SkinnedFrame frame = skinFrame(particles, withSpacing(1));
        const MeshCheck check = checkMesh(frame.mesh);
        EXPECT_TRUE(check.closed()) << seed;
        EXPECT_TRUE(check.crossings.count == 0 || frame.report.crossings > 0) << seed;
        crossing += frame.report.crossings > 0;
    }
    EXPECT_LE(crossing, 5u);
}

TEST(Skin, HasAllParticlesInsideHoweverThinOrCoarseItIs) {
    std::uint64_t seed = 0;
    forEveryCloud(60, [&](const Cloud& cloud) {
        if (cloud.particles.size() > 400) return;
        SkinParams params = withSpacing(cloud.radius / 1.5);
        params.skin = 0.05 * static_cast<double>(1 + ++seed % 9) * params.spacing;
        params.radius *= seed % 2 == 0 ? 0.8 : 1;
        params.arc_subdivisions = seed % 4 < 2 ? 1 : 0;
        const Mesh skin = skinFrame(cloud.particles, params).mesh;
        EXPECT_EQ(faultsOf(checkMesh(skin)), std::vector<std::string_view>{});
        const std::vector<Vec3> points(cloud.particles.position.begin(), cloud.particles.position.end());
        for (const double distance : distancesOutside(skin, {}, points)) EXPECT_EQ(distance, 0);
    });
}

TEST(Skin, IsTheSameForEveryParticleOrderAndThreadCount) {
    const Particles liquid = box(12, 12, 9, 0.4, 5);
    const Mesh mesh = skinFrame(liquid, withSpacing(1)).mesh;
    const Mesh other = skinFrame(shuffled(liquid, 7), withSpacing(1)).mesh;
    EXPECT_EQ(mesh.position, other.position);
    EXPECT_EQ(mesh.triangles, other.triangles);
    Mesh alone;
    withThreads(1, [&] { alone = skinFrame(liquid, withSpacing(1)).mesh; });
    EXPECT_EQ(mesh.position, alone.position);
    EXPECT_EQ(mesh.triangles, alone.triangles);
}

}  // namespace
}  // namespace betamesh
