
#include "skin/hull.h"

#include "base/index.h"
#include "base/simd.h"
#include "base/union_find.h"
#include "exact/predicates.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

namespace betamesh {

namespace {

using Int = __int128;
constexpr std::int64_t kContraction = 27488;           // 1e-7 radii
constexpr std::int64_t kLargestContraction = 1 << 28;  // 1e-3 radii
constexpr double kRadius = 0x1p38;

// Sign of (b - a) × (c - a) · (p - a): +1 where p lies above the triangle, on the side it is seen
// counter-clockwise from. Differences are below 2^40, so everything fits in 128 bits.
int orient(const Vec3i& a, const Vec3i& b, const Vec3i& c, const Vec3i& p) {
    const Vec3i iu = b - a, iv = c - a, iw = p - a;
    const Vec3 u = toDouble(iu), v = toDouble(iv), w = toDouble(iw);
    const double xy = u.x * v.y, yx = u.y * v.x, yz = u.y * v.z, zy = u.z * v.y, zx = u.z * v.x, xz = u.x * v.z;
    const double determinant = (yz - zy) * w.x + (zx - xz) * w.y + (xy - yx) * w.z;
    const double size = (std::abs(yz) + std::abs(zy)) * std::abs(w.x) + (std::abs(zx) + std::abs(xz)) * std::abs(w.y) +
                        (std::abs(xy) + std::abs(yx)) * std::abs(w.z);
    const double bound = 16 * 0x1p-53 * size;  // seven roundings along any path, twice over
    if (determinant > bound) return 1;
    if (determinant < -bound) return -1;
    const Int exact = (Int{iu.y} * iv.z - Int{iu.z} * iv.y) * iw.x + (Int{iu.z} * iv.x - Int{iu.x} * iv.z) * iw.y +
                      (Int{iu.x} * iv.y - Int{iu.y} * iv.x) * iw.z;
    return (exact > 0) - (exact < 0);
}

// Are the normals of two coplanar triangles alike (+1) or opposite (-1)?
int sameTurn(const Vec3i& a, const Vec3i& b, const Vec3i& c, const Vec3i& d, const Vec3i& e, const Vec3i& f) {
    const auto component = [](const Vec3i& u, const Vec3i& v, int k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        return Int{u[i]} * v[j] - Int{u[j]} * v[i];
    };
    for (int k = 0; k < 3; ++k) {
        const Int first = component(b - a, c - a, k), second = component(e - d, f - d, k);
        if (first != 0 && second != 0) return (first > 0) == (second > 0) ? 1 : -1;
    }
    return 0;
}

// The same when every point is lifted outwards by its own tiny amount, the lexicographically first by most: never 0
// for four distinct points of a sphere round the origin, whichever way the triangle faces.
int liftedOrient(const Vec3i& a, const Vec3i& b, const Vec3i& c, const Vec3i& p) {
    if (const int sign = orient(a, b, c, p)) return sign;
    const int facing = orient(a, b, c, Vec3i(0)) > 0 ? -1 : 1;
    const Vec3i& first = std::min({a, b, c, p}, before);
    if (first == p) return facing;
    if (first == a) return -facing * sameTurn(a, b, c, p, b, c);
    if (first == b) return -facing * sameTurn(a, b, c, a, p, c);
    return -facing * sameTurn(a, b, c, a, b, p);
}

// A run of loop points that coincide, and what follows it in its loop.
struct Pass {
    std::uint32_t location;
    std::uint32_t first_id, ids;  // in a list
    std::uint32_t next = kInvalidIndex;   // pass; kInvalidIndex where the whole loop is this one location
};

// A triangle of locations, and of the points that its corners stand for. A side runs from one corner to the next; what
// is beyond it is its twin, which runs back, or the pass at its tail, where it is a loop's.
struct Facet {
    Triangle location, id{kInvalidIndex, kInvalidIndex, kInvalidIndex}, beyond{kInvalidIndex, kInvalidIndex, kInvalidIndex};
};

// Sides by number.
constexpr std::uint32_t sideOf(std::uint32_t facet, std::uint32_t corner) { return facet << 2 | corner; }
constexpr std::uint32_t facetOf(std::uint32_t side) { return side >> 2; }
constexpr std::uint32_t cornerOf(std::uint32_t side) { return side & 3; }
constexpr std::uint32_t nextCorner(std::uint32_t corner) { return corner == 2 ? 0 : corner + 1; }

// What is beyond a side, in one number: kInvalidIndex, a side, or from kLoop on a pass.
constexpr std::uint32_t kLoop = std::uint32_t{1} << 31;
constexpr bool isSide(std::uint32_t beyond) { return beyond < kLoop; }
constexpr std::uint32_t passOf(std::uint32_t beyond) {
    return beyond == kInvalidIndex || isSide(beyond) ? kInvalidIndex : beyond - kLoop;
}

// Where a location's points part the two facets on an edge: the chain of points that fills the gap, from the
// facet that has the edge location -> other to the one that has it backwards.
struct Gap {
    std::uint32_t location, other;
    std::vector<std::uint32_t> chain;
};

// What lies on the left of the ways from one location to another: a side or, where that is outside a loop, a pass. A
// hash table with open addressing.
class HalfEdgeMap {
public:
    // For at most so many ways.
    void clear(std::size_t ways) {
        const std::size_t slots = std::bit_ceil(2 * ways + 2);
        shift_ = 64 - std::countr_zero(slots);
        way_.assign(slots, kFree);
        left_.resize(slots);
    }
    // kInvalidIndex where there is nothing yet.
    std::uint32_t at(std::uint32_t from, std::uint32_t to) const {
        const std::size_t slot = slotOf(from, to);
        return way_[slot] == kFree ? kInvalidIndex : left_[slot];
    }
    // False where there is something already.
    bool put(std::uint32_t from, std::uint32_t to, std::uint32_t left) {
        const std::size_t slot = slotOf(from, to);
        if (way_[slot] != kFree) return false;
        way_[slot] = wayOf(from, to);
        left_[slot] = left;
        return true;
    }

private:
    static constexpr std::uint64_t kFree = ~std::uint64_t{0};
    static std::uint64_t wayOf(std::uint32_t from, std::uint32_t to) { return std::uint64_t{from} << 32 | to; }
    // Its own, or where it would be.
    std::size_t slotOf(std::uint32_t from, std::uint32_t to) const {
        constexpr std::uint64_t kSpread = 0x9E3779B97F4A7C15;  // 2^64 in the golden ratio
        const std::uint64_t way = wayOf(from, to);
        std::size_t slot = (way ^ way >> 29) * kSpread >> shift_;
        while (way_[slot] != kFree && way_[slot] != way) slot = slot + 1 < way_.size() ? slot + 1 : 0;
        return slot;
    }

