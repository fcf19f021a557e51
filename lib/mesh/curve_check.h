// Are curves in a plane fit for use? What is wrong with them, how often, and where first.

#pragma once

#include "mesh/curve_measure.h"
#include "mesh/mesh_check.h"

namespace betamesh {

/// Two edges that pass through each other. Those that only touch, or lie on one line, do not.
struct EdgeCrossing {
    std::uint32_t first = 0, second = 0;  ///< edge rows, ascending
    Vec3 position{0, 0, 0};
    double depth = 0;  ///< the shortest way of an end that parts the two, world units
};

/// Edges with positions that are not finite, or from a vertex to itself, are counted as such and left out of all else.
struct CurveCheck {
    std::size_t vertices = 0, edges = 0;  ///< rows
    CurveMeasure measure;

    // Faults.
    Found not_finite;  ///< vertices: positions that are NaN, infinite or beyond 2^200
    Found velocity_not_finite;
    Found repeated_vertices;  ///< edges from a vertex to itself
    Found open_ends;          ///< vertices that edges leave more or less often than they come
    Found crossings;          ///< edges that cross later ones deeper than the tolerance
    bool inside_out = false;  ///< closed, and the area is negative
    // What may be as it should be.
    Found branches;         ///< vertices that several edges leave, as in an alpha mesh
    Found unused_vertices;  ///< of no edge
    Found off_plane;        ///< vertices whose z is not that of the first

    std::vector<EdgeCrossing> deepest_crossings;  ///< the deepest first, at most params.examples
    double deepest = 0;
};

/// same    result for any thread count
/// cost    O(edges log edges) where few of them overlap in x
CurveCheck checkCurves(const Curves& curves, const CheckParams& params);

/// Names of what is wrong; strict: off_plane, branches and unused_vertices too.
std::vector<std::string_view> faultsOf(const CurveCheck& check, bool strict = false);

/// How far each point is outside: 0 where curves go round it, where it lies on one, or within one of the circles beside
/// them; else the distance to the nearest edge, infinite where there is none. Decided exactly; z does not matter.
///
/// in      curves with finite positions
/// cost    O(points · edges)
std::vector<double> distancesOutside(const Curves& curves, const Spheres& beside, const std::vector<Vec3>& points);

}  // namespace betamesh
