// checkMesh() against brute force on small integer coordinates, where degeneracies abound, and on meshes with known
// faults.

#include "base/index.h"
#include "betamesh/check.h"

#include "base/icosphere.h"
#include "base/parallel.h"
#include "base/random.h"
#include "exact/orientation.h"
#include "io/mesh_file.h"
#include "mesh/enclosure.h"
#include "mesh/triangle_contact.h"
#include "support/oracles.h"
#include "support/temporary_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <limits>
#include <numeric>

namespace betamesh {
namespace {

using Points = std::vector<Vec3i>;
using Faults = std::vector<std::string_view>;

std::int64_t dot(const Vec3i& a, const Vec3i& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

Vec3i randomPoint(Random& random, std::uint64_t size) {
    const auto x = static_cast<std::int64_t>(random.below(size)), y = static_cast<std::int64_t>(random.below(size)),
               z = static_cast<std::int64_t>(random.below(size));
    return {x, y, z};
}

Mesh meshOf(const Points& points, std::vector<Triangle> triangles) {
    Mesh mesh;
    for (const Vec3i& p : points) mesh.position.push_back(toDouble(p));
    mesh.triangles = std::move(triangles);
    return mesh;
}

void append(Mesh& mesh, const Mesh& more) {
    const auto n = static_cast<std::uint32_t>(mesh.position.size());
    mesh.position.insert(mesh.position.end(), more.position.begin(), more.position.end());
    for (const Triangle& t : more.triangles) mesh.triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
}

Mesh both(Mesh mesh, const Mesh& more) {
    append(mesh, more);
    return mesh;
}

Mesh moved(Mesh mesh, const Vec3& by) {
    for (Vec3& p : mesh.position) p += by;
    return mesh;
}

Mesh insideOut(Mesh mesh) {
    for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
    return mesh;
}

Mesh sphere(std::uint32_t cuts, double radius = 1) {
    const Icosphere ball = icosphere(cuts);
    Mesh mesh{ball.position, {}, ball.triangles, {}};
    for (Vec3& p : mesh.position) p *= radius;
    return mesh;
}

// Six squares of two triangles.
Mesh box(const Vec3& low = Vec3(0), const Vec3& high = Vec3(1)) {
    Mesh mesh;
    for (int i = 0; i < 8; ++i)
        mesh.position.push_back(
            {(i & 1) != 0 ? high.x : low.x, (i & 2) != 0 ? high.y : low.y, (i & 4) != 0 ? high.z : low.z});
    for (const auto& [a, b, c, d] :
         {std::array{0u, 2u, 3u, 1u}, std::array{4u, 5u, 7u, 6u}, std::array{0u, 1u, 5u, 4u},
          std::array{2u, 6u, 7u, 3u}, std::array{0u, 4u, 6u, 2u}, std::array{1u, 3u, 7u, 5u}}) {
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({a, c, d});
    }
    return mesh;
}

// A torus of m x n vertices; with `klein`, a Klein bottle.
Mesh torus(std::uint32_t m, std::uint32_t n, bool klein = false) {
    Mesh mesh;
    for (std::uint32_t i = 0; i < m; ++i)
        for (std::uint32_t j = 0; j < n; ++j) {
            const double u = 2 * 3.14159265358979 * i / m, v = 2 * 3.14159265358979 * j / n;
            mesh.position.push_back({(3 + std::cos(v)) * std::cos(u), (3 + std::cos(v)) * std::sin(u), std::sin(v)});
        }
    const auto at = [&](std::uint32_t i, std::uint32_t j) {
        j %= n;
        return i < m ? i * n + j : klein ? (n - j) % n : j;
    };
    for (std::uint32_t i = 0; i < m; ++i)
        for (std::uint32_t j = 0; j < n; ++j) {
            mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    return mesh;
}

// Closed and facing outwards.
const std::vector<Triangle> kTetrahedron{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};

// --- oracles on integers ---

// An interval [from, to] of [0, 1] whose ends are fractions with positive denominators.
struct Stretch {
    std::int64_t from = 0, from_over = 1, to = 1, to_over = 1;
    // Keeps where a + (b - a) x >= 0.
    void clip(std::int64_t a, std::int64_t b) {
        if (a < 0 && b < 0) from = 2, from_over = 1;
        if (a >= 0 && b >= 0) return;
        std::int64_t x = a, over = a - b;
        if (over < 0) x = -x, over = -over;
        if (a < 0 && x * from_over > from * over) from = x, from_over = over;
        if (b < 0 && x * to_over < to * over) to = x, to_over = over;
    }
    bool empty() const { return from * to_over > to * from_over; }
};

// Does the closed segment from p to q intersect the closed, non-degenerate triangle a, b, c?
bool meets(const Vec3i& p, const Vec3i& q, const std::array<Vec3i, 3>& t) {
    const Vec3i normal = cross(t[1] - t[0], t[2] - t[0]);
    Stretch stretch;
    const std::int64_t from = dot(normal, p - t[0]), to = dot(normal, q - t[0]);
    stretch.clip(from, to);
    stretch.clip(-from, -to);
    for (std::size_t m = 0; m < 3; ++m) {
        const Vec3i inward = cross(normal, t[(m + 1) % 3] - t[m]);
        stretch.clip(dot(inward, p - t[m]), dot(inward, q - t[m]));
    }
    return !stretch.empty();
}

bool hasArea(const std::array<Vec3i, 3>& t) { return cross(t[1] - t[0], t[2] - t[0]) != Vec3i(0, 0, 0); }

// Does a plane with this normal separate the two sets, which may touch it?
bool parts(const Vec3i& normal, const Points& a, const Points& b) {
    if (normal == Vec3i(0, 0, 0)) return false;
    const auto range = [&](const Points& points) {
        std::pair<std::int64_t, std::int64_t> r{dot(normal, points[0]), dot(normal, points[0])};
        for (const Vec3i& p : points) r = {std::min(r.first, dot(normal, p)), std::max(r.second, dot(normal, p))};
        return r;
    };
    const auto of_a = range(a), of_b = range(b);
    return of_a.second <= of_b.first || of_b.second <= of_a.first;
}

Vec3i normalOf(const Points& points, const Triangle& t) {
    return cross(points[t[1]] - points[t[0]], points[t[2]] - points[t[0]]);
}

bool interiorsDisjoint(const Points& a, const Points& b) {
    for (const Triangle& t : kTetrahedron)
        if (parts(normalOf(a, t), a, b) || parts(normalOf(b, t), a, b)) return true;
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = i + 1; j < 4; ++j)
            for (std::size_t k = 0; k < 4; ++k)
                for (std::size_t l = k + 1; l < 4; ++l)
                    if (parts(cross(a[j] - a[i], b[l] - b[k]), a, b)) return true;
    return false;
}

bool contains(const Points& outer, const Points& inner) {
    for (const Triangle& t : kTetrahedron)
        for (const Vec3i& p : inner)
            if (dot(normalOf(outer, t), p - outer[t[0]]) > 0) return false;
    return true;
}

// Do two coplanar faces overlap?
bool facesOverlap(const Points& a, const Points& b) {
    for (const Triangle& s : kTetrahedron)
        for (const Triangle& t : kTetrahedron) {
            const Vec3i normal = normalOf(a, s);
            const Points of_s{a[s[0]], a[s[1]], a[s[2]]}, of_t{b[t[0]], b[t[1]], b[t[2]]};
            const auto onPlane = [&](const Vec3i& p) { return dot(normal, p - of_s[0]) == 0; };
            if (!std::all_of(of_t.begin(), of_t.end(), onPlane)) continue;
            bool apart = false;
            for (std::size_t m = 0; m < 3; ++m)
                apart = apart || parts(cross(normal, of_s[(m + 1) % 3] - of_s[m]), of_s, of_t) ||
                        parts(cross(normal, of_t[(m + 1) % 3] - of_t[m]), of_s, of_t);
            if (!apart) return true;
        }
    return false;
}

// The contact of the only two triangles of a mesh.
ContactKind kindOf(const Mesh& mesh) {
    const MeshCheck check = checkMesh(mesh);
    EXPECT_LE(check.crossings.count + check.touching, 1u);
    return check.crossings ? ContactKind::crossing : check.touching > 0 ? ContactKind::touching : ContactKind::none;
}

TEST(Orientation, IsTheSignOfRationalArithmetic) {
    using Rational = boost::multiprecision::cpp_rational;
    const auto signOf = [](const Rational& x) { return x > 0 ? 1 : x < 0 ? -1 : 0; };
    int zeros = 0;
    for (std::uint64_t trial = 0; trial < 4000; ++trial) {
        SCOPED_TRACE(trial);
        Random random(trial);
        // Nearly or exactly coplanar, at many scales, some coordinates much finer than others.
        std::array<Vec3, 4> p;
        const double scale = std::ldexp(1, static_cast<int>(random.below(40)) * 10 - 200);
        for (Vec3& q : p) q = random.cube() * scale;
        const double u = static_cast<double>(random.below(8)) / 4, v = static_cast<double>(random.below(8)) / 4;
        if (trial % 3 == 0) p[3] = p[0] + (p[1] - p[0]) * u + (p[2] - p[0]) * v;
        if (trial % 3 == 1)
            for (Vec3& q : p) q = Vec3(std::floor(q.x / scale * 4), std::floor(q.y / scale * 4), 7) * 0x1p-60;
        if (trial % 4 == 2)  // the corners' plane, but for the last bits of some coordinates
            for (Vec3& q : p) {
                q.x = std::floor(q.x / scale * 0x1p50), q.y = std::floor(q.y / scale * 0x1p50), q.z = q.x + q.y;
                if (random.below(3) == 0) q.z += static_cast<double>(random.below(3)) - 1;
            }
        if (trial % 5 == 0) p[trial % 4][static_cast<int>(trial % 3)] = std::ldexp(random.between(-1, 1), -900);
        if (trial % 7 == 0) p[trial % 4].x = std::numeric_limits<double>::denorm_min(), p[3].y = 0x1.8p199;
        const auto d = [&](int i, int k) -> Rational { return Rational(p[i][k]) - Rational(p[3][k]); };
        const Rational determinant = d(0, 0) * (d(1, 1) * d(2, 2) - d(1, 2) * d(2, 1)) +
                                     d(0, 1) * (d(1, 2) * d(2, 0) - d(1, 0) * d(2, 2)) +
                                     d(0, 2) * (d(1, 0) * d(2, 1) - d(1, 1) * d(2, 0));
        EXPECT_EQ(sideOfPlane(p[0], p[1], p[2], p[3]), -signOf(determinant));
        EXPECT_EQ(sideOfPlane(p[1], p[0], p[2], p[3]), signOf(determinant));
        zeros += determinant == 0;
        for (int axis = 0; axis < 3; ++axis) {
            const int k = (axis + 1) % 3, m = (axis + 2) % 3;
            const Rational turn = d(0, k) * d(1, m) - d(0, m) * d(1, k);
            EXPECT_EQ(orientationAlong(axis, p[0], p[1], p[3]), signOf(turn));
        }
    }
    EXPECT_GT(zeros, 100);
    EXPECT_EQ(sideOfPlane({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}), 1);
    EXPECT_EQ(orientationAlong(2, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}), 1);
}

TEST(SelfIntersection, DisjointTrianglesIntersectExactlyWhereTheirSidesDo) {
    int none = 0, touching = 0, crossing = 0;
    for (std::uint64_t trial = 0; trial < 60000; ++trial) {
        SCOPED_TRACE(trial);
        Random random(trial);
        std::array<Vec3i, 3> s, t;
        for (Vec3i& p : s) p = randomPoint(random, 4);
        for (Vec3i& p : t) p = randomPoint(random, 4);
        if (!hasArea(s) || !hasArea(t)) continue;
        if (std::any_of(s.begin(), s.end(), [&](const Vec3i& p) { return std::count(t.begin(), t.end(), p) > 0; }))
            continue;
        bool meet = false, pierced = false;
        for (std::size_t m = 0; m < 3; ++m)
            for (const auto& [own, other] : {std::pair(s, t), std::pair(t, s)}) {
                const Vec3i &p = own[m], &q = own[(m + 1) % 3];
                if (!meets(p, q, other)) continue;
                meet = true;
                // A crossing through the inside: no corner or side of the other triangle touches it.
                const Vec3i normal = cross(other[1] - other[0], other[2] - other[0]);
                bool inside = dot(normal, p - other[0]) * dot(normal, q - other[0]) < 0;
                for (std::size_t k = 0; k < 3; ++k)
                    inside = inside && !meets(other[k], other[(k + 1) % 3], {p, q, own[(m + 2) % 3]});
                pierced = pierced || inside;
            }
        const Mesh mesh = meshOf({s[0], s[1], s[2], t[0], t[1], t[2]}, {{0, 1, 2}, {3, 4, 5}});
        const ContactKind kind = kindOf(mesh);
        EXPECT_EQ(kind != ContactKind::none, meet);
        if (pierced) {
            EXPECT_EQ(kind, ContactKind::crossing);
        }
        ++(kind == ContactKind::none ? none : kind == ContactKind::touching ? touching : crossing);

        // The same on a much finer grid, sheared and translated, where doubles cannot decide.
        Mesh far = mesh;
        for (Vec3& p : far.position)
            p = Vec3(7 + (p.x + 1000 * p.y + 77 * p.z) * 0x1p-38, 5 + (p.y + 900 * p.z) * 0x1p-40, 1 + p.z * 0x1p-52);
        EXPECT_EQ(kindOf(far), kind);
    }
    EXPECT_GT(none, 1000);
    EXPECT_GT(touching, 1000);
    EXPECT_GT(crossing, 1000);
}

TEST(SelfIntersection, TrianglesThatShareACornerIntersectNowhereElse) {
    int crossing = 0, none = 0;
    for (std::uint64_t trial = 0; trial < 40000; ++trial) {
        SCOPED_TRACE(trial);
        Random random(trial);
        std::array<Vec3i, 3> s, t;
        for (Vec3i& p : s) p = randomPoint(random, 4);
        for (Vec3i& p : t) p = randomPoint(random, 4);
        t[0] = s[0];
        if (!hasArea(s) || !hasArea(t)) continue;
        if (s[1] == t[1] || s[1] == t[2] || s[2] == t[1] || s[2] == t[2]) continue;
        // They intersect beyond the corner when the opposite side of one reaches the other.
        const bool meet = meets(s[1], s[2], t) || meets(t[1], t[2], s);
        const ContactKind kind = kindOf(meshOf({s[0], s[1], s[2], t[1], t[2]}, {{0, 1, 2}, {3, 4, 0}}));
        EXPECT_EQ(kind != ContactKind::none, meet);
        const Vec3i n = cross(s[1] - s[0], s[2] - s[0]), m = cross(t[1] - t[0], t[2] - t[0]);
        const auto splits = [](const Vec3i& normal, const std::array<Vec3i, 3>& other) {
            return dot(normal, other[1] - other[0]) * dot(normal, other[2] - other[0]) < 0;
        };
        if (splits(n, t) && splits(m, s)) {  // each passes through the other's plane at the corner
            EXPECT_EQ(kind, meet ? ContactKind::crossing : ContactKind::none);
        }
        ++(kind == ContactKind::crossing ? crossing : none);
        // As different vertices of the mesh: the corner itself is a touch.
        const ContactKind apart = kindOf(meshOf({s[0], s[1], s[2], t[0], t[1], t[2]}, {{0, 1, 2}, {4, 5, 3}}));
        EXPECT_NE(apart, ContactKind::none);
        if (!meet) {
            EXPECT_EQ(apart, ContactKind::touching);
        }
    }
    EXPECT_GT(crossing, 1000);
    EXPECT_GT(none, 1000);
}

TEST(SelfIntersection, TrianglesThatShareAnEdgeOverlapOnlyWhenFolded) {
    int folded = 0;
    for (std::uint64_t trial = 0; trial < 20000; ++trial) {
        SCOPED_TRACE(trial);
        Random random(trial);
        Points p{4, Vec3i(0, 0, 0)};
        for (Vec3i& q : p) q = randomPoint(random, 3);
        const Vec3i n = cross(p[1] - p[0], p[2] - p[0]), m = cross(p[1] - p[0], p[3] - p[0]);
        if (n == Vec3i(0, 0, 0) || m == Vec3i(0, 0, 0) || p[2] == p[3]) continue;
        const bool fold = cross(n, m) == Vec3i(0, 0, 0) && dot(n, m) > 0;
        EXPECT_EQ(kindOf(meshOf(p, {{0, 1, 2}, {3, 1, 0}})), fold ? ContactKind::crossing : ContactKind::none);
        folded += fold;
    }
    EXPECT_GT(folded, 100);
}

TEST(SelfIntersection, TetrahedraCrossWhereTheirInteriorsOverlapAndNeitherContainsTheOther) {
    int crossing = 0, disjoint = 0, nested = 0, touching = 0;
    for (std::uint64_t trial = 0; trial < 40000; ++trial) {
        SCOPED_TRACE(trial);
        Random random(trial);
        Points a, b;
        for (Points* points : {&a, &b}) {
            for (int i = 0; i < 4; ++i) {
                points->push_back(randomPoint(random, trial % 2 == 0 ? 3 : trial % 4 == 1 ? 5 : 2));
                if (trial % 4 == 3 && points == &b) points->back() += Vec3i(1);
                if (trial % 4 == 3 && points == &a && i > 0) points->back()[i - 1] += 9;  // holds the other, often
            }
            const std::int64_t volume = dot(normalOf(*points, {0, 1, 2}), (*points)[3] - (*points)[0]);
            if (volume < 0) std::swap((*points)[0], (*points)[1]);
            if (volume == 0) points->clear();
        }
        if (a.empty() || b.empty()) continue;
        const Mesh mesh = both(meshOf(a, kTetrahedron), meshOf(b, kTetrahedron));
        const MeshCheck check = checkMesh(mesh);
        const bool apart = interiorsDisjoint(a, b), held = contains(a, b) || contains(b, a);
        EXPECT_EQ(check.crossings.count > 0, (!apart && !held) || facesOverlap(a, b));

        // The same with an edge split on one side only, and a degenerate triangle between.
        Points split;
        for (const Vec3i& p : a) split.push_back(p * std::int64_t{2});
        split.push_back(a[0] + a[1]);
        Mesh flat = meshOf(split, {{0, 2, 4}, {4, 2, 1}, {0, 4, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}});
        append(flat,
               meshOf({b[0] * std::int64_t{2}, b[1] * std::int64_t{2}, b[2] * std::int64_t{2}, b[3] * std::int64_t{2}},
                      kTetrahedron));
        EXPECT_EQ(checkMesh(flat).crossings.count > 0, check.crossings.count > 0);
        EXPECT_EQ(checkMesh(flat).zero_area.count, 1u);

        EXPECT_TRUE(check.closed() && check.oriented() && check.edgeManifold() && check.vertexManifold());
        EXPECT_EQ(check.components.size(), 2u);
        crossing += check.crossings.count > 0;
        touching += !check.crossings && check.touching > 0;
        disjoint += apart;
        nested += held;
        // Crossings are at most as deep as the displacement that separates the two.
        EXPECT_LE(check.deepest, 8);
        for (const SelfCrossing& found : check.deepest_crossings)
            for (int k = 0; k < 3; ++k) {
                EXPECT_GE(found.position[k], -1e-9);
                EXPECT_LE(found.position[k], 13 + 1e-9);
            }
        const MeshCheck joined = checkMesh(weldVertices(mesh));  // what lies on the same three corners is one fault
        EXPECT_EQ(joined.crossings || joined.duplicates, check.crossings.count > 0);
    }
    for (const int seen : {crossing, disjoint, nested, touching}) EXPECT_GT(seen, 100);
}

TEST(SelfIntersection, AnEdgeOnAFaceCrossesIfItsTrianglesAreOnBothSides) {
    const auto judge = [](const Vec3& apex, const std::vector<Triangle>& roof) {
        Mesh mesh =
            meshOf({{-9, -9, 0}, {9, -9, 0}, {0, 9, 0}, {-2, 0, 0}, {2, 0, 0}, {0, 0, 0}, {0, 1, 3}}, {{0, 1, 2}});
        mesh.position.push_back(apex);
        mesh.triangles.insert(mesh.triangles.end(), roof.begin(), roof.end());
        return checkMesh(mesh);
    };
    const std::vector<Triangle> two{{3, 4, 6}, {4, 3, 7}};
    const std::vector<Triangle> split{{3, 4, 6}, {4, 3, 5}, {5, 3, 7}, {4, 5, 7}};  // one of them without area
    EXPECT_EQ(judge({0, 1, -3}, two).crossings.count, 2u);
    EXPECT_NEAR(judge({0, 1, -3}, two).deepest, 3, 1e-12);
    EXPECT_EQ(judge({0, -1, 3}, two).crossings.count, 0u);
    EXPECT_EQ(judge({0, -1, 3}, two).touching, 2u);
    EXPECT_EQ(judge({0, 1, -3}, split).crossings.count, 3u);
    EXPECT_EQ(judge({0, -1, 3}, split).crossings.count, 0u);
    EXPECT_EQ(judge({0, -1, 3}, split).touching, 5u);  // two of them where the split edge lies along itself
}

TEST(SelfIntersection, OverlappingEdgesCrossIfTheirTrianglesAlternate) {
    int crossing = 0;
    for (std::uint64_t trial = 0; trial < 5000; ++trial) {
        SCOPED_TRACE(trial);
        Random random(trial);
        std::array<double, 4> angle;
        Points p{{-2, 0, 0}, {2, 0, 0}, {-1, 0, 0}, {3, 0, 0}};
        for (double& x : angle) {
            Vec3i v(0, 0, 0);
            while (v.y == 0 && v.z == 0) v = randomPoint(random, 7) - Vec3i(3);
            p.push_back(v);
            x = std::atan2(static_cast<double>(v.z), static_cast<double>(v.y));
        }
        std::array<double, 4> sorted = angle;
        std::sort(sorted.begin(), sorted.end());
        bool distinct = sorted[3] - sorted[0] < 2 * 3.14159265358979 - 1e-6;
        for (std::size_t i = 0; i < 3; ++i) distinct = distinct && sorted[i + 1] - sorted[i] > 1e-6;
        if (!distinct) continue;  // they lie on each other
        const bool first = sorted[0] == angle[0] || sorted[0] == angle[1];
        const bool third = sorted[2] == angle[0] || sorted[2] == angle[1];
        const bool second = sorted[1] == angle[0] || sorted[1] == angle[1];
        const bool alternate = first == third && first != second;
        const MeshCheck check = checkMesh(meshOf(p, {{0, 1, 4}, {1, 0, 5}, {2, 3, 6}, {3, 2, 7}}));
        EXPECT_EQ(check.crossings.count, alternate ? 4u : 0u);
        EXPECT_EQ(check.touching, alternate ? 0u : 4u);
        crossing += alternate;
    }
    EXPECT_GT(crossing, 1000);
}

TEST(SelfIntersection, IsTheSameForAnyThreadCountAndOrder) {
    Mesh mesh;
    for (std::uint64_t i = 0; i < 60; ++i) append(mesh, moved(sphere(6, 0.4), Random(i).cube()));
    const MeshCheck check = checkMesh(mesh);
    EXPECT_GT(check.crossings.count, 1000u);
    const auto same = [&](const MeshCheck& other) {
        EXPECT_EQ(other.crossings.count, check.crossings.count);
        EXPECT_EQ(other.crossings.first, check.crossings.first);
        EXPECT_EQ(other.touching, check.touching);
        ASSERT_EQ(other.deepest_crossings.size(), check.deepest_crossings.size());
        for (std::size_t i = 0; i < check.deepest_crossings.size(); ++i) {
            EXPECT_EQ(other.deepest_crossings[i].first, check.deepest_crossings[i].first);
            EXPECT_EQ(other.deepest_crossings[i].second, check.deepest_crossings[i].second);
            EXPECT_EQ(other.deepest_crossings[i].position, check.deepest_crossings[i].position);
        }
    };
    for (const int threads : {1, 2, 5}) withThreads(threads, [&] { same(checkMesh(mesh)); });
    Mesh turned = mesh;
    std::reverse(turned.triangles.begin(), turned.triangles.end());
    EXPECT_EQ(checkMesh(turned).crossings.count, check.crossings.count);

    // All pairs, without a tree.
    const std::vector<std::uint32_t> across(3 * mesh.triangles.size(), kInvalidIndex);
    std::vector<std::uint32_t> place(mesh.position.size());
    std::iota(place.begin(), place.end(), 0u);
    std::size_t crossings = 0;
    for (std::uint32_t s = 0; s < 3000; ++s)
        for (std::uint32_t t = s + 1; t < 3000; ++t)
            crossings += contactOf({mesh.position, mesh.triangles, place, across}, s, t).kind == ContactKind::crossing;
    Mesh few = mesh;
    few.triangles.resize(3000);
    EXPECT_EQ(checkMesh(few).crossings.count, crossings);
}

TEST(SelfIntersection, DepthIsTheDisplacementThatSeparatesTwoTriangles) {
    for (const double depth : {0.25, 1e-3, 1e-9}) {
        // A needle through a large triangle.
        Mesh mesh;
        mesh.position = {{-9, -9, 0}, {9, -9, 0}, {0, 9, 0}, {0, 0, -depth}, {0.5, 0, 4}, {-0.5, 0, 4}};
        mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
        const MeshCheck check = checkMesh(mesh);
        ASSERT_EQ(check.crossings.count, 1u);
        EXPECT_NEAR(check.deepest, depth, depth * 1e-9);
        EXPECT_NEAR(check.deepest_crossings[0].position.length(), 0, depth);
        EXPECT_EQ(checkMesh(mesh, {depth * 1.01, 8}).crossings.count, 0u);
        EXPECT_EQ(checkMesh(mesh, {depth * 1.01, 8}).shallow, 1u);
        EXPECT_EQ(checkMesh(mesh, {depth * 0.99, 8}).crossings.count, 1u);
        EXPECT_TRUE(checkMesh(mesh, {0, 0}).deepest_crossings.empty());
    }
}

// Two ridges along one line, whose ends overlap slightly.
TEST(SelfIntersection, DepthOfTwoRidgesIsAtMostTheirOverlap) {
    for (const double overlap : {0.25, 1e-3, 1e-9}) {
        Mesh mesh;
        mesh.position = {{0, 0, -1}, {0, 0, overlap}, {1, 0.25, -0.5}, {-1, 0.25, -0.5},
                         {0, 0, 0},  {0, 0, 1},       {0.25, 1, 0.5},  {0.25, -1, 0.5}};
        mesh.triangles = {{0, 1, 2}, {1, 0, 3}, {4, 5, 6}, {5, 4, 7}};
        const MeshCheck check = checkMesh(mesh);
        EXPECT_GT(check.crossings.count, 0u);
        EXPECT_GT(check.deepest, 0.5 * overlap);
        EXPECT_LE(check.deepest, overlap);
    }
}

TEST(MeshCheck, FindsNoFaultsInValidMeshes) {
    for (const Mesh& mesh : {Mesh{}, box(), sphere(1), sphere(7), both(sphere(5, 3), insideOut(sphere(4))),
                             both(sphere(3), moved(sphere(4), Vec3(3))), torus(12, 8)}) {
        const MeshCheck check = checkMesh(mesh);
        EXPECT_EQ(faultsOf(check, true), Faults{});
        const MeshMeasure measure = measureMesh(mesh);
        EXPECT_EQ(check.components.size(), measure.components);
        EXPECT_EQ(check.euler, measure.euler);
        EXPECT_NEAR(check.volume, measure.volume, 1e-12 * (1 + std::abs(measure.volume)));
        EXPECT_NEAR(check.area, measure.area, 1e-12 * (1 + measure.area));
        for (const ComponentCheck& component : check.components) {
            EXPECT_TRUE(component.closed);
            ASSERT_TRUE(component.genus.has_value());
            EXPECT_EQ(component.euler, 2 - 2 * *component.genus);
        }
    }
    EXPECT_EQ(checkMesh(torus(12, 8)).components[0].genus, 1);
    EXPECT_EQ(checkMesh(torus(12, 8)).euler, 0);
    EXPECT_NEAR(checkMesh(box()).volume, 1, 1e-15);
    const MeshCheck hollow = checkMesh(both(sphere(9, 3), insideOut(sphere(9))));
    EXPECT_GT(hollow.components[0].volume, 0);
    EXPECT_LT(hollow.components[1].volume, 0);
}

TEST(MeshCheck, FindsTheFaultsOfBrokenMeshes) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    Mesh open = box();
    open.triangles.pop_back();
    EXPECT_EQ(checkMesh(open).open_edges.count, 3u);
    EXPECT_EQ(faultsOf(checkMesh(open)), Faults{"open_edges"});
    EXPECT_FALSE(checkMesh(open).components[0].genus.has_value());

