#include "mesh/polygon_triangles.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace betamesh {

namespace {

using Loop = std::vector<std::uint32_t>;

double squaredDistance(const PlanePoint& a, const PlanePoint& b) {
    return (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]);
}

double doubledArea(const std::vector<PlanePoint>& point, const Loop& loop) {
    double area = 0;
    for (std::size_t i = 0; i < loop.size(); ++i)
        area += orientation(point[loop[0]], point[loop[i]], point[loop[(i + 1) % loop.size()]]);
    return area;
}

// Is p inside a loop, by the parity of crossings of the ray in +x?
bool encloses(const std::vector<PlanePoint>& point, const Loop& loop, const PlanePoint& p) {
    bool inside = false;
    for (std::size_t i = 0; i < loop.size(); ++i) {
        const PlanePoint &a = point[loop[i]], &b = point[loop[(i + 1) % loop.size()]];
        if ((a[1] > p[1]) == (b[1] > p[1])) continue;
        if ((orientation(a, b, p) > 0) == (b[1] > a[1])) inside = !inside;
    }
    return inside;
}

// Do the open segments ab and cd meet, or does one contain an end of the other in its inside?
bool meet(const PlanePoint& a, const PlanePoint& b, const PlanePoint& c, const PlanePoint& d) {
    const auto within = [](const PlanePoint& p, const PlanePoint& from, const PlanePoint& to) {
        return p != from && p != to && p[0] >= std::min(from[0], to[0]) && p[0] <= std::max(from[0], to[0]) &&
               p[1] >= std::min(from[1], to[1]) && p[1] <= std::max(from[1], to[1]);
    };
    const double c_side = orientation(a, b, c), d_side = orientation(a, b, d), a_side = orientation(c, d, a),
                 b_side = orientation(c, d, b);
    if (((c_side > 0 && d_side < 0) || (c_side < 0 && d_side > 0)) &&
        ((a_side > 0 && b_side < 0) || (a_side < 0 && b_side > 0)))
        return true;
    return (c_side == 0 && within(c, a, b)) || (d_side == 0 && within(d, a, b)) || (a_side == 0 && within(a, c, d)) ||
           (b_side == 0 && within(b, c, d));
}

// Is the direction from loop[i] to p inside the angle of the loop there, which opens to the left?
bool isInAngle(const std::vector<PlanePoint>& point, const Loop& loop, std::size_t i, const PlanePoint& p) {
    const PlanePoint &before = point[loop[(i + loop.size() - 1) % loop.size()]], &at = point[loop[i]],
                     &after = point[loop[(i + 1) % loop.size()]];
    const bool left_of_in = orientation(before, at, p) > 0, left_of_out = orientation(at, after, p) > 0;
    return orientation(before, at, after) > 0 ? left_of_in && left_of_out : left_of_in || left_of_out;
}

// Joins a hole to a polygon by a bridge that is traversed in both directions: from the hole's leftmost vertex to the
// nearest vertex that it sees, or to the nearest one if the loops cross so that it sees none.
void joinHole(const std::vector<PlanePoint>& point, const Loop& hole, const std::vector<Loop>& other_holes,
              Loop& polygon) {
    const auto first = std::min_element(hole.begin(), hole.end(),
                                        [&](std::uint32_t a, std::uint32_t b) { return point[a] < point[b]; });
    const PlanePoint& from = point[*first];
    std::vector<std::size_t> nearest(polygon.size());
    for (std::size_t i = 0; i < nearest.size(); ++i) nearest[i] = i;
    std::stable_sort(nearest.begin(), nearest.end(), [&](std::size_t a, std::size_t b) {
        return squaredDistance(point[polygon[a]], from) < squaredDistance(point[polygon[b]], from);
    });
    const auto crosses = [&](const Loop& loop, const PlanePoint& to) {
        for (std::size_t i = 0; i < loop.size(); ++i)
            if (meet(from, to, point[loop[i]], point[loop[(i + 1) % loop.size()]])) return true;
        return false;
    };
    const auto sees = [&](std::size_t i) {
        const PlanePoint& to = point[polygon[i]];
        return isInAngle(point, polygon, i, from) && !crosses(polygon, to) && !crosses(hole, to) &&
               std::none_of(other_holes.begin(), other_holes.end(), [&](const Loop& h) { return crosses(h, to); });
    };
    const auto seen = std::find_if(nearest.begin(), nearest.end(), sees);
    const std::size_t at = seen == nearest.end() ? nearest.front() : *seen;
    Loop bridge(first, hole.end());
    bridge.insert(bridge.end(), hole.begin(), first + 1);
    bridge.push_back(polygon[at]);
    polygon.insert(polygon.begin() + static_cast<std::ptrdiff_t>(at) + 1, bridge.begin(), bridge.end());
}

