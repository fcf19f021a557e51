// Gift wrapping of points on a sphere from loops inwards. Internal to the hull.

#pragma once

#include "base/index.h"
#include "skin/hull_geometry.h"
#include "skin/sphere_loops.h"

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

namespace betamesh {

/// A run of consecutive loop points at one location.
struct LoopPass {
    std::uint32_t location;
    std::uint32_t first_point, points;   // in GiftWrap's list of the points of passes
    std::uint32_t next = kInvalidIndex;  // next pass of the loop; kInvalidIndex if all of it is here
};

/// A facet of the hull. A side runs from one corner to the next. Beyond it is its twin, the side that runs back, or, if
/// it is part of a loop, the pass at its tail.
struct HullFacet {
    Triangle location;
    Triangle point{kInvalidIndex, kInvalidIndex, kInvalidIndex};  // of each corner; set where some share a location
    Triangle beyond{kInvalidIndex, kInvalidIndex, kInvalidIndex};
};

// Sides as one number: facet and first corner.
constexpr std::uint32_t sideOf(std::uint32_t facet, std::uint32_t corner) { return facet << 2 | corner; }
constexpr std::uint32_t facetOf(std::uint32_t side) { return side >> 2; }
constexpr std::uint32_t cornerOf(std::uint32_t side) { return side & 3; }
constexpr std::uint32_t nextCorner(std::uint32_t corner) { return corner == 2 ? 0 : corner + 1; }

// What is beyond a side as one number: kInvalidIndex, a side, or from kBeyondLoop on a pass.
inline constexpr std::uint32_t kBeyondLoop = std::uint32_t{1} << 31;
constexpr bool isSide(std::uint32_t beyond) { return beyond < kBeyondLoop; }
constexpr std::uint32_t passOf(std::uint32_t beyond) {
    return beyond == kInvalidIndex || isSide(beyond) ? kInvalidIndex : beyond - kBeyondLoop;
}

/// A hash table, with open addressing, from half-edges between locations to what lies on their left: a side of a facet
/// or, outside a loop, a pass.
class HalfEdgeMap {
public:
    /// Makes room for `count` half-edges.
    void clear(std::size_t count) {
        const std::size_t slots = std::bit_ceil(2 * count + 2);
        shift_ = 64 - std::countr_zero(slots);
        key_.assign(slots, kFree);
        left_.resize(slots);
    }
    /// What is on the left; kInvalidIndex if unknown.
    std::uint32_t at(std::uint32_t from, std::uint32_t to) const {
        const std::size_t slot = slotOf(from, to);
        return key_[slot] == kFree ? kInvalidIndex : left_[slot];
    }
    /// False if it is known already.
    bool put(std::uint32_t from, std::uint32_t to, std::uint32_t left) {
        const std::size_t slot = slotOf(from, to);
        if (key_[slot] != kFree) return false;
        key_[slot] = keyOf(from, to);
        left_[slot] = left;
        return true;
    }

private:
    static constexpr std::uint64_t kFree = ~std::uint64_t{0};
    static std::uint64_t keyOf(std::uint32_t from, std::uint32_t to) { return std::uint64_t{from} << 32 | to; }
    // The slot of a half-edge, or the free one where it belongs.
    std::size_t slotOf(std::uint32_t from, std::uint32_t to) const {
        constexpr std::uint64_t kSpread = 0x9E3779B97F4A7C15;  // 2^64 / golden ratio
        const std::uint64_t key = keyOf(from, to);
        std::size_t slot = (key ^ key >> 29) * kSpread >> shift_;
        while (key_[slot] != kFree && key_[slot] != key) slot = slot + 1 < key_.size() ? slot + 1 : 0;
        return slot;
    }

    int shift_ = 63;
    std::vector<std::uint64_t> key_;
    std::vector<std::uint32_t> left_;
};

/// Finds the facets of the convex hull of points that lie to the left of some loops. Points that coincide are joined
/// into locations: the facets are triangles of locations. Keeps its memory from one run to the next.
class GiftWrap {
public:
    /// in      with_likely_facets: whether to use LoopsOnSphere::likely_facet; contraction: points closer than this
    ///         along every axis coincide
    /// out     false if no consistent hull is found; fillings of loops that have shrunk to a point are added to `out`
    bool run(const LoopsOnSphere& loops, bool with_likely_facets, std::int64_t contraction, LoopFilling& out);

