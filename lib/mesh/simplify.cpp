#include "betamesh/simplify.h"

#include "base/box.h"
#include "base/chosen_rows.h"
#include "base/compressed_rows.h"
#include "base/index.h"
#include "base/parallel.h"
#include "base/random.h"
#include "betamesh/check.h"
#include "betamesh/error.h"
#include "exact/orientation.h"
#include "mesh/collapse_ring.h"
#include "mesh/mesh_edges.h"
#include "mesh/triangle_tree.h"
#include "mesh/vertex_normals.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>

namespace betamesh {

namespace {

constexpr std::size_t kMostOriginals = 256;   // original triangles that the triangles around a vertex may replace
constexpr float kLeastNormalCosine = 0.94F;   // of a triangle's normal to those of its corners: 20 degrees
constexpr double kLeastQuality = 0.1;         // of a triangle: 4 sqrt(3) area / squared sides, 1 if equilateral
constexpr double kLargestTolerance = 1;       // in median lengths of edges; more leaves out no more
constexpr double kLargestFacingCosine = 0.5;  // between the normals of triangles that may come to cross
constexpr float kErrorSteps = 32;             // errors are compared in this many steps of the tolerance
constexpr std::size_t kSmallestShare = 500;   // a round that removes less than one vertex in so many is the last one
constexpr int kMostAttempts = 8;              // at a mesh without new crossings
constexpr std::size_t kMostCrossings = 1000;  // that are looked at in each attempt
constexpr int kTurns = 4;                     // of a round
constexpr std::uint64_t kTaken = 0;           // less than any claim
constexpr std::uint64_t kNobody = std::numeric_limits<std::uint64_t>::max();

// A small set of numbers, for one search.
class SmallSet {
public:
    SmallSet() { slot_.fill(kInvalidIndex); }
    // Returns whether it was new. At most half of the slots may be taken.
    bool insert(std::uint32_t number) {
        std::size_t i = hash(0, number) % slot_.size();
        for (; slot_[i] != kInvalidIndex; i = (i + 1) % slot_.size())
            if (slot_[i] == number) return false;
        slot_[i] = number;
        return true;
    }

private:
    std::array<std::uint32_t, 4 * kMostOriginals> slot_;
};

// The vertex to collapse into.
struct Collapse {
    std::uint32_t target = kInvalidIndex;
    float error = 1;  // distance of the new triangles from the original surface, in tolerances
    float room = 0;   // distance that they may have, in tolerances
};

// Removes vertices by collapsing edges, in rounds. The collapses of a round have no vertex in common, those around the
// removed vertices included, so that they can be carried out in any order.
class Simplifier {
public:
    // room: how far each triangle may be from the new surface, in tolerances; those without stay.
    Simplifier(const Mesh& mesh, double tolerance, const std::vector<Vec3>& normals, const std::vector<float>& room)
        : position_(mesh.position),
          original_(mesh.triangles),
          original_normal_(normals),
          original_across_(trianglesAcross(sortedSides(mesh.triangles))),
          original_star_(starsOf(mesh.triangles)),
          tolerance_(tolerance),
          triangles_(mesh.triangles),
          row_(triangles_.size()),
          error_(triangles_.size()),
          room_(room),
          star_(original_star_),
          collapse_(position_.size()),
          is_stale_(position_.size(), 0),
          claim_(position_.size()) {
        std::iota(row_.begin(), row_.end(), 0);
        vertices_ = indicesWhere(position_.size(), [&](std::uint32_t v) {
            const auto star = star_[v];
            return std::all_of(star.begin(), star.end(), [&](std::uint32_t t) { return room[t] > 0; });
        });
    }

    void run() {
        parallelFor(vertices_.size(), 256,
                    [&](std::size_t i) { collapse_[vertices_[i]] = bestCollapse(vertices_[i]); });
        for (std::uint64_t round = 0;; ++round) {
            const std::size_t removed = removeVertices(round);
            if (removed * kSmallestShare <= vertices_.size()) return;
            star_ = starsOf(triangles_);
        }
    }

    std::vector<Triangle>& triangles() { return triangles_; }
    // Rows of the mesh that the triangles come from.
    const std::vector<std::uint32_t>& rows() const { return row_; }

private:
    // The triangles of each vertex, ascending.
    IndexRows starsOf(std::span<const Triangle> triangles) const {
        return sortedIntoRows<std::uint32_t>(position_.size(), triangles.size(), [&](std::size_t t, const auto& visit) {
            for (const std::uint32_t v : triangles[t]) visit(v, static_cast<std::uint32_t>(t));
        });
    }

