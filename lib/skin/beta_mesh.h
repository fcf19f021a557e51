// The beta mesh on its way: vertices that move, triangles, and what each vertex stands for.

#pragma once

#include "base/compressed_rows.h"
#include "base/dual.h"
#include "betamesh/mesh.h"

#include <utility>

namespace betamesh {

/// How points that only make a curved surface finer come and go as the surface moves.
enum class Appearance {
    on_boundary,  ///< all at once; every point lies on the boundary of the union of balls
    gradual,      ///< continuously in time, out of chords and facets; what is smoothed afterwards does not jump
};

/// A vertex that appeared not long ago, or is about to vanish, on an edge or a facet of others. `share` grows from 0
/// there to 1. Its position holds it so far from them before smoothing; what smoothing makes of it has to be held back
/// again, by the same share, towards what it makes of them. One where an edge is about to give way to the other
/// diagonal of a quad goes from the one to the other as its four corners say: its share stays 0.
struct FadingVertex {
    std::uint32_t vertex;
    std::array<std::uint32_t, 4> from;  ///< the vertices of the edge, facet or quad; where fewer the last again
    std::array<Dual, 4> weight;         ///< where among them; they sum to 1
    Dual share;
    DualVec3 whole;  ///< where the vertex would be with a share of 1
};

/// Those on edges, on facets, and in quads; facets may have one another's vertices for corners, quads any. Then, for each
/// time that long edges are split, those on these edges, and those in quads that this leaves.
inline constexpr std::size_t kTessellationGroups = 3;
using FadingVertices = std::array<std::vector<FadingVertex>, kTessellationGroups + 2 * 2>;

/// A vertex far from any rim, which smoothing leaves where it is but for this step outwards: facets miss what their
/// ball bulges out between vertices, and drops would be the smaller for it.
struct VolumeOffset {
    std::uint32_t vertex;
    DualVec3 step;
};

/// Vertices with their motion. Ones that no triangle uses are allowed.
struct BetaMesh {
    std::vector<DualVec3> vertex;
    std::vector<Triangle> triangles;
    std::vector<Dual> rim_distance;  ///< of each vertex from the rim of its face, as in FacePoints; none: all 0
    FadingVertices fading;
    std::vector<VolumeOffset> volume_offsets;
    std::vector<std::uint32_t> ball_begin;  ///< the first triangle made for each ball, then all; none: not known
};

/// Vertices that no triangle uses are left out.
Mesh asMesh(const std::vector<DualVec3>& vertex, std::vector<Triangle> triangles);
inline Mesh asMesh(BetaMesh&& beta) { return asMesh(beta.vertex, std::move(beta.triangles)); }

/// Brings the vertices into another order: order[i] is the one that comes i-th.
void reorderVertices(BetaMesh& mesh, const std::vector<std::uint32_t>& order);

/// Many points that move, in two arrays, for which there is room sooner than for one twice as large.
struct DualPoints {
    std::vector<Vec3> position;
    std::vector<Vec3f> velocity;

    DualVec3 operator[](std::size_t row) const { return {position[row], Vec3(velocity[row])}; }
    std::size_t size() const { return position.size(); }
};
DualPoints copyOf(const std::vector<DualVec3>& points);

/// A position as files hold it, in floats.
inline Vec3 asWritten(const Vec3& position) {
    const auto rounded = [](double x) {
        const volatile float nearest = static_cast<float>(x);  // g++ 12 -O3 takes two casts there and back for none
        return static_cast<double>(nearest);
    };
    return {rounded(position.x), rounded(position.y), rounded(position.z)};
}
/// Brings all vertices to where files will have them.
void moveToWritten(BetaMesh& mesh);

/// As in core/vertex_normals.h.
std::vector<Vec3> vertexNormals(const BetaMesh& mesh);

/// The paper's beta mesh. Vertices come in two kinds, one after the other: pure beta vertices, as many and
/// in the order of the ball boundary's vertices, then alphabeta vertices, one per fan.
/// A fan is a face of the alpha graph: the whole ring of triangles round an alpha vertex (closed), or the
/// part of it on one side of a thin sheet (open).
struct PaperMesh : BetaMesh {
    std::size_t pure = 0;                 ///< number of pure beta vertices
    IndexRows fan;                             ///< pure beta vertices round each fan, in order
    std::vector<std::uint8_t> fan_open;   ///< 1 where the last vertex of a fan is not joined to its first
    std::vector<std::uint32_t> fan_ball;  ///< the alpha vertex
    std::vector<std::uint8_t> rim;        ///< one per pure beta vertex: 1 where it belongs to a sheet's rim

    std::uint32_t alphabeta(std::size_t f) const { return static_cast<std::uint32_t>(pure + f); }
    /// Edges of a fan between pure beta vertices.
    std::size_t fanEdges(std::size_t f) const { return fan_open[f] ? fan[f].size() - 1 : fan[f].size(); }
};

}  // namespace betamesh
