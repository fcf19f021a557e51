// The boundary of the union of balls: the structure from which both the alpha mesh and the beta mesh are read.
//
// The exposed parts of the spheres consist of vertices (points on three spheres), arcs (pieces of the circle in which
// two spheres meet), full circles, isolated spheres, and faces (connected pieces of one sphere). Each arc borders two
// faces, each vertex three arcs and three faces: a closed orientable surface.

#pragma once

#include "base/compressed_rows.h"
#include "base/dual.h"
#include "base/index.h"
#include "betamesh/mesh.h"
#include "exact/snapped_particles.h"
#include "skin/exposed_directions.h"

#include <string_view>
#include <variant>

namespace betamesh {

inline constexpr std::size_t kBallsPerTask = 128;  ///< of parallel loops over the balls of a boundary

/// The boundary of a union of balls. Its balls are the exposed ones, in the order of SnappedParticles. Vertex v is the
/// centre of an empty r-ball and the dual of one oriented alpha triangle; if both sides of a triplet are exposed, its
/// two vertices follow one another in the list. Half-edge 3v + m runs from triangle[v][m] to triangle[v][(m + 1) % 3]
/// and stands for one end of an arc, its twin for the other end. A triangle can be adjacent to its own reverse side:
/// there the boundary goes round the rim of a sheet.
struct BallBoundary {
    double quantum = 1;                      ///< world units
    std::int64_t radius = 0;                 ///< of the largest ball, quanta
    std::vector<std::int32_t> radius_of;     ///< of each ball, quanta; empty: all `radius`
    std::vector<double> radius_rate;         ///< of each ball: change of its radius, world units per second; empty: 0
    std::vector<Vec3i> position;             ///< of each ball, quanta
    std::vector<std::uint32_t> row;          ///< of each ball: its particle's row in the input
    std::vector<std::uint32_t> snapped_row;  ///< of each ball: its row in SnappedParticles, ascending

    std::vector<Triangle> triangle;                    ///< of balls, counter-clockwise seen from the vertex
    std::vector<Vec3> vertex;                          ///< world units
    std::vector<std::uint32_t> twin;                   ///< of each half-edge
    std::vector<std::array<std::uint32_t, 2>> circle;  ///< the two balls of each full circle, ascending
    std::vector<std::uint32_t> isolated;               ///< balls that meet no other

    CompressedRows<ExposedDirection> exposed;  ///< of each ball; empty unless directions were given

    /// Cycles of arcs round faces, as half-edges that leave the face's ball with the exposed side on the left. The
    /// triangles h / 3 of one row are the ordered triangles of the paper's alpha graph.
    IndexRows cycle;
    /// The cycles of each face: an entry c < cycle.size() is that cycle, cycle.size() + 2k + s is full circle k seen
    /// from ball circle[k][s]. An isolated sphere is a face without cycles.
    IndexRows face;
    std::vector<std::uint32_t> face_ball;

    Vec3 centre(std::size_t ball) const { return toDouble(position[ball]) * quantum; }
    double worldRadius() const { return static_cast<double>(radius) * quantum; }
    std::int64_t radiusOf(std::size_t ball) const { return radius_of.empty() ? radius : radius_of[ball]; }
    /// Radius of a ball in radii of the largest.
    double scaleOf(std::size_t ball) const {
        return radius_of.empty() ? 1 : static_cast<double>(radius_of[ball]) / static_cast<double>(radius);
    }
    Dual worldRadiusOf(std::size_t ball) const {
        return {static_cast<double>(radiusOf(ball)) * quantum, radius_rate.empty() ? 0 : radius_rate[ball]};
    }
};

/// The half-edge before and after h in its triangle.
inline std::uint32_t previousInTriangle(std::uint32_t h) { return h % 3 == 0 ? h + 2 : h - 1; }
inline std::uint32_t nextInTriangle(std::uint32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }

/// The vertex of the reverse side of v's triangle, which is then v - 1 or v + 1; v itself if that side is not exposed.
std::uint32_t reverseSide(const BallBoundary& boundary, std::uint32_t v);

/// V - E + F of the boundary, which every closed mesh of it must match.
std::int64_t eulerCharacteristic(const BallBoundary& boundary);

/// Why floating-point predicates gave no valid boundary: an edge between two particles, given by input rows, and what
/// is wrong with it, worded to follow "the edge from … to … ".
struct UnpairedEdge {
    std::uint32_t from, to;
    std::string_view fault;
};

/// Whether to compute twins and cycles, which the alpha mesh does not need.
enum class ArcTracing { none, traced };

/// Computes the boundary with exact predicates: valid for every input. Faces are left to groupFaces(). Also tells in
/// which of the given directions each ball is exposed: here, where its neighbours are known, this takes a quarter of
/// the time it would take later.
///
/// in      n >= 0 snapped particles, the rows of exposure candidates, and unit vectors
/// same    result for any thread count
/// cost    O(n) for a bounded number of neighbours; 1-4 µs per exposed ball
/// source  beta mesh paper, sections 3.2 and 3.3; Edelsbrunner 1993
BallBoundary ballBoundary(const SnappedParticles& particles, const std::vector<std::uint32_t>& exposed,
                          const std::vector<Vec3>& directions = {}, ArcTracing arcs = ArcTracing::traced);

/// The same with the paper's floating-point test, validated by the paper's edge count and by two checks the edge count
/// cannot replace: the triangles round every edge pair up in turn, and no exposed ball is without a triangle.
std::variant<BallBoundary, UnpairedEdge> ballBoundaryInFloats(const SnappedParticles& particles,
                                                              const std::vector<std::uint32_t>& exposed,
                                                              const std::vector<Vec3>& directions = {});

}  // namespace betamesh