    Mesh flipped = box();
    std::swap(flipped.triangles[3][0], flipped.triangles[3][1]);
    EXPECT_EQ(checkMesh(flipped).misoriented_edges.count, 3u);
    EXPECT_EQ(faultsOf(checkMesh(flipped)), Faults{"misoriented_edges"});

    EXPECT_EQ(faultsOf(checkMesh(insideOut(box()))), Faults{"inside_out"});

    Mesh bow_tie = weldVertices(both(box(), box(Vec3(1), Vec3(2))));
    EXPECT_EQ(checkMesh(bow_tie).nonmanifold_vertices.count, 1u);
    EXPECT_EQ(bow_tie.position[checkMesh(bow_tie).nonmanifold_vertices.first], Vec3(1));
    EXPECT_EQ(faultsOf(checkMesh(bow_tie)), Faults{"nonmanifold_vertices"});
    EXPECT_EQ(checkMesh(bow_tie).components.size(), 1u);

    Mesh hinge = weldVertices(both(box(), box(Vec3(1, 1, 0), Vec3(2, 2, 1))));
    EXPECT_EQ(checkMesh(hinge).nonmanifold_edges.count, 1u);
    EXPECT_EQ(checkMesh(hinge).nonmanifold_vertices.count, 0u);
    EXPECT_EQ(faultsOf(checkMesh(hinge)), Faults{"nonmanifold_edges"});

