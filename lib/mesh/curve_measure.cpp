
#include "mesh/curve_measure.h"

#include "base/angles.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace betamesh {

namespace {

constexpr double kLeastEdge = 1e-6;  // relative to the largest coordinate: the resolution of single precision

}  // namespace

std::vector<std::span<const Edge>> linesOf(const Curves& curves) {
    std::vector<std::span<const Edge>> lines;
    const std::span<const Edge> edges = curves.edges;
    for (std::size_t first = 0, i = 0; i < edges.size(); ++i) {
        const bool closed = edges[i][1] == edges[first][0];
        if (!closed && i + 1 < edges.size() && edges[i + 1][0] == edges[i][1]) continue;
        lines.push_back(edges.subspan(first, i + 1 - first));
        first = i + 1;
    }
    return lines;
}

std::int64_t turningNumber(const Curves& curves, std::span<const Edge> line) {
    double largest = 0;
    for (const Edge& edge : line) {
        const Vec3& p = curves.position[edge[0]];
        largest = std::max({largest, std::abs(p.x), std::abs(p.y)});
    }
    const auto offset = [](const Vec3& a, const Vec3& b) { return Vec3(b.x - a.x, b.y - a.y, 0); };
    const double least = kLeastEdge * largest;
    std::vector<Vec3> corners;
    for (const Edge& edge : line) {
        const Vec3& p = curves.position[edge[0]];
        if (corners.empty() || offset(corners.back(), p).length() > least) corners.push_back(p);
    }
    while (corners.size() > 1 && offset(corners.back(), corners.front()).length() <= least) corners.pop_back();
    const std::size_t n = corners.size();
    double turn = 0;
    for (std::size_t i = 0; n > 1 && i < n; ++i) {
        const Vec3 before = offset(corners[i], corners[(i + 1) % n]),
                   after = offset(corners[(i + 1) % n], corners[(i + 2) % n]);
        const double cross = crossZ(before, after);
        turn += std::atan2(cross == 0 ? 0.0 : cross, dot(before, after));  // atan2 of -0 would be a right turn
    }
    return std::llround(turn / kTwoPi);
}

CurveMeasure measureCurves(const Curves& curves) {
    CurveMeasure measure;
    const Vec3 origin = curves.position.empty() ? Vec3(0) : curves.position[0];
    std::vector<std::int64_t> surplus(curves.position.size(), 0);
    for (const Edge& edge : curves.edges) {
        const Vec3 a = curves.position[edge[0]] - origin, b = curves.position[edge[1]] - origin;
        measure.area += crossZ(a, b) / 2;
        measure.length += std::hypot(b.x - a.x, b.y - a.y);
        ++surplus[edge[0]];
        --surplus[edge[1]];
    }
    for (const std::int64_t ends : surplus) measure.unpaired_ends += static_cast<std::size_t>(std::abs(ends));
    for (const std::span<const Edge> line : linesOf(curves)) {
        ++measure.curves;
        if (line.front()[0] == line.back()[1]) measure.turning += turningNumber(curves, line);
    }
    return measure;
}

}  // namespace betamesh
