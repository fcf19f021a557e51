
#include "mesh/jump_sites.h"

#include "base/cell_order.h"
#include "base/union_find.h"
#include "mesh/enclosure.h"
#include "mesh/local_topology.h"

#include <algorithm>
#include <array>

namespace betamesh {

namespace {

constexpr int kCuts = 8;               // round each place
constexpr double kFarthest = 2.0 / 3;  // of the jump: points that tell which way liquid went
constexpr double kBothFrom = 1.0 / 3;  // of their area: a part below this does not count

// IndexRows of points, each row of rows a place, in the order of their first points.
std::vector<std::vector<std::uint32_t>> gathered(const std::vector<FarPoint>& far, double reach) {
    const auto positionOf = [&](std::size_t row) { return far[row].position; };
    const CellOrder cells(far.size(), reach, positionOf);
    UnionFind groups(far.size());
    for (std::uint32_t i = 0; i < far.size(); ++i) {
        const Vec3 p = positionOf(i);
        cells.forRowsIn(p - Vec3(reach), p + Vec3(reach), [&](std::uint32_t j) {
            if (j < i && (p - positionOf(j)).length2() <= reach * reach) groups.join(i, j);
        });
    }
    std::vector<std::vector<std::uint32_t>> places;
    std::vector<std::size_t> place(far.size());
    for (std::uint32_t i = 0; i < far.size(); ++i) {
        const std::uint32_t first = groups.find(i);
        if (first == i) {
            place[i] = places.size();
            places.emplace_back();
        }
        places[place[first]].push_back(i);
    }
    return places;
}

// For every point: has liquid come, where there was none, or gone?
std::vector<bool> liquidHasCome(const Mesh& before, const Mesh& after, const std::vector<FarPoint>& far) {
    std::array<std::vector<Vec3>, 2> points;
    for (const FarPoint& p : far) points[p.after].push_back(p.position);
    const std::array outside{distancesOutside(after, {}, points[0]), distancesOutside(before, {}, points[1])};
    std::vector<bool> come;
    std::array<std::size_t, 2> next{0, 0};
    for (const FarPoint& p : far) come.push_back((outside[p.after][next[p.after]++] > 0) == p.after);
    return come;
}

// What is there after and was not before, negative the other way round.
struct Change {
    std::int64_t euler = 0, parts = 0, pieces = 0, voids = 0;
    bool operator==(const Change&) const = default;
};

// As most of the cuts tell that have the same rims in both meshes, at least two. Cuts that go through different places
// of the two rarely have, and do not agree.
std::optional<Change> changeNear(const std::vector<Vec3>& points, double jump, double reach, const MeshParts& before,
                                 const MeshParts& after) {
    std::vector<double> distances;
    for (int k = 0; k <= kCuts; ++k) distances.push_back(jump + std::max(jump, reach) * k / kCuts);
    const std::vector<LocalTopology> was = before.near(points, distances), is = after.near(points, distances);
    std::vector<std::pair<Change, int>> votes;
    for (std::size_t k = 0; k < distances.size(); ++k) {
        if (!was[k].closed || !is[k].closed || was[k].rims != is[k].rims) continue;
        const Change change{is[k].euler - was[k].euler, is[k].parts - was[k].parts, is[k].pieces - was[k].pieces,
                            is[k].voids - was[k].voids};
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

// A sphere that comes or goes changes the Euler characteristic by two; so does a tube that takes the place of two
// discs, or the reverse. What joins or parts elsewhere, in one part here before and after, does not count.
std::vector<std::pair<SurfaceEvent, std::size_t>> eventsOf(const Change& change, LiquidChange liquid) {
    using enum SurfaceEvent;
    if (change.euler == 0 && change.parts == 0) return {};
    struct Kinds {
        SurfaceEvent of_void, of_piece, of_neither;
    };
    const bool more = change.euler > 0;
    const Kinds kinds = liquid == LiquidChange::gained ? (more ? Kinds{void_closed_off, piece_appeared, hole_closed}
                                                               : Kinds{void_vanished, pieces_joined, neck_formed})
                                                       : (more ? Kinds{void_appeared, pieces_parted, neck_broke}
                                                               : Kinds{void_opened, piece_vanished, hole_opened});
    const std::int64_t sign = more ? 1 : -1, parts = sign * change.parts, times = sign * change.euler / 2;
    std::int64_t voids = sign * change.voids, pieces = sign * change.pieces;
    if (voids + pieces > parts) voids = pieces = 0;
    if (liquid == LiquidChange::both || change.euler % 2 != 0 || times == 0 || voids < 0 || pieces < 0 ||
        voids + pieces > times)
        return {{several, 1}};
    std::vector<std::pair<SurfaceEvent, std::size_t>> events;
    const auto add = [&](SurfaceEvent event, std::int64_t count) {
        if (count > 0) events.emplace_back(event, static_cast<std::size_t>(count));
    };
    add(kinds.of_void, voids);
    add(kinds.of_piece, pieces);
    add(kinds.of_neither, times - voids - pieces);
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

std::vector<Place> placesOf(const Mesh& before, const Mesh& after, const std::vector<FarPoint>& far, double reach) {
    if (far.empty()) return {};
    const MeshParts was(before), is(after);
    const std::vector<bool> come = liquidHasCome(before, after, far);
    std::vector<Place> places;
    for (const std::vector<std::uint32_t>& rows : gathered(far, reach)) {
        Place& place = places.emplace_back();
        place.points = rows.size();
        for (const std::uint32_t row : rows) {
            const FarPoint& p = far[row];
            (p.after ? place.appeared : place.vanished) += p.area;
            if (p.distance > place.jump) place.jump = p.distance, place.position = p.position;
        }
        std::vector<Vec3> points;
        double gained = 0, lost = 0;
        for (const std::uint32_t row : rows) {
            points.push_back(far[row].position);
            if (far[row].distance >= kFarthest * place.jump) (come[row] ? gained : lost) += far[row].area;
        }
        if (gained < kBothFrom * (gained + lost)) place.liquid = LiquidChange::lost;
        if (lost < kBothFrom * (gained + lost)) place.liquid = LiquidChange::gained;
        const std::optional<Change> change = changeNear(points, place.jump, reach, was, is);
        if (change)
            place.events = eventsOf(*change, place.liquid);
        else
            place.events = {{SurfaceEvent::unclear, 1}};
    }
    std::stable_sort(places.begin(), places.end(), [](const Place& a, const Place& b) { return a.jump > b.jump; });
    return places;
}

}  // namespace betamesh
