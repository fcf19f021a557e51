// What is true of edges that are about to turn.

#include "skin/edge_flips.h"

#include "base/icosphere.h"
#include "base/random.h"
#include "betamesh/check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace betamesh {

namespace {

// A quad whose diagonals pass each other inside, its corners on their way.
std::array<DualVec3, 4> randomQuad(Random& random, double apart) {
    std::array<DualVec3, 4> at{DualVec3{{-1, 0, 0}, {}}, DualVec3{{1, 0, 0}, {}}, DualVec3{{0, -1, apart}, {}},
                               DualVec3{{0, 1, apart}, {}}};
    for (DualVec3& p : at) p = {p.position + Vec3(random.unit(), random.unit(), 0) * 0.5, random.cube()};
    return at;
}

Vec3 vertexOf(const std::array<Vec3, 4>& corner, const EdgeFlip& edge) {
    Vec3 sum(0, 0, 0);
    for (std::size_t k = 0; k < 4; ++k) sum += corner[k] * edge.weight[k].value;
    return sum;
}

TEST(EdgeFlip, WeightsSumToOneAndKnowTheirRates) {
    Random random(1);
    constexpr double kStep = 1e-6;
    int found = 0;
    for (int trial = 0; trial < 1000; ++trial) {
        const auto at = randomQuad(random, 0.1 * random.unit());
        const auto edge = edgeFlip(at, 0.1);
        auto before = at, after = at;
        for (std::size_t k = 0; k < 4; ++k) {
            before[k].position += at[k].velocity * -kStep;
            after[k].position += at[k].velocity * kStep;
        }
        const auto edge_before = edgeFlip(before, 0.1), edge_after = edgeFlip(after, 0.1);
        if (!edge || !edge_before || !edge_after) continue;
        ++found;
        Dual sum = 0;
        for (std::size_t k = 0; k < 4; ++k) {
            sum = sum + edge->weight[k];
            EXPECT_GE(edge->weight[k].value, 0);
            EXPECT_NEAR(edge->weight[k].rate,
                        (edge_after->weight[k].value - edge_before->weight[k].value) / (2 * kStep), 1e-3);
        }
        EXPECT_NEAR(sum.value, 1, 1e-12);
        EXPECT_NEAR(sum.rate, 0, 1e-9);
    }
    EXPECT_GE(found, 500);
}

TEST(EdgeFlip, IsTheSameSeenFromEitherSideAsItTurnsWhereverItsCornersGo) {
    Random random(2);
    for (int trial = 0; trial < 1000; ++trial) {
        const auto at = randomQuad(random, 1e-9);
        const auto edge = edgeFlip(at, 0.1), other = edgeFlip({at[2], at[3], at[0], at[1]}, 0.1);
        ASSERT_TRUE(edge && other);
        std::array<Vec3, 4> to;
        for (Vec3& p : to) p = random.cube();
        EXPECT_LE((vertexOf(to, *edge) - vertexOf({to[2], to[3], to[0], to[1]}, *other)).length(), 1e-6);
    }
}

TEST(EdgeFlip, BeginsOnTheEdge) {
    Random random(3);
    int found = 0;
    for (int trial = 0; trial < 1000; ++trial) {
        const auto at = randomQuad(random, 0.0985);
        const auto edge = edgeFlip(at, 0.1);
        EXPECT_FALSE(edgeFlip(randomQuad(random, 0.1 + 1e-6), 0.1));
        if (!edge) continue;
        ++found;
        EXPECT_LE(edge->otherWeight(), 5e-4);
        EXPECT_LE(cross(edge->on_edge.position - at[0].position, at[1].position - at[0].position).length(), 1e-12);
    }
    EXPECT_GE(found, 500);
}

TEST(EdgeFlip, NeverHasItsVertexAtACorner) {
    Random random(5);
    for (int trial = 0; trial < 1000; ++trial) {
        auto at = randomQuad(random, 0.05 * random.unit());
        const std::size_t corner = random.below(2);  // the other diagonal passes it by next to nothing
        const double off = std::pow(10, -8 * random.unit());
        const Vec3 inwards = (at[1 - corner].position - at[corner].position) * off;
        const Vec3 middle = (at[2].position + at[3].position) / 2;
        for (std::size_t k : {2, 3}) at[k].position += at[corner].position + inwards - middle;
        const auto edge = edgeFlip(at, 0.1);
        EXPECT_TRUE(!edge || (edge->on_edge.position - at[corner].position).length() >= 1e-4);
    }
}

TEST(EdgeFlip, IsNoneWhereDiagonalsPassOutsideTheQuadOrNever) {
    const auto at = [](const Vec3& p) { return DualVec3{p, {}}; };
    EXPECT_FALSE(edgeFlip({at({0, 0, 0}), at({1, 0, 0}), at({2, -1, 0}), at({2, 1, 0})}, 0.1));
    EXPECT_FALSE(edgeFlip({at({0, 0, 0}), at({1, 0, 0}), at({0, 1, 0}), at({1, 1, 0})}, 0.1));
    EXPECT_FALSE(edgeFlip({at({0, 0, 0}), at({0, 0, 0}), at({0, 1, 0}), at({1, 1, 0})}, 0.1));
}

// Flips of edges 0-1, 2-3 and so on, each with a triangle in common with the one before.
std::vector<EdgeFlip> chainOfFlips(const std::vector<double>& remoteness) {
    std::vector<EdgeFlip> edges;
    for (std::uint32_t e = 0; e < remoteness.size(); ++e)
        edges.push_back({{2 * e, 2 * e + 1, 0, 0}, {e, e + 1}, {0.3, 0.3, 0.2, 0.2}, {}, remoteness[e]});
    return edges;
}

TEST(TurningEdges, ThatShareATriangleLeaveItToTheNearestTurn) {
    Random random(6);
    for (int trial = 0; trial < 1000; ++trial) {
        std::vector<double> remoteness(1 + random.below(9));
        for (double& r : remoteness) r = random.unit();
        std::vector<EdgeFlip> kept = chainOfFlips(remoteness);
        keepNearestFlips(kept);
        std::vector<std::uint8_t> is_kept(remoteness.size(), 0);
        for (const EdgeFlip& edge : kept) is_kept[edge.corner[0] / 2] = 1;
        for (std::size_t e = 0; e < remoteness.size(); ++e) {
            double other = 1;
            if (e > 0) other = std::min(other, remoteness[e - 1]);
            if (e + 1 < remoteness.size()) other = std::min(other, remoteness[e + 1]);
            EXPECT_FALSE(is_kept[e] && remoteness[e] > other);
            EXPECT_TRUE(is_kept[e] || remoteness[e] > 0.95 * other);
        }
    }
}

// The nearest turn does not depend on the others when it happens, and none is kept where two are equally near.
TEST(TurningEdges, HandOverWithoutAJump) {
    const auto weightOfFirst = [](double first, double second) {
        std::vector<EdgeFlip> edges = chainOfFlips({first, second});
        keepNearestFlips(edges);
        return edges.empty() || edges[0].corner[0] != 0 ? 0 : edges[0].otherWeight();
    };
    for (const double second : {0.01, 0.2, 0.9}) {
        EXPECT_NEAR(weightOfFirst(0, second), 0.5, 1e-12);
        EXPECT_EQ(weightOfFirst(second, second), 0);
        double before = 0.5;
        for (double first = 0; first < 1.1 * second; first += 1e-3 * second) {
            const double weight = weightOfFirst(first, second);
            EXPECT_LE(weight, before);
            EXPECT_NEAR(weight, before, 1e-3);
            before = weight;
        }
    }
}

TEST(TurningEdges, LeaveAMeshClosedWhicheverTurn) {
    const Icosphere ball = icosphere(3);
    std::map<std::array<std::uint32_t, 2>, std::uint32_t> left_of;
    for (std::uint32_t t = 0; t < ball.triangles.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) left_of[{ball.triangles[t][k], ball.triangles[t][(k + 1) % 3]}] = t;
    Random random(4);
    for (const double share_turning : {0.05, 0.3, 0.7, 1.0}) {
        std::vector<EdgeFlip> edges;
        for (const auto& [e, t] : left_of) {
            if (e[0] > e[1] || random.unit() > share_turning) continue;
            const double half = random.unit() / 4;
            edges.push_back({{e[0], e[1], 0, 0},
                             {t, left_of.at({e[1], e[0]})},
                             {0.5 - half, 0.5 - half, half, half},
                             {(ball.position[e[0]] + ball.position[e[1]]) / 2, {}},
                             1 - 4 * half});
        }
        keepNearestFlips(edges);
        Mesh mesh;
        mesh.position = ball.position;
        mesh.triangles = {{0, 0, 0}};  // of another ball
        mesh.triangles.insert(mesh.triangles.end(), ball.triangles.begin(), ball.triangles.end());
        const auto first_vertex = static_cast<std::uint32_t>(mesh.position.size());
        splitFlippingEdges(edges, 1, first_vertex, mesh.triangles);
        for (const EdgeFlip& edge : edges) mesh.position.push_back(edge.on_edge.position);
        EXPECT_EQ(mesh.triangles[0], (Triangle{0, 0, 0}));
        mesh.triangles.erase(mesh.triangles.begin());
        EXPECT_EQ(mesh.triangles.size(), ball.triangles.size() + 2 * edges.size());
        EXPECT_TRUE(faultsOf(checkMesh(mesh)).empty()) << share_turning;
        for (const auto& [a, b, c] : mesh.triangles)  // flat pieces of a ball, all seen from outside
            EXPECT_GT(
                dot(cross(mesh.position[b] - mesh.position[a], mesh.position[c] - mesh.position[a]), mesh.position[a]),
                0);
    }
}

}  // namespace
}  // namespace betamesh