// Cuts off ears: triangles of three consecutive vertices that contain no other vertex.
class EarClipper {
public:
    EarClipper(const std::vector<PlanePoint>& point, const Loop& polygon)
        : point_(point), vertex_(polygon), before_(polygon.size()), after_(polygon.size()) {
        for (std::size_t i = 0; i < vertex_.size(); ++i) {
            after_[i] = (i + 1) % vertex_.size();
            before_[after_[i]] = i;
        }
    }
    void clip(std::vector<Triangle>& triangles) {
        std::size_t at = 0, left = vertex_.size(), refused = 0;
        while (left >= 3) {
            const bool forced = refused > left;  // there is no ear if loops cross: cut off the flattest corner instead
            if (forced) at = flattest(at);
            if (!forced && !isEar(at)) {
                at = after_[at];
                ++refused;
                continue;
            }
            triangles.push_back({vertex_[before_[at]], vertex_[at], vertex_[after_[at]]});
            after_[before_[at]] = after_[at];
            before_[after_[at]] = before_[at];
            at = after_[after_[at]];  // ears next to each other would make fans of slivers
            --left;
            refused = 0;
        }
    }

private:
    double turn(std::size_t i) const { return orientation(at(before_[i]), at(i), at(after_[i])); }
    const PlanePoint& at(std::size_t i) const { return point_[vertex_[i]]; }
    std::size_t flattest(std::size_t start) const {
        std::size_t best = start;
        for (std::size_t i = after_[start]; i != start; i = after_[i])
            if (std::abs(turn(i)) < std::abs(turn(best))) best = i;
        return best;
    }
    bool isEar(std::size_t i) const {
        if (!(turn(i) > 0)) return false;
        const PlanePoint &a = at(before_[i]), &b = at(i), &c = at(after_[i]);
        const double low = std::min({a[0], b[0], c[0]}), high = std::max({a[0], b[0], c[0]});
        for (std::size_t j = after_[after_[i]]; j != before_[i]; j = after_[j]) {
            const PlanePoint& p = at(j);
            if (p[0] < low || p[0] > high || p == a || p == b || p == c) continue;
            if (orientation(a, b, p) >= 0 && orientation(b, c, p) >= 0 && orientation(c, a, p) >= 0) return false;
        }
        return true;
    }

    const std::vector<PlanePoint>& point_;
    const Loop& vertex_;
    std::vector<std::size_t> before_, after_;
};

}  // namespace

double orientation(const PlanePoint& a, const PlanePoint& b, const PlanePoint& c) {
    // The difference of two products to within two units in the last place (Kahan).
    const double x = b[0] - a[0], y = b[1] - a[1], u = c[0] - a[0], v = c[1] - a[1];
    const double product = y * u, error = std::fma(-y, u, product);
    return std::fma(x, v, -product) + error;
}

std::vector<Triangle> polygonTriangles(const std::vector<PlanePoint>& point, const std::vector<Loop>& loops) {
    std::vector<Loop> outer;
    std::vector<double> area;
    std::vector<const Loop*> holes;
    for (const Loop& loop : loops) {
        const double doubled = doubledArea(point, loop);
        if (doubled < 0) {
            holes.push_back(&loop);
        } else {
            outer.push_back(loop);
            area.push_back(doubled);
        }
    }
    std::vector<std::vector<Loop>> holes_of(outer.size());
    std::vector<Triangle> triangles;
    for (const Loop* hole : holes) {
        std::size_t smallest = outer.size();
        for (std::size_t i = 0; i < outer.size(); ++i)
            if ((smallest == outer.size() || area[i] < area[smallest]) && encloses(point, outer[i], point[(*hole)[0]]))
                smallest = i;
        if (smallest < outer.size())
            holes_of[smallest].push_back(*hole);
        else
            EarClipper(point, *hole).clip(triangles);  // loops cross
    }
    for (std::size_t i = 0; i < outer.size(); ++i) {
        std::vector<Loop>& rest = holes_of[i];
        const auto leftmost = [&](const Loop& loop) {
            PlanePoint low{std::numeric_limits<double>::infinity(), 0};
            for (const std::uint32_t v : loop) low = std::min(low, point[v]);
            return low;
        };
        std::sort(rest.begin(), rest.end(), [&](const Loop& a, const Loop& b) { return leftmost(a) > leftmost(b); });
        while (!rest.empty()) {
            const Loop hole = std::move(rest.back());
            rest.pop_back();
            joinHole(point, hole, rest, outer[i]);
        }
        EarClipper(point, outer[i]).clip(triangles);
    }
    return triangles;
}

}  // namespace betamesh
