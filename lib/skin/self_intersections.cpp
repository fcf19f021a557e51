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

// Moves corners of crossing triangles that fade in to the support with the largest weight.
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

// The crossing triangles of a mesh, and what is done until there are none.
class CrossingResolver {
public:
    CrossingResolver(const BallBoundary& boundary, const DualPoints& from, BetaMesh& mesh)
        : from_(from),
          mesh_(mesh),
          radius_(boundary.worldRadius()),
          tree_(mesh, from.position, radius_, crossingFreeComponents(boundary, from.position, mesh)),
          pairs_(crossingPairs(tree_, mesh)) {}

    std::size_t count() const { return pairs_.size(); }
    bool isResolved() const { return pairs_.empty(); }

    // Moves the corners of crossing triangles: to the means of their one-rings, then back through each other. Where
    // more cross then, as among triangles much smaller than the steps, all return to where they were.
    void relaxCorners() {
        if (isResolved()) return;
        const std::size_t most = pairs_.size();
        const std::vector<DualVec3> start = mesh_.vertex;
        for (int i = 0; i < kCornerRelaxations + kMovesBack && !isResolved() && pairs_.size() <= most; ++i)
            moveCorners([&] {
                if (i < kCornerRelaxations)
                    moveToRingMeans(pairs_, tree_, mesh_);
                else
                    moveBackThrough(pairs_, from_, kMoveBack * radius_, mesh_);
            });
        if (pairs_.size() > most) returnTo(start);
    }

    // Reduces the displacements of crossing triangles, after some rounds to nothing, until none cross or nothing is
    // left to reduce.
    void reduceDisplacements() {
        DisplacementLimits limits(from_, radius_, mesh_);
        int round = 0, in_vain = 0;
        for (std::size_t least = ~std::size_t{0}; !isResolved();) {
            tree_.deactivateAll();
            activateNear(1);
            const bool all_the_way = round >= kMaxReductionRounds, any = limits.reduce(pairs_, all_the_way, tree_);
            if (!any && all_the_way) break;
            in_vain = pairs_.size() < least ? 0 : in_vain + 1;
            least = std::min(least, pairs_.size());
            round = any && in_vain < kMaxRoundsInVain ? round + 1 : kMaxReductionRounds;
            tree_.keepActive(
                [&](std::uint32_t v) { return mesh_.vertex[v].position != limits.limitedPosition(v).position; });
            activateNear(0);
            tree_.forActiveTriangles([&](const Triangle& t) {
                for (const std::uint32_t v : t) mesh_.vertex[v] = limits.limitedPosition(v);
            });
            tree_.refit();
            pairs_ = crossingPairs(tree_, mesh_);
        }
    }

    // Moves crossing triangles apart by a few units of single precision, by more with each attempt; back if more cross
    // then.
    void separate() {
        if (isResolved()) return;
        const std::size_t most = pairs_.size();
        const std::vector<DualVec3> start = mesh_.vertex;
        double largest = 0;  // absolute coordinate
        for (const Vec3& p : from_.position)
            for (int k = 0; k < 3; ++k) largest = std::max(largest, std::abs(p[k]));
        double distance = largest * std::numeric_limits<float>::epsilon();
        for (int i = 0; i < kMaxSeparations && !isResolved(); ++i, distance *= kSeparationGrowth)
            moveCorners([&] {
                if (i < kSupportSeparations)
                    moveToSupports(pairs_, mesh_);
                else if (i % 2 == 0)
                    moveOffPlanes(pairs_, distance, kMaxSeparation * radius_, mesh_);
                else
                    moveToRingMeans(pairs_, tree_, mesh_);
            });
        if (pairs_.size() > most) returnTo(start);
    }

private:
    // Activates what is within a distance of the crossing triangles, where they were and where they are; radii of the
    // balls beside them.
    void activateNear(double radii) {
        for (const std::uint32_t t : trianglesOf(pairs_)) {
            Box box;
            double scale = 0;
            for (const std::uint32_t v : mesh_.triangles[t]) {
                box.extendBy(from_.position[v]);
                box.extendBy(mesh_.vertex[v].position);
                scale = std::max(scale, mesh_.scaleOf(v));
            }
            tree_.activate(box, radii * scale * radius_);
        }
    }
    // move() may move the corners of the crossing triangles.
    template <typename Move>
    void moveCorners(const Move& move) {
        tree_.deactivateAll();
        activateNear(0.5);
        move();
        tree_.refit();
        pairs_ = crossingPairs(tree_, mesh_);
    }

    // Moves the vertices back, and looks for crossings along their ways.
    void returnTo(const std::vector<DualVec3>& start) {
        const auto hasMoved = [&](std::uint32_t v) { return mesh_.vertex[v].position != start[v].position; };
        tree_.deactivateAll();
        for (const Triangle& t : mesh_.triangles) {
            if (std::none_of(t.begin(), t.end(), hasMoved)) continue;
            Box box;
            for (const std::uint32_t v : t) {
                box.extendBy(mesh_.vertex[v].position);
                box.extendBy(start[v].position);
            }
            tree_.activate(box, 0);
        }
        mesh_.vertex = start;
        tree_.refit();
        pairs_ = crossingPairs(tree_, mesh_);
    }

    const DualPoints& from_;
    BetaMesh& mesh_;
    double radius_;  // of the largest ball
    PatchTree tree_;
    std::vector<TrianglePair> pairs_;
};

}  // namespace

std::size_t resolveSelfIntersections(const BallBoundary& boundary, const DualPoints& from, BetaMesh& mesh,
                                     bool moves_corners, bool is_last) {
    if (mesh.triangles.empty()) return 0;
    roundToFloats(mesh);
    CrossingResolver crossings(boundary, from, mesh);
    if (moves_corners) crossings.relaxCorners();
    crossings.reduceDisplacements();
    if (is_last) crossings.separate();
    return crossings.count();
}

}  // namespace betamesh