    Mesh twice = box();
    twice.triangles.push_back({twice.triangles[4][1], twice.triangles[4][2], twice.triangles[4][0]});
    EXPECT_EQ(checkMesh(twice).duplicates.count, 1u);
    EXPECT_EQ(checkMesh(twice).duplicates.first, 12u);
    EXPECT_EQ(checkMesh(twice).open_edges.count, 3u);
    EXPECT_EQ(checkMesh(twice).nonmanifold_edges.count, 3u);
    EXPECT_EQ(checkMesh(twice).crossings.count, 0u);

    EXPECT_GT(checkMesh(torus(12, 8, true)).misoriented_edges.count, 0u);
    EXPECT_EQ(checkMesh(torus(12, 8, true)).open_edges.count, 0u);

    Mesh broken = box();
    broken.position[5].y = nan;
    EXPECT_EQ(checkMesh(broken).not_finite.count, 1u);
    EXPECT_EQ(checkMesh(broken).not_finite.first, 5u);
    EXPECT_EQ(faultsOf(checkMesh(broken)), Faults{"not_finite"});
    EXPECT_TRUE(std::isfinite(checkMesh(broken).volume));
    broken = box();
    broken.velocity.assign(8, Vec3(0));
    broken.velocity[2].z = std::numeric_limits<double>::infinity();
    EXPECT_EQ(faultsOf(checkMesh(broken)), Faults{"velocity_not_finite"});

