
#include "skin/tessellate.h"

#include "base/index.h"
#include "base/parallel.h"
#include "skin/edge_flips.h"
#include "skin/hull.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <utility>

namespace betamesh {

namespace {

constexpr std::size_t kBallsPerTask = 128;
constexpr double kGrid = 0x1p38;         // of the hull's points, per radius
constexpr double kLeastClearance = 0.2;  // of points on the boundary, in angles between neighbouring points
constexpr double kSinkingBegins = 0.75;  // rim_distance below which points sink, in the same
constexpr double kSunkInEarnest = 0.3;   // share of the depth's root from which on a point is held back in full
constexpr double kFreeHeight = 0.05;     // over what is beneath, radii per square of the same: free from here on
constexpr double kMargin = 1e-6;         // of that height, far above the rounding of places
constexpr double kSwellingBegins = 0.7, kSwollen = 1.4;  // rim_distance of points far from any rim
constexpr std::size_t kLongestRing = 10;
constexpr double kSinkingDepth = 0.12;  // radii at the rim, in squares of the same
constexpr double kBelowChords = 1.5;    // the same in depths of the longest chords below their arcs, for what moves far
constexpr double kTurning = 0.0025, kTurningFar = 0.01;  // how far diagonals are apart when they begin to turn, likewise
constexpr double kContactDepth = 0.25;  // where balls are too far apart, likewise: deeper than any facet

Vec3i onGrid(const Vec3& direction) {
    return {std::llround(direction.x * kGrid), std::llround(direction.y * kGrid), std::llround(direction.z * kGrid)};
}

// The faces of each ball are neighbours in the list: where those of each begin.
std::vector<std::uint32_t> firstFaces(const BallBoundary& boundary) {
    std::vector<std::uint32_t> count(boundary.position.size(), 0);
    for (const std::uint32_t ball : boundary.face_ball) ++count[ball];
    return exclusiveScan(count);
}

// One ball's loops, with the network's numbers of their points.
struct BallLoops {
    LoopsOnSphere loops;
    std::vector<std::uint32_t> network_point;
    std::vector<std::uint32_t> face_begin;  // the first loop of each face, and how many there are

    void clear() {
        loops.clear();
        network_point.clear();
        face_begin.assign(1, 0);
    }
};

class LoopMaker {
public:
    LoopMaker(const BallBoundary& boundary, const ArcNetwork& network) : boundary_(boundary), network_(network) {}

    void makeLoops(std::uint32_t ball, std::uint32_t first_face, std::uint32_t last_face, BallLoops& out) const {
        out.clear();
        for (std::uint32_t f = first_face; f < last_face; ++f) {
            for (const std::uint32_t c : boundary_.face[f]) {
                if (c < boundary_.cycle.size())
                    addCycle(ball, boundary_.cycle[c], out);
                else
                    addCircle(ball, c - static_cast<std::uint32_t>(boundary_.cycle.size()), out);
                out.loops.loop_begin.push_back(static_cast<std::uint32_t>(out.loops.point.size()));
            }
            out.face_begin.push_back(static_cast<std::uint32_t>(out.loops.is_hole.size()));
        }
    }

private:
    void add(std::uint32_t ball, std::uint32_t point, std::uint32_t circle_before, std::uint32_t circle_after,
             BallLoops& out) const {
        const Vec3 offset = network_.point[point].position - boundary_.centre(ball);
        out.loops.point.push_back(onGrid(offset / boundary_.worldRadius()));
        out.loops.circles.push_back({circle_before, circle_after});
        out.network_point.push_back(point);
    }
    bool barelyMeets(std::uint32_t ball, std::uint32_t other) const {
        const Vec3 offset = toDouble(boundary_.position[other] - boundary_.position[ball]);
        const double diameter = 2 * static_cast<double>(boundary_.radius);
        return dot(offset, offset) > diameter * diameter * (1 - 1e-12);
    }
    void addCycle(std::uint32_t ball, std::span<const std::uint32_t> cycle, BallLoops& out) const {
        bool hole = true;
        for (const std::uint32_t h : cycle) {
            // arrives along the circle with the triangle's second particle, leaves along that with its third
            const std::uint32_t leaving = previousInTriangle(h), ahead = nextInTriangle(h);
            const std::uint32_t before = boundary_.triangle[h / 3][ahead % 3],
                                after = boundary_.triangle[h / 3][leaving % 3];
            add(ball, h / 3, before, after, out);
            hole = hole && barelyMeets(ball, after);
            const std::uint32_t arc = network_.arc_of[leaving], first = network_.arc_begin[arc];
            const std::uint32_t n = network_.arcSize(arc);
            const bool forward = network_.arc_start[arc] == leaving;
            for (std::uint32_t m = 0; m < n; ++m) add(ball, first + (forward ? m : n - 1 - m), after, after, out);
        }
        out.loops.is_hole.push_back(hole);
    }
    void addCircle(std::uint32_t ball, std::uint32_t circle_side, BallLoops& out) const {
        const std::uint32_t k = circle_side / 2, side = circle_side % 2, n = network_.circleSize(k);
        const std::uint32_t other = boundary_.circle[k][1 - side];
        for (std::uint32_t m = 0; m < n; ++m)
            add(ball, network_.circle_begin[k] + (side == 1 ? m : n - 1 - m), other, other, out);
        out.loops.is_hole.push_back(1);
    }