    int shift_ = 63;
    std::vector<std::uint64_t> way_;
    std::vector<std::uint32_t> left_;
};

// A plane through three points, and on which side of it a fourth is: quick where rounding cannot matter.
struct Plane {
    Vec3 origin, normal;
    double bound;  // heights are this exact

    Plane(const Vec3& a, const Vec3& b, const Vec3& c) : origin(a) {
        const Vec3 u = b - a, v = c - a;
        normal = cross(u, v);
        // Products of the differences, below 2^40, carry a rounding each, and so do the sums.
        const double largest_u = std::max({std::abs(u.x), std::abs(u.y), std::abs(u.z)}),
                     largest_v = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
        bound = 0x1p-48 * largest_u * largest_v * 0x1p40;
    }
    enum Side { above, below, unsure };
    Side sideOf(const Vec3& p) const {
        const double height = dot(normal, p - origin);
        return height > bound ? above : height < -bound ? below : unsure;
    }
};

// Places of points, all at once.
struct Places {
    std::vector<double> x, y, z;

    std::size_t size() const { return x.size(); }
    Vec3 at(std::size_t k) const { return {x[k], y[k], z[k]}; }
    void clear() { x.clear(), y.clear(), z.clear(); }
    void add(const Vec3& place) { x.push_back(place.x), y.push_back(place.y), z.push_back(place.z); }
};

// The same by floats, in radii; what fills up the last register is the origin.
struct RoughPlaces {
    std::vector<float> x, y, z;

