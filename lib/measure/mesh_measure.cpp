#include "measure/mesh_measure.h"

#include "core/mesh_edges.h"
#include "exact/orientation.h"

#include <algorithm>
#include <cstdlib>
#include <iterator>

namespace betamesh {

MeshMeasure measureMesh(const Mesh& mesh) {
    MeshMeasure measure;
    const Pieces pieces = piecesOf(mesh.position.size(), mesh.triangles);
    measure.components = pieces.count;
    for (const std::uint32_t piece : pieces.of_vertex) measure.euler += piece != kNoPiece;
    measure.euler += static_cast<std::int64_t>(mesh.triangles.size());

    const Vec3 origin = mesh.position.empty() ? Vec3(0) : mesh.position[0];
    for (const Triangle& t : mesh.triangles) {
        const Vec3 a = mesh.position[t[0]] - origin, b = mesh.position[t[1]] - origin, c = mesh.position[t[2]] - origin;
        measure.volume += volumeBelow(a, b, c);
        measure.area += areaOf(a, b, c);
    }
    forEveryEdge(sortedSides(mesh.triangles), [&](std::span<const TriangleSide> sides) {
        std::int64_t surplus = 0;
        for (const TriangleSide& side : sides) surplus += side.direction;
        measure.unpaired_edges += static_cast<std::size_t>(std::abs(surplus));
        --measure.euler;
    });
    return measure;
}

std::vector<Triangle> placedTriangles(const Mesh& mesh) {
    std::vector<Triangle> placed;
    std::copy_if(mesh.triangles.begin(), mesh.triangles.end(), std::back_inserter(placed), [&](const Triangle& t) {
        return std::all_of(t.begin(), t.end(),
                           [&](std::uint32_t v) { return v < mesh.position.size() && isInRange(mesh.position[v]); });
    });
    return placed;
}

}  // namespace betamesh
