
#include "mesh/triangle_contact.h"

#include "base/index.h"
#include "exact/orientation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace betamesh {

namespace {

using Signs = std::array<int, 3>;

constexpr int kMostDegenerateTriangles = 16;  // that are passed in a row to find a proper one

// Corners that two triangles share.
struct SharedCorners {
    std::array<int, 3> partner{-1, -1, -1};  // for each corner of s the corner of t at the same position, or -1
    int positions = 0;                       // number of such corners
    int vertices = 0;                        // number of them that are one vertex of the mesh

    bool inT(int corner) const { return std::find(partner.begin(), partner.end(), corner) != partner.end(); }
    // Where two corners are shared: the third one.
    int restOfS() const { return partner[0] < 0 ? 0 : partner[1] < 0 ? 1 : 2; }
    int restOfT() const { return !inT(0) ? 0 : !inT(1) ? 1 : 2; }
};

// The intersection of an edge of one triangle with the other triangle's plane: a point on the intersection line of the
// two planes.
struct Crossing {
    std::uint32_t above, below;  // ends of the edge; one of them may be on the plane
};

// The segment of the intersection line that is inside one triangle.
struct Segment {
    Crossing first, last;  // in the order along the line
    bool point = false;    // the triangle only touches the line with a corner
    int side = -1;         // the side of the triangle that is on the line, or -1
};

int after(int corner) { return corner == 2 ? 0 : corner + 1; }
int before(int corner) { return corner == 0 ? 2 : corner - 1; }

int longestAxis(const Vec3& v) {
    int k = 0;
    for (int i = 1; i < 3; ++i)
        if (std::abs(v[i]) > std::abs(v[k])) k = i;
    return k;
}

bool allOn(const Signs& signs, int side) { return signs[0] == side && signs[1] == side && signs[2] == side; }
bool allOnOneSide(const Signs& signs) { return signs[0] != 0 && allOn(signs, signs[0]); }

// The line is directed so that the plane's positive side is on its left, seen from where the triangle is
// counter-clockwise (not `mirrored`) or clockwise. The two triangles of a pair give the line the same direction when
// exactly one of them is mirrored.
Segment segmentOf(const Triangle& t, const Signs& signs, bool mirrored) {
    const auto positive = std::count(signs.begin(), signs.end(), 1),
               negative = std::count(signs.begin(), signs.end(), -1);
    Segment segment;
    // Find the corner that is separated by the line from the other two.
    const bool above = positive == 1 || (positive == 0 && negative == 2);
    const int wanted = positive == 1 ? 1 : positive == 2 ? (negative == 1 ? -1 : 0) : negative == 1 ? -1 : 0;
    const int apex = static_cast<int>(std::find(signs.begin(), signs.end(), wanted) - signs.begin());
    const auto crossing = [&](int corner) {
        return above ? Crossing{t[apex], t[corner]} : Crossing{t[corner], t[apex]};
    };
    segment.first = crossing(above != mirrored ? after(apex) : before(apex));
    segment.last = crossing(above != mirrored ? before(apex) : after(apex));
    segment.point = wanted == 0;
    if (positive + negative == 1) segment.side = after(apex);
    return segment;
}

class TrianglePair {
public:
    TrianglePair(const TestedSurface& surface, std::uint32_t s, std::uint32_t t)
        : surface_(surface), s_(s), t_(t), a_(surface.triangles[s]), b_(surface.triangles[t]) {
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) {
                if (surface.first_at[a_[i]] != surface.first_at[b_[j]]) continue;
                shared_.partner[i] = j;
                ++shared_.positions;
                if (a_[i] == b_[j]) ++shared_.vertices;
            }
    }

    Contact contact() const {
        if (shared_.positions == 3) return shared_.vertices == 3 ? Contact{} : overlap();
        Signs of_b{};
        for (int j = 0; j < 3; ++j)
            if (!shared_.inT(j)) of_b[j] = sideOfPlane(at(a_[0]), at(a_[1]), at(a_[2]), at(b_[j]));
        if (allOnOneSide(of_b)) return {};
        if (allOn(of_b, 0)) return coplanar();
        if (shared_.positions == 2) return alongEdges(after(shared_.restOfS()), after(shared_.restOfT()));
        Signs of_a{};
        for (int i = 0; i < 3; ++i)
            if (shared_.partner[i] < 0) of_a[i] = sideOfPlane(at(b_[0]), at(b_[1]), at(b_[2]), at(a_[i]));
        if (allOnOneSide(of_a)) return {};
        return transversal(of_a, of_b);
    }

private:
    const Vec3& at(std::uint32_t vertex) const { return surface_.position[vertex]; }