    void of(const Places& places) {
        const auto round = [](const std::vector<double>& from, std::vector<float>& to) {
            to.assign((from.size() + kLanes - 1) / kLanes * kLanes, 0);
            for (std::size_t k = 0; k < from.size(); ++k) to[k] = static_cast<float>(from[k] / kRadius);
        };
        round(places.x, x);
        round(places.y, y);
        round(places.z, z);
    }
};

// The number that goes with the largest value, with any of these.
template <std::size_t kWidth>
__attribute__((always_inline)) inline void takeNumberOfLargest(const Floats<kWidth>& value,
                                                               const Floats<kWidth>& number, float& taken) {
    if constexpr (kWidth == 1) {
        taken = number[0];
    } else {
        constexpr std::size_t kHalf = kWidth / 2;
        Floats<kHalf> low, high, low_number, high_number;
        std::memcpy(&low, &value, sizeof low);
        std::memcpy(&high, reinterpret_cast<const float*>(&value) + kHalf, sizeof high);
        std::memcpy(&low_number, &number, sizeof low);
        std::memcpy(&high_number, reinterpret_cast<const float*>(&number) + kHalf, sizeof high);
        takeNumberOfLargest<kHalf>(high > low ? high : low, high > low ? high_number : low_number, taken);
    }
}

// The number of the place to which a plane turns first, about the line through `origin` along which two places lie that
// are left out, from where it faces along `normal`; away: across the line in this plane, where no places are. By
// floats, so perhaps another that is near it.
struct FirstTurnedTo {
    const RoughPlaces& places;
    Vec3f origin, normal, away;
    std::array<float, 2> left_out;
    float& found;

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()() const {
        using Some = Floats<kWidth>;
        const Some zero{}, least = zero + 1e-12F, never = zero - 1e30F;
        Some most = never, most_at{}, at;
        setNumbers<kWidth>(at);
        for (std::size_t i = 0; i < places.x.size(); i += kWidth, at += static_cast<float>(kWidth)) {
            Some x, y, z;
            std::memcpy(&x, &places.x[i], sizeof x);
            std::memcpy(&y, &places.y[i], sizeof y);
            std::memcpy(&z, &places.z[i], sizeof z);
            x -= origin.x, y -= origin.y, z -= origin.z;
            Some depth = zero - (x * normal.x + y * normal.y + z * normal.z);
            depth = depth > least ? depth : least;
            const Some from_first = at - left_out[0], from_second = at - left_out[1];
            Some is_first = 1.0F - from_first * from_first, is_second = 1.0F - from_second * from_second;
            is_first = is_first > 0 ? is_first : zero;
            is_second = is_second > 0 ? is_second : zero;
            const Some cotangent = (x * away.x + y * away.y + z * away.z) / depth + (is_first + is_second) * never;
            most_at = cotangent > most ? at : most_at;
            most = cotangent > most ? cotangent : most;
        }
        takeNumberOfLargest<kWidth>(most, most_at, found);
    }
};

// How many places are not surely below a plane, of the first n.
BETAMESH_EVERY_CPU
std::int64_t countNotBelow(const Places& places, std::size_t n, const Plane& plane) {
    const double *const x = places.x.data(), *const y = places.y.data(), *const z = places.z.data();
    const double ox = plane.origin.x, oy = plane.origin.y, oz = plane.origin.z;
    const double nx = plane.normal.x, ny = plane.normal.y, nz = plane.normal.z, below = -plane.bound;
    std::int64_t count = 0;
    for (std::size_t i = 0; i < n; ++i) count += (x[i] - ox) * nx + (y[i] - oy) * ny + (z[i] - oz) * nz < below ? 0 : 1;
    return count;
}

// How many places are so near this one along every axis, from the first on.
BETAMESH_EVERY_CPU
std::int64_t countNear(const Places& places, std::size_t first, const Vec3& here, double distance) {
    const double *const x = places.x.data(), *const y = places.y.data(), *const z = places.z.data();
    const std::size_t n = places.size();
    const double hx = here.x, hy = here.y, hz = here.z;
    std::int64_t count = 0;
    for (std::size_t i = first; i < n; ++i) {
        const double dx = std::abs(x[i] - hx), dy = std::abs(y[i] - hy), dz = std::abs(z[i] - hz);
        const double farther = dx > dy ? dx : dy, farthest = farther > dz ? farther : dz;
        count += farthest < distance ? 1 : 0;
    }
    return count;
}

}  // namespace

void LoopsOnSphere::clear() {
    point.clear();
    loop_begin.assign(1, 0);
    circles.clear();
    is_hole.clear();
    likely_facet.clear();
    perhaps_above.clear();
}

class HullFiller::Work {
public:
    bool run(const LoopsOnSphere& loops, bool with_likely_facets, std::int64_t contraction, LoopFilling& out) {
        loops_ = &loops;
        contraction_ = contraction;
        out.triangles.clear();
        out.new_point.clear();
        out.across.clear();
        passes_.clear();
        pass_id_.clear();
        facets_.clear();
        gaps_.clear();
        passages_.clear();
        open_.clear();
        contract();
        left_.clear(3 * mostFacets() + loops.circles.size());
        if (!makePasses(out) || (with_likely_facets && !takeLikelyFacets())) return false;
        listCandidates();
        if (!wrapAll()) return false;
        const auto facet_begin = static_cast<std::uint32_t>(out.triangles.size());
        if (contracted_ ? !nameCorners() : !haveOneFanEach()) return false;
        for (const Facet& f : facets_) out.triangles.push_back(contracted_ ? f.id : f.location);
        fillGaps(out);
        listAcross(facet_begin, out);
        return true;
    }

private:
    // Joins points that coincide into locations. Free points never coincide with one another.
    void contract() {
        const std::size_t n = loops_->point.size(), in_loops = loops_->circles.size();
        point_place_.clear();
        for (const Vec3i& p : loops_->point) point_place_.add(toDouble(p));
        const auto near = [&](std::uint32_t a, std::uint32_t b) {
            const Vec3i d = loops_->point[a] - loops_->point[b];
            return std::abs(d.x) < contraction_ && std::abs(d.y) < contraction_ && std::abs(d.z) < contraction_;
        };
        location_of_.resize(n);
        std::iota(location_of_.begin(), location_of_.end(), 0U);
        location_ = loops_->point;
        contracted_ = false;
        for (std::size_t a = 0; a < in_loops && !contracted_; ++a)
            contracted_ = countNear(point_place_, a + 1, point_place_.at(a), static_cast<double>(contraction_)) > 0;
        if (!contracted_) return;
        UnionFind same(n);
        for (std::uint32_t a = 0; a < in_loops; ++a)
            for (std::uint32_t b = a + 1; b < n; ++b)
                if (near(a, b)) same.join(a, b);
        location_.clear();
        point_at_.clear();
        for (std::uint32_t a = 0; a < n; ++a) {
            if (same.find(a) == a) {
                location_of_[a] = static_cast<std::uint32_t>(location_.size());
                location_.push_back(loops_->point[a]);
                point_at_.push_back(a);
            } else {
                location_of_[a] = location_of_[same.find(a)];
                Vec3i& place = location_[location_of_[a]];
                place = std::min(place, loops_->point[a], before);
            }
        }
        circles_at_.assign(location_.size(), {});
        for (std::size_t a = 0; a < in_loops; ++a)
            circles_at_[location_of_[a]].insert(circles_at_[location_of_[a]].end(), loops_->circles[a].begin(),
                                                loops_->circles[a].end());
    }
    bool onCircle(std::uint32_t location, std::uint32_t circle) const {
        if (contracted_)
            return std::find(circles_at_[location].begin(), circles_at_[location].end(), circle) !=
                   circles_at_[location].end();
        return location < loops_->circles.size() &&
               (loops_->circles[location][0] == circle || loops_->circles[location][1] == circle);
    }

