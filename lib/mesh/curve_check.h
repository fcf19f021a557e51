// Validation of plane curves: which faults they have, how many of each, and where the first one is.

#pragma once

#include "mesh/curve_measure.h"
#include "mesh/mesh_check.h"

namespace betamesh {

/// Two edges that properly cross. Edges that only touch or are collinear do not.
struct EdgeCrossing {
    std::uint32_t first = 0, second = 0;  ///< edge rows, ascending
    Vec3 position{0, 0, 0};
    double depth = 0;  ///< smallest displacement of an end point that separates the edges, world units
};

/// Result of checkCurves(). Edges with non-finite positions, or from a vertex to itself, are counted as such and
/// excluded from all other tests.
struct CurveCheck {
    std::size_t vertices = 0, edges = 0;  ///< rows
    CurveMeasure measure;

    // Faults.
    Found not_finite;  ///< vertices: positions that are NaN, infinite or beyond 2^200
    Found velocity_not_finite;
    Found repeated_vertices;  ///< edges from a vertex to itself
    Found open_ends;          ///< vertices with different numbers of outgoing and incoming edges
    Found crossings;          ///< pairs that cross deeper than the tolerance; first is that of the smallest pair
    bool inside_out = false;  ///< closed, with a negative area
    // Faults only in strict mode.
    Found branches;         ///< vertices with several outgoing edges, as in an alpha mesh
    Found unused_vertices;  ///< vertices without edges
    Found off_plane;        ///< vertices whose z differs from that of the first vertex

    std::vector<EdgeCrossing> deepest_crossings;  ///< sorted by depth, deepest first; at most params.examples
    double deepest = 0;
};

/// same    result for any thread count
/// cost    O(edges log edges) where few edges overlap in x
CurveCheck checkCurves(const Curves& curves, const CheckParams& params);

/// Names of the faults found; with strict also off_plane, branches and unused_vertices.
std::vector<std::string_view> faultsOf(const CurveCheck& check, bool strict = false);

/// Distance of each point to the enclosed region: 0 where the winding number of the curves is positive, on a curve, or
/// inside one of the circles `beside`; else the distance to the nearest edge, infinite without edges. Inside and
/// outside are decided exactly; z is ignored.
///
/// in      curves with finite positions
/// cost    O(points · edges)
std::vector<double> distancesOutside(const Curves& curves, const Spheres& beside, const std::vector<Vec3>& points);

}  // namespace betamesh
