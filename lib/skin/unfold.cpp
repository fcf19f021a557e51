#include "skin/unfold.h"

#include "base/index.h"
#include "base/parallel.h"
#include "exact/orientation.h"
#include "mesh/triangle_tree.h"
#include "skin/constants.h"
#include "skin/edge_flips.h"
#include "skin/local_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace betamesh {

namespace {

using CornerPoints = std::array<Vec3, 3>;

Vec3 vectorArea(const CornerPoints& at) { return cross(at[1] - at[0], at[2] - at[0]) * 0.5; }

CornerPoints cornersOf(const BetaMesh& mesh, std::uint32_t triangle) {
    const auto& [a, b, c] = mesh.triangles[triangle];
    return {mesh.vertex[a].position, mesh.vertex[b].position, mesh.vertex[c].position};
}

Box boxOf(const CornerPoints& at) {
    Box box;
    for (const Vec3& corner : at) box.extendBy(corner);
    return box;
}

// Triangles that face the wrong way with an area that could be seen.
std::vector<std::uint32_t> invertedTriangles(const std::vector<Vec3f>& normal, double spacing, const BetaMesh& mesh) {
    return indicesWhere(mesh.triangles.size(), [&](std::uint32_t t) {
        const auto& [a, b, c] = mesh.triangles[t];
        const Vec3 outwards = Vec3(normal[a] + normal[b] + normal[c]).normalized();
        const double length = spacing * mesh.scaleOf(a);
        return dot(vectorArea(cornersOf(mesh, t)), outwards) < -kLeastInverted * length * length;
    });
}

// Triangles whose boxes overlap that of one of the triangles given.
std::vector<std::uint32_t> trianglesNear(const BetaMesh& mesh, const std::vector<std::uint32_t>& triangles) {
    std::vector<Vec3> position;
    std::vector<Triangle> copies;
    for (const std::uint32_t t : triangles) {
        const auto first = static_cast<std::uint32_t>(position.size());
        for (const Vec3& corner : cornersOf(mesh, t)) position.push_back(corner);
        copies.push_back({first, first + 1, first + 2});
    }
    const TriangleTree tree(position, copies);
    const auto isNear = [&](const Box& box) {
        bool any = false;
        tree.forTriangles([&](const Box& other) { return other.intersects(box); },
                          [&](std::uint32_t) {
                              any = true;
                              return false;
                          });
        return any;
    };
    constexpr std::size_t kBlock = 64;  // of consecutive triangles, most of which are near each other
    const std::size_t blocks = (mesh.triangles.size() + kBlock - 1) / kBlock;
    const auto endOf = [&](std::size_t block) { return std::min(mesh.triangles.size(), (block + 1) * kBlock); };
    const std::vector<std::uint32_t> near_blocks = indicesWhere(blocks, [&](std::uint32_t block) {
        Box box;
        for (std::size_t t = block * kBlock; t < endOf(block); ++t)
            for (const std::uint32_t v : mesh.triangles[t]) box.extendBy(mesh.vertex[v].position);
        return isNear(box);
    });
    std::vector<std::uint32_t> near;
    for (const std::uint32_t block : near_blocks)
        for (auto t = static_cast<std::uint32_t>(block * kBlock); t < endOf(block); ++t)
            if (isNear(boxOf(cornersOf(mesh, t)))) near.push_back(t);
    return near;
}

class Unfolding {
public:
    // core: the triangles that may change, of the mesh
    Unfolding(const BetaMesh& mesh, const std::vector<std::uint32_t>& core, double spacing, double farthest)
        : surface_(mesh, withRings(mesh, trianglesNear(mesh, core), kRings)),
          tree_(surface_.position, surface_.triangles),
          is_core_(surface_.triangles.size(), 0),
          farthest_(farthest) {
        for (const std::uint32_t t : core) is_core_[surface_.triangleOf(t)] = 1;
        for (const std::uint32_t v : surface_.vertex) spacing_.push_back(spacing * mesh.scaleOf(v));
        findNormals();
    }

    void run() {
        for (int round = 0; round < kUnfoldingRounds; ++round) {
            bool any = false;
            for (std::uint32_t t = 0; t < surface_.triangles.size(); ++t)
                if (is_core_[t] != 0 && inverted(surface_.triangles[t]) > leastGain(t)) any |= flipBest(t);
            if (!any) return;
        }
    }
    void writeTo(BetaMesh& mesh) const {
        for (const std::uint32_t t : flipped_)
            for (std::size_t k = 0; k < 3; ++k)
                mesh.triangles[surface_.row[t]][k] = surface_.vertex[surface_.triangles[t][k]];
    }

private:
    static constexpr int kRings = 3;  // around what may be in contact: enough for contacts and for normals

