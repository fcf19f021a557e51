// Triangles of CGAL's alpha shapes whose vertices are numbered. CGAL is a peer to compare with, in tests and benchmarks
// alone.

#pragma once

#include "betamesh/mesh.h"

#include <CGAL/Triangulation_utils_3.h>

#include <vector>

namespace betamesh {

/// The triangle of facet `opposite` of a cell, counter-clockwise seen from outside the cell.
template <typename Cell>
Triangle facetOf(const Cell& cell, int opposite) {
    const auto at = [&](int k) {
        return cell->vertex(CGAL::Triangulation_utils_3::vertex_triple_index(opposite, k))->info();
    };
    return {at(0), at(2), at(1)};  // the order of the triple is counter-clockwise seen from inside
}

inline Triangle reversed(const Triangle& t) { return {t[0], t[2], t[1]}; }

/// The triangles with an exposed side, counter-clockwise seen from there; those with two come twice. A facet between a
/// filled and an empty cell is exposed to the empty one, a facet of the shape between two empty ones to both.
template <typename AlphaShape>
std::vector<Triangle> exposedTriangles(const AlphaShape& shape) {
    std::vector<Triangle> triangles;
    for (auto facet = shape.finite_facets_begin(); facet != shape.finite_facets_end(); ++facet) {
        const auto kind = shape.classify(*facet);
        if (kind != AlphaShape::REGULAR && kind != AlphaShape::SINGULAR) continue;
        const bool inside = shape.classify(facet->first) == AlphaShape::INTERIOR;
        const Triangle t = facetOf(facet->first, facet->second);
        if (kind == AlphaShape::SINGULAR || inside) triangles.push_back(t);
        if (kind == AlphaShape::SINGULAR || !inside) triangles.push_back(reversed(t));
    }
    return triangles;
}

}  // namespace betamesh
