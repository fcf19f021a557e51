#include "betamesh/check.h"

#include "base/parallel.h"
#include "exact/orientation.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace betamesh {

namespace {

constexpr int kAxis = 2;  // predicates project along z

double distanceToLine(const Vec3& p, const Vec3& a, const Vec3& b) {
    return std::abs(crossZ(b - a, p - a)) / std::hypot(b.x - a.x, b.y - a.y);
}

bool properlyCross(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    return orientationAlong(kAxis, a, b, c) * orientationAlong(kAxis, a, b, d) < 0 &&
           orientationAlong(kAxis, c, d, a) * orientationAlong(kAxis, c, d, b) < 0;
}

EdgeCrossing crossingOf(const Curves& curves, std::uint32_t first, std::uint32_t second) {
    const Vec3 &a = curves.position[curves.edges[first][0]], &b = curves.position[curves.edges[first][1]],
               &c = curves.position[curves.edges[second][0]], &d = curves.position[curves.edges[second][1]];
    const double on_left = distanceToLine(c, a, b), on_right = distanceToLine(d, a, b);
    const double depth = std::min({on_left, on_right, distanceToLine(a, c, d), distanceToLine(b, c, d)});
    const double t = on_left + on_right > 0 ? on_left / (on_left + on_right) : 0.5;
    return {first, second, c * (1 - t) + d * t, depth};
}

// Sweeps over the edges' bounding boxes in x. valid: rows of the edges that take part.
void findCrossings(const Curves& curves, const std::vector<std::uint32_t>& valid, const CheckParams& params,
                   CurveCheck& check) {
    struct Box {
        double low, high, bottom, top;
        std::uint32_t edge;
    };
    std::vector<Box> boxes;
    for (const std::uint32_t e : valid) {
        const Vec3 &a = curves.position[curves.edges[e][0]], &b = curves.position[curves.edges[e][1]];
        boxes.push_back({std::min(a.x, b.x), std::max(a.x, b.x), std::min(a.y, b.y), std::max(a.y, b.y), e});
    }
    std::sort(boxes.begin(), boxes.end(),
              [](const Box& a, const Box& b) { return std::pair(a.low, a.edge) < std::pair(b.low, b.edge); });
    std::vector<std::vector<EdgeCrossing>> found(boxes.size());
    parallelFor(boxes.size(), 256, [&](std::size_t i) {
        const Box& box = boxes[i];
        const Edge& edge = curves.edges[box.edge];
        for (std::size_t k = i + 1; k < boxes.size() && boxes[k].low <= box.high; ++k) {
            const Edge& other = curves.edges[boxes[k].edge];
            if (boxes[k].bottom > box.top || boxes[k].top < box.bottom) continue;
            if (properlyCross(curves.position[edge[0]], curves.position[edge[1]], curves.position[other[0]],
                              curves.position[other[1]]))
                found[i].push_back(
                    crossingOf(curves, std::min(box.edge, boxes[k].edge), std::max(box.edge, boxes[k].edge)));
        }
    });
    std::vector<EdgeCrossing>& all = check.deepest_crossings;
    for (const auto& some : found)
        std::copy_if(some.begin(), some.end(), std::back_inserter(all),
                     [&](const EdgeCrossing& c) { return c.depth >= params.tolerance; });
    std::sort(all.begin(), all.end(), [](const EdgeCrossing& a, const EdgeCrossing& b) {
        return std::tuple(-a.depth, a.first, a.second) < std::tuple(-b.depth, b.first, b.second);
    });
    if (all.empty()) return;
    check.deepest = all.front().depth;
    check.crossings.count = all.size();
    check.crossings.first =
        std::min_element(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first < b.first; })->first;
    all.resize(std::min(all.size(), params.examples));
}

}  // namespace

CurveCheck checkCurves(const Curves& curves, const CheckParams& params) {
    CurveCheck check;
    const std::size_t n = curves.position.size();
    check.vertices = n;
    check.edges = curves.edges.size();
    for (std::size_t v = 0; v < n; ++v) {
        if (!isInRange(curves.position[v])) check.not_finite.add(v);
        if (curves.position[v].z != curves.position[0].z) check.off_plane.add(v);
        if (curves.velocity.empty()) continue;
        const Vec3& velocity = curves.velocity[v];
        if (!isFinite(velocity)) check.velocity_not_finite.add(v);
    }
    Curves valid;
    std::vector<std::uint32_t> rows, outgoing(n, 0), incoming(n, 0);
    valid.position = curves.position;
    for (std::uint32_t e = 0; e < curves.edges.size(); ++e) {
        const Edge& edge = curves.edges[e];
        if (edge[0] == edge[1]) check.repeated_vertices.add(e);
        if (edge[0] == edge[1] || !isInRange(curves.position[edge[0]]) || !isInRange(curves.position[edge[1]]))
            continue;
        valid.edges.push_back(edge);
        rows.push_back(e);
        ++outgoing[edge[0]];
        ++incoming[edge[1]];
    }
    for (std::size_t v = 0; v < n; ++v) {
        if (outgoing[v] != incoming[v]) check.open_ends.add(v);
        if (outgoing[v] > 1) check.branches.add(v);
        if (outgoing[v] + incoming[v] == 0) check.unused_vertices.add(v);
    }
    check.measure = measureCurves(valid);
    check.inside_out = !check.open_ends && check.measure.area < 0;
    findCrossings(curves, rows, params, check);
    return check;
}

std::vector<std::string_view> faultsOf(const CurveCheck& check, bool strict) {
    std::vector<std::string_view> faults;
    const auto add = [&](bool found, std::string_view name) {
        if (found) faults.push_back(name);
    };
    add(check.not_finite.count > 0, "not_finite");
    add(check.velocity_not_finite.count > 0, "velocity_not_finite");
    add(check.repeated_vertices.count > 0, "repeated_vertices");
    add(check.open_ends.count > 0, "open_ends");
    add(check.inside_out, "inside_out");
    add(check.crossings.count > 0, "crossings");
    if (!strict) return faults;
    add(check.off_plane.count > 0, "off_plane");
    add(check.branches.count > 0, "branches");
    add(check.unused_vertices.count > 0, "unused_vertices");
    return faults;
}

}  // namespace betamesh