    // An edge from corner a to b of triangle t, which has the further corner c; that of the triangle across is d.
    struct Edge {
        std::uint32_t t, across;
        std::size_t side, side_across;
        std::uint32_t a, b, c, d;
    };
    // A triangle before a flip.
    struct Former {
        std::uint32_t t;
        Triangle corners;
        std::array<std::uint32_t, 3> across;
    };

    CornerPoints cornersAt(const Triangle& t) const {
        return {surface_.position[t[0]], surface_.position[t[1]], surface_.position[t[2]]};
    }

    // The surface's normals: means of vector areas, so that what is upside down counts against its neighbours.
    void findNormals() {
        normal_.assign(surface_.position.size(), Vec3(0));
        for (const Triangle& t : surface_.triangles)
            for (const std::uint32_t v : t) normal_[v] += vectorArea(cornersAt(t));
        for (int ring = 1; ring < kRings; ++ring) {
            std::vector<Vec3> sum(normal_.size(), Vec3(0));
            for (const Triangle& t : surface_.triangles)
                for (const std::uint32_t v : t) sum[v] += normal_[t[0]] + normal_[t[1]] + normal_[t[2]];
            normal_ = std::move(sum);
        }
        for (Vec3& normal : normal_) normal.normalize();
    }

    // The area that faces the wrong way.
    double inverted(const Triangle& t) const {
        const Vec3 outwards = (normal_[t[0]] + normal_[t[1]] + normal_[t[2]]).normalized();
        return std::max(0.0, -dot(vectorArea(cornersAt(t)), outwards));
    }

    std::optional<Edge> edgeAt(std::uint32_t t, std::size_t side) const {
        const Triangle& corner = surface_.triangles[t];
        Edge edge{
            t, surface_.across[3 * t + side], side, 0, corner[side], corner[(side + 1) % 3], corner[(side + 2) % 3], 0};
        if (edge.across == kInvalidIndex) return std::nullopt;
        const Triangle& other = surface_.triangles[edge.across];
        while (edge.side_across < 3 && other[edge.side_across] != edge.b) ++edge.side_across;
        if (edge.side_across == 3 || other[(edge.side_across + 1) % 3] != edge.a) return std::nullopt;
        edge.d = other[(edge.side_across + 2) % 3];
        if (edge.c == edge.d || areJoined(t, edge.c, edge.d)) return std::nullopt;
        return edge;
    }
    // Has a corner c of triangle t an edge to vertex d? True if that is not known.
    bool areJoined(std::uint32_t t, std::uint32_t c, std::uint32_t d) const {
        std::uint32_t at = t;
        do {
            const Triangle& corner = surface_.triangles[at];
            const std::size_t k = corner[0] == c ? 0 : corner[1] == c ? 1 : 2;
            if (corner[(k + 1) % 3] == d || corner[(k + 2) % 3] == d) return true;
            at = surface_.across[3 * at + k];
            if (at == kInvalidIndex) return true;
        } while (at != t);
        return false;
    }
    // Is the distance between the two diagonals of the quad small?
    bool isNearlyPlane(const Edge& edge) const {
        const auto at = [&](std::uint32_t v) -> const Vec3& { return surface_.position[v]; };
        return passNear(at(edge.a), at(edge.b), at(edge.c), at(edge.d), farthest_ * spacing_[edge.a]);
    }

    // The inverted area that a flip has to gain, square world units.
    double leastGain(std::uint32_t t) const {
        const double spacing = spacing_[surface_.triangles[t][0]];
        return kLeastInverted * spacing * spacing;
    }

    // Replaces the edge of an inverted triangle that gains most.
    bool flipBest(std::uint32_t t) {
        struct Choice {
            Edge edge;
            double gain;
        };
        std::vector<Choice> choices;
        for (std::size_t side = 0; side < 3; ++side) {
            const std::optional<Edge> edge = edgeAt(t, side);
            if (!edge || is_core_[edge->across] == 0 || !isNearlyPlane(*edge)) continue;
            const double before = inverted(surface_.triangles[t]) + inverted(surface_.triangles[edge->across]);
            const double after = inverted({edge->c, edge->a, edge->d}) + inverted({edge->d, edge->b, edge->c});
            if (before - after > leastGain(t)) choices.push_back({*edge, before - after});
        }
        std::stable_sort(choices.begin(), choices.end(),
                         [](const Choice& a, const Choice& b) { return a.gain > b.gain; });
        return std::any_of(choices.begin(), choices.end(), [&](const Choice& choice) { return flip(choice.edge); });
    }

