#include "exact/bounded_hull.h"

#include "core/union_find.h"
#include "exact/predicates.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace betamesh {

namespace {

using Int = __int128;
constexpr std::uint32_t kNone = ~std::uint32_t{0};
constexpr double kContraction = 0x1p38 * 1e-7;
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

// The same when every point is lifted outwards by its own tiny amount, the lexicographically first by most:
// never 0 for four distinct points of a sphere.
int liftedOrient(const Vec3i& a, const Vec3i& b, const Vec3i& c, const Vec3i& p) {
    if (const int sign = orient(a, b, c, p)) return sign;
    const Vec3i& first = std::min({a, b, c, p}, before);
    if (first == p) return 1;
    if (first == a) return -sameTurn(a, b, c, p, b, c);
    if (first == b) return -sameTurn(a, b, c, a, p, c);
    return -sameTurn(a, b, c, a, b, p);
}

// A run of loop points that coincide, and what follows it in its loop.
struct Pass {
    std::uint32_t location;
    std::vector<std::uint32_t> ids;
    std::uint32_t next = kNone;  // pass; kNone where the whole loop is this one location
};

struct Facet {
    Triangle location;
    Triangle id;
};

// Where a location's points part the two facets on an edge: the chain of points that fills the gap, from the
// facet that has the edge location -> other to the one that has it backwards.
struct Gap {
    std::uint32_t location, other;
    std::vector<std::uint32_t> chain;
};

class Filler {
public:
    explicit Filler(const LoopsOnSphere& loops) : loops_(loops) {}

    bool run(LoopFilling& out) {
        contract();
        if (!makePasses(out) || !wrapAll() || !nameCorners()) return false;
        for (const Facet& f : facets_) out.triangles.push_back(f.id);
        fillGaps(out);
        return true;
    }

private:
    std::uint64_t key(std::uint32_t a, std::uint32_t b) const { return std::uint64_t{a} * location_.size() + b; }

    void contract() {
        const std::size_t n = loops_.point.size();
        UnionFind same(n);
        for (std::uint32_t a = 0; a < n; ++a)
            for (std::uint32_t b = 0; b < a; ++b) {
                const Vec3i d = loops_.point[a] - loops_.point[b];
                if (std::abs(static_cast<double>(d.x)) < kContraction &&
                    std::abs(static_cast<double>(d.y)) < kContraction &&
                    std::abs(static_cast<double>(d.z)) < kContraction)
                    same.join(a, b);
            }
        location_of_.resize(n);
        for (std::uint32_t a = 0; a < n; ++a) {
            if (same.find(a) == a) {
                location_of_[a] = static_cast<std::uint32_t>(location_.size());
                location_.push_back(loops_.point[a]);
            } else {
                location_of_[a] = location_of_[same.find(a)];
                Vec3i& place = location_[location_of_[a]];
                place = std::min(place, loops_.point[a], before);
            }
        }
        circles_at_.resize(location_.size());
        for (std::size_t a = 0; a < loops_.circles.size(); ++a)
            circles_at_[location_of_[a]].insert(circles_at_[location_of_[a]].end(), loops_.circles[a].begin(),
                                                loops_.circles[a].end());
    }

