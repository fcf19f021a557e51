// Properties of every skinned frame.

#include "betamesh/skin.h"

#include "base/dual.h"
#include "base/parallel.h"
#include "base/random.h"
#include "betamesh/check.h"
#include "betamesh/error.h"
#include "skin/ball_boundary.h"
#include "skin/coverage.h"
#include "support/clouds.h"
#include "support/oracles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <set>

namespace betamesh {

namespace {

// Spacing 1, every coordinate jittered by up to a quarter of it.
Particles jitteredBox(int nx, int ny, int nz, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> jitter(-0.25f, 0.25f);
    Particles box;
    for (int z = 0; z < nz; ++z)
        for (int y = 0; y < ny; ++y)
            for (int x = 0; x < nx; ++x)
                box.position.emplace_back(static_cast<float>(x) + jitter(random),
                                          static_cast<float>(y) + jitter(random),
                                          static_cast<float>(z) + jitter(random));
    return box;
}

SkinParams withRadius(double radius) {
    SkinParams params;
    params.radius = radius;
    return params;
}

SkinParams asInThePaper(double radius) {
    SkinParams params = withRadius(radius);
    params.tessellation = Tessellation::paper;
    params.smoothing = SmoothingMethod::paper;
    return params;
}

// Area-weighted RMS angle between the triangles of a slab's top face, far from its sides, and the plane. Triangles
// steeper than 60 degrees are ignored: they belong to gaps that the jitter left.
double roughness(const Mesh& mesh, double low, double high, double bottom) {
    double sum = 0, area = 0;
    for (const Triangle& t : mesh.triangles) {
        const Vec3 &a = mesh.position[t[0]], &b = mesh.position[t[1]], &c = mesh.position[t[2]];
        const Vec3 middle = (a + b + c) / 3, normal = cross(b - a, c - a);
        if (std::min(middle.x, middle.y) < low || std::max(middle.x, middle.y) > high || middle.z < bottom) continue;
        const double size = normal.length();
        if (!(normal.z > 0.5 * size)) continue;
        const double angle = std::acos(std::min(1.0, normal.z / size));
        sum += angle * angle * size;
        area += size;
    }
    return std::sqrt(sum / area) * 180 / std::numbers::pi;
}

}  // namespace

TEST(SkinFrame, ThePapersMeshIsClosedForEveryCloud) {
    forEveryCloud(2000, [](const Cloud& cloud) {
        for (const SmoothingMethod smoothing : {SmoothingMethod::none, SmoothingMethod::paper}) {
            SkinParams params = asInThePaper(cloud.radius);
            params.smoothing = smoothing;
            const SkinnedFrame frame = skinFrame(cloud.particles, params);
            EXPECT_EQ(measureMesh(frame.mesh).unpaired_edges, 0u);
            for (const Vec3& p : frame.mesh.position) ASSERT_TRUE(std::isfinite(p.x + p.y + p.z));
            for (const Vec3& v : frame.mesh.velocity) ASSERT_TRUE(std::isfinite(v.x + v.y + v.z));
        }
    });
}

TEST(SkinFrame, TheAlphaMeshIsClosedForEveryCloud) {
    forEveryCloud(500, [](const Cloud& cloud) {
        SkinParams params = withRadius(cloud.radius);
        params.surface = SurfaceKind::alpha;
        const SkinnedFrame frame = skinFrame(cloud.particles, params);
        EXPECT_EQ(measureMesh(frame.mesh).unpaired_edges, 0u);
        EXPECT_EQ(frame.mesh.triangles.size(), frame.report.alpha_triangles);
    });
}

TEST(SkinFrame, TheAlphaMeshIsThatOfTheBoundaryWithAllItsArcs) {
    forEveryCloud(500, [](const Cloud& cloud) {
        SkinParams params = withRadius(cloud.radius);
        params.surface = SurfaceKind::alpha;
        const SkinnedFrame frame = skinFrame(cloud.particles, params);
        const SnappedParticles snapped = snapParticles(cloud.particles, cloud.radius);
        const BallBoundary boundary = ballBoundary(snapped, exposureCandidates(snapped));
        ASSERT_EQ(frame.mesh.triangles.size(), boundary.triangle.size());
        std::set<std::uint32_t> used;
        for (std::size_t t = 0; t < boundary.triangle.size(); ++t)
            for (std::size_t m = 0; m < 3; ++m) {
                used.insert(boundary.triangle[t][m]);
                EXPECT_EQ(frame.mesh.position[frame.mesh.triangles[t][m]], boundary.centre(boundary.triangle[t][m]));
            }
        EXPECT_EQ(frame.mesh.position.size(), used.size());
        EXPECT_EQ(frame.report.alpha_vertices, used.size());
    });
}

// All balls are exposed, and each has hundreds of neighbours.
TEST(SkinFrame, DenseClustersAreOneComponentOfTheRightGenus) {
    std::mt19937 random(13);
    std::uniform_real_distribution<double> share(0, 1);
    Particles plane, cylinder;
    for (int i = 0; i < 800; ++i) plane.position.emplace_back(Vec3(share(random), share(random), 0) * 5);
    for (int i = 0; i < 1500; ++i) {
        const double angle = 2 * std::numbers::pi * share(random);
        cylinder.position.emplace_back(Vec3(3 * std::cos(angle), 3 * std::sin(angle), 4 * share(random)));
    }
    for (const auto& [particles, euler] : {std::pair(&plane, 2), {&cylinder, 0}}) {
        const MeshMeasure measure = measureMesh(skinFrame(*particles, withRadius(1.5)).mesh);
        EXPECT_EQ(measure.unpaired_edges, 0u);
        EXPECT_EQ(measure.components, 1u);
        EXPECT_EQ(measure.euler, euler);
    }
}

TEST(SkinFrame, IsTheSameForEveryParticleOrderAndThreadCount) {
    forEveryCloud(20, [](const Cloud& cloud) {
        std::vector<SkinParams> kinds(4, withRadius(cloud.radius));
        kinds[1] = asInThePaper(cloud.radius);
        kinds[1].resolve_intersections = true;
        kinds[2].surface = SurfaceKind::alpha;
        kinds[3].surface = SurfaceKind::union_;
        for (const SkinParams& params : kinds) {
            const SkinnedFrame one = skinFrame(cloud.particles, params);
            SkinnedFrame other;
            withThreads(1, [&] { other = skinFrame(shuffled(cloud.particles, 3), params); });
            EXPECT_EQ(one.mesh.position, other.mesh.position);
            EXPECT_EQ(one.mesh.velocity, other.mesh.velocity);
            EXPECT_EQ(one.mesh.triangles, other.mesh.triangles);
            EXPECT_EQ(one.spheres.position, other.spheres.position);
            EXPECT_EQ(one.spheres.id, other.spheres.id);
        }
    });
}

TEST(SkinFrame, ExternalSpheresAreTheParticlesWithoutTriangles) {
    Particles particles;  // one alone, two that touch in a circle
    particles.position = {{0, 0, 0}, {10, 0, 0}, {11, 0, 0}};
    particles.id = {7, 8, 9};
    const SkinnedFrame frame = skinFrame(particles, asInThePaper(1));
    EXPECT_EQ(frame.report.isolated_particles, 1u);
    EXPECT_EQ(frame.report.degenerate_edges, 1u);
    EXPECT_EQ(frame.spheres.id, (std::vector<std::uint64_t>{7, 8, 9}));
    EXPECT_TRUE(frame.mesh.triangles.empty());
    for (const float radius : frame.spheres.radius) EXPECT_NEAR(radius, 1, 1e-5);
}

TEST(SkinFrame, DuplicatesChangeNothing) {
    for (std::uint64_t seed = 0; seed < 100; ++seed) {
        const Cloud cloud = randomCloud(seed);
        SCOPED_TRACE(cloud.name);
        Particles twice = cloud.particles;
        twice.position.insert(twice.position.end(), cloud.particles.position.begin(), cloud.particles.position.end());
        twice.velocity.insert(twice.velocity.end(), cloud.particles.velocity.begin(), cloud.particles.velocity.end());
        for (std::size_t i = 0; i < cloud.particles.size(); ++i) twice.id.push_back(1000 + i);
        const SkinnedFrame one = skinFrame(cloud.particles, withRadius(cloud.radius));
        const SkinnedFrame other = skinFrame(twice, withRadius(cloud.radius));
        EXPECT_EQ(one.mesh.position, other.mesh.position);
        EXPECT_EQ(one.mesh.triangles, other.mesh.triangles);
        EXPECT_EQ(one.report.distinct_particles, other.report.distinct_particles);
    }
}

TEST(SkinFrame, FlatFacesAreAsFlatAsThePaperMakesThem) {
    double raw = 0, once = 0, thrice = 0;
    constexpr int kSlabs = 3;
    for (unsigned seed = 1; seed <= kSlabs; ++seed) {
        const Particles slab = jitteredBox(60, 60, 6, seed);
        const auto measured = [&](SmoothingMethod smoothing, int passes) {
            SkinParams params = asInThePaper(1.5);
            params.smoothing = smoothing;
            params.passes = passes;
            return roughness(skinFrame(slab, params).mesh, 8, 51, 3) / kSlabs;
        };
        raw += measured(SmoothingMethod::none, 0);
        once += measured(SmoothingMethod::paper, 1);
        thrice += measured(SmoothingMethod::paper, 3);
    }
    EXPECT_NEAR(raw, 8.6, 0.4);
    EXPECT_NEAR(once, 3.3, 0.2);
    EXPECT_NEAR(thrice, 1.6, 0.2);
}

TEST(SkinFrame, FloatPredicatesFailOnALatticePerturbAndRecover) {
    for (const float step : {1.0f, 1.0f / 64, 0.1f})
        for (const int side : {2, 3, 8, 11}) {
            SCOPED_TRACE(std::to_string(side) + " particles to the side, spacing " + std::to_string(step));
            Particles lattice;
            for (int z = 0; z < side; ++z)
                for (int y = 0; y < side; ++y)
                    for (int x = 0; x < side; ++x)
                        lattice.position.emplace_back(step * static_cast<float>(x), step * static_cast<float>(y),
                                                      step * static_cast<float>(z));
            SkinParams params = withRadius(1.5 * step);
            params.predicates = PredicateKind::floating;
            const SkinnedFrame frame = skinFrame(lattice, params);
            EXPECT_GE(frame.report.perturbation_retries, 1);
            EXPECT_EQ(frame.report.alpha_triangles, static_cast<std::size_t>(12 * (side - 1) * (side - 1)));
            EXPECT_EQ(measureMesh(frame.mesh).unpaired_edges, 0u);

            params.retries = 0;
            try {
                skinFrame(lattice, params);
                FAIL() << "an exact lattice was found valid without a perturbation";
            } catch (const Error& error) {
                EXPECT_NE(std::string(error.what()).find("the edge from particle"), std::string::npos) << error.what();
            }
        }
}

TEST(SkinFrame, FloatPredicatesNeedNoPerturbationOnAJitteredLattice) {
    for (unsigned seed = 0; seed < 5; ++seed) {
        SkinParams params = withRadius(1.5);
        params.predicates = PredicateKind::floating;
        params.retries = 0;
        EXPECT_EQ(skinFrame(jitteredBox(12, 12, 12, seed), params).report.perturbation_retries, 0);
    }
}

TEST(SkinFrame, FloatAndExactPredicatesAgreeAwayFromTies) {
    const Particles box = jitteredBox(14, 14, 14, 11);
    SkinParams params = withRadius(1.5);
    const SkinnedFrame exact = skinFrame(box, params);
    params.predicates = PredicateKind::floating;
    const SkinnedFrame floating = skinFrame(box, params);
    EXPECT_EQ(exact.mesh.triangles, floating.mesh.triangles);
}

TEST(SkinFrame, ACompleteMeshIsCheckedAtThePrecisionOfFiles) {
    forEveryCloud(40, [](const Cloud& cloud) {
        if (cloud.particles.size() > 400) return;
        for (const int passes : {0, 1}) {
            SkinParams params;
            params.radius = cloud.radius;
            params.passes = passes;
            for (const Vec3& p : skinFrame(cloud.particles, params).mesh.position)
                for (int k = 0; k < 3; ++k) {
                    const volatile float written = static_cast<float>(p[k]);  // or g++ 12 may not round at all
                    ASSERT_EQ(static_cast<double>(written), p[k]);
                }
        }
    });
}

TEST(SkinFrame, RigidMotionMovesEveryVertexRigidly) {
    for (unsigned seed = 0; seed < 5; ++seed) {
        Particles box = jitteredBox(8, 8, 8, seed);
        const Vec3 turn(0.3, -0.7, 0.5), drift(1, 2, -0.5);
        for (const Vec3f& p : box.position) box.velocity.emplace_back(drift + cross(turn, Vec3(p)));
        for (const SkinParams& params : {withRadius(1.5), asInThePaper(1.5)}) {
            const SkinnedFrame frame = skinFrame(box, params);
            double worst = 0, fastest = 0;
            for (std::size_t v = 0; v < frame.mesh.position.size(); ++v) {
                const Vec3 expected = drift + cross(turn, frame.mesh.position[v]);
                worst = std::max(worst, (frame.mesh.velocity[v] - expected).length());
                fastest = std::max(fastest, expected.length());
            }
            EXPECT_LE(worst, 1e-4 * fastest);
        }
    }
}

TEST(SkinFrame, VelocityIsTheRateAtWhichVerticesMove) {
    int compared = 0;
    for (unsigned seed = 0; seed < 40; ++seed) {
        Particles box = jitteredBox(6, 6, 6, seed);
        std::mt19937 random(seed + 100);
        std::normal_distribution<float> speed(0, 1);
        for (std::size_t i = 0; i < box.size(); ++i)
            box.velocity.emplace_back(speed(random), speed(random), speed(random));
        constexpr double kStep = 1e-3;
        const auto moved = [&](double time) {
            Particles later = box;
            for (std::size_t i = 0; i < box.size(); ++i)
                later.position[i] += box.velocity[i] * static_cast<float>(time);
            return skinFrame(later, asInThePaper(1.5)).mesh;
        };
        const Mesh now = moved(0), before = moved(-kStep), after = moved(kStep);
        if (now.triangles != before.triangles || now.triangles != after.triangles) continue;
        ++compared;
        double error = 0, size = 0;
        for (std::size_t v = 0; v < now.position.size(); ++v) {
            const Vec3 difference = (after.position[v] - before.position[v]) / (2 * kStep);
            if (difference.length() > 10) continue;  // damped on purpose
            error += (now.velocity[v] - difference).length2();
            size += difference.length2();
        }
        EXPECT_LE(std::sqrt(error / size), 0.01) << "seed " << seed;
    }
    EXPECT_GE(compared, 3);
}

TEST(SkinFrame, NoParticleOfAClosedVolumeIsOutsideAfterResolvingIntersections) {
    const auto check = [](const Particles& particles, double radius) {
        for (const int passes : {0, 1, 3}) {
            SkinParams params = asInThePaper(radius);
            params.resolve_intersections = true;
            params.passes = passes;
            params.surface = SurfaceKind::alpha;
            const Mesh alpha = skinFrame(particles, params).mesh;
            params.surface = SurfaceKind::beta;
            const Mesh beta = skinFrame(particles, params).mesh;
            for (std::size_t i = 0; i < particles.size(); ++i) {
                const Vec3 p(particles.position[i]);
                if (windingNumber(alpha, p) < 0.01) continue;  // of a sheet or a tendril, not of a volume
                if (windingNumber(beta, p) > 0.5) continue;
                EXPECT_LE(distanceTo(beta, p), 1e-6 * radius)
                    << "particle " << i << " after " << passes << " passes lies neither inside nor on the surface";
            }
        }
    };
    for (unsigned seed = 0; seed < 5; ++seed) {
        SCOPED_TRACE("box " + std::to_string(seed));
        check(jitteredBox(7, 7, 7, seed), 1.5);
    }
    Particles tetrahedron;
    tetrahedron.position = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    check(tetrahedron, 1.5);
}

// All spheres of a small circle nearly share two points, where smoothing makes their tips cross.
TEST(SkinFrame, ASmallCircleIsClosedAtAnyDistanceFromTheOrigin) {
    for (const float far : {0.0F, 4e8F}) {
        Particles circle;
        for (int i = 0; i < 100; ++i) {
            const double angle = 2 * std::numbers::pi * i / 100;
            circle.position.emplace_back(far, std::cos(angle) * 0.2, std::sin(angle) * 0.2);
        }
        const MeshMeasure measure = measureMesh(skinFrame(circle, withRadius(1)).mesh);
        EXPECT_EQ(measure.unpaired_edges, 0u) << "at " << far;
        EXPECT_EQ(measure.components, 1u) << "at " << far;
        EXPECT_EQ(measure.euler, 2) << "at " << far;
    }
}

TEST(SkinFrame, PositionsBeyondTheIntegerRangeAreAnError) {
    Particles far;
    far.position = {{0, 0, 0}, {1e30f, 0, 0}};
    EXPECT_THROW(skinFrame(far, withRadius(0.01)), Error);
    EXPECT_THROW(skinFrame(far, withRadius(0)), Error);
}

TEST(SkinFrame, ARadiusLargerThanTheWholeCloudIsAnError) {
    Particles particles;
    Random random(1);
    for (int i = 0; i < 60000; ++i) particles.position.emplace_back(random.cube() + Vec3(5));
    EXPECT_THROW(skinFrame(particles, withRadius(100)), Error);
    EXPECT_NO_THROW(skinFrame(particles, withRadius(0.08)));
}

TEST(SkinFrame, RefusesARadiusOutOfScaleWithTheSpacing) {
    Particles particles;
    particles.position = {{0, 0, 0}, {1, 0, 0}};
    for (const double spacing : {1e-12, 0.009, 101.0, 1e12}) {
        SkinParams params = withRadius(1);
        params.spacing = spacing;
        EXPECT_THROW(skinFrame(particles, params), Error) << spacing;
        EXPECT_THROW(skinPlane(particles, params), Error) << spacing;
    }
    for (const double spacing : {0.02, 1.0, 99.0}) {
        SkinParams params = withRadius(1);
        params.spacing = spacing;
        EXPECT_FALSE(skinFrame(particles, params).mesh.triangles.empty()) << spacing;
    }
}

}  // namespace betamesh
