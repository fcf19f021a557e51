#include "base/parallel.h"
#include "peers.h"
#include "support/cgal_alpha_shape.h"

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Fixed_alpha_shape_3.h>
#include <CGAL/Fixed_alpha_shape_cell_base_3.h>
#include <CGAL/Fixed_alpha_shape_vertex_base_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

namespace betamesh {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Numbered = CGAL::Triangulation_vertex_base_with_info_3<std::uint32_t, Kernel>;

std::vector<std::pair<Kernel::Point_3, std::uint32_t>> numberedPoints(const Particles& particles) {
    std::vector<std::pair<Kernel::Point_3, std::uint32_t>> points;
    for (std::uint32_t i = 0; i < particles.size(); ++i) {
        const Vec3f& p = particles.position[i];
        points.emplace_back(Kernel::Point_3(p.x, p.y, p.z), i);
    }
    return points;
}

Mesh meshOf(const Particles& particles, std::vector<Triangle> triangles) {
    Mesh mesh;
    for (const Vec3f& p : particles.position) mesh.position.emplace_back(p);
    mesh.triangles = std::move(triangles);
    return mesh;
}

}  // namespace

Mesh cgalFixedAlphaShape(const Particles& particles, double radius) {
    using Vertex = CGAL::Fixed_alpha_shape_vertex_base_3<Kernel, Numbered>;
    using Cell = CGAL::Fixed_alpha_shape_cell_base_3<Kernel>;
    using Triangulation = CGAL::Delaunay_triangulation_3<Kernel, CGAL::Triangulation_data_structure_3<Vertex, Cell>>;
    using AlphaShape = CGAL::Fixed_alpha_shape_3<Triangulation>;
    const auto points = numberedPoints(particles);
    Triangulation triangulation(points.begin(), points.end());
    AlphaShape shape(triangulation, radius * radius);
    return meshOf(particles, exposedTriangles(shape));
}

Mesh cgalDelaunay(const Particles& particles, double radius) {
    using Structure = CGAL::Triangulation_data_structure_3<Numbered, CGAL::Delaunay_triangulation_cell_base_3<Kernel>,
                                                           CGAL::Parallel_tag>;
    using Triangulation = CGAL::Delaunay_triangulation_3<Kernel, Structure>;
    const auto points = numberedPoints(particles);
    CGAL::Bbox_3 box;
    for (const auto& [point, number] : points) box += point.bbox();
    Triangulation::Lock_data_structure locks(box, 50);
    const Triangulation triangulation(points.begin(), points.end(), &locks);

    std::vector<Triangulation::Facet> facets;
    for (auto facet = triangulation.finite_facets_begin(); facet != triangulation.finite_facets_end(); ++facet)
        facets.push_back(*facet);
    const double alpha = radius * radius;
    const auto filled = [&](const Triangulation::Cell_handle& cell) {
        return !triangulation.is_infinite(cell) &&
               CGAL::squared_radius(cell->vertex(0)->point(), cell->vertex(1)->point(), cell->vertex(2)->point(),
                                    cell->vertex(3)->point()) <= alpha;
    };
    std::vector<std::uint8_t> sides(facets.size());  // bit 0: facing out of its cell, bit 1: facing into it
    parallelFor(facets.size(), 4096, [&](std::size_t i) {
        const auto& [cell, opposite] = facets[i];
        const auto other = cell->neighbor(opposite);
        const bool here = filled(cell), there = filled(other);
        if (here && there) return;
        if (here != there) {
            sides[i] = here ? 1 : 2;
            return;
        }
        const auto at = [&](int k) {
            return cell->vertex(CGAL::Triangulation_utils_3::vertex_triple_index(opposite, k))->point();
        };
        if (CGAL::squared_radius(at(0), at(1), at(2)) <= alpha && triangulation.is_Gabriel(cell, opposite))
            sides[i] = 3;
    });
    std::vector<Triangle> triangles;
    for (std::size_t i = 0; i < facets.size(); ++i) {
        if (sides[i] == 0) continue;
        const Triangle t = facetOf(facets[i].first, facets[i].second);
        if (sides[i] & 1) triangles.push_back(t);
        if (sides[i] & 2) triangles.push_back(reversed(t));
    }
    return meshOf(particles, std::move(triangles));
}

}  // namespace betamesh