    // A round of several turns. In each, every vertex that may be removed claims itself and those around it, of which
    // none may have been taken in this round; of several claims on a vertex the one with the smallest error counts.
    // Those that got all they claimed take it. Returns their number.
    std::size_t removeVertices(std::uint64_t round) {
        std::vector<std::uint32_t> candidates = verticesWhere(
            vertices_, [&](std::uint32_t v) { return is_stale_[v] || collapse_[v].target != kInvalidIndex; });
        std::fill(claim_.begin(), claim_.end(), kNobody);
        std::size_t removed = 0;
        for (int turn = 0; turn < kTurns; ++turn) {
            const auto claimOf = [&](std::uint32_t v) {
                return (errorStep(v) + 1) << 56 | (hash(round, v) >> 40) << 32 | v;
            };
            parallelFor(candidates.size(), 512, [&](std::size_t i) {
                const std::uint64_t claim = claimOf(candidates[i]);
                forOneRing(candidates[i], [&](std::uint32_t w) {
                    std::atomic_ref<std::uint64_t> least(claim_[w]);
                    for (std::uint64_t now = least; claim < now && !least.compare_exchange_weak(now, claim);) {
                    }
                });
            });
            const std::vector<std::uint32_t> chosen = verticesWhere(candidates, [&](std::uint32_t v) {
                bool is_first = true;
                forOneRing(v, [&](std::uint32_t w) { is_first &= claim_[w] == claimOf(v); });
                return is_first;
            });
            parallelFor(chosen.size(), 128, [&](std::size_t i) {
                forOneRing(chosen[i], [&](std::uint32_t w) { claim_[w] = kTaken; });
                removeVertex(chosen[i]);
            });
            removed += chosen.size();
            candidates = verticesWhere(candidates, [&](std::uint32_t v) {
                bool is_free = true;
                forOneRing(v, [&](std::uint32_t w) { is_free &= claim_[w] != kTaken; });
                return is_free;
            });
            parallelFor(claim_.size(), 8192, [&](std::size_t v) {
                if (claim_[v] != kTaken) claim_[v] = kNobody;
            });
        }
        compact();
        return removed;
    }

    template <typename Predicate>
    static std::vector<std::uint32_t> verticesWhere(const std::vector<std::uint32_t>& rows, const Predicate& holds) {
        std::vector<std::uint32_t> found = indicesWhere(rows.size(), [&](std::uint32_t i) { return holds(rows[i]); });
        for (std::uint32_t& i : found) i = rows[i];
        return found;
    }

    // Visits a vertex and those around it, each several times.
    template <typename Visit>
    void forOneRing(std::uint32_t v, const Visit& visit) const {
        for (const std::uint32_t t : star_[v])
            for (const std::uint32_t w : triangles_[t]) visit(w);
    }

    std::uint64_t errorStep(std::uint32_t v) const {
        return static_cast<std::uint64_t>(collapse_[v].error * kErrorSteps);
    }

    // Does nothing if that has become impossible, or if the error has become larger.
    void removeVertex(std::uint32_t v) {
        const std::uint64_t step = errorStep(v);
        if (is_stale_[v] || !keepsTopology(v, collapse_[v].target)) collapse_[v] = bestCollapse(v);
        is_stale_[v] = 0;
        const std::uint32_t target = collapse_[v].target;
        if (target == kInvalidIndex || errorStep(v) > step) return;
        forOneRing(v, [&](std::uint32_t w) { is_stale_[w] = 1; });
        for (const std::uint32_t t : star_[v]) {
            std::replace(triangles_[t].begin(), triangles_[t].end(), v, target);
            error_[t] = collapse_[v].error;
            room_[t] = collapse_[v].room;
        }
        collapse_[v].target = v;
    }

    // Drops vanished triangles and removed vertices.
    void compact() {
        const std::vector<std::uint32_t> kept = indicesWhere(triangles_.size(), [&](std::uint32_t t) {
            const auto& [a, b, c] = triangles_[t];
            return a != b && b != c && c != a;
        });
        const auto keep = [&](auto& rows) {
            std::remove_cvref_t<decltype(rows)> left(kept.size());
            parallelFor(kept.size(), 8192, [&](std::size_t i) { left[i] = rows[kept[i]]; });
            rows = std::move(left);
        };
        keep(triangles_);
        keep(row_);
        keep(error_);
        keep(room_);
        std::erase_if(vertices_, [&](std::uint32_t v) { return collapse_[v].target == v; });
    }

