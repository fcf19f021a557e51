// The beta mesh while it is being made: vertices with their motion, triangles, and the role of each vertex.

#pragma once

#include "base/compressed_rows.h"
#include "base/dual.h"
#include "betamesh/mesh.h"

#include <utility>

namespace betamesh {

/// How points that only refine a curved surface come and go as the surface moves.
enum class Appearance {
    on_boundary,  ///< at once: every point lies on the boundary of the union of balls
    gradual,      ///< continuously in time, fading in from chords and facets, so that smoothed surfaces do not jump
};

/// A vertex that fades in on an edge or facet of others, or fades out there. Its weight `fade` is 0 on that edge or
/// facet, where the vertex makes no difference, and grows to 1. Before smoothing the vertex has the position that its
/// weight gives it; after smoothing it must be blended again, by the same weight, towards the smoothed edge or facet.
/// A vertex of an edge flip in progress is a combination of the four corners of its quad: its weight stays 0.
struct FadingVertex {
    std::uint32_t vertex;
    /// The vertices from which it rises: those of the edge, facet or quad (of one diagonal, then the other); the last
    /// one repeated if fewer.
    std::array<std::uint32_t, 4> support;
    std::array<Dual, 4> support_weight;  ///< barycentric weights of these; they sum to 1
    Dual fade;                           ///< weight of the vertex's own position, 0 to 1
    DualVec3 unfaded;                    ///< where the vertex would be at weight 1
};

/// The fading vertices by what they fade in on: edges, then facets, then quads. Those on facets may refer to one
/// another, those in quads to any others. Then, from two further groups on, for each time that long edges are split
/// (before and after smoothing), those on these edges, and those in the quads that result.
inline constexpr std::size_t kOnEdges = 0, kOnFacets = 1, kInQuads = 2, kFirstRefinement = 3, kLastRefinement = 5;
using FadingVertices = std::array<std::vector<FadingVertex>, kLastRefinement + 2>;

/// Volume-compensating offset of a vertex far from any rim: smoothing leaves such a vertex in place but for this step
/// outwards. Facets lie inside the sphere between their vertices, which would make drops too small.
struct VolumeOffset {
    std::uint32_t vertex;
    DualVec3 step;
};

/// Vertices with their motion. Vertices that no triangle uses are allowed.
struct BetaMesh {
    std::vector<DualVec3> vertex;
    std::vector<Triangle> triangles;
    std::vector<Dual> rim_distance;  ///< of each vertex, as in FacePoints; empty: all 0
    FadingVertices fading;
    std::vector<VolumeOffset> volume_offsets;
    std::vector<std::uint32_t> ball_begin;  ///< first triangle of each ball, then their number; empty: not known
    /// Local particle spacing at each vertex, in spacings of the frame; empty: all 1.
    std::vector<float> scale;

    double scaleOf(std::size_t v) const { return scale.empty() ? 1 : static_cast<double>(scale[v]); }
};

/// The plain mesh, without vertices that no triangle uses.
Mesh asMesh(const std::vector<DualVec3>& vertex, std::vector<Triangle> triangles);
inline Mesh asMesh(BetaMesh&& beta) { return asMesh(beta.vertex, std::move(beta.triangles)); }

/// The vertices, without motion, and triangles of a mesh.
BetaMesh asBetaMesh(const Mesh& mesh);

/// Removes triangles, and leaves all vertices. isKept(row)
template <typename IsKept>
void keepTriangles(BetaMesh& mesh, const IsKept& isKept) {
    std::size_t kept = 0, ball = 0;
    const auto endBallsAt = [&](std::size_t t) {
        for (; ball < mesh.ball_begin.size() && mesh.ball_begin[ball] == t; ++ball)
            mesh.ball_begin[ball] = static_cast<std::uint32_t>(kept);
    };
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        endBallsAt(t);
        if (isKept(t)) mesh.triangles[kept++] = mesh.triangles[t];
    }
    endBallsAt(mesh.triangles.size());
    mesh.triangles.resize(kept);
}

/// Reorders the vertices: new vertex i is old vertex order[i].
void reorderVertices(BetaMesh& mesh, const std::vector<std::uint32_t>& order);

/// Points with their motion in two arrays, velocities in floats: less memory than DualVec3, and in smaller blocks.
struct DualPoints {
    std::vector<Vec3> position;
    std::vector<Vec3f> velocity;

    DualVec3 operator[](std::size_t row) const { return {position[row], Vec3(velocity[row])}; }
    std::size_t size() const { return position.size(); }
};
DualPoints dualPoints(const std::vector<DualVec3>& points);

/// Adds points for the vertices of the last refinement, where the points of their supports place them.
void addLastRefinement(const FadingVertices& fading, DualPoints& points);

/// A position rounded to floats, as files store it.
inline Vec3 roundedToFloats(const Vec3& position) {
    const auto rounded = [](double x) {
        const volatile float nearest = static_cast<float>(x);  // g++ 12 -O3 drops a cast there and back
        return static_cast<double>(nearest);
    };
    return {rounded(position.x), rounded(position.y), rounded(position.z)};
}
/// Rounds all vertices as files will.
void roundToFloats(BetaMesh& mesh);

/// As in mesh/vertex_normals.h.
std::vector<Vec3> vertexNormals(const BetaMesh& mesh);

/// Blends the displacements of vertices that fade in with those of their supports.
void blendFading(const FadingVertices& fading, std::vector<DualVec3>& displacement);

/// The paper's beta mesh. First come the pure beta vertices, in the order of the ball boundary's vertices, then the
/// alphabeta vertices, one per fan. A fan is a face of the alpha graph: the whole ring of triangles round an alpha
/// vertex (closed), or the part of it on one side of a thin sheet (open).
struct PaperMesh : BetaMesh {
    std::size_t pure = 0;                 ///< number of pure beta vertices
    IndexRows fan;                        ///< pure beta vertices round each fan, in order
    std::vector<std::uint8_t> fan_open;   ///< 1 if the last vertex of a fan is not joined to its first
    std::vector<std::uint32_t> fan_ball;  ///< the alpha vertex
    std::vector<std::uint8_t> rim;        ///< of each pure beta vertex: 1 if it belongs to a sheet's rim

    std::uint32_t alphabeta(std::size_t f) const { return static_cast<std::uint32_t>(pure + f); }
    /// Number of edges of a fan between pure beta vertices.
    std::size_t fanEdges(std::size_t f) const { return fan_open[f] ? fan[f].size() - 1 : fan[f].size(); }
};

}  // namespace betamesh
