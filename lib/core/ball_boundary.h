// The boundary of the union of balls: the one structure behind the alpha mesh and the beta mesh.
//
// What stays exposed of the spheres is made of vertices (points on three spheres), arcs (pieces of the
// circle where two spheres meet), full circles, bare spheres, and faces (connected pieces of one sphere).
// Each arc borders two faces, each vertex three arcs and three faces: a closed orientable surface.

#pragma once

#include "core/graph.h"
#include "core/mesh.h"

namespace betamesh {

/// Stands for a ball that is not exposed, or for none.
inline constexpr std::uint32_t kHidden = ~std::uint32_t{0};

/// A direction from a ball, one of a fixed set, in which its sphere is exposed. Clearance is as of FacePoints.
struct ExposedDirection {
    std::uint32_t direction;
    std::uint32_t nearest;  ///< whose cap it has least clearance from; kHidden where that ball is not exposed
    float clearance;
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
    std::vector<std::uint32_t> bare;                   ///< balls that meet no other

    RowsOf<ExposedDirection> exposed;  ///< of each ball, where directions were given

    /// Cycles of arcs round faces, as half-edges that leave the face's ball, exposed side on the left:
    /// the triangles 3v + m / 3 of one row are the ordered triangles of the paper's alpha graph.
    Rows cycle;
    /// The cycles of each face: row c < cycle.size() is that cycle, cycle.size() + 2k + s is full circle k
    /// seen from ball circle[k][s]. A bare sphere is a face without cycles.
    Rows face;
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

}  // namespace betamesh