    // Of size 0 unless the triangles form one closed fan that is a height field over the ring's plane.
    OneRing oneRing(std::uint32_t v) const {
        OneRing ring;
        const std::span<const std::uint32_t> star = star_[v];
        const std::size_t n = star.size();
        if (n < 3 || n > kMostNeighbours) return ring;
        std::array<std::uint32_t, kMostNeighbours> end;
        for (std::size_t i = 0; i < n; ++i) {
            const Triangle& t = triangles_[star[i]];
            const std::size_t k = t[0] == v ? 0 : t[1] == v ? 1 : 2;
            ring.vertex[i] = t[(k + 1) % 3];
            end[i] = t[(k + 2) % 3];
            ring.error = std::max<double>(ring.error, error_[star[i]]);
            ring.room = std::min<double>(ring.room, room_[star[i]]);
        }
        for (std::size_t i = 0; i + 1 < n; ++i) {
            std::size_t j = i + 1;
            while (j < n && ring.vertex[j] != end[i]) ++j;
            if (j == n) return ring;
            std::swap(ring.vertex[i + 1], ring.vertex[j]);
            std::swap(end[i + 1], end[j]);
        }
        if (end[n - 1] != ring.vertex[0]) return ring;
        for (std::size_t i = 0; i < n; ++i) ring.position[i] = position_[ring.vertex[i]] - position_[v];
        ring.size = n;
        if (!ring.projectAll()) ring.size = 0;
        return ring;
    }

    // The collapse with the smallest error within the room that there is. The error of the old triangles and the height
    // between them and the new ones are an upper bound; where it is too large, the height above the original surface
    // counts.
    Collapse bestCollapse(std::uint32_t v) const {
        const OneRing ring = oneRing(v);
        std::array<std::pair<double, std::size_t>, kMostNeighbours> target;  // smallest heights first
        std::size_t n = 0;
        for (std::size_t i = 0; i < ring.size; ++i) {
            if (!hasGoodTriangles(ring, i)) continue;
            const double height = ring.heightBetween(i) / tolerance_;
            if (height <= ring.room + ring.error) target[n++] = {height, i};
        }
        std::sort(target.begin(), target.begin() + static_cast<std::ptrdiff_t>(n));
        std::optional<OriginalPart> original;
        for (std::size_t k = 0; k < n; ++k) {
            const auto& [height, i] = target[k];
            if (!keepsTopology(v, ring.vertex[i])) continue;
            double error = ring.error + height;
            if (error > ring.room) {
                if (!original) original = originalBeneath(v, ring);
                error = original->heightBetween(ring, i) / tolerance_;
            }
            if (error <= ring.room) return {ring.vertex[i], static_cast<float>(error), static_cast<float>(ring.room)};
        }
        return {};
    }

    // Found from triangle to triangle, beginning at v: vertices never move, so v is a vertex of both surfaces.
    OriginalPart originalBeneath(std::uint32_t v, const OneRing& ring) const {
        OriginalPart part;
        Box box;
        for (std::size_t i = 0; i < ring.size; ++i) box.extendBy(Vec3(ring.projected[i].x, ring.projected[i].y, 0));
        std::vector<std::uint32_t> found(original_star_[v].begin(), original_star_[v].end());
        if (found.size() > kMostOriginals) return part;
        SmallSet known;
        for (const std::uint32_t t : found) known.insert(t);
        for (std::size_t next = 0; next < found.size(); ++next) {
            const std::size_t t = found[next];
            const Triangle& triangle = original_[t];
            std::array<Vec3, 3> corner;
            for (std::size_t k = 0; k < 3; ++k) corner[k] = ring.project(position_[triangle[k]] - position_[v]);
            if (found.size() > kMostOriginals || !(across(corner[1] - corner[0], corner[2] - corner[0]) > 0))
                return part;
            for (std::size_t k = 0; k < 3; ++k) {
                const std::size_t l = (k + 1) % 3;
                const Vec3 &p = corner[k], &q = corner[l];
                if (std::max(p.x, q.x) < box.min.x || std::min(p.x, q.x) > box.max.x ||
                    std::max(p.y, q.y) < box.min.y || std::min(p.y, q.y) > box.max.y)
                    continue;
                if (original_star_[triangle[k]][0] == t) part.vertices.push_back(p);  // once, of all triangles with it
                if (triangle[k] < triangle[l]) part.edges.push_back({p, q});
                const std::uint32_t beyond = original_across_[3 * t + k];
                if (beyond != kInvalidIndex && known.insert(beyond)) found.push_back(beyond);
            }
        }
        part.is_field = true;
        return part;
    }