    bool makePasses(LoopFilling& out) {
        pass_at_.assign(location_.size(), kNone);
        for (std::size_t l = 0; l + 1 < loops_.loop_begin.size(); ++l) {
            const std::uint32_t begin = loops_.loop_begin[l], n = loops_.loop_begin[l + 1] - begin;
            const auto at = [&](std::uint32_t k) { return begin + k % n; };
            std::uint32_t start = 0;  // the first point of a run
            while (start < n && location_of_[at(start)] == location_of_[at(start + n - 1)]) ++start;
            const auto first = static_cast<std::uint32_t>(passes_.size());
            if (start == n) {
                if (!loops_.is_hole[l]) {
                    fillPoint(begin, n, out);
                    continue;
                }
                Pass pass{location_of_[begin], {}, kNone};
                for (std::uint32_t k = 0; k < n; ++k) pass.ids.push_back(at(k));
                if (pass_at_[pass.location] != kNone) return false;
                pass_at_[pass.location] = first;
                passes_.push_back(pass);
                continue;
            }
            for (std::uint32_t k = start; k < start + n; ++k) {
                const std::uint32_t id = at(k), location = location_of_[id];
                if (k == start || location != passes_.back().location) passes_.push_back({location, {}, 0});
                passes_.back().ids.push_back(id);
            }
            for (auto p = first; p < passes_.size(); ++p) {
                passes_[p].next = p + 1 < passes_.size() ? p + 1 : first;
                if (pass_at_[passes_[p].location] == kNone) pass_at_[passes_[p].location] = p;
            }
        }
        for (std::uint32_t p = 0; p < passes_.size(); ++p) {
            if (passes_[p].next == kNone) continue;
            const std::uint32_t a = passes_[p].location, b = passes_[passes_[p].next].location;
            if (!boundary_.emplace(key(a, b), p).second) return false;
        }
        for (const auto& [edge, pass] : boundary_) {
            const auto a = static_cast<std::uint32_t>(edge / location_.size()),
                       b = static_cast<std::uint32_t>(edge % location_.size());
            if (boundary_.contains(key(b, a))) return false;
        }
        return true;
    }

    // A face that has shrunk to a point.
    void fillPoint(std::uint32_t begin, std::uint32_t n, LoopFilling& out) const {
        if (n == 3) {
            out.triangles.push_back({begin, begin + 1, begin + 2});
            return;
        }
        const auto centre = static_cast<std::uint32_t>(loops_.point.size() + out.new_point.size());
        out.new_point.push_back(loops_.point[begin]);
        for (std::uint32_t k = 0; k < n; ++k) out.triangles.push_back({begin + k, begin + (k + 1) % n, centre});
    }

    // The location that sees all others below the plane through the edge a -> b and itself.
    std::uint32_t wrap(std::uint32_t a, std::uint32_t b, std::uint32_t circle) const {
        std::uint32_t best = kNone;
        for (std::uint32_t p = 0; p < location_.size(); ++p) {
            if (p == a || p == b) continue;
            if (circle != kNone &&
                std::find(circles_at_[p].begin(), circles_at_[p].end(), circle) != circles_at_[p].end())
                continue;
            if (best == kNone || liftedOrient(location_[a], location_[b], location_[best], location_[p]) > 0) best = p;
        }
        return best;
    }

    bool addFacet(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::vector<std::array<std::uint32_t, 2>>& open) {
        const auto f = static_cast<std::uint32_t>(facets_.size());
        facets_.push_back({{a, b, c}, {kNone, kNone, kNone}});
        const Triangle corner{a, b, c};
        for (std::size_t m = 0; m < 3; ++m) {
            const std::uint32_t from = corner[m], to = corner[(m + 1) % 3];
            if (!facet_of_.emplace(key(from, to), f).second) return false;
            if (boundary_.contains(key(to, from))) return false;
            if (!boundary_.contains(key(from, to)) && !facet_of_.contains(key(to, from))) open.push_back({to, from});
        }
        return facets_.size() <= 2 * location_.size() + 4;
    }

    using OpenEdges = std::vector<std::array<std::uint32_t, 2>>;

    bool wrapFrom(std::uint32_t a, std::uint32_t b, std::uint32_t circle, OpenEdges& open) {
        const std::uint32_t first = wrap(a, b, circle);
        if (first == kNone || !addFacet(a, b, first, open)) return false;
        while (!open.empty()) {
            const auto [from, to] = open.back();
            open.pop_back();
            if (facet_of_.contains(key(from, to))) continue;
            const std::uint32_t apex = wrap(from, to, kNone);
            if (apex == kNone || !addFacet(from, to, apex, open)) return false;
        }
        return true;
    }

