// How two triangles of one surface meet, decided by exact signs.

#pragma once

#include "base/index.h"
#include "mesh/mesh_edges.h"

#include <cstdint>
#include <span>

namespace betamesh {

/// A surface to be judged. Triangles have three distinct vertices each, which exist, with finite positions.
struct JudgedSurface {
    std::span<const Vec3> position;
    std::span<const Triangle> triangles;
    std::span<const std::uint32_t> place;   ///< of each vertex: equal where positions are
    std::span<const std::uint32_t> across;  ///< of each side 3t + m: the triangle beyond it, or kInvalidIndex
};

enum class ContactKind {
    none,      ///< nothing but the corner or edge that the triangles share
    touching,  ///< a common point or stretch of an edge, where the surface stays on one side
    crossing,  ///< the surface passes through itself, or covers itself
};

struct Contact {
    ContactKind kind = ContactKind::none;
    bool coplanar = false;   ///< a crossing that covers an area
    Vec3 position{0, 0, 0};  ///< in the middle of what is common, but for rounding
    double depth = 0;        ///< of a crossing, world units
};

/// Judges triangles s and t, neither of which may be degenerate.
///
/// Corners that stand at the same place count as the same corner; where the mesh does not share them, the
/// triangles touch there. A stretch of an edge that lies on the other triangle, or along one of its edges, is
/// a crossing where the two triangles at that edge lie on different sides of the other surface, else a touch.
///
/// The depth is the shortest way by which one triangle (with its neighbour, where an edge crosses) can be
/// moved off the other: 0 where they lie in one plane.
///
/// source  the order of crossings with the line where two planes meet: Guigue & Devillers 2003
Contact contactOf(const JudgedSurface& surface, std::uint32_t s, std::uint32_t t);

}  // namespace betamesh
