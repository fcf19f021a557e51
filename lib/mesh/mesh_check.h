// Is a mesh fit for use? What is wrong with it, how often, and where first.

#pragma once

#include "betamesh/mesh.h"

#include <optional>
#include <string_view>

namespace betamesh {

struct CheckParams {
    double tolerance = 0;      ///< world units, >= 0: crossings shallower than this do not count
    std::size_t examples = 8;  ///< how many crossings are listed
};

/// IndexRows of one kind.
struct Found {
    std::size_t count = 0;
    std::uint32_t first = 0;  ///< the smallest such row, if there is one

    explicit operator bool() const { return count > 0; }
};

/// Two triangles that pass through or cover each other.
struct SelfCrossing {
    std::uint32_t first = 0, second = 0;  ///< triangle rows, ascending
    Vec3 position{0, 0, 0};               ///< in the middle of what is common, but for rounding
    double depth = 0;                     ///< the shortest way that parts the two, world units; see triangle_contact.h
    bool coplanar = false;                ///< they cover a common area
};

/// Triangles that share no vertex with others.
struct ComponentCheck {
    std::size_t vertices = 0, edges = 0, triangles = 0;
    std::int64_t euler = 0;             ///< vertices - edges + triangles
    std::optional<std::int64_t> genus;  ///< handles; only where the component is a closed, oriented manifold
    bool closed = true;
    double volume = 0;  ///< world units cubed, positive where triangles face outwards; meaningful where closed
    double area = 0;    ///< world units squared
};

/// Counts of edges are at their vertex with the smaller row. Triangles with missing or repeated vertices are
/// counted as such and left out of all that follows; those with positions that are not finite are left out of
/// volumes, areas and contacts, zero-area ones of contacts.
struct MeshCheck {
    std::size_t vertices = 0, triangles = 0;  ///< rows of the mesh
    std::size_t edges = 0;
    std::int64_t euler = 0;  ///< used vertices - edges + triangles
    double volume = 0;       ///< world units cubed
    double area = 0;         ///< world units squared
    std::vector<ComponentCheck> components;

    // Faults. IndexRows of vertices:
    Found not_finite;  ///< positions that are NaN, infinite or beyond 2^200
    Found velocity_not_finite;
    Found open_edges;            ///< with an odd number of triangles
    Found misoriented_edges;     ///< run through at least twice more often in one direction than in the other
    Found nonmanifold_edges;     ///< with more than two triangles
    Found nonmanifold_vertices;  ///< round which triangles form several fans that share no edge
    // IndexRows of triangles:
    Found missing_vertices;   ///< that name a vertex which does not exist
    Found repeated_vertices;  ///< that name one vertex twice
    Found duplicates;         ///< with the same three vertices, in any order, as one before
    Found crossings;          ///< pairs, those below the tolerance left out; first is that of the smallest pair
    bool inside_out = false;  ///< closed and oriented, with a negative volume

    // No faults, unless one is strict:
    Found zero_area;  ///< triangles whose corners are on one line, exactly
    Found unused_vertices;
    Found coincident_vertices;  ///< at the same position as one before: mendable by weldVertices
    std::size_t touching = 0;   ///< pairs of triangles that touch where the mesh does not join them
    std::size_t shallow = 0;    ///< crossings below the tolerance

    double deepest = 0;                           ///< of all crossings, world units
    std::vector<SelfCrossing> deepest_crossings;  ///< the deepest first, as many as asked for

    bool closed() const { return !open_edges; }
    bool oriented() const { return !misoriented_edges && !inside_out; }
    bool edgeManifold() const { return !nonmanifold_edges && !duplicates; }
    bool vertexManifold() const { return !nonmanifold_vertices; }
};

/// Judges a mesh. Every decision is exact for the doubles that the mesh holds; lengths, areas, volumes and
/// depths are rounded.
///
/// in      any mesh, whatever is wrong with it
/// same    result for any thread count
/// cost    O(triangles log triangles) and the pairs of triangles whose boxes meet
MeshCheck checkMesh(const Mesh& mesh, const CheckParams& params = {});

/// The names of the faults, as in reports; none where the mesh is fit for use.
std::vector<std::string_view> faultsOf(const MeshCheck& check, bool strict = false);

/// Joins vertices at identical positions into the first of them, whose velocity and attributes stay; unused
/// ones go, and so do triangles that lose a corner by it.
Mesh weldVertices(const Mesh& mesh);

}  // namespace betamesh