    bool wrapAll() {
        OpenEdges open;
        bool any_edge = false;
        for (std::uint32_t p = 0; p < passes_.size(); ++p) {
            if (passes_[p].next == kNone) continue;
            any_edge = true;
            const std::uint32_t a = passes_[p].location, b = passes_[passes_[p].next].location;
            if (facet_of_.contains(key(a, b))) continue;
            if (!wrapFrom(a, b, loops_.circles[passes_[p].ids.back()][1], open)) return false;
        }
        if (any_edge || passes_.empty()) return true;
        // Nothing but points on the loops' side: the whole hull, from an edge at its lowest x.
        const auto lowest = static_cast<std::uint32_t>(std::min_element(location_.begin(), location_.end(), before) -
                                                       location_.begin());
        const Vec3i beside = location_[lowest] + Vec3i(0, 0, std::int64_t{1} << 38);
        std::uint32_t other = kNone;
        for (std::uint32_t p = 0; p < location_.size(); ++p)
            if (p != lowest &&
                (other == kNone || orient(location_[lowest], beside, location_[other], location_[p]) > 0))
                other = p;
        return other != kNone && wrapFrom(lowest, other, kNone, open);
    }

    // The corner of the facet on the left of from -> to, at `to`.
    std::uint32_t& cornerAt(std::uint32_t from, std::uint32_t to) {
        Facet& f = facets_[facet_of_.at(key(from, to))];
        for (std::size_t m = 0; m < 3; ++m)
            if (f.location[m] == to) return f.id[m];
        return f.id[0];
    }
    std::uint32_t apexOf(std::uint32_t from, std::uint32_t to) const {
        const Facet& f = facets_[facet_of_.at(key(from, to))];
        for (const std::uint32_t v : f.location)
            if (v != from && v != to) return v;
        return kNone;
    }

    // Walks the facets round `at`, from the one on the left of from -> at: the rim of the fan, from `from` on.
    // Ends behind a loop edge, or where it began.
    std::vector<std::uint32_t> rimOf(std::uint32_t from, std::uint32_t at) const {
        std::vector<std::uint32_t> rim{from};
        while (rim.size() <= facets_.size() + 1) {
            const std::uint32_t next = apexOf(rim.back(), at);
            rim.push_back(next);
            if (boundary_.contains(key(at, next)) || next == from) break;
        }
        return rim;
    }

    // Gives each corner of each facet the point it stands for, one fan at a time.
    bool nameCorners() {
        std::vector<std::uint32_t> before_pass(passes_.size(), kNone);
        for (std::uint32_t p = 0; p < passes_.size(); ++p)
            if (passes_[p].next != kNone) before_pass[passes_[p].next] = p;
        std::size_t named = 0;
        for (std::uint32_t p = 0; p < passes_.size(); ++p) {
            if (passes_[p].next == kNone) continue;
            const std::uint32_t at = passes_[p].location;
            const auto rim = rimOf(passes_[before_pass[p]].location, at);
            const auto end = boundary_.find(key(at, rim.back()));
            if (end == boundary_.end() || end->second != p) return false;
            named += rim.size() - 1;
            nameOpenFan(passes_[p], rim);
        }
        for (const Facet& f : facets_)
            for (std::size_t m = 0; m < 3; ++m) {
                if (f.id[m] != kNone) continue;
                const std::uint32_t at = f.location[m], from = f.location[(m + 2) % 3];
                const auto rim = rimOf(from, at);
                if (rim.back() != from) return false;
                const std::uint32_t pass = pass_at_[at];
                if (pass != kNone && passes_[pass].next != kNone) return false;  // a loop's point has one fan only
                if (!done_.emplace(at, true).second) return false;
                named += rim.size() - 1;
                nameClosedFan(at, rim);
            }
        for (const Pass& pass : passes_)
            if (pass.next == kNone && !done_.contains(pass.location)) return false;
        return named == 3 * facets_.size();
    }

