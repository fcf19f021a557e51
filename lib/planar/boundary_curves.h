// Closed curves made of the boundary of discs: the alpha mesh and the beta mesh of a plane, before smoothing.

#pragma once

#include "base/dual.h"
#include "betamesh/curves.h"
#include "planar/disc_boundary.h"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <vector>

namespace betamesh {

/// The beta mesh of a plane: closed polylines with moving vertices. Vertices of one line are consecutive, with the
/// liquid on their left; the last one is connected to the first.
struct BetaCurve {
    std::vector<DualVec3> vertex;
    std::vector<Dual> scale;              ///< of each vertex: radius of its disc in radii of the largest; empty: all 1
    std::vector<std::uint8_t> pure;       ///< of each vertex: 1 where two circles intersect, 0 on an arc between them
    std::vector<std::uint32_t> begin{0};  ///< first vertex of each line, and one entry past the last

    std::size_t lines() const { return begin.size() - 1; }
    Dual scaleOf(std::size_t v) const { return scale.empty() ? 1 : scale[v]; }
    /// The values of `scale`.
    std::vector<double> scales() const {
        std::vector<double> values;
        for (const Dual& s : scale) values.push_back(s.value);
        return values;
    }
    double leastScale() const {
        double least = 1;
        for (const Dual& s : scale) least = std::min(least, s.value);
        return least;
    }
    void add(const DualVec3& point, bool is_pure) {
        vertex.push_back(point);
        pure.push_back(is_pure);
    }
    void endLine() { begin.push_back(static_cast<std::uint32_t>(vertex.size())); }
};

/// Calls visit(vertex before, vertex, vertex after) for every vertex of every line.
template <typename Visit>
void forEveryVertex(const BetaCurve& curve, const Visit& visit) {
    for (std::size_t l = 0; l < curve.lines(); ++l) {
        const std::uint32_t first = curve.begin[l], last = curve.begin[l + 1] - 1;
        for (std::uint32_t v = first; v <= last; ++v) visit(v == first ? last : v - 1, v, v == last ? first : v + 1);
    }
}

/// The alpha mesh: one oriented segment between particles per boundary vertex, line by line. Around thin features the
/// curve goes back and forth, so segments there occur twice, once in each direction. Isolated particles have none.
///
/// out     vertices are the discs that some segment uses
/// cost    O(segments)
/// source  beta mesh paper, section 3.2
Curves alphaCurves(const DiscBoundary& boundary, const std::vector<DualVec3>& discs);

/// The number of alpha segments whose reverse is also a segment; both of a pair count.
std::size_t doubleSidedSegments(const DiscBoundary& boundary);

/// The paper's beta mesh: one line per cycle of the boundary. Each pure beta vertex is followed by the alphabeta vertex
/// of the arc that begins there: the projection of the particle onto the chord of the arc, which is the chord's
/// midpoint. Entry k of boundary.cycle.item becomes vertices 2k and 2k + 1.
///
/// cost    O(vertices)
/// source  beta mesh paper, section 3.4.2 and Figure 8 (a)
BetaCurve paperCurve(const DiscBoundary& boundary, const std::vector<DualVec3>& vertices);

/// The complete beta mesh: every arc from vertex to vertex, with a point wherever it passes one of `directions` (>= 8)
/// fixed directions from its centre; isolated discs become polygons of these points. A point appears or vanishes where
/// it coincides with the end of its arc, so the curve moves continuously. Nothing crosses before smoothing, because all
/// points of a disc are on one circle and in its power cell.
///
/// out     one line per cycle of the boundary, then one per isolated disc
/// cost    O(points)
BetaCurve completeCurve(const DiscBoundary& boundary, const std::vector<DualVec3>& discs,
                        const std::vector<DualVec3>& vertices, int directions);

/// Removes lines that bound small holes, with everything inside these. Other lines and their order do not change.
///
/// in      the complete curve of discs of that radius or larger ones, not yet moved. isSmall(line, area): called for
/// lines that bound
///         holes, with the enclosed area, world units squared
/// out     number of holes filled
/// cost    O(points), more where holes are large enough to contain drops
std::size_t fillHoles(BetaCurve& curve, double radius,
                      const std::function<bool(std::size_t line, double area)>& isSmall);

/// For each cycle of a boundary: does a disc fit between its discs in the region that the cycle bounds? Its radius is
/// that by which the discs of `wider` are larger. It fits if the boundary of those has a vertex there. Exact for holes.
/// Outside the liquid a single particle, or two far apart, leave no vertex and give false.
///
/// in      boundaries of the same particles; `wider` has larger discs and may lack some that nearly coincide. Where
///         sizes differ, also those that are covered in `boundary`
/// same    result for any thread count
/// cost    O(vertices)
std::vector<bool> cyclesWithRoom(const DiscBoundary& boundary, const DiscBoundary& wider);

}  // namespace betamesh
