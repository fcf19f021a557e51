// Properties of simplified meshes: they are valid, near the original, and made of its vertices.

#include "betamesh/simplify.h"

#include "base/icosphere.h"
#include "base/parallel.h"
#include "base/random.h"
#include "betamesh/check.h"
#include "betamesh/coherence.h"
#include "betamesh/error.h"
#include "betamesh/skin.h"
#include "mesh/triangle_tree.h"
#include "support/clouds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

namespace betamesh {
namespace {

// The largest distance from points all over a mesh, in at most some 4,000 triangles, to another one.
double largestDistance(const Mesh& from, const Mesh& to) {
    const TriangleTree tree(to.position, to.triangles);
    const std::size_t step = from.triangles.size() / 4000 + 1;
    std::vector<double> distance((from.triangles.size() + step - 1) / step);
    parallelFor(distance.size(), 64, [&](std::size_t t) {
        const auto& [a, b, c] = from.triangles[t * step];
        constexpr int kSteps = 4;
        for (int i = 0; i <= kSteps; ++i)
            for (int j = 0; i + j <= kSteps; ++j)
                distance[t] = std::max(distance[t], tree.distanceTo((from.position[a] * i + from.position[b] * j +
                                                                     from.position[c] * (kSteps - i - j)) /
                                                                    kSteps));
    });
    return distance.empty() ? 0 : *std::max_element(distance.begin(), distance.end());
}

// Faults, components and the sum over their Euler characteristics.
void expectSameTopology(const Mesh& mesh, const Mesh& result) {
    const MeshCheck before = checkMesh(mesh), after = checkMesh(result);
    EXPECT_EQ(faultsOf(after), faultsOf(before));
    EXPECT_EQ(after.euler, before.euler);
    ASSERT_EQ(after.components.size(), before.components.size());
    for (std::size_t c = 0; c < after.components.size(); ++c)
        EXPECT_EQ(after.components[c].euler, before.components[c].euler);
    EXPECT_EQ(after.unused_vertices.count, 0u);
}

// Every vertex of the result is one of the mesh, in the same order, with all that belongs to it.
void expectVerticesOf(const Mesh& mesh, const Mesh& result) {
    ASSERT_EQ(result.velocity.empty(), mesh.velocity.empty());
    ASSERT_EQ(result.attributes.size(), mesh.attributes.size());
    std::size_t row = 0;
    for (std::size_t v = 0; v < result.position.size(); ++v, ++row) {
        const auto isSame = [&] {
            if (result.position[v] != mesh.position[row]) return false;
            if (!mesh.velocity.empty() && result.velocity[v] != mesh.velocity[row]) return false;
            for (std::size_t a = 0; a < mesh.attributes.size(); ++a)
                if (result.attributes[a].real[v] != mesh.attributes[a].real[row]) return false;
            return true;
        };
        while (row < mesh.position.size() && !isSame()) ++row;
        ASSERT_LT(row, mesh.position.size()) << "vertex " << v;
    }
}

void expectSimplified(const Mesh& mesh, double tolerance) {
    const Mesh result = simplified(mesh, tolerance);
    EXPECT_LE(result.triangles.size(), mesh.triangles.size());
    expectSameTopology(mesh, result);
    expectVerticesOf(mesh, result);
    constexpr double kRounding = 1 + 1e-6;
    EXPECT_LE(largestDistance(mesh, result), tolerance * kRounding);
    EXPECT_LE(largestDistance(result, mesh), tolerance * kRounding);
}

Mesh skinOf(const Cloud& cloud) {
    SkinParams params;
    params.radius = cloud.radius;
    params.attributes = {};
    Mesh mesh = skinFrame(cloud.particles, params).mesh;
    Attribute& rows = mesh.attributes.emplace_back(Attribute{"row", 1, {}, {}, {}});
    for (std::size_t v = 0; v < mesh.position.size(); ++v) rows.real.push_back(static_cast<float>(v));
    return mesh;
}

TEST(Simplify, IsValidNearAndMadeOfVerticesOfTheOriginal) {
    forEveryCloud(20, [](const Cloud& cloud) {
        if (cloud.particles.size() > 500) return;
        const Mesh mesh = skinOf(cloud);
        const double tolerance = std::array{0.002, 0.01, 0.1, 1.0}[hash(1, cloud.particles.size()) % 4];
        SCOPED_TRACE(tolerance);
        expectSimplified(mesh, tolerance * cloud.radius);
    });
}

// A closed block of unit squares, each of two triangles.
Mesh block(int n) {
    Mesh mesh;
    std::map<std::array<int, 3>, std::uint32_t> row;
    const auto vertex = [&](const std::array<int, 3>& at) {
        const auto [entry, is_new] = row.try_emplace(at, static_cast<std::uint32_t>(row.size()));
        if (is_new) mesh.position.emplace_back(at[0], at[1], at[2]);
        return entry->second;
    };
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (const int end : {0, n})
            for (int i = 0; i < n; ++i)
                for (int j = 0; j < n; ++j) {
                    const auto corner = [&](int x, int y) {
                        std::array<int, 3> at{};
                        at[axis] = end, at[(axis + 1) % 3] = x, at[(axis + 2) % 3] = y;
                        return vertex(at);
                    };
                    std::uint32_t a = corner(i, j), b = corner(i + 1, j), c = corner(i + 1, j + 1),
                                  d = corner(i, j + 1);
                    if (end == 0) std::swap(b, d);
                    mesh.triangles.push_back({a, b, c});
                    mesh.triangles.push_back({a, c, d});
                }
    return mesh;
}

TEST(Simplify, LeavesFewTrianglesOfFlatFaces) {
    const Mesh mesh = block(20);
    expectSimplified(mesh, 0.01);
    EXPECT_LT(simplified(mesh, 0.01).triangles.size(), mesh.triangles.size() / 3);  // edges of the block are kept
}

TEST(Simplify, LeavesFewerTrianglesTheMoreIsTolerated) {
    const Icosphere sphere = icosphere(40);
    const Mesh mesh{sphere.position, {}, sphere.triangles, {}, {}};
    std::size_t before = mesh.triangles.size();
    for (const double tolerance : {5e-4, 2e-3, 1e-2}) {
        expectSimplified(mesh, tolerance);
        const std::size_t now = simplified(mesh, tolerance).triangles.size();
        EXPECT_LT(now, before);
        before = now;
    }
    EXPECT_LT(before, mesh.triangles.size() / 8);
}

// Opposite sides of a thin sheet are nearer to each other than long tolerances.
TEST(Simplify, LongTolerancesKeepNoMoreOfThinSheetsThanShortOnes) {
    Cloud cloud{"sheet", {}, 1.5};
    Random random(1);
    for (int i = 0; i < 400; ++i) cloud.particles.position.emplace_back(Vec3(i % 20, i / 20, 0) + random.cube() * 0.2);
    const Mesh mesh = skinOf(cloud);
    std::size_t before = mesh.triangles.size() / 2;
    for (const double tolerance : {0.03, 0.1, 0.3, 1.0, 100.0}) {
        const std::size_t now = simplified(mesh, tolerance).triangles.size();
        EXPECT_LT(now, before + before / 20) << tolerance;
        before = now;
    }
}

// Unions of balls cross themselves; what crossed before may go on to do so, and costs no more.
TEST(Simplify, AcceptsMeshesThatCrossThemselves) {
    Cloud cloud{"union", {}, 1.5};
    for (int i = 0; i < 64; ++i) cloud.particles.position.emplace_back(i % 4, i / 4 % 4, i / 16);
    Mesh twice = skinOf(cloud);
    const auto n = static_cast<std::uint32_t>(twice.position.size());
    Mesh other = twice;
    for (std::uint32_t v = 0; v < n; ++v) twice.position.push_back(twice.position[v] + Vec3(1.1, 0.3, 0.7));
    for (const auto& [a, b, c] : other.triangles) twice.triangles.push_back({a + n, b + n, c + n});
    twice.velocity.clear();
    twice.attributes.clear();
    const Mesh result = simplified(twice, 0.02);
    EXPECT_LT(result.triangles.size(), twice.triangles.size());
    EXPECT_LE(checkMesh(result).crossings.count, checkMesh(twice).crossings.count);
    EXPECT_FALSE(checkMesh(result).open_edges);
}

TEST(Simplify, HasTheSameBytesForAnyNumberOfThreads) {
    const Mesh mesh = skinOf(awkwardClouds().back());
    const Mesh usual = simplified(mesh, 0.02);
    for (const int threads : {1, 2, 5})
        withThreads(threads, [&] {
            const Mesh again = simplified(mesh, 0.02);
            EXPECT_EQ(again.triangles, usual.triangles);
            EXPECT_EQ(again.position, usual.position);
        });
}

TEST(Simplify, KeepsBordersAndWhatIsNotAManifold) {
    Mesh mesh = block(12);
    mesh.triangles.erase(mesh.triangles.begin(), mesh.triangles.begin() + 2 * 12 * 12);  // an open side
    const auto isOnBorder = [](const Vec3& p) { return p.x == 0; };
    const auto border = std::count_if(mesh.position.begin(), mesh.position.end(), isOnBorder);
    const auto inside = std::count_if(mesh.position.begin(), mesh.position.end(), [](const Vec3& p) {
        return p.x == 0 && p.y > 0 && p.y < 12 && p.z > 0 && p.z < 12;
    });
    const Mesh open = simplified(mesh, 0.01);
    EXPECT_LT(open.triangles.size(), mesh.triangles.size());
    EXPECT_EQ(std::count_if(open.position.begin(), open.position.end(), isOnBorder), border - inside);
    EXPECT_EQ(checkMesh(open).open_edges.count, checkMesh(mesh).open_edges.count);

    Mesh twice = block(6);  // two blocks that share an edge
    const Mesh other = block(6);
    const auto first = static_cast<std::uint32_t>(twice.position.size());
    for (const Vec3& p : other.position) twice.position.push_back(p - Vec3(6, 6, 0));
    for (const auto& [a, b, c] : other.triangles) twice.triangles.push_back({a + first, b + first, c + first});
    twice = weldVertices(twice);
    expectSimplified(twice, 0.01);
}

TEST(Simplify, KeepsTheComponentOfEachTriangle) {
    Cloud cloud{"two", {}, 1.5};
    for (int i = 0; i < 60; ++i) cloud.particles.position.emplace_back(i % 5, i / 5 % 3, i / 15 * 30);
    SkinParams params;
    params.radius = cloud.radius;
    params.components = true;
    const Mesh mesh = skinFrame(cloud.particles, params).mesh, result = simplified(mesh, 0.05);
    ASSERT_EQ(result.component->size(), result.triangles.size());
    const auto heightOf = [](const Mesh& of, std::size_t t) {
        return std::lround(of.position[of.triangles[t][0]].z / 30);
    };
    std::map<long, std::int32_t> at;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) at[heightOf(mesh, t)] = (*mesh.component)[t];
    for (std::size_t t = 0; t < result.triangles.size(); ++t)
        EXPECT_EQ((*result.component)[t], at[heightOf(result, t)]);
}

TEST(Simplify, RefusesTolerancesThatAreNotLengths) {
    for (const double tolerance : {0.0, -1.0, std::numeric_limits<double>::infinity(), std::nan("")})
        EXPECT_THROW(simplified(block(1), tolerance), Error);
    EXPECT_TRUE(simplified({}, 1).triangles.empty());
}

}  // namespace
}  // namespace betamesh
