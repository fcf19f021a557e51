
#include "planar/keep_inside.h"

#include "base/cell_grid.h"
#include "base/parallel.h"
#include "mesh/enclosure.h"
#include "planar/curve_displacement.h"
#include "skin/constants.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace betamesh {

namespace {

// The edge nearest to a particle.
struct NearestEdge {
    double distance = std::numeric_limits<double>::infinity();  // where none is within reach
    bool is_inside = true;                                      // the particle
    Vec3 normal{0};                                             // outwards
    double farther = 0;                                         // distance of the farther end

    double depth() const { return is_inside ? distance : -distance; }
};

// A curve as it is while particles are sought in it.
struct FixedCurve {
    std::vector<Vec3> position, normal;  // of each vertex; normals are outwards and of unit length
    std::vector<Edge> edges;

    explicit FixedCurve(const BetaCurve& curve) : normal(curve.vertex.size(), Vec3(0)) {
        for (const DualVec3& vertex : curve.vertex) position.push_back(vertex.position);
        forEveryVertex(curve, [&](std::uint32_t before, std::uint32_t v, std::uint32_t after) {
            edges.push_back({v, after});
            normal[v] = outwards(position[after] - position[before]);
        });
    }

    static Vec3 outwards(const Vec3& along) { return Vec3(along.y, -along.x, 0).normalized(); }

    std::vector<NearestEdge> nearestOf(const std::vector<DeepPoint>& particles, double reach) const {
        double longest = 0;
        for (const auto& [a, b] : edges) longest = std::max(longest, (position[b] - position[a]).length());
        const double within = reach + longest / 2;
        const CellGrid middles(edges.size(), std::max(longest, reach / 4),
                               [&](std::size_t e) { return (position[edges[e][0]] + position[edges[e][1]]) / 2; });
        const EnclosedRegion region(position, edges);
        std::vector<NearestEdge> nearest(particles.size());
        parallelFor(particles.size(), 64, [&](std::size_t i) {
            const Vec3& p = particles[i].position;
            nearest[i].is_inside = region.contains(p);
            middles.forRowsIn(p - Vec3(within, within, 0), p + Vec3(within, within, 0), [&](std::uint32_t e) {
                const Vec3 &a = position[edges[e][0]], &b = position[edges[e][1]], along = b - a;
                const double squared = along.length2(),
                             t = squared > 0 ? std::clamp(dot(p - a, along) / squared, 0.0, 1.0) : 0,
                             distance = (p - a - along * t).length();
                if (!(distance < nearest[i].distance)) return;
                nearest[i].distance = distance;
                nearest[i].normal = outwards(along);
                nearest[i].farther = std::max((p - a).length(), (p - b).length());
            });
        });
        return nearest;
    }
};

// Raises the curve once; false if nothing was missing anywhere.
bool raise(const std::vector<DeepPoint>& particles, double reach, double unit, BetaCurve& curve) {
    const FixedCurve fixed(curve);
    const std::vector<NearestEdge> nearest = fixed.nearestOf(particles, reach);
    std::vector<Vec3> sum(curve.vertex.size(), Vec3(0));
    std::vector<double> weight(curve.vertex.size());
    const CellGrid vertices(curve.vertex.size(), unit, [&](std::size_t v) { return fixed.position[v]; });
    bool any = false;
    for (std::size_t i = 0; i < particles.size(); ++i) {
        const double height = particles[i].least_depth - nearest[i].depth();
        if (!(height > 0) || !(nearest[i].distance < reach)) continue;
        any = true;
        const Vec3 centre = particles[i].position + nearest[i].normal * nearest[i].depth();
        const double width = kBumpWidth * std::max(nearest[i].farther, height);
        vertices.forRowsIn(centre - Vec3(width, width, 0), centre + Vec3(width, width, 0), [&](std::uint32_t v) {
            const double t = 1 - (fixed.position[v] - centre).length2() / (width * width),
                         facing = dot(fixed.normal[v], nearest[i].normal);
            if (!(t > 0) || !(facing > 0)) return;
            const double w = t * t * std::sqrt(facing);
            sum[v] += nearest[i].normal * (height * w * w);
            weight[v] += w;
        });
    }
    if (!any) return false;
    std::vector<DualVec3> displacement(curve.vertex.size());
    for (std::size_t v = 0; v < sum.size(); ++v)
        if (weight[v] > 0) displacement[v].position = sum[v] / weight[v];
    moveWithoutCrossings(curve, displacement, unit);
    return true;
}

// Takes displacements back around particles that are outside, in full up to `share` times the distance to where they
// ought to be; false if none is outside.
bool restore(const std::vector<DeepPoint>& particles, const std::vector<DualVec3>& before, double reach, double unit,
             double share, BetaCurve& curve) {
    const std::vector<NearestEdge> nearest = FixedCurve(curve).nearestOf(particles, reach);
    std::vector<double> kept(curve.vertex.size(), 1);
    bool any = false;
    for (std::size_t i = 0; i < particles.size(); ++i) {
        if (nearest[i].is_inside) continue;
        any = true;
        const Vec3& p = particles[i].position;
        const double there = nearest[i].distance < reach ? nearest[i].farther + particles[i].least_depth : reach,
                     within = share * there;
        for (std::size_t v = 0; v < kept.size(); ++v) {  // where it is or was
            const double distance =
                std::sqrt(std::min((curve.vertex[v].position - p).length2(), (before[v].position - p).length2()));
            kept[v] = std::min(kept[v], smoothStep(2 * distance / within - 1).value);
        }
    }
    if (!any) return false;
    std::vector<DualVec3> displacement(curve.vertex.size());
    for (std::size_t v = 0; v < kept.size(); ++v) {
        displacement[v] = (curve.vertex[v] - before[v]) * kept[v];
        curve.vertex[v] = before[v];
    }
    moveWithoutCrossings(curve, displacement, unit);
    return true;
}

}  // namespace

void keepInside(const std::vector<DeepPoint>& particles, const std::vector<DualVec3>& before, double reach, double unit,
                BetaCurve& curve) {
    if (curve.vertex.empty()) return;
    for (int round = 0; round < kBumpRounds && raise(particles, reach, unit, curve); ++round) {
    }
    double share = 2;
    for (int round = 0; round < kMaxRestorations && restore(particles, before, reach, unit, share, curve); ++round)
        share *= 2;
}

}  // namespace betamesh
