#include "support/planar_clouds.h"

#include "base/random.h"
#include "exact/snapped_particles.h"

#include <gtest/gtest.h>

#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <iterator>
#include <numbers>

namespace betamesh {

namespace {

using Points = std::vector<Vec3>;

Cloud cloud(std::string name, const Points& points, double radius, double z = 0) {
    Cloud made{std::move(name), {}, radius};
    for (std::size_t i = 0; i < points.size(); ++i) {
        made.particles.position.emplace_back(Vec3(points[i].x, points[i].y, z));
        const Vec3 velocity = Random(17, i).ball() * radius;
        made.particles.velocity.emplace_back(Vec3(velocity.x, velocity.y, 0));
        made.particles.id.push_back(i);
    }
    return made;
}

Points lattice(int width, int height, const Vec3& step = {1, 1, 0}) {
    Points points;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) points.push_back(Vec3(x, y, 0) * step);
    return points;
}

Points jittered(Points points, double amplitude, std::uint64_t seed) {
    for (std::size_t i = 0; i < points.size(); ++i) points[i] += Random(seed, i).cube() * amplitude;
    return points;
}

Points concatenate(Points a, const Points& b, const Vec3& offset = {0, 0, 0}) {
    for (const Vec3& p : b) a.push_back(p + offset);
    return a;
}

Points ring(int n, double radius) {
    Points points;
    for (int i = 0; i < n; ++i) {
        const double angle = 2 * std::numbers::pi * i / n;
        points.push_back(Vec3(std::cos(angle), std::sin(angle), 0) * radius);
    }
    return points;
}

// All integer points at exactly that distance from the origin.
Points wholeCircle(int radius) {
    Points points;
    for (int y = -radius; y <= radius; ++y)
        for (int x = -radius; x <= radius; ++x)
            if (x * x + y * y == radius * radius) points.emplace_back(x, y, 0);
    return points;
}

void addFew(std::vector<Cloud>& clouds) {
    clouds.push_back(cloud("empty", {}, 1));
    clouds.push_back(cloud("one", {{0.5, -2, 0}}, 1, 3));
    for (const double distance : {0x1p-19, 0x1p-10, 0.25, 1.0, 2 - 0x1p-19, 2.0, 2 + 0x1p-19, 3.0})
        for (const Vec3& way : {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 1, 0), Vec3(0, -1, 0)})
            clouds.push_back(
                cloud("two at " + std::to_string(distance) + " r", {{1, 1, 0}, Vec3(1, 1, 0) + way * distance}, 1));
    clouds.push_back(cloud("two at exactly 2r, aslant", {{0, 0, 0}, {6, 8, 0}}, 5));
    clouds.push_back(cloud("five coincident", Points(5, {1, 2, 0}), 1, -7));
    clouds.push_back(cloud("three on a line", {{0, 0, 0}, {1, 2, 0}, {3, 6, 0}}, 4));
    clouds.push_back(cloud("three in a chain of contacts", {{0, 0, 0}, {2, 0, 0}, {4, 0, 0}}, 1));
    clouds.push_back(cloud("three: equilateral", {{0, 0, 0}, {1, 0, 0}, {0.5, std::sqrt(0.75), 0}}, 1));
    clouds.push_back(cloud("three: circumradius exactly r, right", {{0, 0, 0}, {6, 0, 0}, {0, 8, 0}}, 5));
    clouds.push_back(cloud("three: circumradius exactly r, acute", {{5, 0, 0}, {-3, 4, 0}, {-3, -4, 0}}, 5));
    clouds.push_back(cloud("three: circumradius exactly r, obtuse", {{5, 0, 0}, {4, 3, 0}, {3, 4, 0}}, 5));
    clouds.push_back(cloud("three: each touches both others", {{0, 0, 0}, {2, 0, 0}, {1, std::sqrt(3.0), 0}}, 1));
    clouds.push_back(cloud("contact with two that nearly coincide", {{0, 0, 0}, {2, 0, 0}, {2, 0x1p-19, 0}}, 1));
    clouds.push_back(cloud("contact with two behind each other", {{0, 0, 0}, {2, 0, 0}, {2 - 0x1p-19, 0, 0}}, 1));
    clouds.push_back(
        cloud("four: square, circumradius exactly r", {{3, 4, 0}, {-4, 3, 0}, {-3, -4, 0}, {4, -3, 0}}, 5));
}

void addTies(std::vector<Cloud>& clouds) {
    for (const double radius : {0.5, std::sqrt(0.5), 0.75, 1.0, 1.25, 1.5, 2.0, 3.0})
        clouds.push_back(cloud("lattice, r/dx " + std::to_string(radius), lattice(7, 6), radius));
    clouds.push_back(cloud("lattice, circumradius exactly r", lattice(6, 6, {6, 8, 0}), 5));
    clouds.push_back(cloud("lattice, contacts at exactly 2r", lattice(5, 5, {10, 10, 0}), 5));
    clouds.push_back(cloud("line", lattice(12, 1), 1.5));
    clouds.push_back(cloud("line, aslant", lattice(12, 1, {1, 1, 0}), 1.5));
    Points diagonal;
    for (int i = 0; i < 12; ++i) diagonal.emplace_back(3 * i, 4 * i, 0);
    clouds.push_back(cloud("line, contacts at exactly 2r", diagonal, 2.5));
    for (const int radius : {5, 13, 25, 65}) {
        const Points circle = wholeCircle(radius);
        const std::string name = "all on one circle of radius " + std::to_string(radius);
        clouds.push_back(cloud(name + " = r", circle, radius));
        clouds.push_back(cloud(name + " < r", circle, radius + 0.5));
        clouds.push_back(cloud(name + " > r", circle, radius - 0.5));
        clouds.push_back(cloud(name + " = r, and its centre", concatenate(circle, {{0, 0, 0}}), radius));
    }
    clouds.push_back(cloud("two circles of radius r that share a point",
                           concatenate(wholeCircle(5), wholeCircle(5), {10, 0, 0}), 5));
}

