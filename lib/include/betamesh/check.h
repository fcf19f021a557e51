// Measures and validation of triangle meshes and plane curves: which faults they have, how many of each, and where the
// first one is.

#pragma once

#include "betamesh/curves.h"
#include "betamesh/mesh.h"

#include <optional>
#include <string_view>

namespace betamesh {

/// Size and shape of a mesh, for meshes that are known to be valid.
struct MeshMeasure {
    std::size_t components = 0;      ///< connected components
    std::int64_t euler = 0;          ///< used vertices - edges + triangles
    double volume = 0;               ///< enclosed, world units cubed; meaningful for closed meshes
    double area = 0;                 ///< world units squared
    std::size_t unpaired_edges = 0;  ///< half-edges without an opposite one; 0 when closed
};

/// Measures a mesh.
///
/// in      triangles whose vertices exist
/// same    result for any thread count
/// cost    O(triangles log triangles)
MeshMeasure measureMesh(const Mesh& mesh);

/// Parameters of checkMesh() and checkCurves().
struct CheckParams {
    double tolerance = 0;      ///< world units, >= 0: crossings shallower than this are not faults
    std::size_t examples = 8;  ///< number of crossings to list
};

/// Occurrences of one fault.
struct FaultCount {
    std::size_t count = 0;
    std::uint32_t first = 0;  ///< the smallest row that has it; meaningful if count > 0

    /// Has the fault occurred?
    explicit operator bool() const { return count > 0; }

    /// Counts an occurrence in a row.
    void add(std::size_t row) {
        if (count++ == 0 || row < first) first = static_cast<std::uint32_t>(row);
    }
};

/// Two triangles that pass through each other or overlap in a plane.
struct SelfCrossing {
    std::uint32_t first = 0, second = 0;  ///< triangle rows, ascending
    Vec3 position{0, 0, 0};               ///< centre of the intersection, rounded
    double depth = 0;                     ///< smallest displacement that separates the two, world units; 0 if coplanar
    bool coplanar = false;                ///< they are in one plane and overlap
};

/// A connected component of the mesh.
struct ComponentCheck {
    std::size_t vertices = 0, edges = 0, triangles = 0;
    std::int64_t euler = 0;             ///< vertices - edges + triangles
    std::optional<std::int64_t> genus;  ///< only for closed, oriented manifolds
    bool closed = true;
    double volume = 0;  ///< world units cubed, positive where triangles face outwards; meaningful if closed
    double area = 0;    ///< world units squared
};

/// Result of checkMesh(). An edge is reported by its vertex with the smaller row. Triangles with missing or repeated
/// vertices are counted as such and excluded from everything else; those with non-finite positions are excluded from
/// volumes, areas and contacts, and zero-area ones from contacts.
struct MeshCheck {
    std::size_t vertices = 0, triangles = 0;  ///< rows of the mesh
    std::size_t edges = 0;
    std::int64_t euler = 0;  ///< used vertices - edges + triangles
    double volume = 0;       ///< world units cubed
    double area = 0;         ///< world units squared
    std::vector<ComponentCheck> components;

    // Faults found at vertices and edges; rows are vertices:
    FaultCount not_finite;  ///< positions that are NaN, infinite or beyond 2^200
    FaultCount velocity_not_finite;
    FaultCount open_edges;            ///< edges with an odd number of triangles
    FaultCount misoriented_edges;     ///< edges used in one direction at least twice more often than in the other
    FaultCount nonmanifold_edges;     ///< edges with more than two triangles
    FaultCount nonmanifold_vertices;  ///< vertices whose triangles form several fans that share no edge
    // Faults of triangles; rows are triangles:
    FaultCount missing_vertices;   ///< a vertex that does not exist
    FaultCount repeated_vertices;  ///< the same vertex twice
    FaultCount duplicates;         ///< the same three vertices, in any order, as an earlier triangle
    FaultCount crossings;          ///< pairs that cross by at least the tolerance; first is that of the smallest pair
    bool inside_out = false;       ///< closed and oriented, with a negative volume

