
#include "skin/self_intersections.h"

#include "base/cell_order.h"
#include "base/compressed_rows.h"
#include "base/index.h"
#include "base/parallel.h"
#include "base/union_find.h"
#include "mesh/mesh_edges.h"
#include "mesh/triangle_contact.h"
#include "skin/component_crossings.h"
#include "skin/patch_tree.h"
#include "skin/star_shaped.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>

namespace betamesh {

namespace {

constexpr std::size_t kMostBalls = 64;       // of what may be a drop
constexpr std::size_t kMostCompared = 4096;  // triangles, with one another
constexpr int kRounds = 24;                  // after which what still crosses goes back all the way
constexpr int kHalvings = 32;                // of the way, to find where two triangles meet
constexpr double kShortOf = 0.999;           // of the way to there
constexpr double kMeanWidth = 0.5;           // of the kernel of mean ways, radii
constexpr double kPieceWidth = 0.0625;       // of what counts as one piece in it
constexpr int kSeparations = 24;             // attempts to separate triangles that cross in every known state
constexpr int kCollapses = 4;                // the first of them: what rises from edges and facets goes back to corners
constexpr double kSeparationGrowth = 1.5;    // of the distance, from one attempt to the next
constexpr double kLargestSeparation = 0.02;  // radii
constexpr double kStepOfTime = 1e-4;         // in which nothing moves further, in radii: to see how the place changes
constexpr double kFarthestOff = 0.05;        // that it may change in this step, as a share of the way
constexpr double kFastest = 2;               // that this may move vertices, in largest speeds of the two triangles

// Where a vertex is, for a start and in the end.
struct Way {
    DualVec3 from, to;
};

// The share of the ways of six vertices up to which their triangles do not cross; none where they do from the start,
// or only together with others.
template <typename WayOf>
std::optional<Dual> freeShare(const Triangle& s, const Triangle& t, const WayOf& wayOf, double radius) {
    const auto crossAt = [&](double share, double time) {
        const auto there = [&](std::uint32_t v) {
            const Way& way = wayOf(v);
            const DualVec3 at = way.from + (way.to - way.from) * share;
            return at.position + at.velocity * time;
        };
        return meetingOf(s, t, there) == Meeting::crossing;
    };
    const auto lastFree = [&](double free, double crossing, double time) {
        for (int i = 0; i < kHalvings; ++i) {
            const double middle = (free + crossing) / 2;
            (crossAt(middle, time) ? crossing : free) = middle;
        }
        return free;
    };
    if (crossAt(0, 0) || !crossAt(1, 0)) return std::nullopt;
    const double share = lastFree(0, 1, 0);
    double speed = 0, farthest = 0;
    for (const Triangle& triangle : {s, t})
        for (const std::uint32_t v : triangle) {
            const Way& way = wayOf(v);
            speed = std::max({speed, way.from.velocity.length(), way.to.velocity.length()});
            farthest = std::max(farthest, (way.to.position - way.from.position).length());
        }
    if (speed == 0) return share * kShortOf;
    const double step = kStepOfTime * radius / speed, low = share - kFarthestOff, high = share + kFarthestOff;
    if (crossAt(low, step) || !crossAt(high, step)) return share * kShortOf;
    const double rate = (lastFree(low, high, step) - share) / step, largest = kFastest * speed / farthest;
    return Dual(share, std::clamp(rate, -largest, largest)) * kShortOf;
}

// Some triangles, and those within two edges of them: as much of a surface as it takes to judge how they meet.
class Surroundings {
public:
    Surroundings(const BetaMesh& mesh, const std::vector<TrianglePair>& pairs) {
        constexpr int kRings = 2;
        std::vector<std::uint8_t> is_near(mesh.vertex.size(), 0);
        const auto mark = [&](const Triangle& t) {
            for (const std::uint32_t v : t) is_near[v] = 1;
        };
        for (const TrianglePair& pair : pairs)
            for (const std::uint32_t t : pair) mark(mesh.triangles[t]);
        for (int ring = 0; ring < kRings; ++ring) {
            row_.clear();
            for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
                const auto& [a, b, c] = mesh.triangles[t];
                if (is_near[a] | is_near[b] | is_near[c]) row_.push_back(t);
            }
            for (const std::uint32_t t : row_) mark(mesh.triangles[t]);
        }
        std::vector<std::uint32_t> number(mesh.vertex.size(), kInvalidIndex);
        for (const std::uint32_t row : row_) {
            Triangle& t = triangles_.emplace_back(mesh.triangles[row]);
            for (std::uint32_t& v : t) {
                if (number[v] == kInvalidIndex) {
                    number[v] = static_cast<std::uint32_t>(position_.size());
                    position_.push_back(mesh.vertex[v].position);
                }
                v = number[v];
            }
        }
        place_ = placesOfVertices(position_);
        across_ = trianglesAcross(sortedSides(triangles_));
    }

