
#include "mesh/jump_sites.h"

#include "base/cell_order.h"
#include "base/union_find.h"
#include "mesh/enclosure.h"
#include "mesh/local_topology.h"

#include <algorithm>
#include <array>

namespace betamesh {

namespace {

constexpr int kCuts = 8;               // distances at which the surroundings of a site are cut out, besides the jump's
constexpr double kFarthest = 2.0 / 3;  // of the jump: only points farther than this decide whether liquid came or went
constexpr double kBothFrom = 1.0 / 3;  // of those points' area: the smaller of gain and loss is ignored below this

// Clusters of points no farther apart than `reach`: rows of `far`, clusters in the order of their first points.
std::vector<std::vector<std::uint32_t>> clustersOf(const std::vector<FarPoint>& far, double reach) {
    const auto positionOf = [&](std::size_t row) { return far[row].position; };
    const CellOrder cells(far.size(), reach, positionOf);
    UnionFind groups(far.size());
    for (std::uint32_t i = 0; i < far.size(); ++i) {
        const Vec3 p = positionOf(i);
        cells.forRowsIn(p - Vec3(reach), p + Vec3(reach), [&](std::uint32_t j) {
            if (j < i && (p - positionOf(j)).length2() <= reach * reach) groups.join(i, j);
        });
    }
    std::vector<std::vector<std::uint32_t>> clusters;
    std::vector<std::size_t> cluster(far.size());
    for (std::uint32_t i = 0; i < far.size(); ++i) {
        const std::uint32_t first = groups.find(i);
        if (first == i) {
            cluster[i] = clusters.size();
            clusters.emplace_back();
        }
        clusters[cluster[first]].push_back(i);
    }
    return clusters;
}

// For every point: true if liquid appeared there, false if it disappeared.
std::vector<bool> liquidAppeared(const Mesh& before, const Mesh& after, const std::vector<FarPoint>& far) {
    std::array<std::vector<Vec3>, 2> points;
    for (const FarPoint& p : far) points[p.after].push_back(p.position);
    const std::array outside{distancesOutside(after, {}, points[0]), distancesOutside(before, {}, points[1])};
    std::vector<bool> appeared;
    std::array<std::size_t, 2> next{0, 0};
    for (const FarPoint& p : far) appeared.push_back((outside[p.after][next[p.after]++] > 0) == p.after);
    return appeared;
}

// LocalTopology after minus before.
struct TopologyChange {
    std::int64_t euler = 0, patches = 0, outer_surfaces = 0, voids = 0;
    bool operator==(const TopologyChange&) const = default;
};

// The change on which most cuts agree, at least two, among those with equally many rims in both meshes. Cuts that pass
// through features of only one of the meshes rarely have equally many, and disagree with each other.
std::optional<TopologyChange> changeNear(const std::vector<Vec3>& points, double jump, double reach,
                                         const LocalTopologyQuery& before, const LocalTopologyQuery& after) {
    std::vector<double> distances;
    for (int k = 0; k <= kCuts; ++k) distances.push_back(jump + std::max(jump, reach) * k / kCuts);
    const std::vector<LocalTopology> was = before.near(points, distances), is = after.near(points, distances);
    std::vector<std::pair<TopologyChange, int>> votes;
    for (std::size_t k = 0; k < distances.size(); ++k) {
        if (!was[k].closed || !is[k].closed || was[k].rims != is[k].rims) continue;
        const TopologyChange change{is[k].euler - was[k].euler, is[k].patches - was[k].patches,
                                    is[k].outer_surfaces - was[k].outer_surfaces, is[k].voids - was[k].voids};
        const auto same =
            std::find_if(votes.begin(), votes.end(), [&](const auto& vote) { return vote.first == change; });
        if (same == votes.end())
            votes.emplace_back(change, 1);
        else
            ++same->second;
    }
    const auto most =
        std::max_element(votes.begin(), votes.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
    if (most == votes.end() || most->second < 2) return std::nullopt;
    return most->first;
}

// A sphere that appears or vanishes changes the Euler characteristic by two; so does a tube that replaces two discs, or
// the reverse. Components that merge or split elsewhere, and have one patch here before and after, do not count.
std::vector<std::pair<SurfaceEvent, std::size_t>> eventsOf(const TopologyChange& change, LiquidChange liquid) {
    using enum SurfaceEvent;
    if (change.euler == 0 && change.patches == 0) return {};
    struct Kinds {
        SurfaceEvent of_void, of_outer_surface, of_neither;
    };
    const bool more = change.euler > 0;
    const Kinds kinds = liquid == LiquidChange::gained ? (more ? Kinds{void_closed_off, piece_appeared, hole_closed}
                                                               : Kinds{void_vanished, pieces_joined, neck_formed})
                                                       : (more ? Kinds{void_appeared, pieces_parted, neck_broke}
                                                               : Kinds{void_opened, piece_vanished, hole_opened});
    const std::int64_t sign = more ? 1 : -1, patches = sign * change.patches, times = sign * change.euler / 2;
    std::int64_t voids = sign * change.voids, outer_surfaces = sign * change.outer_surfaces;
    if (voids + outer_surfaces > patches) voids = outer_surfaces = 0;
    if (liquid == LiquidChange::both || change.euler % 2 != 0 || times == 0 || voids < 0 || outer_surfaces < 0 ||
        voids + outer_surfaces > times)
        return {{several, 1}};
    std::vector<std::pair<SurfaceEvent, std::size_t>> events;
    const auto add = [&](SurfaceEvent event, std::int64_t count) {
        if (count > 0) events.emplace_back(event, static_cast<std::size_t>(count));
    };
    add(kinds.of_void, voids);
    add(kinds.of_outer_surface, outer_surfaces);
    add(kinds.of_neither, times - voids - outer_surfaces);
    return events;
}

}  // namespace

std::string_view nameOf(SurfaceEvent event) {
    switch (event) {
        case SurfaceEvent::void_appeared:
            return "void appeared";
        case SurfaceEvent::void_vanished:
            return "void vanished";
        case SurfaceEvent::void_opened:
            return "void opened";
        case SurfaceEvent::void_closed_off:
            return "void closed off";
        case SurfaceEvent::hole_opened:
            return "hole opened";
        case SurfaceEvent::hole_closed:
            return "hole closed";
        case SurfaceEvent::neck_formed:
            return "neck formed";
        case SurfaceEvent::neck_broke:
            return "neck broke";
        case SurfaceEvent::pieces_joined:
            return "pieces joined";
        case SurfaceEvent::pieces_parted:
            return "pieces parted";
        case SurfaceEvent::piece_appeared:
            return "piece appeared";
        case SurfaceEvent::piece_vanished:
            return "piece vanished";
        case SurfaceEvent::several:
            return "several changes of topology";
        case SurfaceEvent::unclear:
            return "unclear";
    }
    return "";
}

std::string_view nameOf(LiquidChange change) {
    return change == LiquidChange::gained ? "gained" : change == LiquidChange::lost ? "lost" : "both";
}

std::vector<JumpSite> jumpSites(const Mesh& before, const Mesh& after, const std::vector<FarPoint>& far, double reach) {
    if (far.empty()) return {};
    const LocalTopologyQuery was(before), is(after);
    const std::vector<bool> appeared = liquidAppeared(before, after, far);
    std::vector<JumpSite> sites;
    for (const std::vector<std::uint32_t>& rows : clustersOf(far, reach)) {
        JumpSite& site = sites.emplace_back();
        site.points = rows.size();
        for (const std::uint32_t row : rows) {
            const FarPoint& p = far[row];
            (p.after ? site.appeared : site.vanished) += p.area;
            if (p.distance > site.jump) site.jump = p.distance, site.position = p.position;
        }
        std::vector<Vec3> points;
        double gained = 0, lost = 0;
        for (const std::uint32_t row : rows) {
            points.push_back(far[row].position);
            if (far[row].distance >= kFarthest * site.jump) (appeared[row] ? gained : lost) += far[row].area;
        }
        if (gained < kBothFrom * (gained + lost)) site.liquid = LiquidChange::lost;
        if (lost < kBothFrom * (gained + lost)) site.liquid = LiquidChange::gained;
        const std::optional<TopologyChange> change = changeNear(points, site.jump, reach, was, is);
        if (change)
            site.events = eventsOf(*change, site.liquid);
        else
            site.events = {{SurfaceEvent::unclear, 1}};
    }
    std::stable_sort(sites.begin(), sites.end(), [](const JumpSite& a, const JumpSite& b) { return a.jump > b.jump; });
    return sites;
}

}  // namespace betamesh
