#include "support/oracles.h"

#include "base/union_find.h"
#include "exact/predicates.h"
#include "exact/snapped_particles.h"
#include "skin/patch_tree.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

namespace betamesh {

namespace {

Triangle smallestFirst(Triangle t) {
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    return t;
}

// Calls visit(a, b, c) for every oriented triplet of distinct particles, smallest first.
template <typename Visit>
void forEveryOrientedTriplet(std::uint32_t n, const Visit& visit) {
    for (std::uint32_t a = 0; a < n; ++a)
        for (std::uint32_t b = a + 1; b < n; ++b)
            for (std::uint32_t c = a + 1; c < n; ++c)
                if (b != c) visit(a, b, c);
}

}  // namespace

TriangleSet canonical(const std::vector<Triangle>& triangles) {
    TriangleSet set;
    for (const Triangle& t : triangles) set.insert(smallestFirst(t));
    return set;
}

TriangleSet bruteForceAlphaTriangles(const SnappedParticles& snapped) {
    TriangleSet found;
    forEveryOrientedTriplet(static_cast<std::uint32_t>(snapped.size()), [&](auto a, auto b, auto c) {
        const std::int64_t radius = snapped.radiusOf(a);
        const auto ball = [&](std::uint32_t p) {
            return OffsetBall{snapped.position[p] - snapped.position[a], snapped.radiusOf(p)};
        };
        const OffsetBall u = ball(b), v = ball(c);
        if (!ballExists(u, v, radius)) return;
        for (std::uint32_t p = 0; p < snapped.size(); ++p) {
            if (p == a || p == b || p == c) continue;
            const OffsetBall w = ball(p);
            if (spheresMeet(w, radius)) {
                if (insideBall(u, v, w, 1, radius)) return;
            } else if (const std::int64_t wider = w.radius - radius;
                       wider > 0 && w.centre.dot(w.centre) < wider * wider) {
                return;  // ball a is inside w
            }
        }
        found.insert(smallestFirst({snapped.row[a], snapped.row[b], snapped.row[c]}));
    });
    return found;
}

TriangleSet perturbedAlphaTriangles(const SnappedParticles& snapped) {
    using Real =
        boost::multiprecision::number<boost::multiprecision::cpp_bin_float<3000, boost::multiprecision::digit_base_2>,
                                      boost::multiprecision::et_off>;
    using Point = std::array<Real, 3>;
    const auto minus = [](const Point& p, const Point& q) { return Point{p[0] - q[0], p[1] - q[1], p[2] - q[2]}; };
    const auto inner = [](const Point& p, const Point& q) -> Real { return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]; };
    const auto outer = [](const Point& p, const Point& q) {
        return Point{p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]};
    };

    const auto n = static_cast<std::uint32_t>(snapped.size());
    std::vector<std::uint32_t> rank(n);  // in lexicographic order
    for (std::uint32_t i = 0; i < n; ++i)
        rank[i] =
            static_cast<std::uint32_t>(std::count_if(snapped.position.begin(), snapped.position.end(),
                                                     [&](const Vec3i& p) { return before(p, snapped.position[i]); }));
    std::vector<Point> centre(n);
    std::vector<Real> squared_radius(n);
    for (std::uint32_t i = 0; i < n; ++i) {
        const Vec3i& p = snapped.position[i];
        centre[i] = {Real(p.x), Real(p.y), Real(p.z)};
        // R² + η + ε_rank with η = 2^-200, ε_k = 2^-(450 + 180 k)
        squared_radius[i] = Real(snapped.radiusOf(i)) * snapped.radiusOf(i) + ldexp(Real(1), -200) +
                            ldexp(Real(1), -450 - 180 * static_cast<int>(rank[i]));
    }

    TriangleSet found;
    forEveryOrientedTriplet(n, [&](auto a, auto b, auto c) {
        const Point u = minus(centre[b], centre[a]), v = minus(centre[c], centre[a]), normal = outer(u, v);
        const Real n_squared = inner(normal, normal);
        if (n_squared == 0) return;
        // x: the point of equal power to all three in their plane: x·u = f, x·v = g, x·normal = 0
        const Real f = (inner(u, u) + squared_radius[a] - squared_radius[b]) / 2;
        const Real g = (inner(v, v) + squared_radius[a] - squared_radius[c]) / 2;
        const Point vn = outer(v, normal), nu = outer(normal, u);
        Point x;
        for (std::size_t k = 0; k < 3; ++k) x[k] = (f * vn[k] + g * nu[k]) / n_squared;
        const Real height_squared = squared_radius[a] - inner(x, x);
        if (height_squared <= 0) return;
        const Real rise = sqrt(height_squared / n_squared);
        for (std::size_t k = 0; k < 3; ++k) x[k] += rise * normal[k];
        for (std::uint32_t p = 0; p < n; ++p) {
            if (p == a || p == b || p == c) continue;
            const Point offset = minus(minus(centre[p], centre[a]), x);
            if (inner(offset, offset) < squared_radius[p]) return;
        }
        found.insert(smallestFirst({snapped.row[a], snapped.row[b], snapped.row[c]}));
    });
    return found;
}

