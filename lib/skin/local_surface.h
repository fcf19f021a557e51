// A part of a mesh that is large enough to decide whether its triangles cross.

#pragma once

#include "mesh/triangle_contact.h"
#include "skin/beta_mesh.h"

#include <algorithm>
#include <vector>

namespace betamesh {

/// The rows of the triangles given and of those that have a vertex in common with them, and so on `rings` times;
/// ascending.
///
/// cost    O(triangles of the mesh · rings)
std::vector<std::uint32_t> withRings(const BetaMesh& mesh, const std::vector<std::uint32_t>& triangles, int rings);

/// Some triangles of a mesh, numbered anew as are their vertices, with what contacts depend on. Whether two triangles
/// cross depends on those within two rings of them.
struct LocalSurface {
    std::vector<std::uint32_t> row;     ///< of each triangle in the mesh, ascending
    std::vector<std::uint32_t> vertex;  ///< of the mesh, of each vertex
    std::vector<Triangle> triangles;
    std::vector<Vec3> position;
    std::vector<std::uint32_t> first_at, across;  ///< as in TestedSurface

    LocalSurface(const BetaMesh& mesh, std::vector<std::uint32_t> rows);

    /// The number of a triangle, given by its row in the mesh.
    std::uint32_t triangleOf(std::uint32_t mesh_row) const {
        return static_cast<std::uint32_t>(std::lower_bound(row.begin(), row.end(), mesh_row) - row.begin());
    }
    bool cross(std::uint32_t s, std::uint32_t t) const {
        return contactOf({position, triangles, first_at, across}, s, t).kind == ContactKind::crossing;
    }
};

}  // namespace betamesh
