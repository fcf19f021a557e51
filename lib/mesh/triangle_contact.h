// How two triangles of one surface intersect, decided by exact predicates.

#pragma once

#include "base/index.h"
#include "mesh/mesh_edges.h"

#include <cstdint>
#include <span>

namespace betamesh {

/// The surface whose triangles are tested. Each triangle has three distinct vertices, which exist and have finite
/// positions.
struct TestedSurface {
    std::span<const Vec3> position;
    std::span<const Triangle> triangles;
    std::span<const std::uint32_t>
        first_at;  ///< of each vertex: the first vertex at its position, firstVerticesAtPositions()
    std::span<const std::uint32_t> across;  ///< of each side: the triangle across it, trianglesAcross()
};

enum class ContactKind {
    none,      ///< nothing in common but the corner or edge that the triangles share
    touching,  ///< a common point or edge segment, where the surface stays on one side
    crossing,  ///< the surface passes through itself or overlaps itself
};

struct Contact {
    ContactKind kind = ContactKind::none;
    bool coplanar = false;   ///< a crossing of coplanar triangles that overlap
    Vec3 position{0, 0, 0};  ///< centre of the intersection, rounded
    double depth = 0;        ///< of a crossing, world units
};

/// The contact of triangles s and t, neither of which may be degenerate.
///
/// Corners at the same position count as one corner; if they are different vertices of the mesh, the triangles touch
/// there. An edge segment that is on the other triangle, or along one of its edges, is a crossing where the two
/// triangles at that edge are on different sides of the other surface, else a touch.
///
/// The depth is the smallest displacement that separates the two triangles (with the neighbour, where an edge crosses);
/// 0 for coplanar ones.
///
/// source  the order of intersections along the line of the two planes: Guigue & Devillers 2003
Contact contactOf(const TestedSurface& surface, std::uint32_t s, std::uint32_t t);

}  // namespace betamesh