    std::span<const std::uint32_t> idsOf(const Pass& pass) const {
        return std::span(pass_id_).subspan(pass.first_id, pass.ids);
    }
    void addPass(std::uint32_t location, std::uint32_t next) {
        passes_.push_back({location, static_cast<std::uint32_t>(pass_id_.size()), 0, next});
    }
    void addId(std::uint32_t id) {
        pass_id_.push_back(id);
        ++passes_.back().ids;
    }

    bool makePasses(LoopFilling& out) {
        pass_at_.assign(location_.size(), kInvalidIndex);
        for (std::size_t l = 0; l + 1 < loops_->loop_begin.size(); ++l) {
            const std::uint32_t begin = loops_->loop_begin[l], n = loops_->loop_begin[l + 1] - begin;
            const auto at = [&](std::uint32_t k) { return begin + k % n; };
            std::uint32_t start = 0;  // the first point of a run
            while (start < n && location_of_[at(start)] == location_of_[at(start + n - 1)]) ++start;
            const auto first = static_cast<std::uint32_t>(passes_.size());
            if (start == n) {
                if (!loops_->is_hole[l]) {
                    fillPoint(begin, n, out);
                    continue;
                }
                const std::uint32_t location = location_of_[begin];
                if (pass_at_[location] != kInvalidIndex) return false;
                pass_at_[location] = first;
                addPass(location, kInvalidIndex);
                for (std::uint32_t k = 0; k < n; ++k) addId(at(k));
                continue;
            }
            for (std::uint32_t k = start; k < start + n; ++k) {
                const std::uint32_t id = at(k), location = location_of_[id];
                if (k == start || location != passes_.back().location) addPass(location, 0);
                addId(id);
            }
            for (auto p = first; p < passes_.size(); ++p) {
                passes_[p].next = p + 1 < passes_.size() ? p + 1 : first;
                if (pass_at_[passes_[p].location] == kInvalidIndex) pass_at_[passes_[p].location] = p;
            }
        }
        for (std::uint32_t p = 0; p < passes_.size(); ++p) {
            if (passes_[p].next == kInvalidIndex) continue;
            const std::uint32_t a = passes_[p].location, b = passes_[passes_[p].next].location;
            if (left_.at(a, b) != kInvalidIndex || !left_.put(b, a, kLoop + p)) return false;
        }
        return true;
    }

    // A face that has shrunk to a point.
    void fillPoint(std::uint32_t begin, std::uint32_t n, LoopFilling& out) const {
        if (n == 3) {
            out.triangles.push_back({begin, begin + 1, begin + 2});
            return;
        }
        const auto centre = static_cast<std::uint32_t>(loops_->point.size() + out.new_point.size());
        out.new_point.push_back(loops_->point[begin]);
        for (std::uint32_t k = 0; k < n; ++k) out.triangles.push_back({begin + k, begin + (k + 1) % n, centre});
    }