    const BallBoundary& boundary_;
    const ArcNetwork& network_;
};

// Another ball that touches this one lightly, or is about to, as seen from it. There is room beside it where the cosine
// of the angle to `towards` is far below `rim`.
struct NearTangentNeighbour {
    DualVec3 towards;  // unit vector
    Dual rim;        // the cosine of the cap's half-angle; above one where they do not touch yet
};

// Of each ball, those that no wider cap hides: the rim of that one is nearer.
CompressedRows<NearTangentNeighbour> lightTouches(const std::vector<DualVec3>& balls, const ArcNetwork& network, const FacePoints& points,
                                double radius) {
    return sortedIntoRows<NearTangentNeighbour>(balls.size(), balls.size(), [&](std::size_t b, const auto& visit) {
        for (const std::uint32_t l : network.at_ball[b]) {
            const ArcLine& line = network.line[l];
            if (line.radius.value >= kWideCap * radius) continue;
            const DualVec3 way = balls[line.balls[line.balls[0] == b ? 1 : 0]] - balls[b];
            const Dual distance = length(way);
            visit(b, NearTangentNeighbour{way / distance, distance / (2 * radius)});
        }
        for (std::uint32_t p = points.begin[b]; p < points.begin[b + 1]; ++p)
            if (const FacePoints::Contact* contact = points.contactOf(p))
                visit(b, NearTangentNeighbour{contact->direction, 1 + (1 - contact->touching) * (kSwollen * kWideCap)});
    });
}

// Where the points inside faces are, seen from their ball.
class Placement {
public:
    Placement(const FacePoints& points, const ArcSubdivision& subdivision)
        : points_(points), sinking_(subdivision.appearance == Appearance::gradual) {
        // Each of n points has a cell of area 4π / n: two triangles of side `angle`.
        const double n = static_cast<double>(points.directions.position.size());
        angle_ = std::sqrt(8 * std::numbers::pi / (std::sqrt(3.0) * n));
        double volume = 0;
        for (const auto& [a, b, c] : points.directions.triangles) {
            const std::vector<Vec3>& p = points.directions.position;
            volume += dot(p[a], cross(p[b], p[c])) / 6;
        }
        const double longest = std::max(subdivision.max_angle, subdivision.flat_angle);
        depth_ = subdivision.moves_far ? kBelowChords * longest * longest / 8 : kSinkingDepth * angle_ * angle_;
        turning_ = (subdivision.moves_far ? kTurningFar : kTurning) * angle_ * angle_;
        offset_ = std::cbrt(4 * std::numbers::pi / 3 / volume) - 1;
    }
    bool sinks(std::uint32_t p) const {
        return sinking_ && (points_.rim_distance[p].value < kSinkingBegins * angle_ || points_.contactOf(p));
    }
    bool used(std::uint32_t p) const {
        return sinking_ || (points_.rim_distance[p].value >= kLeastClearance * angle_ && !points_.contactOf(p));
    }
    double turningDistance() const { return turning_; }
    // In radii of the ball.
    DualVec3 at(std::uint32_t p) const {
        const DualVec3 direction = points_.outwards(p);
        if (!sinks(p)) return direction;
        const Dual below = nearRim(p), apart = one_minus_contact(p);
        return direction * (1 - (below * below * depth_ + apart * apart * (kContactDepth * angle_ * angle_)));
    }