    // For triangles that have only a shared corner in common.
    Contact sharedCorner() const {
        if (shared_.vertices == shared_.positions) return {};
        for (int i = 0; i < 3; ++i)
            if (shared_.partner[i] >= 0) return {ContactKind::touching, false, at(a_[i]), 0};
        return {};
    }

    // Order along the line: -1, 0, 1 where x, of s, is before, at or after y, of t.
    int order(const Crossing& x, const Crossing& y) const {
        for (const std::uint32_t v : {x.above, x.below})
            for (const std::uint32_t w : {y.above, y.below})
                if (surface_.first_at[v] == surface_.first_at[w]) return 0;
        return sideOfPlane(at(x.above), at(x.below), at(y.above), at(y.below));
    }

    Vec3 pointOf(const Crossing& x, const Triangle& other) const {
        const Vec3 normal = cross(at(other[1]) - at(other[0]), at(other[2]) - at(other[0]));
        const double above = std::abs(dot(normal, at(x.above) - at(other[0])));
        const double below = std::abs(dot(normal, at(x.below) - at(other[0])));
        const double sum = above + below;
        return sum > 0 ? at(x.above) * (below / sum) + at(x.below) * (above / sum) : at(x.above);
    }

    Contact transversal(const Signs& of_a, const Signs& of_b) const {
        const Segment x = segmentOf(a_, of_a, false), y = segmentOf(b_, of_b, true);
        const int from = order(x.first, y.last), to = order(x.last, y.first);
        if (from > 0 || to < 0) return {};
        const Vec3 begin = order(x.first, y.first) >= 0 ? pointOf(x.first, b_) : pointOf(y.first, a_);
        const Vec3 end = order(x.last, y.last) <= 0 ? pointOf(x.last, b_) : pointOf(y.last, a_);
        const Vec3 middle = (begin + end) / 2;
        if (x.point || y.point || from == 0 || to == 0)
            return shared_.positions == 0 ? Contact{ContactKind::touching, false, middle, 0} : sharedCorner();

        if (x.side < 0 && y.side < 0) return {ContactKind::crossing, false, middle, depth({}, {})};
        if (x.side >= 0 && y.side >= 0) return alongEdges(x.side, y.side, middle);
        if (x.side >= 0) return edgeOnFace(s_, x.side, of_a[before(x.side)], b_, middle);
        return edgeOnFace(t_, y.side, of_b[before(y.side)], a_, middle);
    }

    // A side of triangle `of` is on `face`, whose plane has the third corner of `of` on its side `apex_side`.
    Contact edgeOnFace(std::uint32_t of, int side, int apex_side, const Triangle& face, const Vec3& middle) const {
        const std::uint32_t apex = apexAcross(of, side);
        const bool crosses =
            apex != kInvalidIndex && sideOfPlane(at(face[0]), at(face[1]), at(face[2]), at(apex)) == -apex_side;
        if (!crosses) return {ContactKind::touching, false, middle, 0};
        return {ContactKind::crossing, false, middle, of == s_ ? depth({apex}, {}) : depth({}, {apex})};
    }

    // Sides m of s and n of t overlap along one line.
    Contact alongEdges(int m, int n) const { return alongEdges(m, n, (at(a_[m]) + at(a_[after(m)])) / 2); }
    Contact alongEdges(int m, int n, const Vec3& middle) const {
        if (shared_.vertices == 2) return {};
        const std::uint32_t across_s = apexAcross(s_, m), across_t = apexAcross(t_, n);
        if (across_s == kInvalidIndex || across_t == kInvalidIndex ||
            !interleaved(a_[m], a_[after(m)], a_[before(m)], across_s, b_[before(n)], across_t))
            return {ContactKind::touching, false, middle, 0};
        return {ContactKind::crossing, false, middle, depth({across_s}, {across_t})};
    }