    bool takeLikelyFacets() {
        const std::size_t in_loops = loops_->circles.size();
        for (const Triangle& t : loops_->likely_facet) {
            const Triangle at{location_of_[t[0]], location_of_[t[1]], location_of_[t[2]]};
            const Plane plane = planeThrough(at[0], at[1], at[2]);
            const auto isBelow = [&](std::size_t p) { return plane.sideOf(point_place_.at(p)) == Plane::below; };
            const bool below = std::all_of(loops_->perhaps_above.begin(), loops_->perhaps_above.end(), isBelow) &&
                               countNotBelow(point_place_, in_loops, plane) == 0;
            if (below && !addFacet(at[0], at[1], at[2])) return false;
        }
        for (std::uint32_t f = 0; f < facets_.size(); ++f)
            for (std::uint32_t m = 0; m < 3; ++m)
                if (facets_[f].beyond[m] == kInvalidIndex) open_.push_back(sideOf(f, m));
        return true;
    }

    // Points round which there is nothing left to find are no candidates.
    void listCandidates() {
        candidates_.clear();
        closed_.assign(location_.size(), 0);
        for (const Facet& f : facets_)
            for (const std::uint32_t v : f.location) closed_[v] = 1;
        for (const std::uint32_t side : open_) closed_[tailOf(side)] = closed_[headOf(side)] = 0;
        for (std::uint32_t p = 0; p < location_.size(); ++p)
            if (!closed_[p]) candidates_.push_back(p);
        candidate_at_.resize(location_.size());
        candidate_place_.clear();
        for (std::uint32_t k = 0; k < candidates_.size(); ++k) {
            candidate_at_[candidates_[k]] = k;
            candidate_place_.add(toDouble(location_[candidates_[k]]));
        }
        rough_place_.of(candidate_place_);
    }

    Plane planeThrough(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
        return {toDouble(location_[a]), toDouble(location_[b]), toDouble(location_[c])};
    }

    // The location that sees all others below the plane through the edge a -> b and itself.
    std::uint32_t wrap(std::uint32_t a, std::uint32_t b, std::uint32_t circle) const {
        const auto allowed = [&](std::uint32_t p) {
            return p != a && p != b && (circle == kInvalidIndex || !onCircle(p, circle));
        };
        std::size_t k = 0;
        while (k < candidates_.size() && !allowed(candidates_[k])) ++k;
        if (k == candidates_.size()) return kInvalidIndex;
        std::uint32_t best = candidates_[k];
        Plane plane = planeThrough(a, b, best);
        for (++k; k < candidates_.size(); ++k) {
            const Plane::Side side = plane.sideOf(candidate_place_.at(k));
            if (side == Plane::below) continue;
            const std::uint32_t p = candidates_[k];
            if (!allowed(p)) continue;
            if (side == Plane::unsure && liftedOrient(location_[a], location_[b], location_[best], location_[p]) <= 0)
                continue;
            best = p;
            plane = planeThrough(a, b, best);
        }
        return best;
    }
    // The same beyond a facet's side, from its head a to its tail b, where floats find it and all others are surely
    // below; else kInvalidIndex.
    std::uint32_t wrapQuickly(std::uint32_t side) const {
        const std::uint32_t a = headOf(side), b = tailOf(side);
        const auto& [u, v, w] = facets_[facetOf(side)].location;
        const Plane facet = planeThrough(u, v, w);
        const Vec3 origin = toDouble(location_[a]), edge = toDouble(location_[b]) - origin;
        const Vec3 normal = facet.normal / (kRadius * kRadius);
        float found = 0;
        onThisCpu(FirstTurnedTo{rough_place_,
                                Vec3f(origin / kRadius),
                                Vec3f(normal),
                                Vec3f(cross(normal, edge / kRadius)),
                                {static_cast<float>(candidate_at_[a]), static_cast<float>(candidate_at_[b])},
                                found});
        const auto best = static_cast<std::size_t>(found);
        if (best >= candidates_.size()) return kInvalidIndex;
        const Plane plane(origin, origin + edge, candidate_place_.at(best));
        constexpr std::int64_t kOnIt = 3;  // a, b and this one
        return countNotBelow(candidate_place_, candidate_place_.size(), plane) == kOnIt ? candidates_[best] : kInvalidIndex;
    }