    /// Do some points share a location? Otherwise point and location numbers are the same.
    bool isContracted() const { return contracted_; }
    std::size_t locations() const { return location_.size(); }
    /// The first point of a location, where some share one.
    const std::uint32_t& pointAt(std::uint32_t location) const { return point_at_[location]; }
    /// The first pass at a location; kInvalidIndex if there is none.
    std::uint32_t passAt(std::uint32_t location) const { return pass_at_[location]; }
    const std::vector<LoopPass>& passes() const { return passes_; }
    std::span<const std::uint32_t> pointsOf(const LoopPass& pass) const {
        return std::span(pass_point_).subspan(pass.first_point, pass.points);
    }
    std::vector<HullFacet>& facets() { return facets_; }
    const std::vector<HullFacet>& facets() const { return facets_; }
    /// The side or pass to the left of a half-edge.
    std::uint32_t leftOf(std::uint32_t from, std::uint32_t to) const { return half_edges_.at(from, to); }
    std::uint32_t tailOf(std::uint32_t side) const { return facets_[facetOf(side)].location[cornerOf(side)]; }
    std::uint32_t headOf(std::uint32_t side) const {
        return facets_[facetOf(side)].location[nextCorner(cornerOf(side))];
    }

private:
    struct FanStart {
        std::uint32_t facets = 0, first = kInvalidIndex;  // number of facets, and the side at whose head the fan begins
    };

    void contract();
    bool onCircle(std::uint32_t location, std::uint32_t circle) const;
    bool makePasses(LoopFilling& out);
    void fillPoint(std::uint32_t begin, std::uint32_t n, LoopFilling& out) const;
    bool addLikelyFacets();
    void listCandidates();
    std::uint32_t wrap(std::uint32_t a, std::uint32_t b, std::uint32_t circle) const;
    std::uint32_t wrapQuickly(std::uint32_t side) const;
    bool addFacet(std::uint32_t a, std::uint32_t b, std::uint32_t c);
    bool wrapAt(std::uint32_t from, std::uint32_t to, std::uint32_t circle);
    bool wrapBeyond(std::uint32_t side);
    bool closeWith(std::uint32_t from, std::uint32_t to, std::uint32_t apex);
    bool closeAll();
    bool wrapAll();
    bool haveOneFanEach();
    std::size_t mostFacets() const { return 2 * location_.size() + 4; }
    HullPlane planeThrough(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
        return {toDouble(location_[a]), toDouble(location_[b]), toDouble(location_[c])};
    }
    void addPass(std::uint32_t location, std::uint32_t next) {
        passes_.push_back({location, static_cast<std::uint32_t>(pass_point_.size()), 0, next});
    }
    void addPassPoint(std::uint32_t point) {
        pass_point_.push_back(point);
        ++passes_.back().points;
    }

    const LoopsOnSphere* loops_ = nullptr;
    std::int64_t contraction_ = 0;
    bool contracted_ = false;
    std::vector<std::uint32_t> location_of_;  // of each point
    std::vector<Vec3i> location_;             // the lexicographically first of its points
    std::vector<std::uint32_t> point_at_;
    std::vector<std::vector<std::uint32_t>> circles_at_;  // of each location, where some points share one
    std::vector<std::uint32_t> pass_at_, pass_point_;
    std::vector<LoopPass> passes_;
    HalfEdgeMap half_edges_;
    std::vector<std::uint8_t> is_closed_;                   // of each location: surrounded by facets
    std::vector<std::uint32_t> candidates_, candidate_at_;  // locations, and the row of each location among them
    PointColumns point_columns_, candidate_columns_;
    FloatColumns candidate_floats_;
    std::vector<FanStart> fan_start_;  // of each location
    std::vector<std::uint32_t> open_;  // sides that still need a facet beyond
    std::vector<HullFacet> facets_;
};

}  // namespace betamesh
