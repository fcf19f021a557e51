// What is true of the mesh while it is moved.

#include "skin/deforming_mesh.h"

#include "base/icosphere.h"
#include "base/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

namespace betamesh {
namespace {

// A ball of uneven radius, folded at most of its vertices. Velocities number the vertices, as these are sorted anew.
BetaMesh crumpledBall(unsigned seed) {
    const Icosphere ball = icosphere(3);
    Random random(seed);
    BetaMesh mesh;
    mesh.triangles = ball.triangles;
    for (const Vec3& p : ball.position)
        mesh.vertex.push_back({p * (1 + 0.15 * random.unit()), Vec3(static_cast<double>(mesh.vertex.size()), 0, 0)});
    return mesh;
}

// The edge between two triangles, and the corners opposite.
struct Edge {
    std::uint32_t a, b, left, right;
};
std::vector<Edge> edgesOf(const std::vector<Triangle>& triangles) {
    std::map<std::array<std::uint32_t, 2>, std::uint32_t> apex;
    for (const Triangle& t : triangles)
        for (std::size_t k = 0; k < 3; ++k) apex[{t[k], t[(k + 1) % 3]}] = t[(k + 2) % 3];
    std::vector<Edge> edges;
    for (const auto& [e, left] : apex)
        if (e[0] < e[1]) edges.push_back({e[0], e[1], left, apex.at({e[1], e[0]})});
    return edges;
}

// Replaces both triangles at an edge by four round a new vertex.
std::uint32_t split(const Edge& edge, BetaMesh& mesh) {
    const auto v = static_cast<std::uint32_t>(mesh.vertex.size());
    std::erase_if(mesh.triangles, [&](const Triangle& t) {
        const auto has = [&](std::uint32_t x) { return std::find(t.begin(), t.end(), x) != t.end(); };
        return has(edge.a) && has(edge.b) && (has(edge.left) || has(edge.right));
    });
    for (const auto& [from, to] :
         {std::array{edge.a, edge.right}, {edge.right, edge.b}, {edge.b, edge.left}, {edge.left, edge.a}})
        mesh.triangles.push_back({from, to, v});
    return v;
}

// Where the first vertices are after folds have been relaxed.
std::vector<Vec3> relaxed(BetaMesh mesh, std::size_t count) {
    DeformingMesh surface(mesh, 1);
    surface.relaxFolds();
    std::vector<Vec3> position(count);
    for (std::size_t v = 0; v < surface.size(); ++v)
        if (const auto number = static_cast<std::size_t>(mesh.vertex[v].velocity.x); number < count)
            position[number] = surface.position()[v];
    return position;
}

double farthestApart(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
    double farthest = 0;
    for (std::size_t v = 0; v < a.size(); ++v) farthest = std::max(farthest, (a[v] - b[v]).length());
    return farthest;
}

// A vertex that has just begun to fade in on an edge changes nothing.
TEST(DeformingMesh, RelaxesFoldsAlikeWithAVertexThatFadesInOnAnEdge) {
    for (unsigned seed = 0; seed < 20; ++seed) {
        const BetaMesh mesh = crumpledBall(seed);
        const std::vector<Vec3> without = relaxed(mesh, mesh.vertex.size());
        std::vector<Vec3> before;
        for (const DualVec3& v : mesh.vertex) before.push_back(v.position);
        ASSERT_GE(farthestApart(before, without), 0.005);

        const std::vector<Edge> edges = edgesOf(mesh.triangles);
        Random random(seed);
        for (const std::size_t group : {0, 2, 3}) {
            const Edge& edge = edges[random.below(edges.size())];
            BetaMesh with = mesh;
            const double share = 0.1 + 0.8 * random.unit();
            const std::uint32_t v = split(edge, with);
            const DualVec3 place = mesh.vertex[edge.a] * (1 - share) + mesh.vertex[edge.b] * share;
            with.vertex.push_back({place.position, Vec3(1e6, 0, 0)});
            with.fading[group].push_back(
                {v, {edge.a, edge.b, edge.left, edge.right}, {1 - share, share, 0, 0}, 0, place});
            EXPECT_LE(farthestApart(without, relaxed(with, mesh.vertex.size())), 1e-5) << seed << ' ' << group;
        }
    }
}

// As when two edges of a triangle have just become long: a quad is left, with a vertex inside.
TEST(DeformingMesh, RelaxesFoldsAlikeWithVerticesThatFadeInOnTwoEdgesOfATriangle) {
    for (unsigned seed = 0; seed < 20; ++seed) {
        const BetaMesh mesh = crumpledBall(seed);
        const auto count = static_cast<std::uint32_t>(mesh.vertex.size());
        const auto [a, b, c] = mesh.triangles[Random(seed).below(mesh.triangles.size())];
        BetaMesh with = mesh;
        std::erase_if(with.triangles, [&](const Triangle& t) {
            return std::count_if(t.begin(), t.end(), [&](std::uint32_t v) { return v == a || v == b || v == c; }) == 3;
        });
        const std::uint32_t on_bc = count, on_ca = count + 1, inside = count + 2;
        for (const auto& [from, to, middle] : {Triangle{b, c, on_bc}, Triangle{c, a, on_ca}}) {
            const auto beyond = std::find_if(with.triangles.begin(), with.triangles.end(), [&](const Triangle& t) {
                return std::find(t.begin(), t.end(), from) != t.end() && std::find(t.begin(), t.end(), to) != t.end();
            });
            const std::uint32_t apex = (*beyond)[0] ^ (*beyond)[1] ^ (*beyond)[2] ^ from ^ to;
            with.triangles.erase(beyond);
            with.triangles.insert(with.triangles.end(), {{to, middle, apex}, {middle, from, apex}});
            with.vertex.push_back({(mesh.vertex[from].position + mesh.vertex[to].position) / 2, Vec3(1e6, 0, 0)});
            with.fading[3].push_back({middle, {from, to, to, to}, {0.5, 0.5, 0, 0}, 0, with.vertex.back()});
        }
        with.triangles.push_back({c, on_ca, on_bc});
        const std::array<std::uint32_t, 4> quad{a, b, on_bc, on_ca};
        for (std::size_t k = 0; k < 4; ++k) with.triangles.push_back({quad[k], quad[(k + 1) % 4], inside});
        DualVec3 place;
        for (const std::uint32_t v : quad) place = place + with.vertex[v] * 0.25;
        with.vertex.push_back({place.position, Vec3(1e6, 0, 0)});
        with.fading[4].push_back({inside, {a, on_bc, b, on_ca}, {0.25, 0.25, 0.25, 0.25}, 0, place});
        EXPECT_LE(farthestApart(relaxed(mesh, count), relaxed(with, count)), 1e-5) << seed;
    }
}

// Where the first vertices are after sharp parts have been faired.
std::vector<Vec3> faired(BetaMesh mesh, std::size_t count) {
    DeformingMesh surface(mesh, 1);
    surface.fairSharpParts(std::vector<float>(surface.size(), 1));
    std::vector<Vec3> position(count);
    for (std::size_t v = 0; v < surface.size(); ++v)
        if (const auto number = static_cast<std::size_t>(mesh.vertex[v].velocity.x); number < count)
            position[number] = surface.position()[v];
    return position;
}

TEST(DeformingMesh, FairsSpikesAndLeavesRoundPartsAlone) {
    const Icosphere ball = icosphere(8);
    BetaMesh mesh;
    mesh.triangles = ball.triangles;
    for (const Vec3& p : ball.position)
        mesh.vertex.push_back({p * 2.0, Vec3(static_cast<double>(mesh.vertex.size()), 0, 0)});
    const std::size_t count = mesh.vertex.size();
    std::vector<Vec3> round;
    for (const DualVec3& v : mesh.vertex) round.push_back(v.position);
    EXPECT_EQ(farthestApart(faired(mesh, count), round), 0);
    for (const std::size_t spike : {std::size_t{0}, count / 2, count - 1})
        for (const double height : {-0.6, 0.6}) {
            BetaMesh spiked = mesh;
            spiked.vertex[spike].position *= 1 + height / 2;
            const std::vector<Vec3> after = faired(spiked, count);
            EXPECT_LE(std::abs(after[spike].length() - 2), 0.15) << spike << ' ' << height;
            for (std::size_t v = 0; v < count; ++v)
                if ((round[v] - round[spike]).length() > 1.6) {
                    EXPECT_EQ(after[v], round[v]) << v;
                }
        }
}

// Where four particles have a common sphere, one vertex becomes two, each with a half of its neighbours; which half is
// which changes at that moment.
TEST(DeformingMesh, FairsAlikeHoweverAVertexIsDivided) {
    const BetaMesh ball = crumpledBall(1);
    const auto count = static_cast<std::uint32_t>(ball.vertex.size());
    for (std::uint32_t v = 0; v < count; v += 7) {
        std::map<std::uint32_t, std::uint32_t> after;  // neighbours of v, counterclockwise
        for (const Triangle& t : ball.triangles)
            for (std::size_t k = 0; k < 3; ++k)
                if (t[k] == v) after[t[(k + 1) % 3]] = t[(k + 2) % 3];
        std::vector<std::uint32_t> round{after.begin()->first};
        while (after.at(round.back()) != round[0]) round.push_back(after.at(round.back()));
        const auto dividedAt = [&](std::size_t first) {  // from first to first + 3 one half, the other from there
            BetaMesh divided = ball;
            const DualVec3 twin{ball.vertex[v].position, Vec3(1e6, 0, 0)};
            divided.vertex.push_back(twin);
            const std::uint32_t from = round[first], to = round[(first + 3) % round.size()];
            for (std::size_t k = 0; k < 3; ++k)
                for (Triangle& t : divided.triangles) {
                    const std::uint32_t a = round[(first + k) % round.size()],
                                        b = round[(first + k + 1) % round.size()];
                    const auto has = [&](std::uint32_t x) { return std::find(t.begin(), t.end(), x) != t.end(); };
                    if (has(v) && has(a) && has(b)) std::replace(t.begin(), t.end(), v, count);
                }
            divided.triangles.insert(divided.triangles.end(), {{v, from, count}, {v, count, to}});
            return faired(divided, count);
        };
        const std::vector<Vec3> one = dividedAt(0);
        EXPECT_LE(farthestApart(one, dividedAt(1)), 1e-4) << v;
        EXPECT_LE(farthestApart(one, faired(ball, count)), 1e-4) << v;
    }
}

BetaMesh unitBall() {
    const Icosphere ball = icosphere(2);
    BetaMesh mesh;
    mesh.triangles = ball.triangles;
    for (const Vec3& p : ball.position) mesh.vertex.push_back({p, Vec3(0)});
    return mesh;
}

// Where a vertex that fades in on an edge of the unit ball belongs: between the chord and the sphere.
void expectBetweenChordAndSphere(const FadingVertex& fading, const DeformingMesh& surface) {
    const Vec3 middle = (surface.position()[fading.support[0]] + surface.position()[fading.support[1]]) / 2;
    EXPECT_GE(fading.fade.value, 0.05);
    EXPECT_LE(middle.length(), 0.97);
    EXPECT_NEAR(surface.position()[fading.vertex].length(), middle.length() + (1 - middle.length()) * fading.fade.value,
                0.003);
}

TEST(DeformingMesh, RefinesASphereByPointsOnTheSphere) {
    BetaMesh mesh = unitBall();
    const std::size_t edges = edgesOf(mesh.triangles).size(), triangles = mesh.triangles.size();
    DeformingMesh surface(mesh, 1);
    const std::vector<Vec3> before = surface.position();
    DualPoints on_chords = dualPoints(mesh.vertex);
    surface.refineOnCurves(1.5);
    surface.writePositions();
    addLastRefinement(mesh.fading, on_chords);
    ASSERT_EQ(surface.size(), before.size() + edges);
    EXPECT_EQ(mesh.triangles.size(), 4 * triangles);
    ASSERT_EQ(on_chords.size(), surface.size());
    for (std::size_t v = 0; v < before.size(); ++v) EXPECT_EQ(surface.position()[v], before[v]);
    for (std::size_t v = before.size(); v < surface.size(); ++v) EXPECT_LE(on_chords.position[v].length(), 0.97);
    ASSERT_EQ(mesh.fading[kLastRefinement].size(), edges);
    for (const FadingVertex& fading : mesh.fading[kLastRefinement]) expectBetweenChordAndSphere(fading, surface);
}

// A vertex that has just begun to fade in on a long edge, or where two diagonals cross, takes the place of the one that
// would split it.
TEST(DeformingMesh, RefinesAlikeWithAVertexThatFadesIn) {
    const BetaMesh ball = unitBall();
    for (const std::size_t group : {0, 2, 3, 4})
        for (const Edge& edge : edgesOf(ball.triangles)) {
            BetaMesh with = ball;
            const std::uint32_t v = split(edge, with);
            const DualVec3 place = (ball.vertex[edge.a] + ball.vertex[edge.b]) * 0.5;
            with.vertex.push_back({place.position, Vec3(1, 0, 0)});
            with.fading[group].push_back({v, {edge.a, edge.b, edge.left, edge.right}, {0.5, 0.5, 0, 0}, 0, place});
            DeformingMesh surface(with, 1);
            surface.refineOnCurves(1.5);
            expectBetweenChordAndSphere(with.fading[group].front(), surface);
        }
}

}  // namespace
}  // namespace betamesh
