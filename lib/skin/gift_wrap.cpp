#include "skin/gift_wrap.h"

#include "base/union_find.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace betamesh {

namespace {

// How many of the first n points are not surely below a plane.
BETAMESH_EVERY_CPU
std::int64_t countNotBelow(const PointColumns& points, std::size_t n, const HullPlane& plane) {
    const double *const x = points.x.data(), *const y = points.y.data(), *const z = points.z.data();
    const double ox = plane.origin.x, oy = plane.origin.y, oz = plane.origin.z;
    const double nx = plane.normal.x, ny = plane.normal.y, nz = plane.normal.z, below = -plane.bound;
    std::int64_t count = 0;
    for (std::size_t i = 0; i < n; ++i) count += (x[i] - ox) * nx + (y[i] - oy) * ny + (z[i] - oz) * nz < below ? 0 : 1;
    return count;
}

// How many points from `first` on are less than `distance` away from this one along every axis.
BETAMESH_EVERY_CPU
std::int64_t countNear(const PointColumns& points, std::size_t first, const Vec3& here, double distance) {
    const double *const x = points.x.data(), *const y = points.y.data(), *const z = points.z.data();
    const std::size_t n = points.size();
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

bool GiftWrap::run(const LoopsOnSphere& loops, bool with_likely_facets, std::int64_t contraction, LoopFilling& out) {
    loops_ = &loops;
    contraction_ = contraction;
    passes_.clear();
    pass_point_.clear();
    facets_.clear();
    open_.clear();
    contract();
    half_edges_.clear(3 * mostFacets() + loops.circles.size());
    if (!makePasses(out) || (with_likely_facets && !addLikelyFacets())) return false;
    listCandidates();
    return wrapAll() && (contracted_ || haveOneFanEach());
}

// Joins points that coincide into locations. Free points never coincide with each other.
void GiftWrap::contract() {
    const std::size_t n = loops_->point.size(), in_loops = loops_->circles.size();
    point_columns_.clear();
    for (const Vec3i& p : loops_->point) point_columns_.add(toDouble(p));
    const auto near = [&](std::uint32_t a, std::uint32_t b) {
        const Vec3i d = loops_->point[a] - loops_->point[b];
        return std::abs(d.x) < contraction_ && std::abs(d.y) < contraction_ && std::abs(d.z) < contraction_;
    };
    location_of_.resize(n);
    std::iota(location_of_.begin(), location_of_.end(), 0U);
    location_ = loops_->point;
    contracted_ = false;
    for (std::size_t a = 0; a < in_loops && !contracted_; ++a)
        contracted_ = countNear(point_columns_, a + 1, point_columns_.at(a), static_cast<double>(contraction_)) > 0;
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
            Vec3i& lowest = location_[location_of_[a]];
            lowest = std::min(lowest, loops_->point[a], before);
        }
    }
    circles_at_.assign(location_.size(), {});
    for (std::size_t a = 0; a < in_loops; ++a)
        circles_at_[location_of_[a]].insert(circles_at_[location_of_[a]].end(), loops_->circles[a].begin(),
                                            loops_->circles[a].end());
}

bool GiftWrap::onCircle(std::uint32_t location, std::uint32_t circle) const {
    if (contracted_)
        return std::find(circles_at_[location].begin(), circles_at_[location].end(), circle) !=
               circles_at_[location].end();
    return location < loops_->circles.size() &&
           (loops_->circles[location][0] == circle || loops_->circles[location][1] == circle);
}

// Lists the passes of all loops, and fills loops that have shrunk to a point. False if two loops share an edge.
bool GiftWrap::makePasses(LoopFilling& out) {
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
            for (std::uint32_t k = 0; k < n; ++k) addPassPoint(at(k));
            continue;
        }
        for (std::uint32_t k = start; k < start + n; ++k) {
            const std::uint32_t point = at(k), location = location_of_[point];
            if (k == start || location != passes_.back().location) addPass(location, 0);
            addPassPoint(point);
        }
        for (auto p = first; p < passes_.size(); ++p) {
            passes_[p].next = p + 1 < passes_.size() ? p + 1 : first;
            if (pass_at_[passes_[p].location] == kInvalidIndex) pass_at_[passes_[p].location] = p;
        }
    }
    for (std::uint32_t p = 0; p < passes_.size(); ++p) {
        if (passes_[p].next == kInvalidIndex) continue;
        const std::uint32_t a = passes_[p].location, b = passes_[passes_[p].next].location;
        if (half_edges_.at(a, b) != kInvalidIndex || !half_edges_.put(b, a, kBeyondLoop + p)) return false;
    }
    return true;
}

