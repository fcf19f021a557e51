#include "skin/hull.h"

#include "skin/gift_wrap.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

namespace betamesh {

namespace {

// Distances along each axis below which points count as one, in 2^-38 radii: 1e-7 radii at first, at most 1e-3.
constexpr std::int64_t kContraction = 27488;
constexpr std::int64_t kLargestContraction = 1 << 28;

// A gap between the two facets on an edge, where the points at one end differ: the chain of points that fills it, from
// the facet with the edge location -> other to the one with the reverse edge.
struct Gap {
    std::uint32_t location, other;
    std::vector<std::uint32_t> chain;
};

}  // namespace

class HullFiller::Work {
public:
    bool run(const LoopsOnSphere& loops, bool with_likely_facets, std::int64_t contraction, LoopFilling& out) {
        out.triangles.clear();
        out.new_point.clear();
        out.across.clear();
        gaps_.clear();
        passages_.clear();
        if (!wrap_.run(loops, with_likely_facets, contraction, out)) return false;
        const bool contracted = wrap_.isContracted();
        if (contracted && !assignPoints()) return false;
        const auto facet_begin = static_cast<std::uint32_t>(out.triangles.size());
        for (const HullFacet& f : wrap_.facets()) out.triangles.push_back(contracted ? f.point : f.location);
        fillGaps(out);
        listAcross(facet_begin, out);
        return true;
    }

private:
    // The fan of facets round the head of a side: how many, and the pass of the loop edge beyond the last one;
    // kInvalidIndex if they go all the way round.
    struct Fan {
        std::uint32_t pass;
        std::size_t facets;
    };
    // Lists the fan that begins with the side's facet: fan_ gets the points of its facets' corners at the centre, rim_
    // the locations round it, from the side's tail on.
    std::optional<Fan> listFan(std::uint32_t side) {
        rim_.clear();
        fan_.clear();
        if (side == kInvalidIndex) return std::nullopt;
        rim_.push_back(wrap_.tailOf(side));
        while (isSide(side) && fan_.size() <= wrap_.facets().size()) {
            HullFacet& facet = wrap_.facets()[facetOf(side)];
            const std::uint32_t m = nextCorner(cornerOf(side));
            fan_.push_back(&facet.point[m]);
            rim_.push_back(facet.location[nextCorner(m)]);
            side = facet.beyond[m];
            if (passOf(side) != kInvalidIndex || rim_.back() == rim_.front()) return Fan{passOf(side), fan_.size()};
        }
        return std::nullopt;
    }

    // Assigns to each corner of each facet the point it stands for, one fan at a time. False if the fans are
    // inconsistent.
    bool assignPoints() {
        before_pass_.assign(wrap_.passes().size(), kInvalidIndex);
        for (std::uint32_t p = 0; p < wrap_.passes().size(); ++p)
            if (wrap_.passes()[p].next != kInvalidIndex) before_pass_[wrap_.passes()[p].next] = p;
        arriving_for_.assign(wrap_.passes().size(), kInvalidIndex);
        std::size_t assigned = 0;
        for (std::uint32_t p = 0; p < wrap_.passes().size(); ++p) {
            const LoopPass& pass = wrap_.passes()[p];
            if (pass.next == kInvalidIndex) continue;
            const std::uint32_t arriving = wrap_.leftOf(wrap_.passes()[before_pass_[p]].location, pass.location);
            const auto fan = listFan(arriving);
            if (!fan || fan->pass == kInvalidIndex || arriving_for_[fan->pass] != kInvalidIndex) return false;
            arriving_for_[fan->pass] = p;
            assigned += fan->facets;
            assignOpenFan(pass, wrap_.passes()[fan->pass]);
        }
        joinPasses();
        is_done_.assign(wrap_.locations(), 0);
        for (std::uint32_t f = 0; f < wrap_.facets().size(); ++f)
            for (std::uint32_t m = 0; m < 3; ++m) {
                if (wrap_.facets()[f].point[m] != kInvalidIndex) continue;
                const std::uint32_t at = wrap_.facets()[f].location[m], pass = wrap_.passAt(at),
                                    side = sideOf(f, m == 0 ? 2 : m - 1);
                if (pass != kInvalidIndex && wrap_.passes()[pass].next != kInvalidIndex)
                    return false;  // a location of a loop has one fan only
                if (is_done_[at]) return false;
                is_done_[at] = 1;
                const auto fan = listFan(side);
                if (!fan || fan->pass != kInvalidIndex) return false;
                assigned += fan->facets;
                assignClosedFan(at, pass == kInvalidIndex ? std::span(&wrap_.pointAt(at), 1)
                                                          : wrap_.pointsOf(wrap_.passes()[pass]));
            }
        for (const LoopPass& pass : wrap_.passes())
            if (pass.next == kInvalidIndex && !is_done_[pass.location]) return false;
        return assigned == 3 * wrap_.facets().size();
    }