    // Is a point far from any rim?
    bool swells(std::uint32_t p) const {
        return sinking_ && points_.rim_distance[p].value > kSwellingBegins && !points_.contactOf(p);
    }
    // How far outwards it goes then, in radii: a lone drop has the volume of its ball. Two that touch do not swell into
    // each other: narrow caps are as near here as wide ones.
    DualVec3 volumeOffset(std::uint32_t p, std::span<const NearTangentNeighbour> touches) const {
        const DualVec3 outwards = points_.outwards(p);
        Dual room = points_.rim_distance[p];
        for (const auto& [towards, rim] : touches) {
            const Dual here = (rim - dot(outwards, towards)) / kWideCap;
            if (here.value < room.value) room = here;
        }
        return outwards * (smoothStep((room - kSwellingBegins) / (kSwollen - kSwellingBegins)) * offset_);
    }

    // Points in which two balls touch are where the rim of their common circle will be.
    Dual rim_distance(std::uint32_t p) const {
        return points_.contactOf(p) ? points_.rim_distance[p] * one_minus_contact(p) : points_.rim_distance[p];
    }

    // In radii, over what is beneath.
    double freeHeight() const { return kFreeHeight * angle_ * angle_; }
    // How free a sinking point is at this height over what is beneath it, in radii: 0 on it, 1 as it stops to sink.
    Dual shareOf(std::uint32_t p, Dual height) const {
        const Dual near = nearRim(p), apart = one_minus_contact(p), sunk = near.value < apart.value ? apart : near;
        const Dual held = sunk.value < kSunkInEarnest ? sunk / kSunkInEarnest : Dual(1);
        return 1 - held * (1 - smoothStep(height / freeHeight()));
    }

private:
    // From 0, where a point does not sink, to 1 at the rim of its face; where balls touch there is no rim.
    Dual nearRim(std::uint32_t p) const {
        const Dual below = 1 - points_.rim_distance[p] / (kSinkingBegins * angle_);
        if (below.value <= 0) return 0;
        return points_.contactOf(p) ? below * one_minus_contact(p) : below;
    }
    // From 0, where balls touch, to 1 where they are too far apart.
    Dual one_minus_contact(std::uint32_t p) const {
        const FacePoints::Contact* contact = points_.contactOf(p);
        return contact ? 1 - contact->touching : Dual(0);
    }

    const FacePoints& points_;
    bool sinking_;
    double angle_, depth_, turning_, offset_;
};

// The triangles of all directions, each listed at its first corner.
class DirectionTriangles {
public:
    explicit DirectionTriangles(const Icosphere& sphere) : at_(sphere.position.size()) {
        for (const Triangle& t : sphere.triangles) at_[*std::min_element(t.begin(), t.end())].push_back(t);
    }
    // Calls visit(triangle) for every triangle whose corners are all among these; corners are places in the list.
    template <typename Visit>
    void among(const std::vector<std::uint32_t>& directions, std::vector<std::uint32_t>& place,
               const Visit& visit) const {
        place.resize(at_.size(), kInvalidIndex);
        for (std::uint32_t i = 0; i < directions.size(); ++i) place[directions[i]] = i;
        for (const std::uint32_t d : directions)
            for (const auto& [a, b, c] : at_[d])
                if (place[a] != kInvalidIndex && place[b] != kInvalidIndex && place[c] != kInvalidIndex)
                    visit(Triangle{place[a], place[b], place[c]});
        for (const std::uint32_t d : directions) place[d] = kInvalidIndex;
    }

private:
    std::vector<std::vector<Triangle>> at_;
};

constexpr std::uint32_t kNew = std::uint32_t{1} << 31;

// What one task makes: triangles by network point, or by place among the new points from kNew on.
struct Part {
    struct Ball {
        std::uint32_t triangles, points;  // before it
    };
    struct OtherPoint {  // than those inside faces
        DualVec3 vertex;
        Dual rim_distance;
    };
    std::vector<Ball> ball;
    std::vector<Triangle> triangles;
    std::vector<std::uint32_t> point;  // of FacePoints, or from kNew on among the others
    std::vector<OtherPoint> other;
    std::vector<FadingVertex> fading, turning;
    std::uint32_t volume_offsets = 0;  // so many points inside faces