// Fills a loop that has shrunk to a point and surrounds nothing.
void GiftWrap::fillPoint(std::uint32_t begin, std::uint32_t n, LoopFilling& out) const {
    if (n == 3) {
        out.triangles.push_back({begin, begin + 1, begin + 2});
        return;
    }
    const auto centre = static_cast<std::uint32_t>(loops_->point.size() + out.new_point.size());
    out.new_point.push_back(loops_->point[begin]);
    for (std::uint32_t k = 0; k < n; ++k) out.triangles.push_back({begin + k, begin + (k + 1) % n, centre});
}

// Adds the likely facets that are facets. False if they do not fit together.
bool GiftWrap::addLikelyFacets() {
    const std::size_t in_loops = loops_->circles.size();
    for (const Triangle& t : loops_->likely_facet) {
        const Triangle at{location_of_[t[0]], location_of_[t[1]], location_of_[t[2]]};
        const HullPlane plane = planeThrough(at[0], at[1], at[2]);
        const auto isBelow = [&](std::size_t p) { return plane.sideOf(point_columns_.at(p)) == HullPlane::below; };
        const bool below = std::all_of(loops_->perhaps_above.begin(), loops_->perhaps_above.end(), isBelow) &&
                           countNotBelow(point_columns_, in_loops, plane) == 0;
        if (below && !addFacet(at[0], at[1], at[2])) return false;
    }
    for (std::uint32_t f = 0; f < facets_.size(); ++f)
        for (std::uint32_t m = 0; m < 3; ++m)
            if (facets_[f].beyond[m] == kInvalidIndex) open_.push_back(sideOf(f, m));
    return true;
}

// Lists the locations that facets may still be found at: all but those that facets surround already.
void GiftWrap::listCandidates() {
    candidates_.clear();
    is_closed_.assign(location_.size(), 0);
    for (const HullFacet& f : facets_)
        for (const std::uint32_t v : f.location) is_closed_[v] = 1;
    for (const std::uint32_t side : open_) is_closed_[tailOf(side)] = is_closed_[headOf(side)] = 0;
    for (std::uint32_t p = 0; p < location_.size(); ++p)
        if (!is_closed_[p]) candidates_.push_back(p);
    candidate_at_.resize(location_.size());
    candidate_columns_.clear();
    for (std::uint32_t k = 0; k < candidates_.size(); ++k) {
        candidate_at_[candidates_[k]] = k;
        candidate_columns_.add(toDouble(location_[candidates_[k]]));
    }
    candidate_floats_.assign(candidate_columns_);
}

// The location p for which no other lies above the triangle a, b, p; without those on a circle, if one is given.
std::uint32_t GiftWrap::wrap(std::uint32_t a, std::uint32_t b, std::uint32_t circle) const {
    const auto allowed = [&](std::uint32_t p) {
        return p != a && p != b && (circle == kInvalidIndex || !onCircle(p, circle));
    };
    std::size_t k = 0;
    while (k < candidates_.size() && !allowed(candidates_[k])) ++k;
    if (k == candidates_.size()) return kInvalidIndex;
    std::uint32_t best = candidates_[k];
    HullPlane plane = planeThrough(a, b, best);
    for (++k; k < candidates_.size(); ++k) {
        const HullPlane::Side side = plane.sideOf(candidate_columns_.at(k));
        if (side == HullPlane::below) continue;
        const std::uint32_t p = candidates_[k];
        if (!allowed(p)) continue;
        if (side == HullPlane::unsure && liftedOrient(location_[a], location_[b], location_[best], location_[p]) <= 0)
            continue;
        best = p;
        plane = planeThrough(a, b, best);
    }
    return best;
}

// The same for the edge beyond a facet's side, from its head a to its tail b, if floats find the location and all
// others are surely below; otherwise kInvalidIndex.
std::uint32_t GiftWrap::wrapQuickly(std::uint32_t side) const {
    const std::uint32_t a = headOf(side), b = tailOf(side);
    const auto& [u, v, w] = facets_[facetOf(side)].location;
    const HullPlane facet = planeThrough(u, v, w);
    const Vec3 origin = toDouble(location_[a]), edge = toDouble(location_[b]) - origin;
    const Vec3 normal = facet.normal / (kHullRadius * kHullRadius);
    float found = 0;
    onThisCpu(FirstPointTurnedTo{candidate_floats_,
                                 Vec3f(origin / kHullRadius),
                                 Vec3f(normal),
                                 Vec3f(cross(normal, edge / kHullRadius)),
                                 {static_cast<float>(candidate_at_[a]), static_cast<float>(candidate_at_[b])},
                                 found});
    const auto best = static_cast<std::size_t>(found);
    if (best >= candidates_.size()) return kInvalidIndex;
    const HullPlane plane(origin, origin + edge, candidate_columns_.at(best));
    constexpr std::int64_t kOnPlane = 3;  // a, b and the location found
    return countNotBelow(candidate_columns_, candidate_columns_.size(), plane) == kOnPlane ? candidates_[best]
                                                                                           : kInvalidIndex;
}

