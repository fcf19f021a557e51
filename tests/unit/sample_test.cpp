#include "sample/sample.h"

#include "base/parallel.h"
#include "base/random.h"
#include "betamesh/error.h"
#include "skin/spacing.h"
#include "support/clouds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>

namespace betamesh {
namespace {

template <typename T>
bool sameBytes(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

bool sameBytes(const Particles& a, const Particles& b) {
    return sameBytes(a.position, b.position) && sameBytes(a.velocity, b.velocity) && sameBytes(a.id, b.id);
}

constexpr std::array kWithSolver{"dambreak", "dambreak2d", "rotcube"};

bool hasSolver(const std::string& name) {
    return std::find(kWithSolver.begin(), kWithSolver.end(), name) != kWithSolver.end();
}

double fastest(const Particles& particles) {
    double speed = 0;
    for (const Vec3f& v : particles.velocity) speed = std::max(speed, static_cast<double>(v.length()));
    return speed;
}

TEST(Sample, RejectsUnknownNamesAndInvalidFrameRates) {
    try {
        Sample({.name = "dambrake"});
        FAIL() << "no error";
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("dambrake"), std::string::npos);
        for (const SampleInfo& info : samples())
            EXPECT_NE(std::string(error.what()).find(info.name), std::string::npos) << info.name;
    }
    EXPECT_THROW(Sample({.name = "sheet", .frames_per_second = 0}), Error);
    EXPECT_THROW(Sample({.name = "sheet", .frames_per_second = std::nan("")}), Error);
}

TEST(Sample, EveryFrameIsValidAndRowsAreSortedById) {
    for (const SampleInfo& info : samples()) {
        SCOPED_TRACE(info.name);
        Sample sample({.name = info.name, .particles = 1500});
        const std::size_t n = sample.frame(1).size();
        for (const int number : {-3, 1, 2, 12, 24}) {
            const Particles particles = sample.frame(number);
            validate(particles);
            ASSERT_EQ(particles.size(), n);
            ASSERT_EQ(particles.velocity.size(), n);
            ASSERT_EQ(particles.id.size(), n);
            for (std::size_t i = 0; i < n; ++i) ASSERT_EQ(particles.id[i], i);
        }
    }
}

TEST(Sample, HasAboutTheRequestedNumberOfParticles) {
    for (const SampleInfo& info : samples()) {
        SCOPED_TRACE(info.name);
        EXPECT_NEAR(static_cast<double>(Sample({.name = info.name}).frame(1).size()),
                    static_cast<double>(info.particles), 0.05 * static_cast<double>(info.particles));
        for (const std::size_t n : {1000u, 5000u, 100000u})
            EXPECT_NEAR(static_cast<double>(Sample({.name = info.name, .particles = n}).frame(1).size()),
                        static_cast<double>(n), 0.12 * static_cast<double>(n));
        for (const std::size_t n : {1u, 2u, 7u, 50u}) {
            const std::size_t got = Sample({.name = info.name, .particles = n}).frame(3).size();
            EXPECT_GE(got, 1u);
            EXPECT_LE(got, n + 60);
        }
    }
}

TEST(Sample, VelocitiesOfFormulasAreDerivatives) {
    for (const SampleInfo& info : samples()) {
        if (hasSolver(info.name)) continue;
        SCOPED_TRACE(info.name);
        constexpr double kRate = 1000;
        Sample sample({.name = info.name, .particles = 1500, .frames_per_second = kRate});
        for (const int number : {100, 450, 1200}) {
            const Particles before = sample.frame(number - 1), now = sample.frame(number),
                            after = sample.frame(number + 1);
            const double tolerance = 2e-4 + 1e-3 * fastest(now);  // rounding of positions, then of the difference
            for (std::size_t i = 0; i < now.size(); ++i) {
                const Vec3 difference = (Vec3(after.position[i]) - Vec3(before.position[i])) * (kRate / 2);
                ASSERT_LT((difference - Vec3(now.velocity[i])).length(), tolerance) << "particle " << i;
            }
        }
    }
}

TEST(Sample, VelocitiesOfSimulationsAreTheLastDisplacements) {
    for (const char* name : kWithSolver) {
        SCOPED_TRACE(name);
        constexpr double kRate = 2000;  // so short a frame is one step of the solver
        Sample sample({.name = name, .particles = 1500, .frames_per_second = kRate});
        Particles before = sample.frame(300);
        for (int number = 301; number < 304; ++number) {
            const Particles now = sample.frame(number);
            for (std::size_t i = 0; i < now.size(); ++i) {
                const Vec3 moved = (Vec3(now.position[i]) - Vec3(before.position[i])) * kRate;
                ASSERT_LT((moved - Vec3(now.velocity[i])).length(), 1e-3) << "particle " << i;
            }
            before = now;
        }
    }
}

TEST(Sample, BytesDoNotDependOnTheOrderOfRequestsOrTheThreadCount) {
    for (const SampleInfo& info : samples()) {
        SCOPED_TRACE(info.name);
        const SampleParams params{.name = info.name, .particles = 4000, .seed = 7};
        Sample forward(params);
        const Particles six = forward.frame(6), nine = forward.frame(9);
        Sample backward(params);
        EXPECT_TRUE(sameBytes(backward.frame(9), nine));
        EXPECT_TRUE(sameBytes(backward.frame(6), six));
        for (const int threads : {1, 2, 7}) {
            withThreads(threads,
                        [&] { EXPECT_TRUE(sameBytes(Sample(params).frame(9), nine)) << threads << " threads"; });
        }
    }
}

TEST(Sample, TheSeedChangesEverySceneButTheLattice) {
    for (const SampleInfo& info : samples()) {
        SCOPED_TRACE(info.name);
        Sample one({.name = info.name, .particles = 1000, .seed = 1}),
            two({.name = info.name, .particles = 1000, .seed = 2});
        EXPECT_EQ(sameBytes(one.frame(3), two.frame(3)), info.name == "lattice");
    }
}

TEST(Sample, SpacingIsPlausible) {
    for (const SampleInfo& info : samples()) {
        SCOPED_TRACE(info.name);
        Sample sample({.name = info.name, .particles = 8000});
        for (const int number : {1, 8, 16}) {
            const double measured = spacingOf(sample.frame(number).position).value().spacing;
            EXPECT_GT(measured, 0.7 * sample.spacing()) << "frame " << number;
            EXPECT_LT(measured, 1.2 * sample.spacing()) << "frame " << number;
        }
    }
}

TEST(Sample, LatticeIsExact) {
    Sample sample({.name = "lattice", .particles = 1000});
    EXPECT_EQ(sample.spacing(), 1.0 / 64);
    const Particles particles = sample.frame(5);
    std::set<std::array<float, 3>> places;
    for (std::size_t i = 0; i < particles.size(); ++i) {
        EXPECT_EQ(particles.velocity[i], Vec3f(0, 0, 0));
        const Vec3f p = particles.position[i] * 64.0f;
        EXPECT_EQ(p, Vec3f(std::round(p.x), std::round(p.y), std::round(p.z)));
        places.insert({p.x, p.y, p.z});
    }
    EXPECT_EQ(places.size(), 1000u);
}

TEST(Sample, DamBreakStaysInItsTankAndSplashes) {
    Sample sample({.name = "dambreak", .particles = 8000});
    const auto highest = [](const Particles& particles) {
        float y = 0;
        for (const Vec3f& p : particles.position) y = std::max(y, p.y);
        return y;
    };
    EXPECT_LT(highest(sample.frame(1)), 1.05f);
    const Particles splash = sample.frame(24);
    EXPECT_GT(highest(splash), 1.2f);
    double centre = 0;
    for (const Vec3f& p : splash.position) {
        EXPECT_TRUE(p.x > 0 && p.x < 3 && p.y > 0 && p.z > 0 && p.z < 1) << p;
        EXPECT_FALSE(p.x > 1.5f && p.x < 1.8f && p.y < 0.5f && p.z > 0.3f && p.z < 0.7f) << p;
        centre += p.x / static_cast<double>(splash.size());
    }
    EXPECT_GT(centre, 0.9);  // from 0.5
}

TEST(Sample, TheTwoDimensionalDamBreakStaysInItsPlane) {
    Sample sample({.name = "dambreak2d", .particles = 2000});
    const Particles splash = sample.frame(30);
    float highest = 0;
    for (std::size_t i = 0; i < splash.size(); ++i) {
        const Vec3f& p = splash.position[i];
        EXPECT_TRUE(p.x > 0 && p.x < 3 && p.y > 0 && p.z == 0 && splash.velocity[i].z == 0) << p;
        highest = std::max(highest, p.y);
    }
    EXPECT_GT(highest, 1.2f);
}

TEST(Sample, TheRotatingCubeKeepsItsCentreAndFliesApart) {
    Sample sample({.name = "rotcube", .particles = 8000});
    const Particles first = sample.frame(1), late = sample.frame(24);
    Vec3 centre(0, 0, 0);
    double reach = 0;
    for (const Vec3f& p : late.position) {
        centre += Vec3(p) / static_cast<double>(late.size());
        reach = std::max(reach, static_cast<double>(p.length()));
    }
    EXPECT_LT(centre.length(), 0.02);
    EXPECT_GT(reach, 1.5);  // from 0.87
    EXPECT_LT(fastest(late), 1.2 * fastest(first));
}

TEST(Clouds, AreValidHaveUniqueNamesAndShuffleWithoutLoss) {
    std::set<std::string> names;
    std::vector<Cloud> clouds = awkwardClouds();
    for (std::uint64_t seed = 0; seed < 300; ++seed) {
        clouds.push_back(randomCloud(seed));
        EXPECT_TRUE(sameBytes(clouds.back().particles, randomCloud(seed).particles));
        EXPECT_GE(clouds.back().particles.size(), 3u);
        EXPECT_LE(clouds.back().particles.size(), 40u);
    }
    for (const Cloud& cloud : clouds) {
        SCOPED_TRACE(cloud.name);
        EXPECT_TRUE(names.insert(cloud.name).second) << "twice";
        EXPECT_GT(cloud.radius, 0);
        validate(cloud.particles);
        const Particles mixed = shuffled(cloud.particles, 3);
        ASSERT_EQ(mixed.size(), cloud.particles.size());
        std::set<std::uint64_t> ids;
        for (std::size_t i = 0; i < mixed.size(); ++i) {
            ids.insert(mixed.id[i]);
            ASSERT_EQ(mixed.position[i], cloud.particles.position[mixed.id[i]]);
            ASSERT_EQ(mixed.velocity[i], cloud.particles.velocity[mixed.id[i]]);
        }
        EXPECT_EQ(ids.size(), mixed.size());
    }
}

}  // namespace
}  // namespace betamesh