    std::uint32_t tailOf(std::uint32_t side) const { return facets_[facetOf(side)].location[cornerOf(side)]; }
    std::uint32_t headOf(std::uint32_t side) const {
        return facets_[facetOf(side)].location[nextCorner(cornerOf(side))];
    }
    std::size_t mostFacets() const { return 2 * location_.size() + 4; }
    bool addFacet(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        if (facets_.size() == mostFacets()) return false;
        const auto f = static_cast<std::uint32_t>(facets_.size());
        Facet& facet = facets_.emplace_back();
        facet.location = {a, b, c};
        for (std::uint32_t m = 0; m < 3; ++m) {
            const std::uint32_t from = facet.location[m], to = facet.location[nextCorner(m)];
            if (from == to || !left_.put(from, to, sideOf(f, m))) return false;
            const std::uint32_t beyond = facet.beyond[m] = left_.at(to, from);
            if (isSide(beyond)) facets_[facetOf(beyond)].beyond[cornerOf(beyond)] = sideOf(f, m);
        }
        return true;
    }
    bool wrapAt(std::uint32_t from, std::uint32_t to, std::uint32_t circle) {
        return closeWith(from, to, wrap(from, to, circle));
    }
    bool wrapBeyond(std::uint32_t side) {
        const std::uint32_t from = headOf(side), to = tailOf(side), apex = wrapQuickly(side);
        return closeWith(from, to, apex != kInvalidIndex ? apex : wrap(from, to, kInvalidIndex));
    }
    bool closeWith(std::uint32_t from, std::uint32_t to, std::uint32_t apex) {
        if (apex == kInvalidIndex || !addFacet(from, to, apex)) return false;
        for (const std::uint32_t m : {1U, 2U})
            if (facets_.back().beyond[m] == kInvalidIndex)
                open_.push_back(sideOf(static_cast<std::uint32_t>(facets_.size() - 1), m));
        return true;
    }
    bool closeAll() {
        while (!open_.empty()) {
            const std::uint32_t side = open_.back();
            open_.pop_back();
            if (facets_[facetOf(side)].beyond[cornerOf(side)] == kInvalidIndex && !wrapBeyond(side)) return false;
        }
        return true;
    }

    bool wrapAll() {
        bool any_edge = !open_.empty();
        if (!closeAll()) return false;
        for (const Pass& pass : passes_) {
            if (pass.next == kInvalidIndex) continue;
            any_edge = true;
            const std::uint32_t a = pass.location, b = passes_[pass.next].location;
            if (left_.at(a, b) != kInvalidIndex) continue;
            if (!wrapAt(a, b, loops_->circles[idsOf(pass).back()][1]) || !closeAll()) return false;
        }
        if (any_edge || passes_.empty()) return true;
        // Nothing but points on the loops' side: the whole hull, from an edge at its lowest x.
        const auto lowest = static_cast<std::uint32_t>(std::min_element(location_.begin(), location_.end(), before) -
                                                       location_.begin());
        const Vec3i beside = location_[lowest] + Vec3i(0, 0, std::int64_t{1} << 38);
        std::uint32_t other = kInvalidIndex;
        for (std::uint32_t p = 0; p < location_.size(); ++p)
            if (p != lowest &&
                (other == kInvalidIndex || orient(location_[lowest], beside, location_[other], location_[p]) > 0))
                other = p;
        if (other == kInvalidIndex || !wrapAt(lowest, other, kInvalidIndex)) return false;
        open_.push_back(0);
        return closeAll();
    }

    // Do the facets round each location follow one another, from the loop edge that arrives there to the one that
    // leaves, or all round?
    bool haveOneFanEach() {
        round_.assign(location_.size(), {});
        for (std::uint32_t f = 0; f < facets_.size(); ++f)
            for (std::uint32_t m = 0; m < 3; ++m) {
                Round& round = round_[facets_[f].location[nextCorner(m)]];
                ++round.facets;
                if (round.first == kInvalidIndex || passOf(facets_[f].beyond[m]) != kInvalidIndex) round.first = sideOf(f, m);
            }
        for (std::uint32_t v = 0; v < location_.size(); ++v) {
            const auto [facets, first] = round_[v];
            std::uint32_t side = first, passed = 0;
            for (bool again = isSide(side); again; again = isSide(side) && side != first) {
                side = facets_[facetOf(side)].beyond[nextCorner(cornerOf(side))];
                ++passed;
            }
            const std::uint32_t end = pass_at_[v] == kInvalidIndex ? first : kLoop + pass_at_[v];
            if (passed != facets || side != end) return false;
        }
        return true;
    }

    // The facets round the head of a side, from the one that it belongs to: how many, and the pass of the loop edge
    // behind which they end, kInvalidIndex where they go all round.
    struct Fan {
        std::uint32_t pass;
        std::size_t facets;
    };
    // rim_ becomes the rim of the fan, from the side's tail on, fan_ the facets' corners at its middle.
    std::optional<Fan> listFan(std::uint32_t side) {
        rim_.clear();
        fan_.clear();
        if (side == kInvalidIndex) return std::nullopt;
        rim_.push_back(tailOf(side));
        while (isSide(side) && fan_.size() <= facets_.size()) {
            Facet& facet = facets_[facetOf(side)];
            const std::uint32_t m = nextCorner(cornerOf(side));
            fan_.push_back(&facet.id[m]);
            rim_.push_back(facet.location[nextCorner(m)]);
            side = facet.beyond[m];
            if (passOf(side) != kInvalidIndex || rim_.back() == rim_.front()) return Fan{passOf(side), fan_.size()};
        }
        return std::nullopt;
    }