void addLiquids(std::vector<Cloud>& clouds) {
    clouds.push_back(cloud("block", jittered(lattice(14, 14), 0.25, 1), 1.5));
    clouds.push_back(cloud("filament", jittered(lattice(20, 1), 0.25, 2), 1.5));
    clouds.push_back(cloud("filament on a block",
                           concatenate(jittered(lattice(8, 8), 0.2, 3), lattice(1, 9, {1, 1.25, 0}), {4, 8, 0}), 1.5));
    clouds.push_back(cloud("ring", ring(40, 6), 1.5));
    clouds.push_back(cloud("ring that nearly closes over", ring(48, 6), 5.75));
    clouds.push_back(cloud("drop inside a ring", concatenate(ring(40, 6), {{0.25, 0, 0}}), 1.5));
    clouds.push_back(cloud("ring inside a ring inside a ring",
                           concatenate(concatenate(ring(30, 4), ring(60, 9)), ring(90, 14)), 1.25));
    clouds.push_back(cloud("spray", jittered(lattice(8, 8, {4, 4, 0}), 2, 4), 1.5));
    clouds.push_back(cloud("clump", jittered(Points(300, {0, 0, 0}), 0.7, 5), 1));
    clouds.push_back(cloud("nearly coincident", jittered(Points(40, {1, 1, 0}), 1e-6, 6), 1));
    clouds.push_back(cloud("every particle twice",
                           concatenate(jittered(lattice(6, 6), 0.25, 7), jittered(lattice(6, 6), 0.25, 7)), 1.5));
    clouds.push_back(
        cloud("pairs that nearly coincide", concatenate(lattice(6, 6), lattice(6, 6), {0x1p-16, 0, 0}), 1.5));
    clouds.push_back(
        cloud("far from the origin", concatenate({}, jittered(lattice(8, 8), 0.25, 8), {1e5, -1e5, 0}), 1.5, 1e5));
}

}  // namespace

std::vector<Cloud> awkwardPlanarClouds() {
    std::vector<Cloud> clouds;
    addFew(clouds);
    addTies(clouds);
    addLiquids(clouds);
    return clouds;
}

Cloud randomPlanarCloud(std::uint64_t seed) {
    Random random(seed, 2);
    const std::size_t n = 1 + random.below(40);
    const bool snapped = seed % 2 == 0;
    const double edge = std::ceil(std::sqrt(static_cast<double>(n)));
    Points points(n, Vec3(0));
    for (Vec3& p : points)
        for (int axis = 0; axis < 2; ++axis)
            p[axis] = snapped ? static_cast<double>(random.below(static_cast<std::uint64_t>(edge) + 1))
                              : random.between(0, edge);
    if (random.below(5) == 0)
        for (std::size_t i = n / 2; i < n; ++i) points[i] = points[random.below(n)];
    static constexpr double kTies[] = {0.5, 0.75, 1, 1.25, 1.5, 2, 2.5, 3};
    const double radius = snapped ? kTies[random.below(std::size(kTies))] : random.between(0.6, 3);
    return cloud("random planar cloud " + std::to_string(seed), points, radius, seed % 3 == 0 ? 0.5 : 0);
}

void forEveryPlanarCloud(std::uint64_t random_clouds, const std::function<void(const Cloud&)>& check) {
    const auto checkOne = [&](const Cloud& cloud) {
        SCOPED_TRACE(cloud.name);
        if (!testing::Test::HasFailure()) check(cloud);
    };
    for (const Cloud& cloud : awkwardPlanarClouds()) checkOne(cloud);
    for (std::uint64_t seed = 0; seed < random_clouds && !testing::Test::HasFailure(); ++seed)
        checkOne(randomPlanarCloud(seed));
}

SegmentSet bruteForceAlphaSegments(const Particles& particles, double radius) {
    namespace mp = boost::multiprecision;
    using Whole = mp::number<mp::cpp_int_backend<1024, 1024, mp::signed_magnitude, mp::unchecked, void>>;
    const SnappedParticles snapped = snapParticles(particles, radius);
    constexpr int kFiner = 128;  // bits
    const Whole r = (Whole(snapped.radius) << kFiner) + 1;
    struct Point {
        Whole x, y;
        Point operator-(const Point& o) const { return {x - o.x, y - o.y}; }
        Whole dot(const Point& o) const { return x * o.x + y * o.y; }
        Whole cross(const Point& o) const { return x * o.y - y * o.x; }
    };
    std::vector<Point> points;
    for (const Vec3i& p : snapped.position) points.push_back({Whole(p.x) << kFiner, Whole(p.y) << kFiner});

    SegmentSet segments;
    for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t j = 0; j < points.size(); ++j) {
            const Point u = points[j] - points[i];
            const Whole uu = u.dot(u), d = 4 * r * r - uu;
            if (i == j || d < 0) continue;
            bool empty = true;
            for (std::size_t k = 0; empty && k < points.size(); ++k) {
                if (k == i || k == j) continue;
                // |w - c|² - r² = a + b √(d / uu) for the centre c to the right of u
                const Point w = points[k] - points[i];
                const Whole a = w.dot(w) - w.dot(u), b = u.cross(w);
                const Whole weight = a * a * uu * a.sign() + b * b * d * b.sign();
                EXPECT_NE(weight, 0) << "no tie is left at a larger radius";
                empty = weight > 0;
            }
            if (empty) segments.insert({snapped.row[i], snapped.row[j]});
        }
    return segments;
}

}  // namespace betamesh
