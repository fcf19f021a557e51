#include "support/clouds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <numeric>

namespace betamesh {

namespace {

using Points = std::vector<Vec3>;

Particles particlesFrom(const Points& points, double radius) {
    Particles particles;
    for (std::size_t i = 0; i < points.size(); ++i) {
        particles.position.push_back(Vec3f(points[i]));
        particles.velocity.push_back(Vec3f(Random(17, i).ball() * radius));
        particles.id.push_back(i);
    }
    return particles;
}

Cloud cloud(std::string name, const Points& points, double radius) {
    return {std::move(name), particlesFrom(points, radius), radius};
}

Points moved(Points points, const Vec3& by) {
    for (Vec3& p : points) p += by;
    return points;
}

Points concatenate(Points a, const Points& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

// All integer points of a box that `wanted` accepts, times the scale.
template <typename Wanted>
Points wholeNumbers(const Vec3i& low, const Vec3i& high, double scale, const Wanted& wanted) {
    Points points;
    for (std::int64_t z = low.z; z <= high.z; ++z)
        for (std::int64_t y = low.y; y <= high.y; ++y)
            for (std::int64_t x = low.x; x <= high.x; ++x)
                if (wanted(Vec3i(x, y, z))) points.push_back(toDouble({x, y, z}) * scale);
    return points;
}

Points lattice(const Vec3i& size, const Vec3& step = {1, 1, 1}) {
    Points points = wholeNumbers({0, 0, 0}, size - Vec3i(1, 1, 1), 1, [](const Vec3i&) { return true; });
    for (Vec3& p : points) p *= step;
    return points;
}

// All integer points at exactly that distance from the origin.
Points sphereOfWholeNumbers(std::int64_t radius) {
    const Vec3i corner(radius, radius, radius);
    return wholeNumbers(-corner, corner, 1, [&](const Vec3i& p) { return p.length2() == radius * radius; });
}

// The integer points of a ball or, with a hollow, of a shell.
Points latticeBall(double outer, double hollow = 0, double scale = 1) {
    const auto n = static_cast<std::int64_t>(outer) + 1;
    return wholeNumbers({-n, -n, -n}, {n, n, n}, scale, [&](const Vec3i& p) {
        const double d = toDouble(p).length();
        return d <= outer && d >= hollow;
    });
}

Points jittered(Points points, double amplitude, std::uint64_t seed) {
    for (std::size_t i = 0; i < points.size(); ++i) points[i] += Random(seed, i).cube() * amplitude;
    return points;
}

Points randomBox(std::size_t n, const Vec3& size, std::uint64_t seed) {
    Points points;
    for (std::size_t i = 0; i < n; ++i) points.push_back(Random(seed, i).cube() * size * 0.5);
    return points;
}

// A frame not aligned with the grid, so that no coordinate is exact.
Points rotated(Points points) {
    const Vec3 u = Vec3(1, 2, 3).normalized(), v = Vec3(1, 2, 3).cross(Vec3(3, -1, 1)).normalized();
    const Vec3 w = u.cross(v);
    for (Vec3& p : points) p = u * p.x + v * p.y + w * p.z;
    return points;
}

void addFew(std::vector<Cloud>& clouds) {
    clouds.push_back(cloud("empty", {}, 1));
    clouds.push_back(cloud("one", {{0.5, -2, 3}}, 1));
    for (const double distance : {0x1p-20, 0.25, 1.0, 2 - 0x1p-20, 2.0, 2 + 0x1p-20, 3.0, 100.0})
        clouds.push_back(cloud("two at " + std::to_string(distance) + " r", {{1, 1, 1}, {1 + distance, 1, 1}}, 1));
    clouds.push_back(cloud("two at exactly 2r, aslant", {{0, 0, 0}, {6, 8, 0}}, 5));
    clouds.push_back(cloud("two at exactly 2r, in space", {{0, 0, 0}, {2, 4, 4}}, 3));
    clouds.push_back(cloud("five coincident", Points(5, {1, 2, 3}), 1));
    clouds.push_back(cloud("three, equilateral", {{0, 0, 0}, {1, 0, 0}, {0.5, std::sqrt(0.75), 0}}, 1));
    clouds.push_back(cloud("three on a right triangle, circumradius exactly r", {{0, 0, 0}, {6, 0, 0}, {0, 8, 0}}, 5));
    clouds.push_back(cloud("three on a circle round r, obtuse", {{5, 0, 0}, {4, 3, 0}, {3, 4, 0}}, 5));
    clouds.push_back(cloud("three on a circle round r, acute", {{5, 0, 0}, {-3, 4, 0}, {-3, -4, 0}}, 5));
    clouds.push_back(cloud("three too far for a triangle", {{0, 0, 0}, {1.75, 0, 0}, {0.875, 1.75, 0}}, 1));
    clouds.push_back(cloud("three in a chain of contacts", {{0, 0, 0}, {2, 0, 0}, {4, 0, 0}}, 1));
    clouds.push_back(cloud("four: square", lattice({2, 2, 1}), 1));
    clouds.push_back(
        cloud("four: square, circumradius exactly r", {{3, 4, 0}, {-4, 3, 0}, {-3, -4, 0}, {4, -3, 0}}, 5));
    const Points tetrahedron = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
    for (const double radius : {1.25, 1.5, 1.625, 1.75, 2.0, 4.0})
        clouds.push_back(cloud("four: regular tetrahedron, r = " + std::to_string(radius), tetrahedron, radius));
    clouds.push_back(cloud("five: tetrahedron and its centre", concatenate(tetrahedron, {{0, 0, 0}}), 2));
    clouds.push_back(cloud("five: square pyramid", concatenate(lattice({2, 2, 1}), {{0.5, 0.5, 0.75}}), 1));
    clouds.push_back(
        cloud("six: octahedron", {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}, 1.5));
}

void addExactTies(std::vector<Cloud>& clouds) {
    clouds.push_back(cloud("collinear lattice", lattice({12, 1, 1}), 1.5));
    clouds.push_back(cloud("collinear, contacts at exactly 2r", lattice({12, 1, 1}, {2, 2, 2}), 1));
    clouds.push_back(cloud("collinear, aslant", rotated(lattice({12, 1, 1})), 1.5));
    for (const double radius : {0.5, 0.75, 1.0, 1.5, 2.0})
        clouds.push_back(cloud("plane lattice, r/dx " + std::to_string(radius), lattice({7, 6, 1}), radius));
    clouds.push_back(cloud("plane lattice, circumradius exactly r", lattice({6, 6, 1}, {6, 8, 1}), 5));
    clouds.push_back(cloud("plane lattice, aslant", rotated(lattice({7, 6, 1})), 1.5));
    // 1/√2 and √3/2, half diagonals of face and cell, are where the lattice's topology changes.
    for (const double radius : {0.5, std::sqrt(0.5), 0.75, std::sqrt(0.75), 0.875, 1.0, 1.25, 1.5, 2.0, 3.0})
        clouds.push_back(cloud("cubic lattice, r/dx " + std::to_string(radius), lattice({5, 5, 5}), radius));
    clouds.push_back(cloud("box lattice, every cell's circumradius exactly r", lattice({5, 4, 4}, {2, 4, 4}), 3));
    clouds.push_back(cloud("box lattice, contacts at exactly 2r", lattice({4, 4, 4}, {6, 8, 10}), 5));
    const auto even = [](const Vec3i& p) { return (p.x + p.y + p.z) % 2 == 0; };
    clouds.push_back(cloud("FCC", wholeNumbers({0, 0, 0}, {5, 5, 5}, 1, even), 2));
    clouds.push_back(cloud("FCC, octahedral holes exactly r", wholeNumbers({0, 0, 0}, {5, 5, 5}, 1, even), 1));
    const auto alike = [](const Vec3i& p) { return p.x % 2 == p.y % 2 && p.y % 2 == p.z % 2; };
    clouds.push_back(cloud("BCC", wholeNumbers({0, 0, 0}, {6, 6, 6}, 1, alike), 2.5));
    clouds.push_back(cloud("BCC, holes nearly r", wholeNumbers({0, 0, 0}, {6, 6, 6}, 1, alike), std::sqrt(1.25)));
    for (const std::int64_t radius : {3, 5, 7, 9}) {
        const auto r = static_cast<double>(radius);
        const Points sphere = sphereOfWholeNumbers(radius);
        const std::string name = "all on one sphere of radius " + std::to_string(radius);
        clouds.push_back(cloud(name + " = r", sphere, r));
        clouds.push_back(cloud(name + " < r", sphere, r + 0.5));
        clouds.push_back(cloud(name + " = r, and its centre", concatenate(sphere, {{0, 0, 0}}), r));
    }
    const Points two_spheres = concatenate(sphereOfWholeNumbers(5), moved(sphereOfWholeNumbers(5), {10, 0, 0}));
    clouds.push_back(cloud("two spheres of radius r that share a point", two_spheres, 5));
    Points circle;
    for (const Vec3& p : sphereOfWholeNumbers(5))
        if (p.z == 0) circle.push_back(p);
    clouds.push_back(cloud("all on one circle of radius r", circle, 5));
    clouds.push_back(cloud("all on one circle, r-balls on both sides", circle, 13));
    clouds.push_back(cloud("circle and apex on one sphere of radius 13 = r",
                           concatenate(moved(circle, {0, 0, 12}), {{0, 0, -13}, {12, 0, 5}}), 13));
}

void addLiquids(std::vector<Cloud>& clouds) {
    clouds.push_back(cloud("sheet", jittered(lattice({12, 12, 1}), 0.25, 1), 1.5));
    clouds.push_back(cloud("double sheet",
                           concatenate(jittered(lattice({10, 10, 1}), 0.2, 2), moved(lattice({10, 10, 1}), {0, 0, 4})),
                           1.5));
    clouds.push_back(cloud("two sheets that just interact",
                           concatenate(lattice({8, 8, 1}), moved(lattice({8, 8, 1}), {0.5, 0.5, 2.5})), 1.5));
    Points tendril;
    for (int i = 0; i < 40; ++i) tendril.push_back({0.1 * i * std::sqrt(i), std::sin(0.7 * i), std::cos(0.5 * i)});
    clouds.push_back(cloud("tendril, thinning into drops", tendril, 1.5));
    clouds.push_back(cloud(
        "tendril with a sheet at its end",
        concatenate(jittered(lattice({6, 6, 1}), 0.2, 3), moved(lattice({1, 1, 9}, {1, 1, 1.25}), {2, 2, 1})), 1.5));
    clouds.push_back(cloud("ball of a lattice", latticeBall(4), 1.5));
    clouds.push_back(cloud("ball, jittered", jittered(latticeBall(4), 0.25, 4), 1.5));
    clouds.push_back(cloud("bubble: hollow shell", jittered(latticeBall(6, 4.5), 0.25, 5), 1.5));
    clouds.push_back(cloud("bubble: shell of one layer", latticeBall(4.2, 3.7), 1.5));
    clouds.push_back(cloud("drop inside a bubble", concatenate(latticeBall(7, 6), latticeBall(1.5)), 1.5));
    clouds.push_back(cloud("two balls that touch", concatenate(latticeBall(3), moved(latticeBall(3), {7, 0, 0})), 1.5));
    clouds.push_back(cloud("two balls with surfaces at exactly 2r",
                           concatenate(latticeBall(3), moved(latticeBall(3), {9, 0, 0})), 1.5));
    clouds.push_back(
        cloud("drop over a sheet", concatenate(lattice({9, 9, 1}), moved(latticeBall(2), {4, 4, 4.5})), 1.5));
    Points ring;
    for (int i = 0; i < 48; ++i) {
        const double angle = 2 * std::numbers::pi * i / 48;
        ring.push_back({6 * std::cos(angle), 6 * std::sin(angle), 0});
    }
    clouds.push_back(cloud("ring", ring, 1.5));
    clouds.push_back(cloud("ring that nearly closes over", ring, 5.75));
}

void addDense(std::vector<Cloud>& clouds) {
    Points clump;
    for (std::size_t i = 0; i < 2001; ++i) clump.push_back(Random(6, i).ball() * 0.75);
    clouds.push_back(cloud("clump: everyone within 2r of everyone", clump, 1));
    clouds.push_back(cloud(
        "clump on a plane",
        [&] {
            Points flat = clump;
            flat.resize(300);
            for (Vec3& p : flat) p.z = 0.5;
            return flat;
        }(),
        1));
    Points sphere;
    for (std::size_t i = 0; i < 300; ++i) sphere.push_back(Random(18, i).ball().normalized() * 1.5);
    clouds.push_back(cloud("three hundred on one sphere of radius r, but for rounding", sphere, 1.5));
    const Points ball = jittered(latticeBall(3), 0.25, 7);
    clouds.push_back(cloud("every particle twice", concatenate(ball, ball), 1.5));
    clouds.push_back(cloud("every particle nearly twice", concatenate(ball, jittered(ball, 1e-6, 8)), 1.5));
    clouds.push_back(cloud("nearly coincident", jittered(Points(40, {1, 1, 1}), 1e-6, 9), 1));
    Points pairs;
    for (const Vec3& p : lattice({4, 4, 4})) pairs.insert(pairs.end(), {p, p + Vec3(0x1p-16, 0, 0)});
    clouds.push_back(cloud("cubic lattice of close pairs", pairs, 1.5));
}

void addScales(std::vector<Cloud>& clouds) {
    const Points ball = jittered(latticeBall(3), 0.25, 10);
    clouds.push_back(cloud("far from the origin", moved(ball, {1e6, -1e6, 1e6}), 1.5));
    clouds.push_back(cloud("lattice far from the origin", moved(lattice({4, 4, 4}), {0x1p20, -0x1p20, 0x1p20}), 1.5));
    Points small = ball, large = ball;
    for (Vec3& p : small) p *= 1e-6;
    for (Vec3& p : large) p *= 1e5;
    clouds.push_back(cloud("tiny", small, 1.5e-6));
    clouds.push_back(cloud("large", large, 1.5e5));
    clouds.push_back(
        cloud("two groups, a thousand radii apart", concatenate(ball, moved(ball, {1500, 700, -300})), 1.5));
    clouds.push_back(cloud("sparse: nobody meets anybody", randomBox(60, {400, 400, 400}, 11), 1));
}

void addRandom(std::vector<Cloud>& clouds) {
    for (const double radius : {0.6, 0.8, 1.0, 1.5, 2.0, 3.0})
        clouds.push_back(cloud("random box, r/dx " + std::to_string(radius), randomBox(343, {7, 7, 7}, 12), radius));
    clouds.push_back(cloud("random plane", randomBox(100, {10, 10, 0}, 13), 1.5));
    clouds.push_back(cloud("random line", randomBox(40, {30, 0, 0}, 14), 1.5));
    clouds.push_back(cloud("random ball of 2,000", jittered(latticeBall(7.8), 0.4, 15), 1.5));
}

}  // namespace

std::vector<Cloud> awkwardClouds() {
    std::vector<Cloud> clouds;
    addFew(clouds);
    addExactTies(clouds);
    addLiquids(clouds);
    addDense(clouds);
    addScales(clouds);
    addRandom(clouds);
    return clouds;
}

Cloud randomCloud(std::uint64_t seed) {
    Random random(seed);
    const std::size_t n = 3 + random.below(38);
    const bool snapped = random.below(3) == 0;
    const auto dimension = static_cast<int>(random.below(8) == 0 ? 1 + random.below(2) : 3);

    // A mean spacing of 1, so that the radius is r/dx; grid points have spacing 1, too, but there are more of them.
    const double edge = std::ceil(std::pow(static_cast<double>(n), 1.0 / dimension));
    Points points(n, Vec3(0));
    for (Vec3& p : points) {
        for (int axis = 0; axis < dimension; ++axis)
            p[axis] = snapped ? static_cast<double>(random.below(static_cast<std::uint64_t>(edge) + 1))
                              : random.between(0, edge);
        // For half of the flat clouds the plane or line is not aligned with the grid.
        if (dimension < 3 && seed % 2 == 1) p = {p.x, p.y, p.x + p.y};
    }
    if (random.below(5) == 0)
        for (std::size_t i = n / 2; i < n; ++i) points[i] = points[random.below(n / 2)];

    static constexpr double kTies[] = {1, 1.5, 2, 2.5, 3, 1.25, 0.75};
    const double radius = snapped ? kTies[random.below(std::size(kTies))] : random.between(0.6, 3);
    std::string name = "random cloud " + std::to_string(seed) + ": " + std::to_string(n) + " particles, ";
    name += (snapped ? "grid, " : "") + std::to_string(dimension) + "D, r/dx " + std::to_string(radius);
    return cloud(std::move(name), points, radius);
}

void forEveryCloud(std::uint64_t random_clouds, const std::function<void(const Cloud&)>& check) {
    const auto checkOne = [&](const Cloud& cloud) {
        SCOPED_TRACE(cloud.name);
        if (!testing::Test::HasFailure()) check(cloud);
    };
    for (const Cloud& cloud : awkwardClouds()) checkOne(cloud);
    for (std::uint64_t seed = 0; seed < random_clouds && !testing::Test::HasFailure(); ++seed)
        checkOne(randomCloud(seed));
}

double relativeRadius(RadiusPattern pattern, const Vec3& p, Random& random) {
    const double u = random.unit();
    switch (pattern) {
        case RadiusPattern::two:
            return u < 0.5 ? 1 : 0.5;
        case RadiusPattern::twentieth:
            return std::pow(20, -u);
        case RadiusPattern::powers_of_two:
            return std::ldexp(1.0, -static_cast<int>(4 * u));
        case RadiusPattern::wave:
            return 0.625 + 0.375 * std::sin(p.x);
    }
    return 1;
}

std::vector<double> radiiFor(const Cloud& cloud, RadiusPattern pattern, std::uint64_t seed) {
    Random random(seed);
    std::vector<double> radii;
    for (const Vec3f& p : cloud.particles.position)
        radii.push_back(cloud.radius * relativeRadius(pattern, Vec3(p) / cloud.radius, random));
    return radii;
}

Particles shuffled(const Particles& particles, std::uint64_t seed) {
    const std::size_t n = particles.size();
    std::vector<std::size_t> order(n);
    std::iota(order.begin(), order.end(), std::size_t{0});
    Random random(seed);
    for (std::size_t i = n; i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);

    const auto permuted = [&](const auto& column, std::size_t per_row) {
        auto result = column;
        if (!column.empty())
            for (std::size_t i = 0; i < n; ++i)
                for (std::size_t c = 0; c < per_row; ++c) result[i * per_row + c] = column[order[i] * per_row + c];
        return result;
    };
    Particles result = particles;
    result.position = permuted(particles.position, 1);
    result.velocity = permuted(particles.velocity, 1);
    result.id = permuted(particles.id, 1);
    for (Attribute& attribute : result.attributes) {
        attribute.real = permuted(attribute.real, attribute.components);
        attribute.integer = permuted(attribute.integer, attribute.components);
    }
    return result;
}

Particles spiralOnSphere(std::size_t n, double radius) {
    Particles particles;
    for (std::size_t i = 0; i < n; ++i) {
        const double turn = 2.4 * static_cast<double>(i);
        const double z = 1 - (2 * static_cast<double>(i) + 1) / static_cast<double>(n), across = std::sqrt(1 - z * z);
        particles.position.emplace_back(Vec3(across * std::cos(turn), across * std::sin(turn), z) * radius);
    }
    return particles;
}

}  // namespace betamesh