    void add(const OtherPoint& o) {
        point.push_back(kNew + static_cast<std::uint32_t>(other.size()));
        other.push_back(o);
    }
};

// Is p surely so high, as a share of its distance from the origin, over all facets of the points in `ring` beneath it?
// Looks for a plane that parts them by as much: turns it out of the way of whichever point is highest.
bool isFarAbove(const Vec3& p, double height, std::span<const std::uint32_t> ring, const std::vector<Vec3>& point) {
    constexpr int kTurns = 6;
    const double square = p.length2(), level = 1 - height * (1 + kMargin);
    Vec3 normal = p / square;  // p itself stays at level 1
    for (int turn = 0;; ++turn) {
        Vec3 highest(0);
        double most = level;
        for (const std::uint32_t r : ring) {
            const double here = dot(point[r], normal);
            if (here > most) most = here, highest = point[r];
        }
        if (most == level) return true;
        const Vec3 aside = highest - p * (dot(highest, p) / square);
        const double way = aside.length2();
        if (turn == kTurns || !(way > 0)) return false;
        normal -= aside * ((most - level) / way);
    }
}

// The facet of the points in `ring` that a ray from the origin through p leaves last, where p is above it.
std::optional<Triangle> facetBeneath(const Vec3& p, std::span<const std::uint32_t> ring,
                                     const std::vector<Vec3>& point) {
    std::array<Vec3, kLongestRing> at;
    std::array<std::array<double, kLongestRing>, kLongestRing> across;  // p · (i × j)
    std::array<std::uint32_t, kLongestRing> on_left{}, on_right{};      // of i: the j where that is >= 0, <= 0
    for (std::size_t i = 0; i < ring.size(); ++i) {
        at[i] = point[ring[i]];
        for (std::size_t j = 0; j < i; ++j) {
            const double sine = dot(p, cross(at[j], at[i]));
            across[j][i] = sine;
            across[i][j] = -sine;
            on_left[j] |= std::uint32_t{sine >= 0} << i;
            on_left[i] |= std::uint32_t{sine <= 0} << j;
            on_right[j] |= std::uint32_t{sine <= 0} << i;
            on_right[i] |= std::uint32_t{sine >= 0} << j;
        }
    }
    std::optional<Triangle> highest;
    double least = 1;  // height of p over it, as a share of its distance from the origin
    for (std::size_t i = 0; i < ring.size(); ++i)
        for (std::size_t j = i + 1; j < ring.size(); ++j) {
            std::uint32_t third = 0;  // those k with which i and j surround p, one way or the other
            if (across[i][j] >= 0) third |= on_left[j] & on_right[i];
            if (across[i][j] <= 0) third |= on_right[j] & on_left[i];
            for (third = third >> j >> 1 << j << 1; third != 0; third &= third - 1) {
                const auto k = static_cast<std::size_t>(std::countr_zero(third));
                const double u = across[j][k], v = across[k][i], w = across[i][j], sum = u + v + w;
                if (sum == 0) continue;
                const double whole = dot(at[i], cross(at[j], at[k]));
                if (!(whole * sum > 0)) continue;
                const double height = 1 - whole / sum;
                if (highest && least <= height) continue;
                highest = Triangle{ring[i], ring[j], ring[k]};
                least = height;
            }
        }
    return highest;
}

// The third corner of the facet beyond the edge a, b of a facet a, b, c of the points in `ring`; c where there is none.
std::uint32_t facetBeyond(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::span<const std::uint32_t> ring,
                          const std::vector<Vec3>& point) {
    const Vec3 edge = dot(point[a], cross(point[b], point[c])) > 0 ? point[a] - point[b] : point[b] - point[a];
    std::uint32_t beyond = c;
    Vec3 normal(0);
    for (const std::uint32_t d : ring) {
        if (d == a || d == b || d == c || (beyond != c && dot(point[d] - point[a], normal) <= 0)) continue;
        beyond = d;
        normal = cross(edge, point[d] - point[a]);
    }
    return beyond;
}

// Where the ray from the origin through p leaves a facet: the weights of its corners, and how high p is over it, as a
// share of its distance from the origin.
struct Beneath {
    std::array<Dual, 3> weight;
    Dual height;

