// What is true of triangles that are turned the right way up.

#include "skin/unfold.h"

#include "base/random.h"
#include "betamesh/check.h"
#include "mesh/vertex_normals.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace betamesh {

namespace {

constexpr int kSide = 9;  // vertices along a side of the hill

Vec3 onHill(double x, double y) { return roundedToFloats({x, y, -0.02 * (x * x + y * y)}); }

// A flat hill, closed at the bottom, whose vertices are one apart.
BetaMesh hill() {
    Mesh mesh;
    const auto row = [](int x, int y) { return static_cast<std::uint32_t>(y * kSide + x); };
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) mesh.position.push_back(onHill(x - kSide / 2, y - kSide / 2));
    const auto bottom = static_cast<std::uint32_t>(mesh.position.size());
    mesh.position.emplace_back(0, 0, -10);
    for (int y = 0; y + 1 < kSide; ++y)
        for (int x = 0; x + 1 < kSide; ++x) {
            mesh.triangles.push_back({row(x, y), row(x + 1, y), row(x + 1, y + 1)});
            mesh.triangles.push_back({row(x, y), row(x + 1, y + 1), row(x, y + 1)});
        }
    const int last = kSide - 1;
    for (int i = 0; i < last; ++i) {
        mesh.triangles.push_back({row(i + 1, 0), row(i, 0), bottom});
        mesh.triangles.push_back({row(last, i + 1), row(last, i), bottom});
        mesh.triangles.push_back({row(i, last), row(i + 1, last), bottom});
        mesh.triangles.push_back({row(0, i), row(0, i + 1), bottom});
    }
    return asBetaMesh(mesh);
}

// Of the triangles of the hill that face down, those of the bottom apart.
double invertedArea(const BetaMesh& mesh) {
    const std::uint32_t bottom = kSide * kSide;
    double sum = 0;
    for (const auto& [a, b, c] : mesh.triangles) {
        if (a == bottom || b == bottom || c == bottom) continue;
        const auto at = [&](std::uint32_t v) { return mesh.vertex[v].position; };
        sum += std::max(0.0, -cross(at(b) - at(a), at(c) - at(a)).z / 2);
    }
    return sum;
}

bool isValid(const BetaMesh& mesh) { return faultsOf(checkMesh(asMesh(mesh.vertex, mesh.triangles))).empty(); }

void unfoldHill(double farthest, BetaMesh& mesh) {
    std::vector<Vec3f> normal;
    for (const Vec3& n : vertexNormals(mesh)) normal.emplace_back(n);
    unfold(normal, 1, farthest, mesh);
}

TEST(Unfold, AVertexThatHasPassedItsNeighboursLeavesNoTriangleUpsideDown) {
    Random random(1);
    int folded = 0;
    for (int trial = 0; trial < 1000; ++trial) {
        BetaMesh mesh = hill();
        const std::uint32_t moved = kSide * (kSide / 2) + kSide / 2;
        const double angle = 2 * std::numbers::pi * random.unit(), length = 1 + 0.6 * random.unit();
        mesh.vertex[moved].position = onHill(length * std::cos(angle), length * std::sin(angle));
        if (invertedArea(mesh) < 0.01 || !isValid(mesh)) continue;
        ++folded;
        const BetaMesh before = mesh;
        unfoldHill(0.1, mesh);
        EXPECT_LT(invertedArea(mesh), 1e-3) << trial;
        for (std::size_t v = 0; v < mesh.vertex.size(); ++v)
            EXPECT_EQ(mesh.vertex[v].position, before.vertex[v].position);
        EXPECT_EQ(mesh.triangles.size(), before.triangles.size());
        EXPECT_TRUE(isValid(mesh)) << trial;
    }
    EXPECT_GT(folded, 30);
}

TEST(Unfold, DiagonalsThatAreFarApartStay) {
    BetaMesh mesh = hill();
    mesh.vertex[kSide * (kSide / 2) + kSide / 2].position = onHill(1.4, 0.5);
    ASSERT_GT(invertedArea(mesh), 0.01);
    const std::vector<Triangle> before = mesh.triangles;
    unfoldHill(1e-6, mesh);
    EXPECT_EQ(mesh.triangles, before);
}

}  // namespace

}  // namespace betamesh