    // Gives each corner of each facet the point it stands for, one fan at a time.
    bool nameCorners() {
        before_pass_.assign(passes_.size(), kInvalidIndex);
        for (std::uint32_t p = 0; p < passes_.size(); ++p)
            if (passes_[p].next != kInvalidIndex) before_pass_[passes_[p].next] = p;
        arriving_for_.assign(passes_.size(), kInvalidIndex);
        std::size_t named = 0;
        for (std::uint32_t p = 0; p < passes_.size(); ++p) {
            const Pass& pass = passes_[p];
            if (pass.next == kInvalidIndex) continue;
            const std::uint32_t arriving = left_.at(passes_[before_pass_[p]].location, pass.location);
            const auto fan = listFan(arriving);
            if (!fan || fan->pass == kInvalidIndex || arriving_for_[fan->pass] != kInvalidIndex) return false;
            arriving_for_[fan->pass] = p;
            named += fan->facets;
            nameOpenFan(pass, passes_[fan->pass]);
        }
        joinPasses();
        done_.assign(location_.size(), 0);
        for (std::uint32_t f = 0; f < facets_.size(); ++f)
            for (std::uint32_t m = 0; m < 3; ++m) {
                if (facets_[f].id[m] != kInvalidIndex) continue;
                const std::uint32_t at = facets_[f].location[m], pass = pass_at_[at],
                                    side = sideOf(f, m == 0 ? 2 : m - 1);
                if (pass != kInvalidIndex && passes_[pass].next != kInvalidIndex) return false;  // a loop's point has one fan only
                if (done_[at]) return false;
                done_[at] = 1;
                const auto fan = listFan(side);
                if (!fan || fan->pass != kInvalidIndex) return false;
                named += fan->facets;
                nameClosedFan(at, pass == kInvalidIndex ? std::span(&point_at_[at], 1) : idsOf(passes_[pass]));
            }
        for (const Pass& pass : passes_)
            if (pass.next == kInvalidIndex && !done_[pass.location]) return false;
        return named == 3 * facets_.size();
    }

    // Between the edge that arrives with one pass and that which leaves with another: the same, as a rule.
    void nameOpenFan(const Pass& arriving, const Pass& leaving) {
        const auto ids = idsOf(arriving), last_ids = idsOf(leaving);
        const std::size_t part = fan_.size() == 1 ? 1 : fan_.size() / 2;
        for (std::size_t s = 0; s < fan_.size(); ++s) *fan_[s] = s < part ? ids.front() : last_ids.back();
        if (&arriving != &leaving)
            gaps_.push_back({arriving.location, rim_[part], {ids.front(), last_ids.back()}});
        else if (ids.size() > 1)
            gaps_.push_back({arriving.location, rim_[part], {ids.begin(), ids.end()}});
    }
    // Where loops come so close that their points share a location, the surface between them runs through it. What is
    // in the middle of such a passage is a polygon of all the points there.
    void joinPasses() {
        done_.assign(passes_.size(), 0);
        for (std::uint32_t p = 0; p < passes_.size(); ++p) {
            if (done_[p] || arriving_for_[p] == kInvalidIndex || arriving_for_[p] == p) continue;
            std::vector<std::uint32_t>& ring = passages_.emplace_back();
            for (std::uint32_t q = p; !done_[q]; q = arriving_for_[q]) {
                done_[q] = 1;
                const auto ids = idsOf(passes_[q]);
                ring.insert(ring.end(), ids.begin(), ids.end());
            }
        }
    }

    void nameClosedFan(std::uint32_t at, std::span<const std::uint32_t> ids) {
        const std::size_t part = fan_.size() / 2, half = ids.size() / 2;
        for (std::size_t s = 0; s < fan_.size(); ++s) *fan_[s] = s < part ? ids.front() : ids[half];
        if (ids.size() == 1) return;
        const auto middle = ids.begin() + static_cast<std::ptrdiff_t>(half);
        gaps_.push_back({at, rim_[part], {ids.begin(), middle + 1}});
        std::vector<std::uint32_t> back(middle, ids.end());
        back.push_back(ids.front());
        gaps_.push_back({at, rim_[0], back});
    }

    // facet_begin: where the facets begin among the triangles of the filling.
    void listAcross(std::uint32_t facet_begin, LoopFilling& out) const {
        out.across.assign(out.triangles.size(), {kInvalidIndex, kInvalidIndex, kInvalidIndex});
        for (std::uint32_t f = 0; f < facets_.size(); ++f)
            for (std::uint32_t m = 0; m < 3; ++m) {
                const std::uint32_t beyond = facets_[f].beyond[m];
                const bool meet = isSide(beyond) && (!contracted_ || haveSameEnds(sideOf(f, m), beyond));
                out.across[facet_begin + f][m] = meet ? facet_begin + facetOf(beyond) : kInvalidIndex;
            }
    }
    // Of points, not only of locations.
    bool haveSameEnds(std::uint32_t side, std::uint32_t twin) const {
        const Triangle &here = facets_[facetOf(side)].id, &there = facets_[facetOf(twin)].id;
        return here[cornerOf(side)] == there[nextCorner(cornerOf(twin))] &&
               here[nextCorner(cornerOf(side))] == there[cornerOf(twin)];
    }