    Beneath(const DualVec3& p, const std::array<DualVec3, 3>& corner) {
        Dual sum;
        for (std::size_t k = 0; k < 3; ++k) {
            weight[k] = dot(p, cross(corner[(k + 1) % 3], corner[(k + 2) % 3]));
            sum = sum + weight[k];
        }
        for (Dual& w : weight) w = w / sum;
        height = 1 - dot(corner[0], cross(corner[1], corner[2])) / sum;
    }
};

// What the mesh of one ball is made from. Points of a filling: those of the loops, then face points, then new ones.
struct Ball {
    const BallLoops& loops;
    const ArcNetwork& network;
    const std::vector<std::uint32_t>& face_point;  // those that sink come last
    std::size_t first_sinking;                     // of them
    const std::vector<Vec3>& on_grid;              // all of them, rounded, in the hull's units
    const Placement& placement;
    DualVec3 centre;
    double radius;

    std::size_t inLoops() const { return loops.network_point.size(); }
    std::size_t given() const { return loops.loops.point.size(); }
    // Seen from the centre, in radii.
    DualVec3 vertexAt(std::uint32_t face_point_row) const { return centre + placement.at(face_point_row) * radius; }
    // In radii, seen from the centre.
    DualVec3 at(std::uint32_t v) const {
        return v < inLoops() ? (network.point[loops.network_point[v]] - centre) / radius
                             : placement.at(face_point[v - inLoops()]);
    }
};

// Adds the filling of a ball's loops to a part.
class FillingAdder {
public:
    // Room for what one ball needs after another.
    struct Room {
        std::vector<std::uint32_t> number, first, ring;
        std::vector<EdgeFlip> edges;
    };

    FillingAdder(const Ball& ball, const LoopFilling& filling, Part& part, Room& room)
        : ball_(ball),
          filling_(filling),
          part_(part),
          first_triangle_(part.triangles.size()),
          number_(room.number),
          first_(room.first),
          ring_(room.ring),
          edges_(room.edges) {
        number_ = ball.loops.network_point;
        number_.resize(ball.given() + filling.new_point.size(), kInvalidIndex);
        for (const auto& [a, b, c] : filling.triangles) part.triangles.push_back({number(a), number(b), number(c)});
    }

    // FadingOut points are held to what is beneath them.
    void holdSinking() {
        const std::size_t count = ball_.face_point.size();
        if (ball_.given() == ball_.inLoops() || ball_.first_sinking == count) return;
        first_.resize(ball_.given() + filling_.new_point.size());
        for (auto f = static_cast<std::uint32_t>(filling_.triangles.size()); f-- > 0;)  // slivers come last
            for (const std::uint32_t v : filling_.triangles[f]) first_[v] = f;
        for (std::size_t i = ball_.first_sinking; i < count; ++i) {
            const auto v = static_cast<std::uint32_t>(ball_.inLoops() + i);
            if (number_[v] == kInvalidIndex) continue;
            listRing(v);
            if (ring_.size() > kLongestRing) continue;
            const Vec3& here = ball_.on_grid[v];
            if (isFarAbove(here, ball_.placement.freeHeight(), ring_, ball_.on_grid)) continue;
            const auto facet = facetBeneath(here, ring_, ball_.on_grid);
            if (!facet) continue;
            const auto& [a, b, c] = *facet;
            const Beneath beneath(ball_.at(v), {ball_.at(a), ball_.at(b), ball_.at(c)});
            const Dual share = ball_.placement.shareOf(ball_.face_point[i], beneath.height);
            if (share.value >= 1) continue;
            FadingVertex fading{number_[v],
                                {a, b, c, c},
                                {beneath.weight[0], beneath.weight[1], beneath.weight[2], 0},
                                share,
                                ball_.vertexAt(ball_.face_point[i])};
            splitTurningBeneath(ring_, fading);
            for (std::uint32_t& corner : fading.from) corner = number_[corner];
            part_.fading.push_back(fading);
        }
    }