    bool cross(const TrianglePair& pair) const {
        const std::uint32_t s = numberOf(pair[0]), t = numberOf(pair[1]);
        return contactOf({position_, triangles_, place_, across_}, s, t).kind == ContactKind::crossing;
    }

private:
    std::uint32_t numberOf(std::uint32_t triangle) const {
        return static_cast<std::uint32_t>(std::lower_bound(row_.begin(), row_.end(), triangle) - row_.begin());
    }

    std::vector<std::uint32_t> row_;  // of the triangles in the mesh, ascending
    std::vector<Triangle> triangles_;
    std::vector<Vec3> position_;
    std::vector<std::uint32_t> place_, across_;
};

// Where triangles touch, those beyond the touching edges tell whether the surface passes through itself.
std::vector<TrianglePair> crossingsAmong(Meetings meetings, const BetaMesh& mesh) {
    std::vector<TrianglePair>& pairs = meetings.crossing;
    if (meetings.doubtful.empty()) return std::move(pairs);
    const Surroundings surroundings(mesh, meetings.doubtful);
    for (const TrianglePair& pair : meetings.doubtful)
        if (surroundings.cross(pair)) pairs.push_back(pair);
    std::sort(pairs.begin(), pairs.end());
    return std::move(pairs);
}

// How vertices near crossings go: past the mean way of all that is near them, which parts nobody, a share of what
// remains.
class Ways {
public:
    Ways(const DualPoints& from, double radius, BetaMesh& mesh)
        : from_(from), radius_(radius), mesh_(mesh), row_(from.size(), kInvalidIndex), rising_of_(from.size(), nullptr) {
        for (const auto& group : mesh.fading)
            for (const FadingVertex& fading : group) rising_of_[fading.vertex] = &fading;
    }

