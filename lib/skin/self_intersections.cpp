#include "skin/self_intersections.h"

#include "skin/component_crossings.h"
#include "skin/constants.h"
#include "skin/displacement_limits.h"
#include "skin/local_surface.h"
#include "skin/patch_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace betamesh {

namespace {

// The triangles of pairs, ascending.
std::vector<std::uint32_t> trianglesOf(const std::vector<TrianglePair>& pairs) {
    std::vector<std::uint32_t> triangles;
    for (const TrianglePair& pair : pairs) triangles.insert(triangles.end(), pair.begin(), pair.end());
    std::sort(triangles.begin(), triangles.end());
    triangles.erase(std::unique(triangles.begin(), triangles.end()), triangles.end());
    return triangles;
}

// All crossing pairs. Whether triangles that only touch cross depends on the triangles beyond the touching edges.
std::vector<TrianglePair> crossingPairs(const PatchTree& tree, const BetaMesh& mesh) {
    CandidatePairs candidates = tree.candidatePairs();
    std::vector<TrianglePair>& pairs = candidates.crossing;
    if (candidates.undecided.empty()) return std::move(pairs);
    const LocalSurface surface(mesh, withRings(mesh, trianglesOf(candidates.undecided), 2));
    for (const TrianglePair& pair : candidates.undecided)
        if (surface.cross(surface.triangleOf(pair[0]), surface.triangleOf(pair[1]))) pairs.push_back(pair);
    std::sort(pairs.begin(), pairs.end());
    return std::move(pairs);
}

// Moves corners of crossing triangles that fade in to the vertex with the largest weight among those they fade in from.
// Where balls touch, several sheets share a line whose middle single precision cannot represent.
void moveToSupports(const std::vector<TrianglePair>& pairs, BetaMesh& mesh) {
    std::vector<std::uint8_t> is_corner(mesh.vertex.size(), 0);
    for (const TrianglePair& pair : pairs)
        for (const std::uint32_t t : pair)
            for (const std::uint32_t v : mesh.triangles[t]) is_corner[v] = 1;
    for (const auto& group : mesh.fading)
        for (const FadingVertex& fading : group) {
            if (!is_corner[fading.vertex]) continue;
            std::size_t largest = 0;
            for (std::size_t k = 1; k < 4; ++k)
                if (fading.support_weight[k].value > fading.support_weight[largest].value) largest = k;
            mesh.vertex[fading.vertex].position = mesh.vertex[fading.support[largest]].position;
        }
}

// Moves corners of crossing triangles half-way to the means of their one-rings.
void moveToRingMeans(const std::vector<TrianglePair>& pairs, const PatchTree& tree, BetaMesh& mesh) {
    std::vector<std::uint32_t> corners;
    for (const TrianglePair& pair : pairs)
        for (const std::uint32_t t : pair)
            corners.insert(corners.end(), mesh.triangles[t].begin(), mesh.triangles[t].end());
    std::sort(corners.begin(), corners.end());
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    std::vector<std::pair<DualVec3, int>> one_ring(corners.size());  // sum and number of its vertices, each twice
    tree.forActiveTriangles([&](const Triangle& t) {
        for (std::size_t k = 0; k < 3; ++k) {
            const auto at = std::lower_bound(corners.begin(), corners.end(), t[k]);
            if (at == corners.end() || *at != t[k]) continue;
            auto& [sum, count] = one_ring[static_cast<std::size_t>(at - corners.begin())];
            sum = sum + mesh.vertex[t[(k + 1) % 3]] + mesh.vertex[t[(k + 2) % 3]];
            count += 2;
        }
    });
    for (std::size_t i = 0; i < corners.size(); ++i) {
        DualVec3& vertex = mesh.vertex[corners[i]];
        if (const auto& [sum, count] = one_ring[i]; count > 0) vertex = (vertex + sum / Dual(count)) * 0.5;
        vertex.position = roundedToFloats(vertex.position);
    }
}

using VertexDirection = std::pair<std::uint32_t, Vec3>;

// Moves each vertex along the sum of its directions. distance: beside the largest balls, at most `longest` anywhere.
void moveAlong(std::vector<VertexDirection> directions, double distance, double longest, BetaMesh& mesh) {
    std::stable_sort(directions.begin(), directions.end(),
                     [](const VertexDirection& a, const VertexDirection& b) { return a.first < b.first; });
    for (std::size_t i = 0; i < directions.size();) {
        const std::uint32_t v = directions[i].first;
        Vec3 sum(0);
        for (; i < directions.size() && directions[i].first == v; ++i) sum += directions[i].second;
        Vec3& position = mesh.vertex[v].position;
        position = roundedToFloats(position + sum.normalized() * std::min(distance, longest * mesh.scaleOf(v)));
    }
}

// Moves layers that have passed through each other back towards the sides on which they came from. distance: beside the
// largest balls.
void moveBackThrough(const std::vector<TrianglePair>& pairs, const DualPoints& from, double distance, BetaMesh& mesh) {
    const auto now = [&](std::uint32_t v) { return mesh.vertex[v].position; };
    const auto before = [&](std::uint32_t v) { return from.position[v]; };
    const auto normalOf = [&](std::uint32_t t, const auto& at) {
        const auto& [a, b, c] = mesh.triangles[t];
        return cross(at(b) - at(a), at(c) - at(a)).normalized();
    };
    const auto sumOf = [&](std::uint32_t t) {
        const auto& [a, b, c] = mesh.triangles[t];
        return before(a) + before(b) + before(c);
    };
    std::vector<VertexDirection> directions;
    for (const auto& [s, t] : pairs) {
        const Vec3 of_s = normalOf(s, now), of_t = normalOf(t, now);
        if (dot(of_s, of_t) > 0) continue;  // not two layers
        const bool is_gap = dot(sumOf(t) - sumOf(s), normalOf(s, before) - normalOf(t, before)) > 0;
        const Vec3 back = is_gap ? of_t - of_s : of_s - of_t;
        for (const std::uint32_t v : mesh.triangles[s]) directions.emplace_back(v, back);
        for (const std::uint32_t v : mesh.triangles[t]) directions.emplace_back(v, -back);
    }
    moveAlong(std::move(directions), distance, distance, mesh);
}

// Moves crossing triangles away from each other's planes, each to the side of its farthest corner.
void moveOffPlanes(const std::vector<TrianglePair>& pairs, double distance, double longest, BetaMesh& mesh) {
    std::vector<VertexDirection> directions;
    for (const TrianglePair& pair : pairs)
        for (const auto& [plane, moved] : {std::pair(pair[0], pair[1]), std::pair(pair[1], pair[0])}) {
            const auto at = [&](std::uint32_t t, std::size_t k) { return mesh.vertex[mesh.triangles[t][k]].position; };
            const Vec3 normal = cross(at(plane, 1) - at(plane, 0), at(plane, 2) - at(plane, 0)).normalized();
            double farthest = 0;
            for (std::size_t k = 0; k < 3; ++k) {
                const double height = dot(normal, at(moved, k) - at(plane, 0));
                if (std::abs(height) > std::abs(farthest)) farthest = height;
            }
            for (const std::uint32_t v : mesh.triangles[moved])
                directions.emplace_back(v, normal * std::copysign(1.0, farthest));
        }
    moveAlong(std::move(directions), distance, longest, mesh);
}

}  // namespace