    // A gap's chain p1 … pm is joined to the chain y1 … yn at the other end of the edge, mostly one point.
    void fillGaps(LoopFilling& out) {
        for (const std::vector<std::uint32_t>& ring : passages_)
            for (std::size_t k = 1; k + 1 < ring.size(); ++k) out.triangles.push_back({ring[0], ring[k], ring[k + 1]});
        const auto gapOf = [&](std::uint32_t location, std::uint32_t other) {
            const auto is = [&](const Gap& gap) { return gap.location == location && gap.other == other; };
            return static_cast<std::size_t>(std::find_if(gaps_.begin(), gaps_.end(), is) - gaps_.begin());
        };
        for (std::size_t g = 0; g < gaps_.size(); ++g) {
            const Gap& gap = gaps_[g];
            const std::size_t opposite = gapOf(gap.other, gap.location);
            if (opposite < g) continue;
            std::vector<std::uint32_t> other;
            if (opposite < gaps_.size()) {
                other = gaps_[opposite].chain;
            } else {
                const std::uint32_t side = left_.at(gap.location, gap.other);
                other = {facets_[facetOf(side)].id[nextCorner(cornerOf(side))]};
            }
            for (std::size_t s = 0; s + 1 < gap.chain.size(); ++s)
                out.triangles.push_back({gap.chain[s], gap.chain[s + 1], other.back()});
            for (std::size_t s = 0; s + 1 < other.size(); ++s)
                out.triangles.push_back({other[s], other[s + 1], gap.chain.back()});
        }
    }

    const LoopsOnSphere* loops_ = nullptr;
    std::int64_t contraction_ = 0;
    bool contracted_ = false;
    std::vector<std::uint32_t> location_of_;  // of each point
    std::vector<Vec3i> location_;
    std::vector<std::uint32_t> point_at_;  // the first point of each location, where some have several
    std::vector<std::vector<std::uint32_t>> circles_at_;
    std::vector<std::uint32_t> pass_at_, before_pass_, pass_id_;
    std::vector<Pass> passes_;
    HalfEdgeMap left_;
    std::vector<std::uint8_t> closed_, done_;
    std::vector<std::uint32_t> candidates_, candidate_at_, rim_;  // locations; of each of these, where it is among them
    Places point_place_, candidate_place_;
    RoughPlaces rough_place_;  // of candidates
    struct Round {
        std::uint32_t facets = 0, first = kInvalidIndex;  // the side that a fan begins with, at its head
    };
    std::vector<Round> round_;  // each location, where none has several points
    std::vector<std::uint32_t*> fan_;
    std::vector<std::uint32_t> open_;  // sides without a twin, which need one
    std::vector<Facet> facets_;
    std::vector<Gap> gaps_;
    std::vector<std::uint32_t> arriving_for_;  // of each pass: that whose fan ends where it leaves
    std::vector<std::vector<std::uint32_t>> passages_;
};

HullFiller::HullFiller() : work_(std::make_unique<Work>()) {}
HullFiller::~HullFiller() = default;

bool HullFiller::fill(const LoopsOnSphere& loops, LoopFilling& filling) {
    if (!loops.likely_facet.empty() && work_->run(loops, true, kContraction, filling)) return true;
    for (std::int64_t contraction = kContraction; contraction <= kLargestContraction; contraction *= 4)
        if (work_->run(loops, false, contraction, filling)) return true;
    return false;
}

LoopFilling fillWithFan(const LoopsOnSphere& loops, std::uint32_t first_loop, std::uint32_t last_loop) {
    LoopFilling filling;
    std::vector<std::uint32_t> ring;  // all loops joined so far
    for (std::uint32_t l = first_loop; l < last_loop; ++l) {
        std::vector<std::uint32_t> next(loops.loop_begin[l + 1] - loops.loop_begin[l]);
        std::iota(next.begin(), next.end(), loops.loop_begin[l]);
        if (!ring.empty()) {
            // a quad between the edges back -> front of both: what is left is one ring through all points
            filling.triangles.push_back({ring.back(), ring.front(), next.back()});
            filling.triangles.push_back({next.back(), next.front(), ring.back()});
        }
        ring.insert(ring.end(), next.begin(), next.end());
    }
    Vec3 middle(0, 0, 0);
    for (const std::uint32_t id : ring) middle += toDouble(loops.point[id]);
    middle = middle.length2() > 0 ? middle.normalized() * kRadius : toDouble(loops.point[ring[0]]);
    const auto centre = static_cast<std::uint32_t>(loops.point.size());
    filling.new_point.emplace_back(std::llround(middle.x), std::llround(middle.y), std::llround(middle.z));
    for (std::size_t k = 0; k < ring.size(); ++k)
        filling.triangles.push_back({ring[k], ring[(k + 1) % ring.size()], centre});
    return filling;
}

}  // namespace betamesh