    // Takes vertices of crossing triangles back, and those that they rise from, to where they do not cross; where the
    // mean way is no way out, towards where they come from. Then others near them along the edges of triangles that
    // are awake. Returns whether any went back.
    bool shorten(const std::vector<TrianglePair>& pairs, bool all_the_way, const PatchTree& tree) {
        takeIn(tree);
        for (const TrianglePair& pair : pairs)
            for (const std::uint32_t t : pair)
                for (const std::uint32_t v : mesh_.triangles[t]) forSupports(v, [&](std::uint32_t u) { use(u); });
        takeMeanWays();

        std::vector<std::optional<Dual>> limits(pairs.size());
        if (!all_the_way)
            parallelFor(pairs.size(), 16, [&](std::size_t i) {
                std::array<Way, 6> ways;
                std::array<Triangle, 2> corners;
                for (std::uint32_t k = 0; k < 6; ++k) {
                    const std::uint32_t v = mesh_.triangles[pairs[i][k / 3]][k % 3];
                    ways[k] = {state_[row_[v]].base, mesh_.vertex[v]};
                    corners[k / 3][k % 3] = v;
                }
                limits[i] = freeShare(
                    corners[0], corners[1],
                    [&](std::uint32_t v) -> const Way& {
                        std::size_t k = 0;
                        while (corners[k / 3][k % 3] != v) ++k;
                        return ways[k];
                    },
                    radius_);
            });
        std::vector<Dual> before(state_.size());
        for (std::size_t i = 0; i < state_.size(); ++i) before[i] = state_[i].share;
        bool any = false;
        for (std::size_t i = 0; i < pairs.size(); ++i)
            for (const std::uint32_t t : pairs[i])
                for (const std::uint32_t v : mesh_.triangles[t])
                    forSupports(v, [&](std::uint32_t u) {
                        State& state = state_[row_[u]];
                        const bool based_here = state.base.position == from_.position[u];
                        if (limits[i] || all_the_way || based_here)
                            any |= lower(state, limits[i] ? before[row_[u]] * *limits[i] : Dual(0));
                        if (limits[i] || based_here) return;
                        state.base = from_[u];
                        any = true;
                    });
        spread(tree);
        for (State& state : state_)
            if (state.share.value < 1) use(state.vertex);
        takeMeanWays();
        return any;
    }
    DualVec3 placeOf(std::uint32_t v) const {
        if (row_[v] == kInvalidIndex) return mesh_.vertex[v];
        const State& state = state_[row_[v]];
        Dual share = state.share;
        if (rising_of_[v]) {
            const FadingVertex& fading = *rising_of_[v];
            Dual below = 0;
            for (std::size_t k = 0; k < 4; ++k) below = below + shareOf(fading.from[k]) * fading.weight[k];
            share = share * fading.share + below * (1 - fading.share);
        }
        if (share.value >= 1) return state.to;
        const DualVec3 place = state.base + (state.to - state.base) * share;
        return {asWritten(place.position), place.velocity};
    }

private:

    struct State {
        std::uint32_t vertex;
        bool used = false;  // the base is, or will be, where the mean way leads
        DualVec3 base, to;
        Dual share = 1;  // of the way from base to there
    };
    struct Piece {  // of the surface
        DualVec3 middle, way;
        double area = 0;
    };