    // Gives the edges of a hull that are about to turn a vertex each.
    void splitTurning() {
        const std::size_t fixed_from = ball_.inLoops(), fixed_to = fixed_from + ball_.first_sinking;
        const std::size_t given = ball_.given();
        const double farthest = ball_.placement.turningDistance();
        // Points that do not sink are in directions that stay, and edges among them never turn.
        const auto stays = [&](const Triangle& t) {
            return std::all_of(t.begin(), t.end(), [&](std::uint32_t v) { return v >= fixed_from && v < fixed_to; });
        };
        const std::vector<Vec3>& at = ball_.on_grid;
        edges_.clear();
        for (std::uint32_t f = 0; f < filling_.triangles.size(); ++f) {
            const Triangle& t = filling_.triangles[f];
            if (stays(t)) continue;
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
                const std::uint32_t beyond = filling_.across[f][k];
                if (beyond == kInvalidIndex) continue;
                const Triangle& u = filling_.triangles[beyond];
                if (beyond < f && !stays(u)) continue;  // seen from there
                const std::uint32_t d = u[0] != a && u[0] != b ? u[0] : u[1] != a && u[1] != b ? u[1] : u[2];
                if (std::max({a, b, c, d}) >= given || !passNear(at[a], at[b], at[c], at[d], farthest * kGrid))
                    continue;
                auto edge = edgeFlip({ball_.at(a), ball_.at(b), ball_.at(c), ball_.at(d)}, farthest);
                if (!edge) continue;
                edge->corner = {number_[a], number_[b], number_[c], number_[d]};
                edge->triangle = {f, beyond};
                edges_.push_back(*edge);
            }
        }
        const auto first_vertex = kNew + static_cast<std::uint32_t>(part_.point.size());
        splitFlippingEdges(edges_, first_triangle_, first_vertex, part_.triangles);
        for (const EdgeFlip& edge : edges_) {
            const DualVec3 vertex = ball_.centre + edge.on_edge * ball_.radius;
            const auto row = kNew + static_cast<std::uint32_t>(part_.point.size());
            part_.turning.push_back({row, edge.corner, edge.weight, 0, vertex});
            part_.add({vertex, kFullClearance});  // it goes where its corners go
        }
    }

private:

    // What is next to a point inside, as triangles follow one another round it; where slivers interrupt these, both
    // ways as far as there.
    void listRing(std::uint32_t v) {
        ring_.clear();
        const auto add = [&](std::uint32_t other) {
            if (other < ball_.given()) ring_.push_back(other);
        };
        const auto cornerAt = [&](const Triangle& t) { return t[0] == v ? 0U : t[1] == v ? 1U : 2U; };
        std::uint32_t f = first_[v], last = f;
        while (f != kInvalidIndex) {
            const Triangle& t = filling_.triangles[last = f];
            const std::size_t k = cornerAt(t);
            add(t[(k + 1) % 3]);
            f = filling_.across[f][(k + 2) % 3];
            if (f == first_[v]) return;
        }
        add(filling_.triangles[last][(cornerAt(filling_.triangles[last]) + 2) % 3]);
        for (f = first_[v];;) {
            f = filling_.across[f][cornerAt(filling_.triangles[f])];
            if (f == kInvalidIndex) return;
            add(filling_.triangles[f][(cornerAt(filling_.triangles[f]) + 1) % 3]);
        }
    }

    // Where an edge of the facet beneath a point is about to turn, the point is held to the vertex there, too: to the
    // facet's three corners and the one beyond the edge.
    void splitTurningBeneath(std::span<const std::uint32_t> ring, FadingVertex& fading) const {
        const std::vector<Vec3>& at = ball_.on_grid;
        const double farthest = ball_.placement.turningDistance();
        const auto [corner, weight] = std::pair(fading.from, fading.weight);
        double closest = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t l = (k + 1) % 3, m = (k + 2) % 3;
            const std::uint32_t a = corner[k], b = corner[l], c = corner[m], d = facetBeyond(a, b, c, ring, at);
            if (d == c || !passNear(at[a], at[b], at[c], at[d], farthest * kGrid)) continue;
            const auto edge = edgeFlip({ball_.at(a), ball_.at(b), ball_.at(c), ball_.at(d)}, farthest);
            if (!edge || edge->shareOfOther() <= closest) continue;
            closest = edge->shareOfOther();
            const Dual in_edge = edge->weight[0] + edge->weight[1];
            const std::array<Dual, 2> on_edge{edge->weight[0] / in_edge, edge->weight[1] / in_edge};
            const Dual of_first = weight[k] / on_edge[0], of_second = weight[l] / on_edge[1];
            const Dual of_vertex = of_first.value < of_second.value ? of_first : of_second;
            fading.from = {a, b, c, d};
            fading.weight = {weight[k] + of_vertex * (edge->weight[0] - on_edge[0]),
                             weight[l] + of_vertex * (edge->weight[1] - on_edge[1]),
                             weight[m] + of_vertex * edge->weight[2], of_vertex * edge->weight[3]};
        }
    }

