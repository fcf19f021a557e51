// The ball boundary -> samples of it.

#pragma once

#include "core/arc_network.h"
#include "core/ball_boundary.h"
#include "core/boundary_samples.h"
#include "core/face_points.h"

namespace betamesh {

/// Samples of arcs, full circles and wide faces.
///
/// Arcs come in pieces of at most 0.8 radians, full circles in eight; each stands for its length. Their lengths
/// change continuously when arcs appear, vanish or change neighbours, and they are a calmer picture of the
/// surface than the bulging faces are: its bumps' own normals cancel. A sample lies half-way between its
/// arc and the sphere of radius r round the arc's centre, for arcs are the valleys between the balls; its direction is
/// the mean of the two spheres' normals. Where arcs are far away, on drops, tips and edges, a face counts by its
/// area; near arcs it fades out.
///
/// in      a boundary, its balls, its network of arcs and its face points, all with their motion
/// same    result for any thread count
/// cost    O(arcs + points)
BoundarySamples boundarySamples(const BallBoundary& boundary, const std::vector<Moving>& balls,
                                const std::vector<Vec3>& spins, const ArcNetwork& network, const FacePoints& points);

}  // namespace betamesh
