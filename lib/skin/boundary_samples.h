// The ball boundary -> samples of it.

#pragma once

#include "core/arc_network.h"
#include "core/ball_boundary.h"
#include "core/boundary_samples.h"
#include "core/face_points.h"

namespace betamesh {

/// One sample for what is exposed of a ball, where that is a small patch, as in the surface of a liquid; where it is
/// spread out, as on drops, sheets and edges, four, one towards each corner of a tetrahedron. In between there are
/// both, by shares, so that nothing jumps.
///
/// They stand for half of the length of the arcs and full circles round the ball: these change continuously when arcs
/// appear, vanish or change neighbours, and they are a calmer picture of the surface than the bulging faces are, whose
/// bumps' own normals cancel. Arcs are the valleys between the balls, so each counts half-way between itself and
/// the sphere of radius r round its centre; its direction is the mean of the two spheres' normals. Where arcs are
/// far away a face counts by its area; near arcs it fades out.
///
/// in      a boundary, its balls, its network of arcs and its face points, all with their motion
/// same    result for any thread count
/// cost    O(arcs + points)
SamplesInRadii boundarySamples(const BallBoundary& boundary, const std::vector<Moving>& balls,
                               const ArcNetwork& network, const FacePoints& points);

}  // namespace betamesh