    Mesh degenerate = box();
    degenerate.triangles.push_back({0, 3, 3});
    degenerate.triangles.push_back({0, 1, 800});
    EXPECT_EQ(checkMesh(degenerate).repeated_vertices.first, 12u);
    EXPECT_EQ(checkMesh(degenerate).missing_vertices.first, 13u);
    EXPECT_EQ(faultsOf(checkMesh(degenerate)), (Faults{"missing_vertices", "repeated_vertices"}));

    // A square as two triangles with a degenerate one between them.
    Mesh sliver = box();
    sliver.position.push_back(Vec3(0.5, 0.5, 0));
    const Triangle first = sliver.triangles[0];  // 0 2 3, beside 0 3 1
    sliver.triangles[0] = {first[0], first[1], 8};
    sliver.triangles.push_back({8, first[1], first[2]});
    sliver.triangles.push_back({8, first[2], first[0]});
    EXPECT_EQ(checkMesh(sliver).zero_area.count, 1u);
    EXPECT_EQ(faultsOf(checkMesh(sliver)), Faults{});
    EXPECT_EQ(faultsOf(checkMesh(sliver), true), (Faults{"zero_area", "touching"}));

    const Mesh tetrahedron = meshOf({{0, 0, 0}, {3, 0, 0}, {0, 3, 0}, {0, 0, 3}}, kTetrahedron);
    EXPECT_EQ(faultsOf(checkMesh(both(tetrahedron, moved(tetrahedron, Vec3(0.3, 0.4, 0.1))))), Faults{"crossings"});
    const MeshCheck tip = checkMesh(both(tetrahedron, moved(tetrahedron, Vec3(1, 1, -3))));
    EXPECT_EQ(tip.crossings.count, 0u);
    EXPECT_EQ(tip.touching, 3u);
    EXPECT_EQ(faultsOf(tip), Faults{});
}

TEST(MeshCheck, WeldingRepairsVerticesSplitPerCorner) {
    Mesh split;
    const Mesh whole = sphere(4);
    split.attributes = {{"row", 1, {}, {}}};
    for (const Triangle& t : whole.triangles) {
        const auto n = static_cast<std::uint32_t>(split.position.size());
        for (const std::uint32_t v : t) {
            split.position.push_back(whole.position[v]);
            split.attributes[0].integer.push_back(static_cast<std::int32_t>(v));
        }
        split.triangles.push_back({n, n + 1, n + 2});
    }
    split.velocity = split.position;
    const MeshCheck check = checkMesh(split);
    EXPECT_EQ(check.open_edges.count, 3 * whole.triangles.size());
    EXPECT_EQ(check.coincident_vertices.count, split.position.size() - whole.position.size());
    EXPECT_EQ(check.crossings.count, 0u);
    EXPECT_GT(check.touching, 0u);
    const Mesh welded = weldVertices(split);
    EXPECT_EQ(faultsOf(checkMesh(welded), true), Faults{});
    EXPECT_EQ(welded.position.size(), whole.position.size());
    EXPECT_EQ(welded.velocity, welded.position);
    for (std::size_t v = 0; v < welded.position.size(); ++v)
        EXPECT_EQ(welded.position[v], whole.position[static_cast<std::size_t>(welded.attributes[0].integer[v])]);
}

TEST(WeldVertices, KeepsTheTypesOfAttributes) {
    Mesh mesh = sphere(3);
    mesh.attributes = {{"mask", 1, {}, std::vector<std::int32_t>(mesh.position.size(), 3), IntegerType::uint8},
                       {"uv", 2, std::vector<float>(2 * mesh.position.size(), 0.5F), {}}};
    const Mesh welded = weldVertices(mesh), empty = weldVertices({{}, {}, {}, {{"count", 1, {}, {}, {}, true}}});
    EXPECT_EQ(welded.attributes[0].integer_type, IntegerType::uint8);
    EXPECT_FALSE(welded.attributes[1].hasIntegers());
    EXPECT_TRUE(empty.attributes[0].hasIntegers());
}

TEST(MeshCheck, IsTheSameAfterAFileRoundTrip) {
    const TemporaryFolder folder;
    const Mesh mesh = both(both(sphere(5), moved(sphere(5), Vec3(0.5))), moved(torus(9, 5), Vec3(10)));
    writeMesh(folder / "a.ply", mesh);
    const MeshCheck first = checkMesh(readMesh(folder / "a.ply"));
    EXPECT_EQ(first.components.size(), 3u);
    for (const char* name : {"a.obj", "a.bgeo", "a.bgeo.gz"}) {
        writeMesh(folder / name, readMesh(folder / "a.ply"));
        const MeshCheck again = checkMesh(readMesh(folder / name));
        EXPECT_EQ(again.crossings.count, first.crossings.count) << name;
        EXPECT_EQ(again.deepest, first.deepest) << name;
        EXPECT_EQ(again.volume, first.volume) << name;
        EXPECT_EQ(again.euler, first.euler) << name;
    }
}

TEST(DistancesOutside, AgreeWithSolidAnglesAndBruteForce) {
    const std::vector<Mesh> meshes{box(),
                                   sphere(3),
                                   torus(12, 8),
                                   both(sphere(5, 0.9), insideOut(sphere(4, 0.5))),
                                   both(sphere(3), moved(sphere(3), Vec3(0.5))),
                                   insideOut(sphere(3)),
                                   Mesh{}};
    for (std::size_t m = 0; m < meshes.size(); ++m) {
        std::vector<Vec3> points;
        for (std::uint64_t i = 0; i < 400; ++i) points.push_back(Random(m, i).cube() * (i % 3 == 0 ? 4 : 1.2));
        const std::vector<double> distances = distancesOutside(meshes[m], {}, points);
        const double sign = m == 5 ? -1 : 1;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const bool inside = windingNumber(meshes[m], points[i]) * sign > 0.5;
            if (meshes[m].triangles.empty()) {
                EXPECT_TRUE(std::isinf(distances[i]));
            } else {
                EXPECT_NEAR(distances[i], inside ? 0 : distanceTo(meshes[m], points[i]), 1e-12);
            }
        }
    }
}