    // The third vertex of the triangle across a side, or kInvalidIndex. Degenerate triangles are passed, towards the
    // proper triangle at the same line.
    std::uint32_t apexAcross(std::uint32_t t, int side) const {
        const Vec3 &p = at(surface_.triangles[t][side]), &q = at(surface_.triangles[t][after(side)]);
        const int k = longestAxis(q - p);
        const auto between = [&](const Vec3& v, const Vec3& w, const Vec3& x) {
            return std::min(v[k], w[k]) <= x[k] && x[k] <= std::max(v[k], w[k]);
        };
        for (int steps = 0; steps < kMostDegenerateTriangles; ++steps) {
            const std::uint32_t from = surface_.triangles[t][side], to = surface_.triangles[t][after(side)];
            t = surface_.across[3 * t + static_cast<std::uint32_t>(side)];
            if (t == kInvalidIndex) return kInvalidIndex;
            const Triangle& other = surface_.triangles[t];
            const int apex = other[0] != from && other[0] != to ? 0 : other[1] != from && other[1] != to ? 1 : 2;
            if (!onOneLine(p, q, at(other[apex]))) return other[apex];
            side = between(at(other[apex]), at(other[before(apex)]), at(other[after(apex)])) ? before(apex) : apex;
        }
        return kInvalidIndex;
    }

    // For the half-planes bounded by the line from p to q through a, b, c, d: is one of c, d strictly between a and b
    // in counter-clockwise order, the other one strictly between b and a?
    bool interleaved(std::uint32_t p, std::uint32_t q, std::uint32_t a, std::uint32_t b, std::uint32_t c,
                     std::uint32_t d) const {
        const auto turn = [&](std::uint32_t v, std::uint32_t w) { return sideOfPlane(at(p), at(q), at(v), at(w)); };
        const int half = turn(a, b);
        if (half == 0 && !opposite(p, q, a, b)) return false;
        const auto between = [&](std::uint32_t from, std::uint32_t w, std::uint32_t to, int sense) {
            if (sense > 0) return turn(from, w) > 0 && turn(w, to) > 0;
            if (sense < 0) return !(turn(to, w) >= 0 && turn(w, from) >= 0);
            return turn(from, w) > 0;
        };
        return (between(a, c, b, half) && between(b, d, a, -half)) ||
               (between(a, d, b, half) && between(b, c, a, -half));
    }

    // Are a and b, which are coplanar with the line from p to q, on different sides of it?
    bool opposite(std::uint32_t p, std::uint32_t q, std::uint32_t a, std::uint32_t b) const {
        for (int axis = 0; axis < 3; ++axis) {
            const int side = turnAlong(axis, at(p), at(q), at(a));
            if (side != 0) return turnAlong(axis, at(p), at(q), at(b)) == -side;
        }
        return false;
    }

    // An axis along which triangle s projects to a non-degenerate triangle, preferably the largest one.
    int projectionAxis() const {
        const Vec3 normal = cross(at(a_[1]) - at(a_[0]), at(a_[2]) - at(a_[0]));
        int axis = std::abs(normal.x) > std::abs(normal.y) ? 0 : 1;
        if (std::abs(normal.z) > std::abs(normal[axis])) axis = 2;
        for (int k = 0; k < 3; ++k, axis = after(axis))
            if (turnAlong(axis, at(a_[0]), at(a_[1]), at(a_[2])) != 0) break;
        return axis;
    }

    // Two triangles in one plane overlap unless a side of one of them separates it from the other.
    Contact coplanar() const {
        const int axis = projectionAxis();
        for (const bool of_s : {true, false}) {
            const Triangle &own = of_s ? a_ : b_, &other = of_s ? b_ : a_;
            const int sense = turnAlong(axis, at(own[0]), at(own[1]), at(own[2]));
            for (int m = 0; m < 3; ++m) {
                Signs signs{};
                for (int j = 0; j < 3; ++j) {
                    const std::uint32_t v = other[j], p = own[m], q = own[after(m)];
                    if (surface_.first_at[v] == surface_.first_at[p] || surface_.first_at[v] == surface_.first_at[q])
                        continue;
                    signs[j] = sense * turnAlong(axis, at(p), at(q), at(v));
                }
                if (signs[0] <= 0 && signs[1] <= 0 && signs[2] <= 0) return onSeparatingLine(of_s, m, signs);
            }
        }
        return overlap();
    }