bool resolveSelfIntersections(const BallBoundary& boundary, const DualPoints& from, BetaMesh& mesh, bool moves_corners,
                              bool is_last) {
    if (mesh.triangles.empty()) return true;
    roundToFloats(mesh);
    const double radius = boundary.worldRadius();
    PatchTree tree(mesh, from.position, radius, crossingFreeComponents(boundary, from.position, mesh));
    std::vector<TrianglePair> pairs = crossingPairs(tree, mesh);
    if (pairs.empty()) return true;
    const auto activateNear = [&](double radii) {
        for (const std::uint32_t t : trianglesOf(pairs)) {
            Box box;
            double scale = 0;
            for (const std::uint32_t v : mesh.triangles[t]) {
                box.extendBy(from.position[v]);
                box.extendBy(mesh.vertex[v].position);
                scale = std::max(scale, mesh.scaleOf(v));
            }
            tree.activate(box, radii * scale * radius);
        }
    };
    const auto moveCorners = [&](const auto& move) {
        tree.deactivateAll();
        activateNear(0.5);
        move();
        tree.refit();
        pairs = crossingPairs(tree, mesh);
    };
    if (moves_corners) {
        for (int i = 0; i < kCornerRelaxations && !pairs.empty(); ++i)
            moveCorners([&] { moveToRingMeans(pairs, tree, mesh); });
        for (int i = 0; i < kMovesBack && !pairs.empty(); ++i)
            moveCorners([&] { moveBackThrough(pairs, from, kMoveBack * radius, mesh); });
    }
    DisplacementLimits limits(from, radius, mesh);
    for (int round = 0; !pairs.empty();) {
        tree.deactivateAll();
        activateNear(1);
        const bool all_the_way = round >= kMaxReductionRounds, any = limits.reduce(pairs, all_the_way, tree);
        if (!any && all_the_way) break;
        round = any ? round + 1 : kMaxReductionRounds;
        tree.keepActive([&](std::uint32_t v) { return mesh.vertex[v].position != limits.limitedPosition(v).position; });
        activateNear(0);
        tree.forActiveTriangles([&](const Triangle& t) {
            for (const std::uint32_t v : t) mesh.vertex[v] = limits.limitedPosition(v);
        });
        tree.refit();
        pairs = crossingPairs(tree, mesh);
    }
    if (pairs.empty() || !is_last) return pairs.empty();
    double largest = 0;  // absolute coordinate
    for (const Vec3& p : from.position)
        for (int k = 0; k < 3; ++k) largest = std::max(largest, std::abs(p[k]));
    double distance = largest * std::numeric_limits<float>::epsilon();
    for (int i = 0; i < kMaxSeparations && !pairs.empty(); ++i, distance *= kSeparationGrowth)
        moveCorners([&] {
            if (i < kSupportSeparations)
                moveToSupports(pairs, mesh);
            else if (i % 2 == 0)
                moveOffPlanes(pairs, distance, kMaxSeparation * radius, mesh);
            else
                moveToRingMeans(pairs, tree, mesh);
        });
    return pairs.empty();
}

}  // namespace betamesh
