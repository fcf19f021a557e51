// The boundary of the union of balls: the one structure behind the alpha mesh and the beta mesh.
//
// What stays exposed of the spheres is made of vertices (points on three spheres), arcs (pieces of the
// circle where two spheres meet), full circles, bare spheres, and faces (connected pieces of one sphere).
// Each arc borders two faces, each vertex three arcs and three faces: a closed orientable surface.

#pragma once

#include "base/compressed_rows.h"
#include "base/index.h"
#include "betamesh/mesh.h"
#include "exact/snapped_particles.h"

#include <string_view>
#include <variant>

namespace betamesh {


/// A direction from a ball, one of a fixed set, in which its sphere is exposed. Clearance is as of FacePoints.
struct ExposedDirection {
    std::uint32_t direction;
    std::uint32_t nearest;  ///< whose cap it has least rim_distance from; kInvalidIndex where that ball is not exposed
    float rim_distance;
};

/// Balls are the exposed ones, in the order of SnappedParticles. Vertex v is the centre of an empty r-ball,
/// the dual of one oriented alpha triangle; both sides of a triplet, where both are exposed, are neighbours
/// in the list. Half-edge 3v + m runs from triangle[v][m] to triangle[v][(m + 1) % 3]; it stands for one end
/// of an arc, its twin for the other. A triangle may be its own reverse side's neighbour: there the
/// boundary rolls round the rim of a sheet.
struct BallBoundary {
    double quantum = 1;                      ///< world units
    std::int64_t radius = 0;                 ///< in quanta
    std::vector<Vec3i> position;             ///< of each ball, in quanta
    std::vector<std::uint32_t> row;          ///< of each ball's particle as it was given
    std::vector<std::uint32_t> snapped_row;  ///< and in SnappedParticles, ascending

    std::vector<Triangle> triangle;                    ///< of balls, counter-clockwise seen from the vertex
    std::vector<Vec3> vertex;                          ///< world units
    std::vector<std::uint32_t> twin;                   ///< of each half-edge
    std::vector<std::array<std::uint32_t, 2>> circle;  ///< the two balls of each full circle, ascending
    std::vector<std::uint32_t> isolated;                   ///< balls that meet no other

    CompressedRows<ExposedDirection> exposed;  ///< of each ball, where directions were given

    /// Cycles of arcs round faces, as half-edges that leave the face's ball, exposed side on the left:
    /// the triangles 3v + m / 3 of one row are the ordered triangles of the paper's alpha graph.
    IndexRows cycle;
    /// The cycles of each face: row c < cycle.size() is that cycle, cycle.size() + 2k + s is full circle k
    /// seen from ball circle[k][s]. A bare sphere is a face without cycles.
    IndexRows face;
    std::vector<std::uint32_t> face_ball;

    Vec3 centre(std::size_t ball) const { return toDouble(position[ball]) * quantum; }
    double worldRadius() const { return static_cast<double>(radius) * quantum; }
};

/// The half-edge before and after h in its triangle.
inline std::uint32_t previousInTriangle(std::uint32_t h) { return h % 3 == 0 ? h + 2 : h - 1; }
inline std::uint32_t nextInTriangle(std::uint32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }

/// Is v the same triangle as the vertex before or after it, seen from the other side? Returns that vertex,
/// or v itself.
std::uint32_t reverseSide(const BallBoundary& boundary, std::uint32_t v);

/// V - E + F of the boundary: what any closed mesh of it must have.
std::int64_t eulerCharacteristic(const BallBoundary& boundary);

/// Why floating-point predicates gave no valid boundary: an edge between two particles, by their rows, and
/// what is wrong with it, to follow "the edge from … to … ".
struct UnpairedEdge {
    std::uint32_t from, to;
    std::string_view fault;
};

/// Twins and cycles; the alpha mesh has no use for them.
enum class Arcs { left_out, traced };

/// With exact predicates, for every input. All but the faces of cycles, which groupFaces finds. Of the given directions
/// those that are exposed: while a ball's neighbours are at hand this takes a quarter of what it would later.
///
/// in      n >= 0 snapped particles, the rows of those that may be exposed, and unit vectors
/// same    result for any thread count
/// cost    O(n) for a bounded number of neighbours; 1-4 µs per exposed ball
/// source  beta mesh paper, sections 3.2 and 3.3; Edelsbrunner 1993
BallBoundary ballBoundary(const SnappedParticles& particles, const std::vector<std::uint32_t>& exposed,
                          const std::vector<Vec3>& directions = {}, Arcs arcs = Arcs::traced);

/// With the paper's floating-point test, validated by its edge count, and by what the edge count cannot see:
/// that the triangles round an edge close in turn, and that no exposed ball was left without a triangle.
std::variant<BallBoundary, UnpairedEdge> ballBoundaryInFloats(const SnappedParticles& particles,
                                                              const std::vector<std::uint32_t>& exposed,
                                                              const std::vector<Vec3>& directions = {});

}  // namespace betamesh