    // Divides the fan between the loop edge that arrives with one pass and that which leaves with another (as a rule
    // the same) among the points of both.
    void assignOpenFan(const LoopPass& arriving, const LoopPass& leaving) {
        const auto points = wrap_.pointsOf(arriving), last_points = wrap_.pointsOf(leaving);
        const std::size_t part = fan_.size() == 1 ? 1 : fan_.size() / 2;
        for (std::size_t s = 0; s < fan_.size(); ++s) *fan_[s] = s < part ? points.front() : last_points.back();
        if (&arriving != &leaving)
            gaps_.push_back({arriving.location, rim_[part], {points.front(), last_points.back()}});
        else if (points.size() > 1)
            gaps_.push_back({arriving.location, rim_[part], {points.begin(), points.end()}});
    }
    // Where loops come so close that their points share a location, the surface between them runs through it: the
    // middle of such a passage is a polygon of all the points there.
    void joinPasses() {
        is_done_.assign(wrap_.passes().size(), 0);
        for (std::uint32_t p = 0; p < wrap_.passes().size(); ++p) {
            if (is_done_[p] || arriving_for_[p] == kInvalidIndex || arriving_for_[p] == p) continue;
            std::vector<std::uint32_t>& ring = passages_.emplace_back();
            for (std::uint32_t q = p; !is_done_[q]; q = arriving_for_[q]) {
                is_done_[q] = 1;
                const auto points = wrap_.pointsOf(wrap_.passes()[q]);
                ring.insert(ring.end(), points.begin(), points.end());
            }
        }
    }

    // Divides a fan that goes all the way round a location among its points.
    void assignClosedFan(std::uint32_t at, std::span<const std::uint32_t> points) {
        const std::size_t part = fan_.size() / 2, half = points.size() / 2;
        for (std::size_t s = 0; s < fan_.size(); ++s) *fan_[s] = s < part ? points.front() : points[half];
        if (points.size() == 1) return;
        const auto middle = points.begin() + static_cast<std::ptrdiff_t>(half);
        gaps_.push_back({at, rim_[part], {points.begin(), middle + 1}});
        std::vector<std::uint32_t> back(middle, points.end());
        back.push_back(points.front());
        gaps_.push_back({at, rim_[0], back});
    }

    // Sets LoopFilling::across. facet_begin: where the facets begin among the triangles of the filling.
    void listAcross(std::uint32_t facet_begin, LoopFilling& out) const {
        out.across.assign(out.triangles.size(), {kInvalidIndex, kInvalidIndex, kInvalidIndex});
        for (std::uint32_t f = 0; f < wrap_.facets().size(); ++f)
            for (std::uint32_t m = 0; m < 3; ++m) {
                const std::uint32_t beyond = wrap_.facets()[f].beyond[m];
                const bool meet = isSide(beyond) && (!wrap_.isContracted() || haveSameEnds(sideOf(f, m), beyond));
                out.across[facet_begin + f][m] = meet ? facet_begin + facetOf(beyond) : kInvalidIndex;
            }
    }
    // Do a side and its twin have the same points, and not only the same locations?
    bool haveSameEnds(std::uint32_t side, std::uint32_t twin) const {
        const Triangle &here = wrap_.facets()[facetOf(side)].point, &there = wrap_.facets()[facetOf(twin)].point;
        return here[cornerOf(side)] == there[nextCorner(cornerOf(twin))] &&
               here[nextCorner(cornerOf(side))] == there[cornerOf(twin)];
    }

    // Fills each gap's chain p1 … pm with triangles to the chain y1 … yn at the other end of the edge, mostly one
    // point.
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
                const std::uint32_t side = wrap_.leftOf(gap.location, gap.other);
                other = {wrap_.facets()[facetOf(side)].point[nextCorner(cornerOf(side))]};
            }
            for (std::size_t s = 0; s + 1 < gap.chain.size(); ++s)
                out.triangles.push_back({gap.chain[s], gap.chain[s + 1], other.back()});
            for (std::size_t s = 0; s + 1 < other.size(); ++s)
                out.triangles.push_back({other[s], other[s + 1], gap.chain.back()});
        }
    }

    GiftWrap wrap_;
    std::vector<std::uint32_t> before_pass_;   // of each pass: the one before it in its loop
    std::vector<std::uint32_t> arriving_for_;  // of each pass: the one whose fan ends at the loop edge that leaves it
    std::vector<std::uint8_t> is_done_;        // of each location or pass
    std::vector<std::uint32_t> rim_;           // locations
    std::vector<std::uint32_t*> fan_;
    std::vector<Gap> gaps_;
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
    std::vector<std::uint32_t> ring;  // the loops joined so far
    for (std::uint32_t l = first_loop; l < last_loop; ++l) {
        std::vector<std::uint32_t> next(loops.loop_begin[l + 1] - loops.loop_begin[l]);
        std::iota(next.begin(), next.end(), loops.loop_begin[l]);
        if (!ring.empty()) {
            // a quad between the edges back -> front of both leaves one ring through all points
            filling.triangles.push_back({ring.back(), ring.front(), next.back()});
            filling.triangles.push_back({next.back(), next.front(), ring.back()});
        }
        ring.insert(ring.end(), next.begin(), next.end());
    }
    Vec3 middle(0, 0, 0);
    for (const std::uint32_t p : ring) middle += toDouble(loops.point[p]);
    middle = middle.length2() > 0 ? middle.normalized() * kHullRadius : toDouble(loops.point[ring[0]]);
    const auto centre = static_cast<std::uint32_t>(loops.point.size());
    filling.new_point.emplace_back(std::llround(middle.x), std::llround(middle.y), std::llround(middle.z));
    for (std::size_t k = 0; k < ring.size(); ++k)
        filling.triangles.push_back({ring[k], ring[(k + 1) % ring.size()], centre});
    return filling;
}

}  // namespace betamesh