void expectClosedSurfaces(const BallBoundary& boundary) {
    UnionFind pieces(boundary.face.size());
    std::map<std::uint32_t, std::uint32_t> face_of_cycle;
    for (std::uint32_t f = 0; f < boundary.face.size(); ++f)
        for (const std::uint32_t c : boundary.face[f])
            ASSERT_TRUE(face_of_cycle.emplace(c, f).second) << "a cycle bounds two faces";
    ASSERT_EQ(face_of_cycle.size(), boundary.cycle.size() + 2 * boundary.circle.size());
    std::vector<std::uint32_t> cycle_of(boundary.twin.size());
    for (std::uint32_t c = 0; c < boundary.cycle.size(); ++c)
        for (const std::uint32_t h : boundary.cycle[c]) cycle_of[h] = c;
    for (std::uint32_t h = 0; h < boundary.twin.size(); ++h)  // three faces meet in a vertex
        pieces.join(face_of_cycle[cycle_of[h]], face_of_cycle[cycle_of[nextInTriangle(h)]]);
    for (std::uint32_t k = 0; k < boundary.circle.size(); ++k) {
        const auto row = static_cast<std::uint32_t>(boundary.cycle.size()) + 2 * k;
        pieces.join(face_of_cycle[row], face_of_cycle[row + 1]);
    }
    const std::int64_t euler = eulerCharacteristic(boundary);
    EXPECT_EQ(euler % 2, 0);
    EXPECT_LE(euler, 2 * static_cast<std::int64_t>(pieces.groups()));
}

double windingNumber(const Mesh& mesh, const Vec3& point) {
    double solid_angle = 0;  // van Oosterom & Strackee 1983
    for (const Triangle& t : mesh.triangles) {
        const Vec3 a = mesh.position[t[0]] - point, b = mesh.position[t[1]] - point, c = mesh.position[t[2]] - point;
        const double la = a.length(), lb = b.length(), lc = c.length();
        solid_angle +=
            2 * std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
    }
    return solid_angle / (4 * std::numbers::pi);
}

double distanceTo(const Mesh& mesh, const Vec3& point) {
    const auto toSegment = [](const Vec3& a, const Vec3& b, const Vec3& p) {
        const Vec3 along = b - a;
        const double length_squared = along.length2();
        const double t = length_squared > 0 ? std::clamp(dot(p - a, along) / length_squared, 0.0, 1.0) : 0;
        return (p - a - along * t).length();
    };
    double nearest = std::numeric_limits<double>::infinity();
    for (const Triangle& t : mesh.triangles) {
        const Vec3 &a = mesh.position[t[0]], &b = mesh.position[t[1]], &c = mesh.position[t[2]];
        const Vec3 normal = cross(b - a, c - a);
        const bool above = dot(cross(b - a, point - a), normal) > 0 && dot(cross(c - b, point - b), normal) > 0 &&
                           dot(cross(a - c, point - c), normal) > 0;
        nearest = std::min(nearest,
                           above ? std::abs(dot(point - a, normal)) / normal.length()
                                 : std::min({toSegment(a, b, point), toSegment(b, c, point), toSegment(c, a, point)}));
    }
    return nearest;
}

double distanceTo(const Curves& curves, const Vec3& point) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Edge& edge : curves.edges) {
        const Vec3 &a = curves.position[edge[0]], way = curves.position[edge[1]] - a;
        const double t = way.length2() > 0 ? std::clamp(dot(point - a, way) / way.length2(), 0.0, 1.0) : 0;
        nearest = std::min(nearest, (a + way * t - point).length());
    }
    return nearest;
}

bool crossesItself(const std::vector<Vec3>& position, const std::vector<Triangle>& triangles) {
    const auto positionOf = [&](std::uint32_t v) { return position[v]; };
    for (std::size_t s = 0; s < triangles.size(); ++s)
        for (std::size_t t = 0; t < s; ++t)
            if (relationOf(triangles[s], triangles[t], positionOf) == TriangleRelation::crossing) return true;
    return false;
}

}  // namespace betamesh