    void nameOpenFan(const Pass& pass, const std::vector<std::uint32_t>& rim) {
        const std::size_t facets = rim.size() - 1, part = facets == 1 ? 1 : facets / 2;
        for (std::size_t s = 0; s < facets; ++s)
            cornerAt(rim[s], pass.location) = s < part ? pass.ids.front() : pass.ids.back();
        if (pass.ids.size() > 1) gaps_.push_back({pass.location, rim[part], pass.ids});
    }

    void nameClosedFan(std::uint32_t at, const std::vector<std::uint32_t>& rim) {
        const std::size_t facets = rim.size() - 1, part = facets / 2;
        std::vector<std::uint32_t> ids;
        if (pass_at_[at] != kNone)
            ids = passes_[pass_at_[at]].ids;
        else
            ids = {static_cast<std::uint32_t>(std::find(location_of_.begin(), location_of_.end(), at) -
                                              location_of_.begin())};
        const std::size_t half = ids.size() / 2;
        for (std::size_t s = 0; s < facets; ++s) cornerAt(rim[s], at) = s < part ? ids.front() : ids[half];
        if (ids.size() == 1) return;
        const auto middle = ids.begin() + static_cast<std::ptrdiff_t>(half);
        gaps_.push_back({at, rim[part], {ids.begin(), middle + 1}});
        std::vector<std::uint32_t> back(middle, ids.end());
        back.push_back(ids.front());
        gaps_.push_back({at, rim[0], back});
    }

    // A gap's chain p1 … pm is joined to the chain y1 … yn at the other end of the edge, mostly one point.
    void fillGaps(LoopFilling& out) {
        std::unordered_map<std::uint64_t, std::size_t> gap_at;
        for (std::size_t g = 0; g < gaps_.size(); ++g) gap_at.emplace(key(gaps_[g].location, gaps_[g].other), g);
        for (std::size_t g = 0; g < gaps_.size(); ++g) {
            const Gap& gap = gaps_[g];
            const auto opposite = gap_at.find(key(gap.other, gap.location));
            if (opposite != gap_at.end() && opposite->second < g) continue;
            std::vector<std::uint32_t> other;
            if (opposite != gap_at.end())
                other = gaps_[opposite->second].chain;
            else
                other = {cornerAt(gap.location, gap.other)};
            for (std::size_t s = 0; s + 1 < gap.chain.size(); ++s)
                out.triangles.push_back({gap.chain[s], gap.chain[s + 1], other.back()});
            for (std::size_t s = 0; s + 1 < other.size(); ++s)
                out.triangles.push_back({other[s], other[s + 1], gap.chain.back()});
        }
    }

    const LoopsOnSphere& loops_;
    std::vector<std::uint32_t> location_of_;
    std::vector<Vec3i> location_;
    std::vector<std::vector<std::uint32_t>> circles_at_;
    std::vector<std::uint32_t> pass_at_;
    std::vector<Pass> passes_;
    std::unordered_map<std::uint64_t, std::uint32_t> boundary_;  // loop edge -> pass at its tail
    std::unordered_map<std::uint64_t, std::uint32_t> facet_of_;  // directed edge -> facet on its left
    std::unordered_map<std::uint32_t, bool> done_;
    std::vector<Facet> facets_;
    std::vector<Gap> gaps_;
};

}  // namespace

std::optional<LoopFilling> fillWithHull(const LoopsOnSphere& loops) {
    LoopFilling filling;
    if (!Filler(loops).run(filling)) return std::nullopt;
    return filling;
}

LoopFilling fillWithFan(const LoopsOnSphere& loops, const std::vector<std::uint32_t>& loops_of_face) {
    LoopFilling filling;
    std::vector<std::uint32_t> ring;  // all loops joined so far
    for (const std::uint32_t l : loops_of_face) {
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