    Dual shareOf(std::uint32_t v) const { return row_[v] == kInvalidIndex ? Dual(1) : state_[row_[v]].share; }
    bool lower(State& state, Dual share) {
        if (!(share.value < state.share.value)) return false;
        state.share = share;
        return true;
    }
    // Calls visit(u) for a vertex and those that it rises from.
    template <typename Visit>
    void forSupports(std::uint32_t v, const Visit& visit) {
        visit(v);
        if (!rising_of_[v]) return;
        for (const std::uint32_t u : rising_of_[v]->from) visit(u);
    }
    State& stateOf(std::uint32_t v) {
        if (row_[v] == kInvalidIndex) {
            row_[v] = static_cast<std::uint32_t>(state_.size());
            state_.push_back({v, false, from_[v], mesh_.vertex[v]});
        }
        return state_[row_[v]];
    }
    void use(std::uint32_t v) {
        State& state = stateOf(v);
        if (state.used) return;
        state.used = true;
        fresh_.push_back(v);
    }
    // Triangles in one small cell are one piece: there may be thousands where spheres pass by a point.
    void takeIn(const PatchTree& tree) {
        std::vector<Piece> triangle;
        double farthest = 0;  // from the origin, along an axis
        tree.forTrianglesAwake([&](const Triangle& t) {
            DualVec3 middle, end;
            for (const std::uint32_t v : t) {
                middle = middle + from_[v] * (1.0 / 3);
                end = end + stateOf(v).to * (1.0 / 3);
            }
            const std::vector<Vec3>& from = from_.position;
            const double area = betamesh::cross(from[t[1]] - from[t[0]], from[t[2]] - from[t[0]]).length();
            triangle.push_back({middle, end - middle, area});
            for (int k = 0; k < 3; ++k) farthest = std::max(farthest, std::abs(middle.position[k]));
        });
        const double least_width = farthest * 0x1p-30;  // of cells, which have numbers of 32 bits
        const CellOrder cells(triangle.size(), std::max(kPieceWidth * radius_, least_width),
                              [&](std::size_t i) { return triangle[i].middle.position; });
        piece_.clear();
        for (std::uint32_t cell = 0; cell < cells.cells(); ++cell) {
            Piece sum;
            for (const std::uint32_t row : cells.rowsOf(cell)) {
                const Piece& part = triangle[row];
                sum.middle = sum.middle + part.middle * part.area;
                sum.way = sum.way + part.way * part.area;
                sum.area += part.area;
            }
            if (sum.area > 0) piece_.push_back({sum.middle / sum.area, sum.way / sum.area, sum.area});
        }
        near_.emplace(piece_.size(), std::max(kMeanWidth * radius_, least_width),
                      [&](std::size_t i) { return piece_[i].middle.position; });
    }
    void takeMeanWays() {
        const double width = kMeanWidth * radius_, inverse_square = 1 / (width * width);
        parallelFor(fresh_.size(), 64, [&](std::size_t i) {
            const DualVec3 at = from_[fresh_[i]];
            DualVec3 sum;
            Dual weight = 0;
            near_->forRowsIn(at.position - Vec3(width), at.position + Vec3(width), [&](std::uint32_t row) {
                const DualVec3 apart = piece_[row].middle - at;
                const Dual t = 1 - dot(apart, apart) * inverse_square;
                if (t.value <= 0) return;
                const Dual w = t * t * piece_[row].area;
                sum = sum + piece_[row].way * w;
                weight = weight + w;
            });
            if (weight.value > 0) state_[row_[fresh_[i]]].base = at + sum / weight;
        });
        fresh_.clear();
    }
    void spread(const PatchTree& tree) {
        for (bool more = true; more;) {
            more = false;
            tree.forTrianglesAwake([&](const Triangle& t) {
                for (std::size_t m = 0; m < 3; ++m) {
                    const std::uint32_t u = t[m], v = t[(m + 1) % 3];
                    State &at_u = state_[row_[u]], &at_v = state_[row_[v]];
                    if (at_u.share.value >= 1 && at_v.share.value >= 1) continue;
                    const Dual apart = length(from_[u] - from_[v]) / Dual(radius_);
                    more |= lower(at_u, at_v.share + apart);
                    more |= lower(at_v, at_u.share + apart);
                }
            });
        }
    }

