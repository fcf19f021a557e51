// The normals of a mesh: those that it brings, or else computed ones.

#pragma once

#include "betamesh/mesh.h"
#include "mesh/vertex_normals.h"

#include <algorithm>
#include <vector>

namespace betamesh {

/// The attribute `N` of three floats; null if there is none.
inline const Attribute* normalsIn(const std::vector<Attribute>& attributes) {
    const auto isNormals = [](const Attribute& a) { return a.name == "N" && a.components == 3 && a.integer.empty(); };
    const auto found = std::find_if(attributes.begin(), attributes.end(), isNormals);
    return found == attributes.end() ? nullptr : &*found;
}

/// The attribute `N` of a mesh, or else its vertexNormals().
inline std::vector<Vec3> normalsOf(const Mesh& mesh) {
    const Attribute* given = normalsIn(mesh.attributes);
    if (given == nullptr || given->real.size() != 3 * mesh.position.size())
        return vertexNormals(mesh.position.size(), mesh.triangles,
                             [&](std::uint32_t v) -> const Vec3& { return mesh.position[v]; });
    std::vector<Vec3> normals;
    normals.reserve(mesh.position.size());
    for (std::size_t i = 0; i + 2 < given->real.size(); i += 3)
        normals.emplace_back(given->real[i], given->real[i + 1], given->real[i + 2]);
    return normals;
}

}  // namespace betamesh