TEST(DistancesOutside, AreRightForTies) {
    // Grid points on, in and around boxes whose faces, edges and corners are on the grid.
    const Mesh boxes = both(box(Vec3(0), Vec3(2)), box(Vec3(2, 0, 0), Vec3(4)));
    std::vector<Vec3> points;
    std::vector<double> expected;
    for (double x = -1; x <= 5; x += 0.5)
        for (double y = -1; y <= 5; y += 0.5)
            for (double z = -1; z <= 5; z += 0.5) {
                const Vec3 p(x, y, z);
                points.push_back(p);
                const auto beyond = [&](const Vec3& low, const Vec3& high) {
                    Vec3 d;
                    for (int k = 0; k < 3; ++k) d[k] = std::max({low[k] - p[k], p[k] - high[k], 0.0});
                    return d.length();
                };
                expected.push_back(std::min(beyond(Vec3(0), Vec3(2)), beyond(Vec3(2, 0, 0), Vec3(4))));
            }
    const std::vector<double> distances = distancesOutside(boxes, {}, points);
    for (std::size_t i = 0; i < points.size(); ++i) EXPECT_NEAR(distances[i], expected[i], 1e-15) << points[i];
}

TEST(DistancesOutside, AreZeroInsideSpheresBesideTheMesh) {
    Spheres spheres;
    for (std::uint64_t i = 0; i < 60; ++i) {
        spheres.position.push_back(Random(i).cube() * 3);
        spheres.radius.push_back(static_cast<float>(Random(i).between(0.1, 0.4)));
    }
    std::vector<Vec3> points = spheres.position;
    for (std::uint64_t i = 0; i < 3000; ++i) points.push_back(Random(7, i).cube() * 3);
    const std::vector<double> without = distancesOutside(sphere(3), {}, points);
    const std::vector<double> distances = distancesOutside(sphere(3), spheres, points);
    for (std::size_t i = 0; i < points.size(); ++i) {
        bool held = false;
        for (std::size_t k = 0; k < spheres.size(); ++k)
            held = held || (points[i] - spheres.position[k]).length() <= spheres.radius[k];
        EXPECT_EQ(distances[i], held ? 0 : without[i]);
    }
}

}  // namespace
}  // namespace betamesh