    const DualPoints& from_;
    double radius_;
    const BetaMesh& mesh_;
    std::vector<std::uint32_t> row_;              // of each vertex: of state_
    std::vector<const FadingVertex*> rising_of_;  // or none
    std::vector<State> state_;
    std::vector<std::uint32_t> fresh_;
    std::vector<Piece> piece_;  // of what is awake
    std::optional<CellOrder> near_;
};

// Drops: what hangs together of the surface, is small, and does not cross itself.
std::vector<PatchTree::BodyPart> bodiesOf(const BallBoundary& boundary, const std::vector<Vec3>& before,
                                          const BetaMesh& mesh) {
    if (mesh.ball_begin.empty()) return {};
    const auto balls = static_cast<std::uint32_t>(boundary.position.size());
    UnionFind together(balls);
    for (const auto& [a, b, c] : boundary.triangle) {
        together.join(a, b);
        together.join(a, c);
    }
    for (const auto& [a, b] : boundary.circle) together.join(a, b);
    std::vector<std::uint32_t> first(balls);  // of what each hangs together with
    for (std::uint32_t b = 0; b < balls; ++b) first[b] = together.find(b);
    const IndexRows others = sortedIntoRows<std::uint32_t>(
        balls, balls, [&](std::size_t b, const auto& visit) { visit(first[b], static_cast<std::uint32_t>(b)); });

    std::vector<std::uint8_t> is_body(balls, 0);
    const auto facing = std::make_unique_for_overwrite<std::uint64_t[]>(mesh.vertex.size());
    parallelRanges(balls, 256, [&](std::size_t begin, std::size_t end) {
        std::vector<std::array<Vec3, 3>> triangles;
        std::vector<TriangleRange> ranges;
        ComponentCrossings check(mesh, before, {facing.get(), mesh.vertex.size()});
        for (std::size_t b = begin; b < end; ++b) {
            const std::span<const std::uint32_t> drop = others[b];
            if (drop.empty() || drop.size() > kMostBalls) continue;
            Vec3 middle(0);
            triangles.clear();
            ranges.clear();
            for (const std::uint32_t ball : drop) {
                middle += boundary.centre(ball) / static_cast<double>(drop.size());
                ranges.push_back({mesh.ball_begin[ball], mesh.ball_begin[ball + 1]});
                for (std::uint32_t t = mesh.ball_begin[ball]; t < mesh.ball_begin[ball + 1]; ++t) {
                    const auto at = [&](std::size_t k) { return mesh.vertex[mesh.triangles[t][k]].position; };
                    triangles.push_back({at(0), at(1), at(2)});
                }
            }
            is_body[b] =
                isStarShaped(middle, triangles) || (triangles.size() <= kMostCompared && check.crossesNothing(ranges));
        }
    });
    std::vector<PatchTree::BodyPart> bodies;
    for (std::uint32_t b = 0; b < balls; ++b)
        if (is_body[first[b]] && mesh.ball_begin[b] < mesh.ball_begin[b + 1])
            bodies.push_back({mesh.ball_begin[b], mesh.ball_begin[b + 1], first[b] + 1});
    return bodies;
}

// Takes corners of triangles that cross, where they rise from other vertices, to the one of these that counts most. On
// balls that touch, several sheets lie in one line, and floats do not hold its middle.
void collapse(const std::vector<TrianglePair>& pairs, BetaMesh& mesh) {
    std::vector<std::uint8_t> is_corner(mesh.vertex.size(), 0);
    for (const TrianglePair& pair : pairs)
        for (const std::uint32_t t : pair)
            for (const std::uint32_t v : mesh.triangles[t]) is_corner[v] = 1;
    for (const auto& group : mesh.fading)
        for (const FadingVertex& fading : group) {
            if (!is_corner[fading.vertex]) continue;
            std::size_t most = 0;
            for (std::size_t k = 1; k < 4; ++k)
                if (fading.weight[k].value > fading.weight[most].value) most = k;
            mesh.vertex[fading.vertex].position = mesh.vertex[fading.from[most]].position;
        }
}

// Draws corners of triangles that cross half-way to the means of the vertices round them.
void loosen(const std::vector<TrianglePair>& pairs, const PatchTree& tree, BetaMesh& mesh) {
    std::vector<std::uint32_t> corners;
    for (const TrianglePair& pair : pairs)
        for (const std::uint32_t t : pair)
            corners.insert(corners.end(), mesh.triangles[t].begin(), mesh.triangles[t].end());
    std::sort(corners.begin(), corners.end());
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    std::vector<std::pair<DualVec3, int>> round(corners.size());  // sum and number of the vertices, each twice
    tree.forTrianglesAwake([&](const Triangle& t) {
        for (std::size_t k = 0; k < 3; ++k) {
            const auto at = std::lower_bound(corners.begin(), corners.end(), t[k]);
            if (at == corners.end() || *at != t[k]) continue;
            auto& [sum, count] = round[static_cast<std::size_t>(at - corners.begin())];
            sum = sum + mesh.vertex[t[(k + 1) % 3]] + mesh.vertex[t[(k + 2) % 3]];
            count += 2;
        }
    });
    for (std::size_t i = 0; i < corners.size(); ++i) {
        DualVec3& vertex = mesh.vertex[corners[i]];
        if (const auto& [sum, count] = round[i]; count > 0) vertex = (vertex + sum / Dual(count)) * 0.5;
        vertex.position = asWritten(vertex.position);
    }
}

// Moves triangles that cross away from each other's planes, each to the side on which most of it lies.
void separate(const std::vector<TrianglePair>& pairs, double distance, BetaMesh& mesh) {
    std::vector<std::pair<std::uint32_t, Vec3>> ways;
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
                ways.emplace_back(v, normal * std::copysign(1.0, farthest));
        }
    std::stable_sort(ways.begin(), ways.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (std::size_t i = 0; i < ways.size();) {
        const std::uint32_t v = ways[i].first;
        Vec3 way(0);
        for (; i < ways.size() && ways[i].first == v; ++i) way += ways[i].second;
        Vec3& position = mesh.vertex[v].position;
        position = asWritten(position + way.normalized() * distance);
    }
}

}  // namespace