    // The line of side m of one triangle separates the two. Corners of the other triangle with sign 0 are on the line.
    Contact onSeparatingLine(bool of_s, int m, const Signs& signs) const {
        const Triangle &own = of_s ? a_ : b_, &other = of_s ? b_ : a_;
        const Vec3 &p = at(own[m]), &q = at(own[after(m)]);
        const int k = longestAxis(q - p);
        const auto along = [k](const Vec3& v, const Vec3& w) { return v[k] < w[k]; };
        std::vector<Vec3> on_line;
        int n = -1;
        for (int j = 0; j < 3; ++j) {
            if (signs[j] == 0) on_line.push_back(at(other[j]));
            if (signs[j] == 0 && signs[after(j)] == 0) n = j;
        }
        if (on_line.empty()) return {};
        const auto [low, high] = std::minmax_element(on_line.begin(), on_line.end(), along);
        const Vec3 begin = std::max(std::min(p, q, along), *low, along),
                   end = std::min(std::max(p, q, along), *high, along);
        if (along(end, begin)) return {};
        const Vec3 middle = (begin + end) / 2;
        if (!along(begin, end))
            return shared_.positions == 0 ? Contact{ContactKind::touching, false, middle, 0} : sharedCorner();
        return of_s ? alongEdges(m, n, middle) : alongEdges(n, m, middle);
    }

    // For coplanar triangles that overlap: the centre of the overlap, which is s clipped by the sides of t.
    Contact overlap() const {
        std::vector<Vec3> polygon{at(a_[0]), at(a_[1]), at(a_[2])}, clipped;
        const Vec3 normal = cross(at(b_[1]) - at(b_[0]), at(b_[2]) - at(b_[0]));
        for (int m = 0; m < 3; ++m) {
            const Vec3 &p = at(b_[m]), inward = cross(normal, at(b_[after(m)]) - p);
            clipped.clear();
            for (std::size_t i = 0; i < polygon.size(); ++i) {
                const Vec3 &v = polygon[i], &w = polygon[(i + 1) % polygon.size()];
                const double from = dot(v - p, inward), to = dot(w - p, inward);
                if (from >= 0) clipped.push_back(v);
                if ((from < 0) != (to < 0)) clipped.push_back(v + (w - v) * (from / (from - to)));
            }
            if (clipped.empty()) break;  // possible by rounding
            polygon.swap(clipped);
        }
        Vec3 middle(0);
        for (const Vec3& v : polygon) middle += v / static_cast<double>(polygon.size());
        return {ContactKind::crossing, true, middle, 0};
    }

    // Penetration depth of two convex hulls, those of each triangle's corners and, where the crossing is at an edge,
    // the apex of its neighbour. Every direction gives an upper bound. For two triangles the minimum over their normals
    // and the cross products of their edges is exact; directions along edges help where the triangles share a short
    // segment of an edge.
    double depth(const std::vector<std::uint32_t>& more_of_a, const std::vector<std::uint32_t>& more_of_b) const {
        std::vector<std::uint32_t> a(a_.begin(), a_.end()), b(b_.begin(), b_.end());
        a.insert(a.end(), more_of_a.begin(), more_of_a.end());
        b.insert(b.end(), more_of_b.begin(), more_of_b.end());
        const Vec3 origin = at(a_[0]);
        double smallest = std::numeric_limits<double>::infinity();
        const auto tryDirection = [&](const Vec3& direction) {
            const double length = direction.length();
            if (!(length > 0)) return;
            const auto extent = [&](const std::vector<std::uint32_t>& vertices) {
                std::pair<double, double> range{std::numeric_limits<double>::infinity(),
                                                -std::numeric_limits<double>::infinity()};
                for (const std::uint32_t v : vertices) {
                    const double height = dot(at(v) - origin, direction);
                    range = {std::min(range.first, height), std::max(range.second, height)};
                }
                return range;
            };
            const auto of_a = extent(a), of_b = extent(b);
            smallest = std::min(smallest, std::min(of_a.second - of_b.first, of_b.second - of_a.first) / length);
        };
        std::array<Vec3, 3> edges_of_a, edges_of_b;
        for (int m = 0; m < 3; ++m) {
            edges_of_a[m] = at(a_[after(m)]) - at(a_[m]);
            edges_of_b[m] = at(b_[after(m)]) - at(b_[m]);
        }
        tryDirection(cross(edges_of_a[0], edges_of_a[1]));
        tryDirection(cross(edges_of_b[0], edges_of_b[1]));
        for (const Vec3& u : edges_of_a)
            for (const Vec3& v : edges_of_b) tryDirection(cross(u, v));
        for (const auto& edges : {edges_of_a, edges_of_b})
            for (const Vec3& edge : edges) tryDirection(edge);
        return std::max(0.0, smallest);
    }

    const TestedSurface& surface_;
    std::uint32_t s_, t_;
    const Triangle &a_, &b_;
    SharedCorners shared_;
};

}  // namespace

Contact contactOf(const TestedSurface& surface, std::uint32_t s, std::uint32_t t) {
    return TrianglePair(surface, s, t).contact();
}

}  // namespace betamesh