    // Faults only in strict mode:
    FaultCount zero_area;  ///< triangles with exactly collinear corners
    FaultCount unused_vertices;
    FaultCount coincident_vertices;  ///< at exactly the position of an earlier vertex; weldVertices() repairs them
    std::size_t touching = 0;        ///< pairs of triangles that touch where they share no vertex or edge
    std::size_t shallow = 0;         ///< crossings below the tolerance

    double deepest = 0;                           ///< largest depth of all crossings, world units
    std::vector<SelfCrossing> deepest_crossings;  ///< sorted by depth, deepest first; at most params.examples

    // Properties of the mesh as a whole:
    /// Every edge has an even number of triangles.
    bool closed() const { return !open_edges; }
    /// All triangles agree about which side is outside, and it is.
    bool oriented() const { return !misoriented_edges && !inside_out; }
    /// No edge has more than two triangles.
    bool edgeManifold() const { return !nonmanifold_edges && !duplicates; }
    /// The triangles of every vertex form one fan.
    bool vertexManifold() const { return !nonmanifold_vertices; }
};

/// Checks a mesh. Every decision is exact for the mesh's double-precision positions; lengths, areas, volumes and depths
/// are rounded.
///
/// in      any mesh, however broken
/// same    result for any thread count
/// cost    O(triangles log triangles + pairs of triangles whose bounding boxes overlap)
MeshCheck checkMesh(const Mesh& mesh, const CheckParams& params = {});

/// Names of the faults found, as used in reports; empty for a valid mesh.
std::vector<std::string_view> faultsOf(const MeshCheck& check, bool strict = false);

/// Merges vertices at identical positions into the first of them, which keeps its velocity and attributes. Removes
/// unused vertices, and triangles that become degenerate by the merge.
Mesh weldVertices(const Mesh& mesh);

/// Size and shape of curves that are known to be valid.
struct CurveMeasure {
    std::size_t curves = 0;         ///< lines, closed or open
    std::int64_t turning = 0;       ///< sum of the closed lines' turning numbers: components of liquid minus holes
    double area = 0;                ///< enclosed, world units squared; meaningful for closed curves
    double length = 0;              ///< world units
    std::size_t unpaired_ends = 0;  ///< sum over vertices of |outgoing - incoming edges|; 0 when closed
};

/// Measures curves.
///
/// in      edges whose vertices exist; z is ignored
/// cost    O(edges)
CurveMeasure measureCurves(const Curves& curves);

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
    FaultCount not_finite;  ///< vertices: positions that are NaN, infinite or beyond 2^200
    FaultCount velocity_not_finite;
    FaultCount repeated_vertices;  ///< edges from a vertex to itself
    FaultCount open_ends;          ///< vertices with different numbers of outgoing and incoming edges
    FaultCount crossings;          ///< pairs that cross deeper than the tolerance; first is that of the smallest pair
    bool inside_out = false;       ///< closed, with a negative area
    // Faults only in strict mode.
    FaultCount branches;         ///< vertices with several outgoing edges, as in an alpha mesh
    FaultCount unused_vertices;  ///< vertices without edges
    FaultCount off_plane;        ///< vertices whose z differs from that of the first vertex

    std::vector<EdgeCrossing> deepest_crossings;  ///< sorted by depth, deepest first; at most params.examples
    double deepest = 0;
};

/// Checks curves. Crossings are decided exactly; z is ignored.
///
/// in      any curves, however broken
/// same    result for any thread count
/// cost    O(edges log edges) where few edges overlap in x
CurveCheck checkCurves(const Curves& curves, const CheckParams& params);

/// Names of the faults found; with strict also off_plane, branches and unused_vertices.
std::vector<std::string_view> faultsOf(const CurveCheck& check, bool strict = false);

}  // namespace betamesh
