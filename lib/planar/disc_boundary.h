// The boundary of the union of discs: the common structure behind the alpha mesh and the beta mesh of a plane.
//
// The exposed part of the circles consists of vertices (points on two circles), arcs between them, and whole circles of
// isolated discs. Each vertex ends one arc and begins another, so they form closed curves, which are counter-clockwise
// around liquid and clockwise around holes.

#pragma once

#include "base/compressed_rows.h"
#include "base/dual.h"
#include "betamesh/vec3.h"
#include "exact/snapped_particles.h"
#include "skin/boundary_samples.h"

#include <array>

namespace betamesh {

/// Only exposed discs are stored, in the order of SnappedParticles. Vertex v is the point where the circles of a pair
/// of discs meet to the right of segment[v], its dual in the alpha mesh; among discs of one radius r it is the centre
/// of an empty disc of that radius. At vertex v the boundary changes from the circle of the segment's first disc to
/// that of the second, and follows the latter counter-clockwise to vertex next[v]. This arc is a face of the paper's
/// alpha graph. A segment may be followed by its own reverse, at the tip of a thin feature.
struct DiscBoundary {
    double quantum = 1;                      ///< world units
    std::int64_t radius = 0;                 ///< of the largest disc, in quanta
    std::vector<std::int32_t> radius_of;     ///< of each disc, in quanta; empty: all `radius`
    std::vector<double> radius_rate;         ///< of each disc: change of its radius, world units per second; empty: 0
    std::vector<Vec3i> position;             ///< of each disc, in quanta; z is that of the plane
    std::vector<std::uint32_t> row;          ///< row of each disc's particle in the input
    std::vector<std::uint32_t> snapped_row;  ///< row of each disc's particle in SnappedParticles, ascending

    std::vector<std::array<std::uint32_t, 2>> segment;  ///< pairs of discs, the liquid on the left
    std::vector<Vec3> vertex;                           ///< world units
    std::vector<std::uint32_t> next;                    ///< vertex at which the arc from each vertex ends
    IndexRows cycle;                                    ///< the closed curves: vertices in the order of `next`
    std::vector<std::uint32_t> isolated;                ///< discs that intersect no other, unless that is inside them

    Vec3 centre(std::size_t disc) const { return toDouble(position[disc]) * quantum; }
    double worldRadius() const { return static_cast<double>(radius) * quantum; }
    std::int64_t radiusOf(std::size_t disc) const { return radius_of.empty() ? radius : radius_of[disc]; }
    Dual worldRadiusOf(std::size_t disc) const {
        return {static_cast<double>(radiusOf(disc)) * quantum, radius_rate.empty() ? 0 : radius_rate[disc]};
    }
    /// Radius of a disc in radii of the largest.
    double scaleOf(std::size_t disc) const {
        return radius_of.empty() ? 1 : static_cast<double>(radius_of[disc]) / static_cast<double>(radius);
    }
    /// Of all discs; empty where all are 1.
    std::vector<double> scales() const;
    /// Of the smallest disc; 1 without discs.
    double leastScale() const;
    /// Do sizes differ or change?
    bool hasScales() const { return !radius_of.empty() || !radius_rate.empty(); }
    /// The scale of a disc with its rate, for a constant radius of the largest.
    Dual movingScaleOf(std::size_t disc) const { return {scaleOf(disc), worldRadiusOf(disc).rate / worldRadius()}; }
    /// The mean of this over the two discs of a vertex.
    Dual movingScaleOfVertex(std::size_t v) const {
        return (movingScaleOf(segment[v][0]) + movingScaleOf(segment[v][1])) * 0.5;
    }
};

/// Angle subtended by the arc that begins at a vertex, radians in [0, 2π].
double arcAngle(const DiscBoundary& boundary, std::uint32_t v);
/// The length of the arc that begins at a vertex, world units; discs, vertices: those of the boundary, with velocities.
Dual arcLength(const DiscBoundary& boundary, const std::vector<DualVec3>& discs, const std::vector<DualVec3>& vertices,
               std::uint32_t v);

/// Finds every vertex with exact predicates: the points where two circles meet that are in no other disc.
///
/// in      n >= 0 particles of one z, with discs of one radius or of several
/// out     vertices sorted by their first disc, then by direction; curves sorted by their smallest vertices. Every
///         curve is closed, whatever the input
/// same    result for any thread count and particle order
/// cost    O(n) for a bounded number of discs that meet each disc
/// source  beta mesh paper, sections 3.2 and 3.3, in two dimensions; Edelsbrunner 1993, The union of balls
DiscBoundary discBoundary(const SnappedParticles& particles);

/// Samples of the boundary of discs.
struct DiscSamples {
    BoundarySamples sample;
    std::vector<std::uint32_t> disc;  ///< of each sample
    std::vector<std::uint32_t> arc;   ///< of each sample: the vertex at which its arc begins; kInvalidIndex on circles
    std::vector<Dual> scale;          ///< radius of that disc, in radii of the largest; empty: all 1
};

/// Samples of the boundary: all arcs and isolated circles, cut at `directions` fixed directions from each centre. A
/// sample is the midpoint of its segment of the arc, weighted by the length of that, and points away from the centre.
/// As a measure the samples change continuously through every event: arcs appear and vanish with length zero. Where
/// discs begin to touch and cut an arc in two, its samples change slightly.
///
/// in      discs, vertices: those of the boundary, with velocities
/// cost    O(samples)
DiscSamples boundarySamples(const DiscBoundary& boundary, const std::vector<DualVec3>& discs,
                            const std::vector<DualVec3>& vertices, int directions = 24);

}  // namespace betamesh