    bool hasGoodTriangles(const OneRing& ring, std::size_t target) const {
        for (std::size_t i = ring.next(target); i != ring.previous(target); i = ring.next(i))
            if (!isGood(ring, {target, i, ring.next(i)})) return false;
        return true;
    }

    // Does a new triangle have a good shape and about the direction of the original surface at its corners?
    bool isGood(const OneRing& ring, const std::array<std::size_t, 3>& corner) const {
        const Vec3 &a = ring.projected[corner[0]], &b = ring.projected[corner[1]], &c = ring.projected[corner[2]];
        if (!(across(b - a, c - a) > 0)) return false;
        const Vec3& p = ring.position[corner[0]];
        const Vec3 normal = cross(ring.position[corner[1]] - p, ring.position[corner[2]] - p);
        const double double_area = normal.length();
        const double squared_sides = (b - a).length2() + (c - b).length2() + (a - c).length2();
        if (!(double_area * 2 * std::numbers::sqrt3 >= kLeastQuality * squared_sides)) return false;
        for (const std::size_t i : corner)
            if (!(dot(normal, original_normal_[ring.vertex[i]]) >= kLeastNormalCosine * double_area)) return false;
        return true;
    }

    // Is the surface still a manifold of the same topology after v has collapsed into the target? So it is if the two
    // have exactly two common neighbours, and these keep three or more.
    //
    // source  the link condition: Dey, Edelsbrunner, Guha & Nekhayev 1999
    bool keepsTopology(std::uint32_t v, std::uint32_t target) const {
        if (star_[v].size() + star_[target].size() > kMostNeighbours + 4) return false;
        std::size_t common = 0;  // sides of the target's triangles whose other end is a neighbour of v
        for (const std::uint32_t t : star_[target])
            for (const std::uint32_t w : triangles_[t]) {
                if (w == v || w == target || !areNeighbours(v, w)) continue;
                if (star_[w].size() <= 3) return false;
                ++common;
            }
        return common == 4;
    }

    bool areNeighbours(std::uint32_t v, std::uint32_t w) const {
        bool found = false;
        for (const std::uint32_t t : star_[v]) {
            const auto& [a, b, c] = triangles_[t];
            found |= a == w || b == w || c == w;
        }
        return found;
    }

    std::span<const Vec3> position_;
    std::span<const Triangle> original_;
    const std::vector<Vec3>& original_normal_;    // of vertices
    std::vector<std::uint32_t> original_across_;  // the triangle across each side
    IndexRows original_star_;                     // the triangles of each vertex
    const double tolerance_;

    std::vector<Triangle> triangles_;
    std::vector<std::uint32_t> row_;  // of the original triangle whose place each one has
    std::vector<float> error_;        // of each: largest distance to the original surface, in tolerances
    std::vector<float> room_;         // of each: largest distance that is allowed, in tolerances
    IndexRows star_;                  // triangles of each vertex