    // In the network, or from kNew on; of a point used for the first time a new one.
    std::uint32_t number(std::uint32_t v) {
        std::uint32_t& number = number_[v];
        if (number != kInvalidIndex) return number;
        number = kNew + static_cast<std::uint32_t>(part_.point.size());
        if (v < ball_.given()) {
            const std::uint32_t p = ball_.face_point[v - ball_.inLoops()];
            part_.point.push_back(p);
            part_.volume_offsets += ball_.placement.swells(p);
        } else {
            const Vec3 direction = toDouble(filling_.new_point[v - ball_.given()]).normalized();
            part_.add({{ball_.centre.position + direction * ball_.radius, ball_.centre.velocity}, Dual(0)});
        }
        return number;
    }

    const Ball& ball_;
    const LoopFilling& filling_;
    Part& part_;
    std::size_t first_triangle_;
    std::vector<std::uint32_t>& number_;  // of points
    std::vector<std::uint32_t>& first_;   // of points: the first triangle
    std::vector<std::uint32_t>& ring_;
    std::vector<EdgeFlip>& edges_;
};

}  // namespace

BetaMesh completeTessellation(const BallBoundary& boundary, const std::vector<DualVec3>& balls, ArcNetwork network,
                              FacePoints points, const ArcSubdivision& subdivision) {
    const CompressedRows<NearTangentNeighbour> touches = lightTouches(balls, network, points, boundary.worldRadius());
    std::exchange(network.line, {}), std::exchange(network.at_ball, {});  // large, and of no more use
    const std::vector<std::uint32_t> first_face = firstFaces(boundary);
    const LoopMaker maker(boundary, network);
    const Placement placement(points, subdivision);
    const DirectionTriangles direction_triangles(points.directions);

    const std::size_t tasks = (balls.size() + kBallsPerTask - 1) / kBallsPerTask;
    std::vector<Part> parts(tasks);
    parallelFor(tasks, 1, [&](std::size_t task) {
        HullFiller hull;
        LoopFilling filling;
        BallLoops ball_loops;
        LoopsOnSphere& loops = ball_loops.loops;
        FillingAdder::Room room;
        std::vector<std::uint32_t> face_point, direction, place;
        std::vector<Vec3> on_grid;
        for (std::size_t b = task * kBallsPerTask; b < std::min(balls.size(), (task + 1) * kBallsPerTask); ++b) {
            Part& part = parts[task];
            part.ball.push_back(
                {static_cast<std::uint32_t>(part.triangles.size()), static_cast<std::uint32_t>(part.point.size())});
            maker.makeLoops(static_cast<std::uint32_t>(b), first_face[b], first_face[b + 1], ball_loops);
            const auto in_loops = static_cast<std::uint32_t>(loops.point.size());
            face_point.clear();
            direction.clear();
            for (const bool sinking : {false, true})
                for (std::uint32_t p = points.begin[b]; p < points.begin[b + 1]; ++p) {
                    if (!placement.used(p) || placement.sinks(p) != sinking) continue;
                    face_point.push_back(p);
                    if (!sinking) direction.push_back(points.direction[p]);
                    if (points.contactOf(p))
                        loops.perhaps_above.push_back(static_cast<std::uint32_t>(loops.point.size()));
                    loops.point.push_back(onGrid(placement.at(p).position));
                }
            on_grid.resize(loops.point.size());
            std::transform(loops.point.begin(), loops.point.end(), on_grid.begin(), toDouble);
            const Ball ball{ball_loops, network,  face_point, direction.size(),      on_grid,
                            placement,  balls[b], boundary.worldRadius()};
            if (in_loops == 0 && loops.perhaps_above.empty()) {  // a bare sphere
                FillingAdder(ball, {points.directions.triangles, {}, {}}, parts[task], room);
                continue;
            }
            direction_triangles.among(direction, place, [&](const Triangle& t) {
                loops.likely_facet.push_back({in_loops + t[0], in_loops + t[1], in_loops + t[2]});
            });
            if (hull.fill(loops, filling)) {
                FillingAdder adder(ball, filling, parts[task], room);
                if (subdivision.appearance != Appearance::gradual) continue;
                adder.holdSinking();
                adder.splitTurning();
            } else {
                loops.point.resize(in_loops);
                const std::vector<std::uint32_t>& begin = ball_loops.face_begin;
                for (std::size_t f = 0; f + 1 < begin.size(); ++f)
                    FillingAdder(ball, fillWithFan(loops, begin[f], begin[f + 1]), parts[task], room);
            }
        }
    });

    const auto placesIn = [&](auto list) {
        std::vector<std::uint32_t> sizes;
        for (const Part& part : parts) sizes.push_back(static_cast<std::uint32_t>((part.*list).size()));
        return exclusiveScan(sizes);
    };
    const std::vector<std::uint32_t> vertices = placesIn(&Part::point), triangles = placesIn(&Part::triangles),
                                     fading = placesIn(&Part::fading), turning = placesIn(&Part::turning);
    std::vector<std::uint32_t> first_offset;
    for (const Part& part : parts) first_offset.push_back(part.volume_offsets);
    first_offset = exclusiveScan(first_offset);
    BetaMesh mesh;
    const std::size_t in_network = network.point.size();
    mesh.vertex = std::move(network.point);
    firstTouchResize(mesh.vertex, in_network + vertices.back());
    firstTouchResize(mesh.rim_distance, mesh.vertex.size());
    firstTouchResize(mesh.triangles, triangles.back());
    auto &on_edges = mesh.fading[0], &on_facets = mesh.fading[1], &in_quads = mesh.fading[2];
    on_edges = std::move(network.fading);
    firstTouchResize(on_facets, fading.back());
    firstTouchResize(in_quads, turning.back());
    firstTouchResize(mesh.volume_offsets, first_offset.back());
    mesh.ball_begin.assign(balls.size() + 1, triangles.back());
    parallelFor(tasks, 4, [&](std::size_t task) {
        const Part& part = parts[task];
        const auto first = static_cast<std::uint32_t>(in_network + vertices[task]);
        const auto numbered = [&](std::uint32_t v) { return v >= kNew ? first + (v - kNew) : v; };
        VolumeOffset* offset = mesh.volume_offsets.data() + first_offset[task];
        for (std::size_t k = 0; k < part.ball.size(); ++k) {
            const std::size_t b = task * kBallsPerTask + k;
            mesh.ball_begin[b] = triangles[task] + part.ball[k].triangles;
            const std::size_t end = k + 1 < part.ball.size() ? part.ball[k + 1].points : part.point.size();
            for (std::size_t i = part.ball[k].points; i < end; ++i) {
                const std::uint32_t p = part.point[i], v = first + static_cast<std::uint32_t>(i);
                if (p >= kNew) {
                    mesh.vertex[v] = part.other[p - kNew].vertex;
                    mesh.rim_distance[v] = part.other[p - kNew].rim_distance;
                    continue;
                }
                mesh.vertex[v] = balls[b] + placement.at(p) * boundary.worldRadius();
                mesh.rim_distance[v] = placement.rim_distance(p);
                if (placement.swells(p))
                    *offset++ = {v, placement.volumeOffset(p, touches[b]) * boundary.worldRadius()};
            }
        }
        std::transform(part.triangles.begin(), part.triangles.end(), mesh.triangles.begin() + triangles[task],
                       [&](const Triangle& t) {
                           return Triangle{numbered(t[0]), numbered(t[1]), numbered(t[2])};
                       });
        const auto copy = [&](const std::vector<FadingVertex>& from, FadingVertex* to) {
            for (const FadingVertex& r : from) {
                *to = r;
                to->vertex = numbered(r.vertex);
                for (std::uint32_t& v : to->from) v = numbered(v);
                ++to;
            }
        };
        copy(part.fading, on_facets.data() + fading[task]);
        copy(part.turning, in_quads.data() + turning[task]);
    });
    return mesh;
}

}  // namespace betamesh