    // Returns false, and changes nothing, if triangles would cross.
    bool flip(const Edge& edge) {
        const auto& [t, u, k, m, a, b, c, d] = edge;
        const Former formers[] = {former(t), former(u)};
        std::vector<std::uint32_t>& across = surface_.across;
        const std::uint32_t beside_bc = across[3 * t + (k + 1) % 3], beside_ca = across[3 * t + (k + 2) % 3],
                            beside_ad = across[3 * u + (m + 1) % 3], beside_db = across[3 * u + (m + 2) % 3];
        const auto set = [&](std::uint32_t row, const Triangle& corners, const std::array<std::uint32_t, 3>& beside) {
            surface_.triangles[row] = corners;
            std::copy(beside.begin(), beside.end(), across.begin() + 3 * static_cast<std::ptrdiff_t>(row));
        };
        set(t, {c, a, d}, {beside_ca, beside_ad, u});
        set(u, {d, b, c}, {beside_db, beside_bc, t});
        replaceAcross(beside_ad, a, u, t);
        replaceAcross(beside_bc, b, t, u);
        if (!crossesAny(t, u)) {
            flipped_.insert(flipped_.end(), {t, u});
            return true;
        }
        replaceAcross(beside_ad, a, t, u);
        replaceAcross(beside_bc, b, u, t);
        for (const Former& before : formers) set(before.t, before.corners, before.across);
        return false;
    }
    Former former(std::uint32_t t) const {
        return {
            t, surface_.triangles[t], {surface_.across[3 * t], surface_.across[3 * t + 1], surface_.across[3 * t + 2]}};
    }
    // Replaces what is across a side of a triangle that ends at vertex `end` or begins there.
    void replaceAcross(std::uint32_t triangle, std::uint32_t end, std::uint32_t before, std::uint32_t after) {
        if (triangle == kInvalidIndex) return;
        for (std::size_t k = 0; k < 3; ++k) {
            std::uint32_t& across = surface_.across[3 * triangle + k];
            const Triangle& corner = surface_.triangles[triangle];
            if (across == before && (corner[k] == end || corner[(k + 1) % 3] == end)) across = after;
        }
    }

    bool crossesAny(std::uint32_t t, std::uint32_t u) const {
        Box box = boxOf(cornersAt(surface_.triangles[t]));
        box.extendBy(boxOf(cornersAt(surface_.triangles[u])));
        if (isDegenerate(t) || isDegenerate(u) || surface_.cross(t, u)) return true;
        const auto crosses = [&](std::uint32_t x) {
            return x != t && x != u && !isDegenerate(x) && (surface_.cross(t, x) || surface_.cross(u, x));
        };
        bool any = std::any_of(flipped_.begin(), flipped_.end(), crosses);  // their boxes in the tree are out of date
        tree_.forTriangles([&](const Box& other) { return other.intersects(box); },
                           [&](std::uint32_t x) {
                               any = any || crosses(x);
                               return !any;
                           });
        return any;
    }
    bool isDegenerate(std::uint32_t t) const {
        const CornerPoints at = cornersAt(surface_.triangles[t]);
        return areCollinear(at[0], at[1], at[2]);
    }

    LocalSurface surface_;
    TriangleTree tree_;  // with the boxes before any flip
    std::vector<std::uint8_t> is_core_;
    std::vector<Vec3> normal_;
    std::vector<double> spacing_;  // of the particles at each vertex, world units
    double farthest_;              // between diagonals, in these
    std::vector<std::uint32_t> flipped_;
};

}  // namespace

void unfold(const std::vector<Vec3f>& normal, double spacing, double farthest, BetaMesh& mesh) {
    const std::vector<std::uint32_t> inverted = invertedTriangles(normal, spacing, mesh);
    if (inverted.empty()) return;
    Unfolding unfolding(mesh, withRings(mesh, inverted, 1), spacing, farthest);
    unfolding.run();
    unfolding.writeTo(mesh);
}

}  // namespace betamesh
