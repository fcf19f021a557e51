
#include "planar/uncrossed_curve.h"

#include "base/cell_order.h"
#include "base/parallel.h"
#include "exact/orientation.h"

#include <algorithm>
#include <cmath>

namespace betamesh {

namespace {

constexpr double kShallow = 1e-9;  // units
constexpr int kHalvings = 5;       // before a step is given up
constexpr int kBeside = 2;         // vertices on either side that are held back, too

double distanceToLine(const Vec3& p, const Vec3& a, const Vec3& b) {
    return std::abs(crossZ(b - a, p - a)) / (b - a).length();
}

bool cross(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, double shallow) {
    constexpr int kAxis = 2;
    if (std::max(a.x, b.x) < std::min(c.x, d.x) || std::max(c.x, d.x) < std::min(a.x, b.x) ||
        std::max(a.y, b.y) < std::min(c.y, d.y) || std::max(c.y, d.y) < std::min(a.y, b.y))
        return false;
    if (turnAlong(kAxis, a, b, c) * turnAlong(kAxis, a, b, d) >= 0 ||
        turnAlong(kAxis, c, d, a) * turnAlong(kAxis, c, d, b) >= 0)
        return false;
    return std::min({distanceToLine(c, a, b), distanceToLine(d, a, b), distanceToLine(a, c, d),
                     distanceToLine(b, c, d)}) > shallow;
}

// The vertices before and after each one.
struct Neighbours {
    std::vector<std::uint32_t> before, after;

    explicit Neighbours(const BetaCurve& curve) : before(curve.vertex.size()), after(curve.vertex.size()) {
        forEveryVertex(curve, [&](std::uint32_t b, std::uint32_t v, std::uint32_t a) { before[v] = b, after[v] = a; });
    }
};

// For each vertex whether the edge that it begins crosses another.
std::vector<std::uint8_t> crossingEdges(const std::vector<Vec3>& position, const Neighbours& neighbours,
                                        double shallow) {
    const std::size_t n = position.size();
    std::vector<std::uint8_t> crosses(n, 0);
    double longest = 0;
    for (std::size_t v = 0; v < n; ++v)
        longest = std::max(longest, (position[neighbours.after[v]] - position[v]).length());
    if (!(longest > 0)) return crosses;
    const CellOrder cells(n, longest, [&](std::size_t v) { return position[v]; });
    parallelFor(n, 512, [&](std::size_t v) {
        const Vec3 &a = position[v], &b = position[neighbours.after[v]], middle = (a + b) / 2;
        cells.forRowsIn(middle - Vec3(1.5, 1.5, 0) * longest, middle + Vec3(1.5, 1.5, 0) * longest,
                        [&](std::uint32_t u) {
                            if (!crosses[v] && cross(a, b, position[u], position[neighbours.after[u]], shallow))
                                crosses[v] = 1;
                        });
    });
    return crosses;
}

}  // namespace

void moveUncrossed(BetaCurve& curve, const std::vector<DualVec3>& step, double unit) {
    const std::size_t n = curve.vertex.size();
    const Neighbours neighbours(curve);
    std::vector<double> share(n, 1);
    std::vector<Vec3> position(n);
    for (int round = 0;; ++round) {
        for (std::size_t v = 0; v < n; ++v) position[v] = curve.vertex[v].position + step[v].position * share[v];
        const std::vector<std::uint8_t> crosses = crossingEdges(position, neighbours, kShallow * unit);
        std::vector<std::uint8_t> held(n, 0);
        for (std::uint32_t v = 0; v < n; ++v) {
            if (!crosses[v]) continue;
            std::uint32_t at = v;
            for (int k = 0; k < kBeside; ++k) at = neighbours.before[at];
            for (int k = 0; k < 2 * kBeside + 2; ++k, at = neighbours.after[at]) held[at] = 1;
        }
        bool any = false;
        for (std::size_t v = 0; v < n; ++v) {
            if (!held[v] || share[v] == 0) continue;
            share[v] = round < kHalvings ? share[v] / 2 : 0;
            any = true;
        }
        if (!any) break;
    }
    for (std::size_t v = 0; v < n; ++v) curve.vertex[v] = curve.vertex[v] + step[v] * share[v];
}

}  // namespace betamesh
