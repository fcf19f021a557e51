// The boundary of the union of discs: the one structure behind the alpha mesh and the beta mesh of a plane.
//
// What stays exposed of the circles is made of vertices (points on two circles), arcs between them, and bare circles.
// Each vertex ends one arc and begins another: closed curves, which run counter-clockwise round liquid and clockwise
// round holes in it.

#pragma once

#include "base/compressed_rows.h"
#include "betamesh/vec3.h"
#include "exact/snapped_particles.h"

#include <array>

namespace betamesh {

/// Discs are the exposed ones, in the order of SnappedParticles. Vertex v is the centre of an empty disc of radius r to
/// the right of segment[v], its dual in the alpha mesh. There the boundary leaves the circle of the first disc for that
/// of the second, along which it runs counter-clockwise to vertex next[v]. That arc is a face of the paper's alpha
/// graph, its two segments in order; a segment may be followed by its own reverse, where the boundary rolls round the
/// end of something thin.
struct DiscBoundary {
    double quantum = 1;                      ///< world units
    std::int64_t radius = 0;                 ///< in quanta
    std::vector<Vec3i> position;             ///< of each disc, in quanta; z is that of the plane
    std::vector<std::uint32_t> row;          ///< of each disc's particle as it was given
    std::vector<std::uint32_t> snapped_row;  ///< and in SnappedParticles, ascending

    std::vector<std::array<std::uint32_t, 2>> segment;  ///< of discs, the liquid on the left
    std::vector<Vec3> vertex;                           ///< world units
    std::vector<std::uint32_t> next;                    ///< where the arc from each vertex ends
    IndexRows cycle;                                         ///< the closed curves: vertices in the order of `next`
    std::vector<std::uint32_t> isolated;                    ///< discs that meet no other

    Vec3 centre(std::size_t disc) const { return toDouble(position[disc]) * quantum; }
    double worldRadius() const { return static_cast<double>(radius) * quantum; }
};

/// How much of its circle the arc that begins at a vertex covers: 0 to 2π.
double arcAngle(const DiscBoundary& boundary, std::uint32_t v);

/// Finds every vertex by exact signs: the oriented segments of particles whose r-disc on the right is empty.
///
/// in      n >= 0 particles of one z
/// out     vertices sorted by their first disc, then by direction; curves by their smallest vertices. All are closed,
///         whatever the input
/// same    result for any thread count and particle order
/// cost    O(n) for a bounded number of neighbours within two radii
/// source  beta mesh paper, sections 3.2 and 3.3, in two dimensions
DiscBoundary discBoundary(const SnappedParticles& particles);

}  // namespace betamesh