bool resolveSelfIntersections(const BallBoundary& boundary, const DualPoints& from, BetaMesh& mesh, int loosenings, bool last) {
    if (mesh.triangles.empty()) return true;
    moveToWritten(mesh);
    const double radius = boundary.worldRadius();
    PatchTree tree(mesh, from.position, radius, bodiesOf(boundary, from.position, mesh));
    std::vector<TrianglePair> pairs = crossingsAmong(tree.meetings(), mesh);
    if (pairs.empty()) return true;
    const auto wakeNear = [&](double distance) {
        std::vector<std::uint32_t> triangles;
        for (const TrianglePair& pair : pairs) triangles.insert(triangles.end(), pair.begin(), pair.end());
        std::sort(triangles.begin(), triangles.end());
        triangles.erase(std::unique(triangles.begin(), triangles.end()), triangles.end());
        for (const std::uint32_t t : triangles) {
            Box box;
            for (const std::uint32_t v : mesh.triangles[t]) {
                box.extendBy(from.position[v]);
                box.extendBy(mesh.vertex[v].position);
            }
            tree.wake(box, distance);
        }
    };
    for (; loosenings > 0 && !pairs.empty(); --loosenings) {
        tree.sleep();
        wakeNear(radius / 2);
        loosen(pairs, tree, mesh);
        tree.refit();
        pairs = crossingsAmong(tree.meetings(), mesh);
    }
    Ways ways(from, radius, mesh);
    for (int round = 0; !pairs.empty();) {
        tree.sleep();
        wakeNear(radius);
        const bool all_the_way = round >= kRounds, any = ways.shorten(pairs, all_the_way, tree);
        if (!any && all_the_way) break;
        round = any ? round + 1 : kRounds;
        tree.sleepUnless([&](std::uint32_t v) { return mesh.vertex[v].position != ways.placeOf(v).position; });
        wakeNear(0);
        tree.forTrianglesAwake([&](const Triangle& t) {
            for (const std::uint32_t v : t) mesh.vertex[v] = ways.placeOf(v);
        });
        tree.refit();
        pairs = crossingsAmong(tree.meetings(), mesh);
    }
    if (pairs.empty() || !last) return pairs.empty();
    double farthest = 0;
    for (const Vec3& p : from.position)
        for (int k = 0; k < 3; ++k) farthest = std::max(farthest, std::abs(p[k]));
    double distance = farthest * std::numeric_limits<float>::epsilon();
    for (int i = 0; i < kSeparations && !pairs.empty(); ++i, distance *= kSeparationGrowth) {
        tree.sleep();
        wakeNear(radius / 2);
        if (i < kCollapses)
            collapse(pairs, mesh);
        else if (i % 2 == 0)
            separate(pairs, std::min(distance, kLargestSeparation * radius), mesh);
        else
            loosen(pairs, tree, mesh);
        tree.refit();
        pairs = crossingsAmong(tree.meetings(), mesh);
    }
    return pairs.empty();
}

}  // namespace betamesh