bool GiftWrap::addFacet(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    if (facets_.size() == mostFacets()) return false;
    const auto f = static_cast<std::uint32_t>(facets_.size());
    HullFacet& facet = facets_.emplace_back();
    facet.location = {a, b, c};
    for (std::uint32_t m = 0; m < 3; ++m) {
        const std::uint32_t from = facet.location[m], to = facet.location[nextCorner(m)];
        if (from == to || !half_edges_.put(from, to, sideOf(f, m))) return false;
        const std::uint32_t beyond = facet.beyond[m] = half_edges_.at(to, from);
        if (isSide(beyond)) facets_[facetOf(beyond)].beyond[cornerOf(beyond)] = sideOf(f, m);
    }
    return true;
}

bool GiftWrap::wrapAt(std::uint32_t from, std::uint32_t to, std::uint32_t circle) {
    return closeWith(from, to, wrap(from, to, circle));
}

bool GiftWrap::wrapBeyond(std::uint32_t side) {
    const std::uint32_t from = headOf(side), to = tailOf(side), apex = wrapQuickly(side);
    return closeWith(from, to, apex != kInvalidIndex ? apex : wrap(from, to, kInvalidIndex));
}

bool GiftWrap::closeWith(std::uint32_t from, std::uint32_t to, std::uint32_t apex) {
    if (apex == kInvalidIndex || !addFacet(from, to, apex)) return false;
    for (const std::uint32_t m : {1U, 2U})
        if (facets_.back().beyond[m] == kInvalidIndex)
            open_.push_back(sideOf(static_cast<std::uint32_t>(facets_.size() - 1), m));
    return true;
}

bool GiftWrap::closeAll() {
    while (!open_.empty()) {
        const std::uint32_t side = open_.back();
        open_.pop_back();
        if (facets_[facetOf(side)].beyond[cornerOf(side)] == kInvalidIndex && !wrapBeyond(side)) return false;
    }
    return true;
}

bool GiftWrap::wrapAll() {
    bool any_edge = !open_.empty();
    if (!closeAll()) return false;
    for (const LoopPass& pass : passes_) {
        if (pass.next == kInvalidIndex) continue;
        any_edge = true;
        const std::uint32_t a = pass.location, b = passes_[pass.next].location;
        if (half_edges_.at(a, b) != kInvalidIndex) continue;
        if (!wrapAt(a, b, loops_->circles[pointsOf(pass).back()][1]) || !closeAll()) return false;
    }
    if (any_edge || passes_.empty()) return true;
    // Free points and isolated contacts only: the whole hull, starting from an edge at its lowest x.
    const auto lowest =
        static_cast<std::uint32_t>(std::min_element(location_.begin(), location_.end(), before) - location_.begin());
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

// Do the facets round each location form one fan, from the loop edge that arrives there to the one that leaves, or
// all the way round? For locations of one point each.
bool GiftWrap::haveOneFanEach() {
    fan_start_.assign(location_.size(), {});
    for (std::uint32_t f = 0; f < facets_.size(); ++f)
        for (std::uint32_t m = 0; m < 3; ++m) {
            FanStart& start = fan_start_[facets_[f].location[nextCorner(m)]];
            ++start.facets;
            if (start.first == kInvalidIndex || passOf(facets_[f].beyond[m]) != kInvalidIndex)
                start.first = sideOf(f, m);
        }
    for (std::uint32_t v = 0; v < location_.size(); ++v) {
        const auto [facets, first] = fan_start_[v];
        std::uint32_t side = first, passed = 0;
        for (bool again = isSide(side); again; again = isSide(side) && side != first) {
            side = facets_[facetOf(side)].beyond[nextCorner(cornerOf(side))];
            ++passed;
        }
        const std::uint32_t end = pass_at_[v] == kInvalidIndex ? first : kBeyondLoop + pass_at_[v];
        if (passed != facets || side != end) return false;
    }
    return true;
}

}  // namespace betamesh