    std::vector<std::uint32_t> vertices_;  // those that may be removed
    std::vector<Collapse> collapse_;       // the best one of each vertex; into itself: it is removed
    std::vector<std::uint8_t> is_stale_;   // vertices around which triangles have changed since then
    std::vector<std::uint64_t> claim_;     // the least claim on each vertex in a round
};

// For each triangle, half of the distance to other parts of the surface that it could come to cross, in tolerances, at
// most 1.
std::vector<float> roomAround(const Mesh& mesh, double tolerance) {
    const TriangleTree tree(mesh.position, mesh.triangles, tolerance);
    std::vector<Vec3> normal(mesh.triangles.size());
    std::vector<Box> box(mesh.triangles.size());
    parallelFor(normal.size(), 4096, [&](std::size_t t) {
        const auto& [a, b, c] = mesh.triangles[t];
        normal[t] = cross(mesh.position[b] - mesh.position[a], mesh.position[c] - mesh.position[a]).normalized();
        for (const std::uint32_t v : mesh.triangles[t]) box[t].extendBy(mesh.position[v]);
    });
    std::vector<float> room(mesh.triangles.size(), 1);
    parallelFor(tree.leaves(), 256, [&](std::size_t leaf) {
        tree.forPairsOfLeaf(leaf, [&](std::uint32_t s, std::uint32_t t) {
            if (dot(normal[s], normal[t]) > kLargestFacingCosine) return;
            Vec3 gap;
            for (int k = 0; k < 3; ++k)
                gap[k] = std::max({box[s].min[k] - box[t].max[k], box[t].min[k] - box[s].max[k], 0.0});
            const auto half = static_cast<float>(gap.length() / 2 / tolerance);
            for (const std::uint32_t row : {s, t}) {
                std::atomic_ref<float> least(room[row]);
                for (float now = least; half < now && !least.compare_exchange_weak(now, half);) {
                }
            }
        });
    });
    return room;
}

double medianEdge(const Mesh& mesh) {
    std::vector<double> length(mesh.triangles.size());
    parallelFor(length.size(), 4096, [&](std::size_t t) {
        length[t] = (mesh.position[mesh.triangles[t][1]] - mesh.position[mesh.triangles[t][0]]).length();
    });
    const auto middle = length.begin() + static_cast<std::ptrdiff_t>(length.size() / 2);
    std::nth_element(length.begin(), middle, length.end());
    return *middle;
}

// A mesh of some of the vertices. rows: of the triangles in whose place the new ones are.
Mesh withTriangles(const Mesh& mesh, std::vector<Triangle> triangles, const std::vector<std::uint32_t>& rows) {
    const std::vector<std::uint32_t> used = verticesOf(triangles, mesh.position.size());
    std::vector<std::uint32_t> new_row(mesh.position.size());
    for (std::size_t i = 0; i < used.size(); ++i) new_row[used[i]] = static_cast<std::uint32_t>(i);
    for (Triangle& t : triangles)
        for (std::uint32_t& v : t) v = new_row[v];
    Mesh result{chosenRows(mesh.position, used), chosenRows(mesh.velocity, used), std::move(triangles), {}, {}};
    for (const Attribute& a : mesh.attributes) result.attributes.push_back(chosenRows(a, used));
    if (mesh.component) result.component = chosenRows(*mesh.component, rows);
    return result;
}

// Leaves no room to original triangles near those that cross.
void keepNear(const std::vector<SelfCrossing>& crossings, const Mesh& of, const Mesh& original,
              std::vector<float>& room) {
    for (const SelfCrossing& crossing : crossings)
        for (const std::uint32_t t : {crossing.first, crossing.second}) {
            Box box;
            for (const std::uint32_t v : of.triangles[t]) box.extendBy(of.position[v]);
            parallelFor(room.size(), 8192, [&](std::size_t row) {
                for (const std::uint32_t v : original.triangles[row])
                    if (box.intersects(original.position[v])) room[row] = 0;
            });
        }
}

MeshCheck withAllCrossings(const Mesh& mesh) { return checkMesh(mesh, {0, kMostCrossings}); }

}  // namespace

Mesh simplified(const Mesh& mesh, double tolerance) {
    if (!(tolerance > 0) || !std::isfinite(tolerance))
        throw Error("the tolerance of simplification is " + std::to_string(tolerance) +
                    ". Give a positive length in world units.");
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (const std::uint32_t v : mesh.triangles[t])
            if (v >= mesh.position.size() || !isInRange(mesh.position[v]))
                throw Error("triangle " + std::to_string(t) + ": vertex " + std::to_string(v) +
                            " does not exist or has no finite position. Only sound meshes can be simplified.");
    if (mesh.triangles.empty()) return withTriangles(mesh, {}, {});
    tolerance = std::min(tolerance, kLargestTolerance * medianEdge(mesh));
    if (tolerance == 0) return mesh;
    const std::vector<Vec3> normals = vertexNormals(mesh.position.size(), mesh.triangles,
                                                    [&](std::uint32_t v) -> const Vec3& { return mesh.position[v]; });
    std::vector<float> room = roomAround(mesh, tolerance);
    std::optional<std::size_t> crossings_before;
    for (int attempt = 0; attempt < kMostAttempts; ++attempt) {
        Simplifier simplifier(mesh, tolerance, normals, room);
        simplifier.run();
        Mesh result = withTriangles(mesh, std::move(simplifier.triangles()), simplifier.rows());
        const MeshCheck check = withAllCrossings(result);
        if (!check.crossings) return result;
        if (!crossings_before) {
            const MeshCheck before = withAllCrossings(mesh);
            crossings_before = before.crossings.count;
            keepNear(before.deepest_crossings, mesh, mesh, room);
        }
        if (check.crossings.count <= *crossings_before) return result;
        keepNear(check.deepest_crossings, result, mesh, room);
    }
    return mesh;
}

}  // namespace betamesh
